//! Grounds and recorded motions for the tests of the batch engine.

use specforge::robot::Robot;
use specforge::sim::{EngineSettings, State, Terrain, World, open};
use specforge::stream::Stream;

pub const SETTINGS: EngineSettings = EngineSettings { step: 0.002, friction: 0.8, contact_time: None };

pub fn standing(robot: &Robot, lift: f64) -> State {
    State {
        base_position: [0.0, 0.0, robot.standing_height + lift],
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        position: robot.default_pose(),
        velocity: vec![0.0; robot.joints()],
        ..State::default()
    }
}

pub fn field() -> Terrain {
    let mut stream = Stream::new("test/batch/field");
    let heights = (0..31 * 31).map(|_| 0.03 * stream.uniform()).collect();
    Terrain::HeightField { cell: 0.1, counts: [31, 31], heights }
}

pub fn bar() -> Terrain {
    Terrain::BoxObstacle { centre: 0.1, half_length: 0.03, half_width: 4.0, height: 0.02 }
}

/// How the torques of a motion are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// At random within the effort limits.
    Random,
    /// The robot's position control towards targets that change every 50 ms.
    Servo,
}

pub struct Driver {
    stream: Stream,
    drive: Drive,
    target: Vec<f64>,
    step: usize,
}

impl Driver {
    pub fn new(robot: &Robot, drive: Drive, name: &str) -> Self {
        let stream = Stream::new(&format!("test/batch/{name}"));
        Self { stream, drive, target: robot.default_pose(), step: 0 }
    }

    pub fn torque(&mut self, robot: &Robot, state: &State) -> Vec<f64> {
        if self.step.is_multiple_of(25) {
            for (target, home) in self.target.iter_mut().zip(robot.default_pose()) {
                *target = home + 0.2 * self.stream.normal();
            }
        }
        self.step += 1;
        let mut torques = Vec::with_capacity(robot.joints());
        for (index, joint) in robot.links.iter().map(|link| &link.joint).enumerate() {
            let torque = match self.drive {
                Drive::Random => 0.5 * self.stream.normal() * joint.effort_limit,
                Drive::Servo => {
                    let pull = joint.stiffness_gain * (self.target[index] - state.position[index]);
                    pull - joint.damping_gain * state.velocity[index]
                }
            };
            torques.push(torque.clamp(-joint.effort_limit, joint.effort_limit));
        }
        torques
    }
}

/// States and torques of a motion in an engine.
pub fn recorded(
    engine: &str,
    robot: &Robot,
    terrain: &Terrain,
    drive: Drive,
    steps: usize,
) -> Vec<(State, Vec<f64>)> {
    let mut state = standing(robot, 0.04);
    let engine = open(engine).expect("it is built in");
    let mut world: Box<dyn World> =
        engine.build(robot, terrain, &SETTINGS, &state).expect("it takes the robot");
    let mut driver = Driver::new(robot, drive, &robot.name);
    let mut states = Vec::with_capacity(steps);
    for _ in 0..steps {
        let torque = driver.torque(robot, &state);
        states.push((state.clone(), torque.clone()));
        world.step(&torque);
        world.read(&mut state);
    }
    states
}
