//! Specs: descriptors of what may be written, values that were written, and where they came from.

pub mod descriptor;
pub mod value;

pub use descriptor::{Edition, Kind, Param, Presence, Signal, Ty};
pub use value::{Quantity, Sampler, Section, Table, Value};
