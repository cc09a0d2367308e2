//! Environments of one scene over the worlds of one engine: several that step together, or a single one.

use std::sync::Arc;

use super::blueprint::{Blueprint, BlueprintError};
use super::episode::RobotEpisode;
use super::interface::{Crew, Step, View};
use super::scene::Scene;
use super::trial::Mode;
use crate::kinds::Signals;
use crate::sim::{self, Engine, Seat, State, Worlds};

/// Environments whose worlds the engine advances together.
pub struct RobotCrew {
    members: Vec<Member>,
    worlds: Box<dyn Worlds>,
    /// Physics steps per control step.
    ticks: usize,
}

/// One environment of a crew.
struct Member {
    episode: RobotEpisode,
    /// Whether it takes part in the next control step.
    acts: bool,
    outcome: Step,
}

impl RobotCrew {
    /// `count` environments of a scene; the first call for each must be [`Crew::begin`].
    pub fn new(scene: &Arc<Scene>, count: usize) -> Self {
        let member = |_| Member {
            episode: RobotEpisode::new(scene.clone()),
            acts: false,
            outcome: Step { reward: 0.0, end: None },
        };
        Self {
            members: (0..count).map(member).collect(),
            worlds: sim::worlds(&scene.engine, count),
            ticks: scene.rates.control,
        }
    }

    /// `count` environments of a scene, divided into crews of the engine's group size, but into at least as
    /// many crews as threads where possible.
    pub fn divided(scene: &Arc<Scene>, count: usize, threads: usize) -> Vec<Box<dyn Crew>> {
        let width = scene.engine.width().min(count.div_ceil(threads.max(1))).max(1);
        let sizes = (0..count).step_by(width).map(|start| width.min(count - start));
        sizes.map(|size| Box::new(Self::new(scene, size)) as Box<dyn Crew>).collect()
    }
}

impl Crew for RobotCrew {
    fn count(&self) -> usize {
        self.members.len()
    }

    fn view(&self, index: usize) -> &dyn View {
        &self.members[index].episode
    }

    fn begin(&mut self, index: usize, stream: &str) {
        let mut seat = Seat { worlds: self.worlds.as_mut(), index };
        self.members[index].episode.begin(stream, &mut seat);
    }

    fn act(&mut self, index: usize, action: &[f32]) {
        self.members[index].episode.take(action);
        self.members[index].acts = true;
    }

    fn step(&mut self) {
        for tick in 0..self.ticks {
            for (index, member) in self.members.iter_mut().enumerate().filter(|(_, member)| member.acts) {
                member.episode.drive(tick, &mut Seat { worlds: self.worlds.as_mut(), index });
            }
            self.worlds.advance();
            for (index, member) in self.members.iter_mut().enumerate().filter(|(_, member)| member.acts) {
                member.episode.sense(&Seat { worlds: self.worlds.as_mut(), index });
            }
        }
        for member in self.members.iter_mut().filter(|member| member.acts) {
            member.outcome = member.episode.finish();
            member.acts = false;
        }
    }

    fn outcome(&self, index: usize) -> Step {
        self.members[index].outcome
    }
}

/// A single environment.
pub struct RobotEnvironment {
    crew: RobotCrew,
}

impl Blueprint {
    /// A single environment.
    pub fn environment(
        &self,
        engine: Arc<dyn Engine>,
        mode: &Mode,
    ) -> Result<RobotEnvironment, BlueprintError> {
        self.scene(engine, mode).map(RobotEnvironment::new)
    }
}

impl RobotEnvironment {
    /// An environment; the first call must be [`RobotEnvironment::begin`].
    pub fn new(scene: Arc<Scene>) -> Self {
        Self { crew: RobotCrew::new(&scene, 1) }
    }

    /// Starts an episode, as [`Crew::begin`] does.
    pub fn begin(&mut self, stream: &str) {
        self.crew.begin(0, stream);
    }

    /// Advances one control step with the actor's (unclipped) outputs.
    pub fn step(&mut self, action: &[f32]) -> Step {
        self.crew.act(0, action);
        self.crew.step();
        self.crew.outcome(0)
    }

    /// The readable state between two control steps.
    pub fn view(&self) -> &dyn View {
        self.episode()
    }

    fn episode(&self) -> &RobotEpisode {
        &self.crew.members[0].episode
    }

    /// The scene of this environment.
    pub fn scene(&self) -> &Scene {
        self.episode().scene()
    }

    /// The true state of the robot.
    pub fn state(&self) -> &State {
        self.episode().state()
    }

    /// Commanded joint torques of the last control step in N m (mean over its physics steps, before delay
    /// and motor).
    pub fn torque(&self) -> &[f64] {
        self.episode().torque()
    }

    /// Signals for the kinds, after the last control step.
    pub fn signals(&self) -> Signals<'_> {
        self.episode().signals()
    }
}
