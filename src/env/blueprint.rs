//! The blueprint of an environment: decoded fields, robot and motion, and the checks that need all three.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::interface::Sizes;
use super::observation::{Observation, is_mirrored};
use super::privileged;
use crate::control::Law;
use crate::kinds::action::{Action, PhaseAction, Position, Torque};
use crate::kinds::initial::Initial;
use crate::kinds::learn::Ppo;
use crate::kinds::learn::ppo::Critic;
use crate::kinds::motion::{Frame, MIRROR_TOLERANCE, Motion};
use crate::kinds::observe::Observations;
use crate::kinds::physics::Physics;
use crate::kinds::reward::Rewards;
use crate::kinds::task::Task;
use crate::kinds::terrain::Ground;
use crate::kinds::terrain::height_field::{self, SizeError};
use crate::robot::Robot;
use crate::sim::{EngineError, EngineName};
use crate::spec::typed::{InSection, Part, section_mut};
use crate::spec::{Quantity, Section, Table, Value};

/// Standard deviation of the phase action: a tenth of its range, as in the authors' code.
const PHASE_DEVIATION: f64 = 0.1;

/// Everything that defines an environment except the engine: the artefact of the stage `env`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Blueprint {
    /// The decoded fields `physics terrain task initial observe reward terminate randomize action learn`,
    /// of `learn` only `symmetry` and `value.privileged`.
    pub fields: Table,
    /// The nominal robot.
    pub robot: Robot,
    /// The reference motion.
    pub motion: Option<Motion>,
}

