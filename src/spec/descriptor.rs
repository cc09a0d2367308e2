//! One descriptor per kind: the single source of decoding, defaults, checks, schema, `list`, `explain` and
//! the reference pages.
//!
//! Descriptors are plain `const` data. They describe dimensions, not robots; the behaviour of a kind is next
//! to its descriptor in `kinds/`.

use std::fmt;

use crate::quantity::{Dimension, Measure};

/// An edition of the language (`spec = 1`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Edition(pub u32);

impl Edition {
    /// The first edition.
    pub const ONE: Self = Self(1);
}

/// The type of a key's value.
#[derive(Clone, Copy, Debug)]
pub enum Ty {
    /// `true` or `false`.
    Flag,
    /// A whole number: `16384`, or with a count suffix `"80 M"`, `"200 k"`.
    Count,
    /// A bare number without a dimension.
    Number,
    /// A number with a unit of this dimension, as a string.
    Quantity(Dimension),
    /// A string with a `%`: a share of a reference; `1.0` is 100 %.
    Ratio(Share),
    /// Free text (a name, a file).
    Text,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A plain quantity of this dimension, or `{ uniform = [a, b] }`, `{ normal = [mean, std] }`,
    /// `{ log_uniform = [a, b] }`, `{ choice = [...] }`.
    Sampler(Dimension),
    /// A list of items of this type.
    List(&'static Ty),
    /// A table with these keys.
    Table(&'static [Param]),
    /// A table with user-defined keys and values of this type.
    Named(&'static Ty),
    /// A table of one of these kinds, as in their section; its key `kind` selects it.
    Kind(Kinds),
    /// Named tables, each of one of these kinds, as in their section.
    Terms(Kinds),
    /// One of several types, distinguished by the shape of the TOML value (a string, a list, a table with a
    /// certain key). The first match wins.
    OneOf(&'static [Ty]),
}

/// What a ratio is a share of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// The reference: `the joint's effort limit`.
    pub of: &'static str,
    /// For keys that also take a quantity relative to the robot, which its figures turn into a share: what it
    /// measures.
    pub measure: Option<Measure>,
}

impl Share {
    /// A share of a reference, and nothing else.
    pub const fn of(of: &'static str) -> Self {
        Self { of, measure: None }
    }
}

/// The kinds of a section that are also allowed in a table of another section.
#[derive(Clone, Copy)]
pub struct Kinds {
    /// The section: `terrain`.
    pub section: &'static str,
    /// Their noun for messages: `reward term`.
    pub noun: &'static str,
    /// The kinds.
    pub all: fn() -> Vec<&'static Kind>,
}

impl fmt::Debug for Kinds {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.debug_struct("Kinds").field("section", &self.section).finish_non_exhaustive()
    }
}

/// Whether a key is required.
#[derive(Clone, Copy, Debug)]
pub enum Presence {
    /// Required (no silent physical defaults).
    Required,
    /// May be omitted; then absent.
    Optional,
    /// May be omitted; then it has this value, written as TOML.
    Default(&'static str),
}

/// How many items a list has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// At least one; an exact number is checked once the robot is known, if at all.
    Some,
    /// One for each of these.
    Each(&'static [&'static str]),
    /// One for all of these, or one for each.
    OneOrEach(&'static [&'static str]),
}

impl Length {
    /// Whether a list of this length is allowed.
    pub fn fits(self, count: usize) -> bool {
        match self {
            Self::Some => count > 0,
            Self::Each(names) => count == names.len(),
            Self::OneOrEach(names) => count == 1 || count == names.len(),
        }
    }
}

impl fmt::Display for Length {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Some => formatter.write_str("1 or more"),
            Self::Each(names) => write!(formatter, "{}", names.len()),
            Self::OneOrEach(names) => write!(formatter, "1 or {}", names.len()),
        }
    }
}

/// One key of a table.
#[derive(Clone, Copy, Debug)]
pub struct Param {
    /// The key, snake_case.
    pub name: &'static str,
    /// The type of its value.
    pub ty: Ty,
    /// Whether it is required.
    pub presence: Presence,
    /// One or two sentences for the reference page.
    pub doc: &'static str,
    /// Inclusive bounds in SI units, for a list of its items; checked as E0204.
    pub range: Option<(f64, f64)>,
    /// Number of items of its list, checked as E0103; any if absent.
    pub length: Option<Length>,
}

impl Param {
    /// A required key.
    pub const fn required(name: &'static str, ty: Ty) -> Self {
        Self { name, ty, presence: Presence::Required, doc: "", range: None, length: None }
    }

    /// An optional key.
    pub const fn optional(name: &'static str, ty: Ty) -> Self {
        Self { name, ty, presence: Presence::Optional, doc: "", range: None, length: None }
    }

    /// A key with a default, written as a TOML value.
    pub const fn default(name: &'static str, ty: Ty, value: &'static str) -> Self {
        Self { name, ty, presence: Presence::Default(value), doc: "", range: None, length: None }
    }

    /// The same key with a default, written as a TOML value.
    pub const fn or(mut self, value: &'static str) -> Self {
        self.presence = Presence::Default(value);
        self
    }

    /// The same key with its documentation.
    pub const fn doc(mut self, doc: &'static str) -> Self {
        self.doc = doc;
        self
    }

    /// The same key with inclusive bounds in SI units.
    pub const fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    /// The same key with the number of items of its list.
    pub const fn length(mut self, length: Length) -> Self {
        self.length = Some(length);
        self
    }
}

/// A quantity that a kind reads from the simulation; a robot, task or engine may lack it (E0303).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Signal {
    /// Orientation of the base.
    BaseOrientation,
    /// Linear velocity of the base.
    BaseVelocity,
    /// Height of the base above the ground.
    BaseHeight,
    /// Joint positions and velocities.
    Joints,
    /// Commanded joint torques.
    Torque,
    /// Force of the ground on each foot.
    FootForce,
    /// Contacts of links other than the feet.
    BodyContact,
    /// Contacts between links of the robot.
    SelfCollision,
    /// A reference motion (`task.motion`).
    Reference,
    /// A contact schedule of the reference motion.
    ContactSchedule,
    /// The phase of the motion.
    Phase,
    /// A commanded speed (`task.command`).
    CommandSpeed,
    /// An obstacle on the ground (`box_obstacle`).
    Obstacle,
}

/// The keys of one kind. The behaviour is next to it, in `kinds/`.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// The word in the spec.
    pub name: &'static str,
    /// The edition that introduced it.
    pub since: Edition,
    /// Its Markdown page; the first line is the one-line summary.
    pub doc: &'static str,
    /// Its keys, beyond `kind` and `enabled` (and `weight` of a reward term).
    pub params: &'static [Param],
    /// What it reads from the simulation.
    pub needs: &'static [Signal],
}
