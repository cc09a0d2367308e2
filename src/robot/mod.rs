//! Robots: the model read from `robots/NAME.toml`, its checks, kinematics, support polygon and gravity
//! compensation.
//!
//! Uses nalgebra in f64 and a geometry library for collisions, but no simulator.

pub mod checks;
pub mod examine;
pub mod feet;
pub mod file;
pub mod gravity;
pub mod import;
pub mod kinematics;
pub mod legs;
pub mod load;
pub mod model;
pub mod proportions;
pub mod selector;
pub mod self_collision;
pub mod solid;
pub mod stated;
pub mod stretch;
pub mod summary;
pub mod support;
pub mod symmetry;
pub mod urdf;

#[cfg(test)]
pub(crate) mod tests;

pub use checks::Issue;
pub use file::from_table;
pub use gravity::{Balance, GravityCompensation, Weighting, felt_gravity};
pub use kinematics::{GRAVITY, Kinematics};
pub use legs::{Leg, hip_height, leg_length};
pub use load::{diagnostic, load, read, shipped};
pub use model::{Body, Collision, Foot, Joint, Link, Robot, Shape};
pub use proportions::Proportions;
pub use self_collision::SelfCollision;
pub use support::Support;

/// The robots embedded in specforge: name and text of the file.
static EMBEDDED: [(&str, &str); 3] = [
    ("atlas", include_str!("../../robots/atlas.toml")),
    ("g1", include_str!("../../robots/g1.toml")),
    ("tocabi", include_str!("../../robots/tocabi.toml")),
];

/// The text of an embedded robot file.
pub fn embedded(name: &str) -> Option<&'static str> {
    EMBEDDED.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The names of the embedded robots, sorted.
pub fn names() -> impl Iterator<Item = &'static str> {
    EMBEDDED.iter().map(|(name, _)| *name)
}
