//! The schemas of robot files and of motion files, which have no parents and must be complete.

use serde_json::Value;

use super::table::{self, Keys, Place};
use super::{Definitions, finished};
use crate::kinds::motion;
use crate::robot::file;

/// The schema of a robot file.
pub fn robot() -> Value {
    let mut definitions = Definitions::new(Keys::All);
    let body = table::plain(file::PARAMS, Keys::All, &mut definitions);
    finished("specforge robot, edition 1", "A robot: its links, joints, limits and feet.", body, definitions)
}

/// The schema of a motion file.
pub fn motion() -> Value {
    let mut definitions = Definitions::new(Keys::All);
    let kinds = motion::kinds();
    let place = Place { name: "motion", noun: "motion", kinds: &kinds, extra: &[], switched: false };
    let mut body = place.of_any_kind(&mut definitions);
    let demand = place.complete(None, &mut definitions);
    if let Some(branches) = body["allOf"].as_array_mut() {
        branches.push(demand);
    }
    let text = "A reference motion, made for the robot that a spec names.";
    finished("specforge motion, edition 1", text, body, definitions)
}
