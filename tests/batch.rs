//! The batch engine against MuJoCo, whose model it has, and against itself under every instruction set.

#![cfg(all(feature = "batch", feature = "mujoco"))]

#[path = "batch/bits.rs"]
mod bits;
#[path = "batch/differences.rs"]
mod differences;
#[path = "batch/lab.rs"]
mod lab;
#[path = "batch/motion.rs"]
mod motion;
#[path = "batch/one_step.rs"]
mod one_step;
#[path = "batch/oracle.rs"]
mod oracle;
#[path = "batch/robots.rs"]
mod robots;
