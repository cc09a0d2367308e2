//! Specs: descriptors of what may be written, values that were written, and where they came from.

pub mod decode;
pub mod descriptor;
pub mod marks;
pub mod suggest;
pub mod value;

pub use decode::{Decoded, Decoder};
pub use descriptor::{Edition, Kind, Param, Presence, Signal, Ty};
pub use marks::{Mark, Marks};
pub use value::{Quantity, Sampler, Section, Table, Value};
