//! Deployment: the exported policy with its contract, and transfer to another engine.
