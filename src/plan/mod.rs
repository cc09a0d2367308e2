//! Lowering a checked experiment to the dataflow graph. No simulator, no libtorch.
