//! The limit on the size of a suite.

/// Maximum number of arms, and of runs.
pub const MOST: usize = 1_000;