/// Why a blueprint cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum BlueprintError {
    /// A section, or a key that it needs, is missing.
    #[error("the spec has no complete section [{0}]")]
    Missing(&'static str),
    /// A rate is not the physics rate divided by a whole number.
    #[error("{what} of {rate} Hz does not divide the physics rate of {physics} Hz")]
    Rate {
        /// Which rate.
        what: String,
        /// Its value in Hz.
        rate: f64,
        /// The physics rate in Hz.
        physics: f64,
    },
    /// The motion was made for another robot.
    #[error("the motion `{motion}` moves {found} joints, the robot has {expected}")]
    Joints {
        /// Name of the motion.
        motion: String,
        /// Joints of the motion.
        found: usize,
        /// Joints of the robot.
        expected: usize,
    },
    /// `phase_mirror` with a motion that is not its own mirror image half a cycle later.
    #[error(
        "learn.symmetry = \"phase_mirror\" needs a motion that is its own mirror image half a cycle later; \
         `{motion}` differs by {difference:.3} rad: use \"none\""
    )]
    Asymmetric {
        /// Name of the motion.
        motion: String,
        /// Largest difference of a joint in rad.
        difference: f64,
    },
    /// The ground is a height field of an impossible size.
    #[error(transparent)]
    Field(#[from] SizeError),
    /// The motion has values that no robot can follow.
    #[error("the motion `{motion}` cannot be followed: {flaw}")]
    Motion {
        /// Name of the motion.
        motion: String,
        /// What is wrong with it.
        flaw: String,
    },
    /// The engine refused the environment.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

impl Blueprint {
    /// A checked blueprint.
    pub fn new(fields: Table, robot: Robot, motion: Option<Motion>) -> Result<Self, BlueprintError> {
        let blueprint = Self { fields, robot, motion };
        blueprint.check()?;
        Ok(blueprint)
    }

    /// The same environment at another physics rate in Hz, for transfer to a finer engine.
    pub fn with_physics(&self, rate: f64) -> Result<Self, BlueprintError> {
        let mut blueprint = self.clone();
        if let Some(physics) = section_mut::<Physics>(&mut blueprint.fields) {
            physics.insert(
                Physics::rate.name.into(),
                Value::Quantity(Quantity { si: rate, text: format!("{rate} Hz") }),
            );
        }
        blueprint.check()?;
        Ok(blueprint)
    }

    /// The same environment on another decoded `[terrain]`.
    pub fn with_terrain(&self, terrain: Table) -> Result<Self, BlueprintError> {
        let mut blueprint = self.clone();
        blueprint.fields.insert("terrain".into(), Value::Table(terrain));
        blueprint.check()?;
        Ok(blueprint)
    }

    /// A section of the fields; [`Blueprint::new`] guarantees those that every environment needs.
    pub fn section(&self, name: &'static str) -> Section<'_> {
        Section::new(&self.fields).section(name).expect("checked when the blueprint was made")
    }

    /// A decoded section; [`Blueprint::new`] guarantees those that every environment needs.
    pub fn part<P: Part>(&self) -> P {
        Section::new(&self.fields).part().expect("checked when the blueprint was made")
    }

    /// What the policy commands.
    pub fn action(&self) -> Action {
        self.part()
    }

    /// Physics rate in Hz.
    pub fn physics_rate(&self) -> f64 {
        self.section(Physics::SECTION).value(Physics::rate).expect("a spec has a physics rate")
    }

    /// Control rate in Hz.
    pub fn control_rate(&self) -> f64 {
        self.action().rate()
    }

    /// Name of the training engine.
    pub fn engine(&self) -> &'static str {
        let section = self.section(Physics::SECTION);
        section.value(Physics::engine).unwrap_or(EngineName::Rapier).word()
    }

    /// Time limit of an episode in s.
    pub fn episode(&self) -> f64 {
        self.part::<Task>().episode()
    }

    /// Phases at which an episode may start standing, at least one. Evaluations use them in turn.
    pub fn starts(&self) -> Vec<f64> {
        let initial: Initial = self.part();
        if initial.phases().is_empty() { vec![0.0] } else { initial.phases().to_vec() }
    }

    /// Layout and normalisation of the policy's inputs.
    pub fn observation(&self) -> Observation {
        Observation::new(&self.fields, &self.robot)
    }

    /// The low-level law.
    pub fn law(&self) -> Law {
        Law::new(&self.action(), &self.robot)
    }

    /// Whether the last action advances the phase.
    pub fn modulates_phase(&self) -> bool {
        self.action().phase_modulation()
    }

    /// Relative increase of the phase's speed at a phase action of 1; `None` without a phase action.
    pub fn phase_gain(&self) -> Option<f64> {
        let action = self.action();
        action.phase_modulation().then(|| phase_gain(&action, self.motion.as_ref()))
    }

    /// Standard deviation of the exploration noise, one number per action.
    pub fn deviations(&self) -> Vec<f64> {
        let mut deviations = vec![self.law().deviation(); self.robot.joints()];
        deviations.extend(self.modulates_phase().then_some(PHASE_DEVIATION));
        deviations
    }

    /// Whether the critic has privileged inputs.
    pub fn is_privileged(&self) -> bool {
        let learn = Section::new(&self.fields).within::<Ppo>();
        let critic = learn.and_then(|learn| learn.below(Ppo::value));
        critic.and_then(|critic| critic.value(Critic::privileged)).unwrap_or(false)
    }

    /// Lengths of the vectors.
    pub fn sizes(&self) -> Sizes {
        let observation = self.observation().len();
        let extra = if self.is_privileged() { privileged::COUNT } else { 0 };
        let action = self.robot.joints() + usize::from(self.modulates_phase());
        Sizes { observation, privileged: observation + extra, action }
    }

    /// The reference motion; without one, standing in the default pose.
    pub fn reference(&self) -> Cow<'_, Motion> {
        match &self.motion {
            Some(motion) => Cow::Borrowed(motion),
            None => Cow::Owned(standing(&self.robot)),
        }
    }

    pub(super) fn check(&self) -> Result<(), BlueprintError> {
        let spec = Section::new(&self.fields);
        let sections = [
            (Physics::SECTION, spec.at(Physics::rate).is_some()),
            (Ground::SECTION, spec.part::<Ground>().is_some()),
            (Task::SECTION, spec.part::<Task>().is_some()),
            (Initial::SECTION, spec.part::<Initial>().is_some()),
            (Observations::SECTION, spec.within::<Observations>().is_some()),
            (Rewards::SECTION, spec.within::<Rewards>().is_some()),
            (Action::SECTION, spec.part::<Action>().is_some()),
        ];
        if let Some((name, _)) = sections.into_iter().find(|(_, is_whole)| !is_whole) {
            return Err(BlueprintError::Missing(name));
        }
        self.has_a_ground()?;
        self.divides(&Torque::rate.path(), self.control_rate())?;
        if let Some(rate) = self.law().servo_rate() {
            self.divides(&Position::servo_rate.path(), rate)?;
        }
        match &self.motion {
            Some(motion) => self.fits(motion),
            None => Ok(()),
        }
    }

    fn has_a_ground(&self) -> Result<(), BlueprintError> {
        if let Ground::HeightField(field) = self.part() {
            height_field::check_size(field.cell, field.length, field.width)?;
        }
        Ok(())
    }

    fn divides(&self, what: &str, rate: f64) -> Result<(), BlueprintError> {
        let physics = self.physics_rate();
        let ratio = physics / rate;
        if ratio < 0.5 || (ratio - ratio.round()).abs() > 1e-6 {
            return Err(BlueprintError::Rate { what: what.to_owned(), rate, physics });
        }
        Ok(())
    }

    fn fits(&self, motion: &Motion) -> Result<(), BlueprintError> {
        let expected = self.robot.joints();
        if let Some(frame) = motion.samples.iter().find(|frame| frame.position.len() != expected) {
            let (motion, found) = (motion.name.clone(), frame.position.len());
            return Err(BlueprintError::Joints { motion, found, expected });
        }
        motion.check().map_err(|flaw| BlueprintError::Motion { motion: motion.name.clone(), flaw })?;
        let difference = motion.asymmetry(&self.robot.mirror);
        if is_mirrored(Section::new(&self.fields)) && difference > MIRROR_TOLERANCE {
            return Err(BlueprintError::Asymmetric { motion: motion.name.clone(), difference });
        }
        Ok(())
    }
}

/// The motion of a robot standing in its default pose.
fn standing(robot: &Robot) -> Motion {
    let still = vec![0.0; robot.joints()];
    let frame = Frame {
        position: robot.default_pose(),
        velocity: still.clone(),
        acceleration: still,
        base_height: robot.standing_height,
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        contact: [true; 2],
        ..Frame::default()
    };
    Motion { name: "stand".into(), period: STANDING_CYCLE, speed: 0.0, samples: vec![frame] }
}

/// Duration in s of the phase's cycle for a standing robot without a reference motion.
const STANDING_CYCLE: f64 = 2.0;

/// Duration of a cycle of the phase in s.
pub fn cycle(motion: Option<&Motion>) -> f64 {
    motion.map_or(STANDING_CYCLE, |motion| motion.period)
}

/// Relative increase of the phase's speed at a phase action of 1, from `action.phase_action`.
pub fn phase_gain(action: &Action, motion: Option<&Motion>) -> f64 {
    let share = action.phase_action() == PhaseAction::Share;
    motion.filter(|_| share).map_or(1.0, |motion| motion.period)
}
