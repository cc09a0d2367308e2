//! Semantic rules, one file each. No simulator, no libtorch.
