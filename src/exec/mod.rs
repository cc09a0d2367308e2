//! Execution: the store, the scheduler, events, interruption and resume.
