//! Errors of physics engines.

/// An error of an engine.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// The engine's library cannot be loaded (R0005).
    #[error("the library of engine `{engine}` cannot be used: {reason}")]
    LibraryMissing {
        /// The engine.
        engine: &'static str,
        /// The loader's message.
        reason: String,
    },
    /// The engine refused the model.
    #[error("engine `{engine}` refused the robot model: {reason}")]
    Model {
        /// The engine.
        engine: &'static str,
        /// Its reason.
        reason: String,
    },
}
