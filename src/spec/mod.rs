//! Specs: descriptors of the language, decoded values and their origins.

pub mod allow;
mod body;
pub mod bounds;
pub mod claim;
pub mod decode;
pub mod descriptor;
pub mod experiment;
pub mod family;
pub mod folder;
pub mod load;
pub mod marks;
pub mod mistake;
pub mod origin;
pub mod profiles;
pub mod project;
pub mod reach;
mod requires;
pub mod section;
pub mod sets;
pub mod suggest;
pub mod suite;
pub mod synonyms;
pub mod typed;
pub mod value;

pub use claim::Claim;
pub use decode::{Decoded, Decoder};
pub use descriptor::{Edition, Kind, Kinds, Length, Param, Presence, Share, Signal, Ty};
pub use experiment::{Attachment, Experiment, LoadOptions, Loaded, NamedSpec};
pub use load::{Gathered, load, load_in};
pub use marks::{Mark, Marks};
pub use origin::Origin;
pub use reach::Reach;
pub use section::{Embedded, SectionShape, Shape, Vocabulary};
pub use value::{Quantity, Sampler, Section, Table, Value};

#[cfg(test)]
mod tests;
