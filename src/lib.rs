//! specforge: a compiler for robot-learning experiments.
//!
//! The modules stand in the order of the pipeline, which is also the only direction in which they
//! may import: a module uses those above it, never those below (`tests/layering.rs`).

pub mod allocation;
pub mod bounded;
pub mod crash;
pub mod escape;
pub mod safe_fs;

pub mod diag;
pub mod finite;
pub mod quantity;
pub mod syntax;

pub mod spec;
pub mod stream;

pub mod outcome;

pub mod robot;

pub mod sim;

pub mod kinds;

pub mod statistics;

pub mod format;
pub mod schema;

pub mod check;

pub mod scaffold;

pub mod plan;

pub mod seal;

pub mod control;

pub mod env;

pub mod learn;

pub mod evaluate;

pub mod deploy;

pub mod exec;

pub mod report;

pub mod study;

pub mod cli;
