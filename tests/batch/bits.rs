//! The same bits under every instruction set, in every lane, whatever the other lanes hold.

use specforge::robot::Robot;
use specforge::sim::batch::{Batch, Set};
use specforge::sim::{Contacts, State, Terrain};

use super::lab::{Drive, Driver, SETTINGS, bar, field, standing};
use super::robots::{decorated, drawn, shipped};

/// Steps of a motion.
const STEPS: usize = 60;

/// A robot's motion: the bits of its states and forces.
fn bits(state: &State, contacts: &Contacts) -> Vec<u64> {
    let base =
        [&state.base_position[..], &state.base_velocity, &state.base_rate, &state.base_orientation].concat();
    let joints = state.position.iter().chain(&state.velocity);
    let forces = contacts.foot_force.iter().flatten();
    base.iter()
        .chain(joints)
        .chain(forces)
        .map(|value| value.to_bits())
        .chain([u64::from(contacts.body)])
        .collect()
}

/// Moves robots in the lanes of one group, each by its own driver, and gives the bits of each.
fn moved(set: Set, robots: &[(Robot, Drive, String)], terrain: &Terrain) -> Vec<Vec<u64>> {
    let mut worlds = Batch::slots(set, robots.len());
    let mut all: Vec<(State, Driver, Vec<u64>)> = Vec::new();
    for (lane, (robot, drive, name)) in robots.iter().enumerate() {
        let state = standing(robot, 0.03);
        worlds.place(lane, robot, terrain, &SETTINGS, &state).expect("it fits");
        all.push((state, Driver::new(robot, *drive, name), Vec::new()));
    }
    for _ in 0..STEPS {
        for (lane, ((robot, ..), (state, driver, _))) in robots.iter().zip(&mut all).enumerate() {
            worlds.apply(lane, &driver.torque(robot, state));
        }
        worlds.advance();
        for (lane, (state, _, bits_of)) in all.iter_mut().enumerate() {
            worlds.read(lane, state);
            bits_of.extend(bits(state, &worlds.contacts(lane)));
        }
    }
    all.into_iter().map(|(.., bits)| bits).collect()
}

fn case(robot: &Robot, number: usize) -> (Robot, Drive, String) {
    let drive = if number.is_multiple_of(2) { Drive::Servo } else { Drive::Random };
    (robot.clone(), drive, format!("bits/{}/{number}", robot.name))
}

/// Every robot by itself in scalar arithmetic, then in groups of every width, in two orders and with others
/// beside it.
fn assert_equal_bits(robots: &[(Robot, Drive, String)], terrain: &Terrain) {
    let alone: Vec<Vec<u64>> = robots
        .iter()
        .map(|robot| moved(Set::Scalar, std::slice::from_ref(robot), terrain).remove(0))
        .collect();
    for set in Set::available() {
        let lanes = set.lanes();
        for order in [(0..robots.len()).collect::<Vec<_>>(), (0..robots.len()).rev().collect()] {
            for chunk in order.chunks(lanes) {
                let group: Vec<_> = chunk.iter().map(|index| robots[*index].clone()).collect();
                for (index, bits) in chunk.iter().zip(moved(set, &group, terrain)) {
                    let first = bits.iter().zip(&alone[*index]).position(|(a, b)| a != b);
                    assert_eq!(first, None, "{set:?}, {} beside {chunk:?}", robots[*index].2);
                }
            }
        }
    }
}

#[test]
fn every_instruction_set_and_every_company_gives_equal_bits() {
    assert!(Set::available().len() > 1, "this machine has no AVX2: nothing is compared");
    for robot in shipped() {
        for terrain in [Terrain::Flat, Terrain::Slope { angle: -0.2 }, bar(), field()] {
            let robots: Vec<_> = (0..8).map(|number| case(&robot, number)).collect();
            assert_equal_bits(&robots, &terrain);
        }
    }
}

#[test]
fn robots_of_other_figures_beside_each_other_give_equal_bits() {
    let robots: Vec<_> = (0..8).map(|number| case(&drawn("tocabi", number), number)).collect();
    assert_equal_bits(&robots, &Terrain::Flat);
    let robots: Vec<_> = (0..8).map(|number| case(&decorated("g1"), number)).collect();
    for terrain in [Terrain::Flat, bar(), field()] {
        assert_equal_bits(&robots, &terrain);
    }
}

#[test]
fn robots_of_other_trees_and_grounds_share_the_slots_and_move_as_alone() {
    let mut worlds = Batch::slots(Set::Scalar, 3);
    let robots = shipped();
    let grounds = [Terrain::Flat, Terrain::Slope { angle: 0.1 }, Terrain::Flat];
    // Every slot holds every robot once.
    for turn in 0..3 {
        for slot in 0..3 {
            let robot = &robots[(slot + turn) % 3];
            let start = standing(robot, 0.0);
            worlds.place(slot, robot, &grounds[slot], &SETTINGS, &start).expect("it takes the robot");
        }
        let mut states = vec![State::default(); 3];
        for _ in 0..20 {
            (0..3).for_each(|slot| worlds.apply(slot, &vec![1.0; robots[(slot + turn) % 3].joints()]));
            worlds.advance();
        }
        for slot in 0..3 {
            worlds.read(slot, &mut states[slot]);
            let robot = &robots[(slot + turn) % 3];
            let engine = specforge::sim::open("batch").expect("it is built in");
            let start = standing(robot, 0.0);
            let mut alone =
                engine.build(robot, &grounds[slot], &SETTINGS, &start).expect("it takes the robot");
            (0..20).for_each(|_| alone.step(&vec![1.0; robot.joints()]));
            let mut state = State::default();
            alone.read(&mut state);
            assert_eq!(states[slot], state, "turn {turn}, slot {slot}");
        }
    }
}
