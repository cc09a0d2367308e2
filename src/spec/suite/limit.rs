//! The limit on the size of a suite.

/// More arms are a mistake, and so are more runs.
pub const MOST: usize = 1_000;
