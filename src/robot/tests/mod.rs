//! Tests of the robots that come with specforge.

mod gravity;
mod kinematics;
mod model;
mod reader;

pub(crate) use reader::{robot, table};
