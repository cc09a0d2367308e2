//! Single steps of the batch engine and of MuJoCo from the states of a motion.

use specforge::robot::Robot;
use specforge::sim::{Contacts, State, Terrain, open};

use super::lab::{Drive, SETTINGS, recorded};
use super::oracle::Oracle;

/// Accelerations and contacts of a step of the batch engine.
fn ours(
    robot: &Robot,
    terrain: &Terrain,
    state: &State,
    torque: &[f64],
    push: [f64; 3],
) -> (Vec<f64>, Contacts) {
    let engine = open("batch").expect("it is built in");
    let mut world = engine.build(robot, terrain, &SETTINGS, state).expect("it takes the robot");
    world.push(push);
    world.step(torque);
    let mut after = State::default();
    world.read(&mut after);
    let all = |state: &State| [&state.base_velocity[..], &state.base_rate[..], &state.velocity[..]].concat();
    let change = all(&after).iter().zip(all(state)).map(|(a, b)| (a - b) / SETTINGS.step).collect();
    (change, world.contacts())
}

/// Differences of a motion's steps.
pub struct Differences {
    /// Of accelerations, relative to the largest one of the step, sorted.
    pub relative: Vec<f64>,
    /// Largest one of foot forces in N.
    pub force: f64,
    /// Steps in which one engine has the body on the ground and the other has not.
    pub body: usize,
    /// Steps in which something touches the ground.
    pub touching: usize,
}

/// The steps of 1.2 s of a motion, every second one, each second of them with a push.
pub fn differences(robot: &Robot, terrain: &Terrain, drive: Drive) -> Differences {
    let mut oracle = Oracle::new(robot, terrain, &SETTINGS);
    let mut found = Differences { relative: Vec::new(), force: 0.0, body: 0, touching: 0 };
    for (number, (state, torque)) in
        recorded("mujoco", robot, terrain, drive, 600).into_iter().enumerate().step_by(2)
    {
        let push = if number.is_multiple_of(4) { [80.0, -50.0, 30.0] } else { [0.0; 3] };
        let (ours, our_contacts) = ours(robot, terrain, &state, &torque, push);
        let (theirs, their_contacts) = oracle.step(&state, &torque, push);
        let scale = theirs.iter().fold(1.0, |most: f64, value| most.max(value.abs()));
        let error = ours.iter().zip(&theirs).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        found.relative.push(error / scale);
        for (own, other) in
            our_contacts.foot_force.iter().flatten().zip(their_contacts.foot_force.iter().flatten())
        {
            found.force = found.force.max((own - other).abs());
        }
        found.body += usize::from(our_contacts.body != their_contacts.body);
        let forces = their_contacts.foot_force.iter().flatten();
        found.touching += usize::from(their_contacts.body || forces.copied().any(|force| force != 0.0));
    }
    found.relative.sort_by(f64::total_cmp);
    found
}

impl Differences {
    /// The smallest difference that a share of the steps is below.
    pub fn at(&self, share: f64) -> f64 {
        self.relative[(share * (self.relative.len() - 1) as f64) as usize]
    }
}
