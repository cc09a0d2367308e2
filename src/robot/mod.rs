//! Robots: the model read from `robots/NAME.toml`, its checks, kinematics and gravity compensation.
//!
//! Uses nalgebra in f64 and knows no simulator.

pub mod model;

pub use model::{Collision, Foot, Joint, Link, Robot, Shape};
