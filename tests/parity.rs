//! The parity suite: the same robots in every engine, quantity by quantity, and `docs/reference/parity.md`.
//!
//! Every quantity is measured once; a test holds the bounds of its rows, and the page shows the same rows.
//! `SPECFORGE_BLESS=1 cargo test --test parity` writes the page again.

#![cfg(all(feature = "batch", feature = "rapier", feature = "mujoco"))]

#[path = "parity/biped.rs"]
mod biped;
#[path = "parity/defects.rs"]
mod defects;
#[path = "parity/flight.rs"]
mod flight;
#[path = "parity/ground.rs"]
mod ground;
#[path = "parity/inertia.rs"]
mod inertia;
#[path = "parity/lab.rs"]
mod lab;
#[path = "parity/laws.rs"]
mod laws;
#[path = "parity/page.rs"]
mod page;
#[path = "parity/replay.rs"]
mod replay;
#[path = "parity/stance.rs"]
mod stance;
#[path = "parity/table.rs"]
mod table;
#[path = "parity/touch.rs"]
mod touch;

use std::sync::LazyLock;

use specforge::robot::Robot;
use table::Row;

/// The rows of every robot in one part of the suite.
type Part = LazyLock<Vec<(String, Vec<Row>)>>;

fn measured(rows: fn(&Robot) -> Vec<Row>) -> Vec<(String, Vec<Row>)> {
    lab::robots().iter().map(|robot| (robot.name.clone(), rows(robot))).collect()
}

static INERTIA: Part = LazyLock::new(|| measured(inertia::rows));
static TOUCH: Part = LazyLock::new(|| measured(touch::rows));
static FLIGHT: Part = LazyLock::new(|| measured(flight::rows));
static STANCE: Part = LazyLock::new(|| measured(stance::rows));
static GROUND: Part = LazyLock::new(|| measured(ground::rows));
static REPLAY: Part = LazyLock::new(|| measured(replay::rows));

/// Drops of the shipped robots with every setting of contact.
static STIFFNESS: LazyLock<Vec<(String, Vec<ground::Impact>)>> = LazyLock::new(|| {
    let shipped = specforge::robot::names().filter_map(specforge::robot::shipped);
    shipped.map(|robot| (robot.name.clone(), ground::stiffness(&robot))).collect()
});

/// Fails with every row whose bound does not hold.
fn assert_holds(part: &Part) {
    let broken: Vec<String> = part
        .iter()
        .flat_map(|(robot, rows)| {
            rows.iter().filter(|row| !row.holds()).map(move |row| format!("{robot}: {row:?}"))
        })
        .collect();
    assert!(broken.is_empty(), "out of bounds:\n{}", broken.join("\n"));
}

#[test]
fn masses_inertias_axes_and_gravity_are_the_models() {
    assert_holds(&INERTIA);
}

#[test]
fn soles_touch_the_ground_where_the_kinematics_has_them() {
    assert_holds(&TOUCH);
}

#[test]
fn robots_in_the_air_move_alike_and_keep_their_momentum() {
    assert_holds(&FLIGHT);
}

#[test]
fn torques_at_rest_are_those_of_statics_in_double_and_single_support() {
    assert_holds(&STANCE);
}

#[test]
fn feet_slip_where_coulomb_says_and_land_in_time() {
    assert_holds(&GROUND);
}

#[test]
fn torques_of_one_engine_move_the_robot_of_the_other_alike_for_a_while() {
    assert_holds(&REPLAY);
}

#[test]
fn with_a_contact_time_of_5_ms_the_peaks_of_mujoco_are_those_of_rapier() {
    for (robot, impacts) in STIFFNESS.iter() {
        let peak = |contact: ground::Contact| {
            impacts[ground::CONTACTS.iter().position(|other| *other == contact).unwrap()].mean
        };
        let own = peak(("rapier", 0.002, None));
        for (contact, low, high) in [
            (("MuJoCo", 0.002, Some(0.005)), 0.9, 1.1),
            (("MuJoCo", 0.0005, Some(0.005)), 0.85, 1.2),
            (("MuJoCo", 0.002, None), 0.4, 0.75),
        ] {
            let ratio = peak(contact) / own;
            assert!((low..high).contains(&ratio), "{robot}: the peak of {contact:?} is {ratio} of rapier's");
        }
    }
}

#[test]
fn the_page_of_the_parity_suite_shows_these_figures() {
    let parts: [&Part; 6] = [&INERTIA, &TOUCH, &FLIGHT, &STANCE, &GROUND, &REPLAY];
    let rows = |index: usize| parts.iter().flat_map(|part| part[index].1.clone()).collect();
    let tables: Vec<(String, Vec<Row>)> =
        INERTIA.iter().enumerate().map(|(index, (robot, _))| (robot.clone(), rows(index))).collect();
    page::assert_blessed(&page::text(&tables, &STIFFNESS));
}
