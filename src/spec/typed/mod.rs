//! Typed keys: one declaration gives a key's documentation, its type in the spec language and its type in
//! Rust.
//!
//! `keys!` declares the keys of a table as a struct, `kind!` those of a kind, `choice!` the words that a key
//! takes and `either!` a value with several forms; `section!` collects the kinds of a section.
//! A declaration generates the [`Param`]s for the decoder, the checks, the schema and the reference pages,
//! the struct that the rest of the program uses, and a [`Key`] for each key, for looking up single values and
//! their places. Keys that are not declared do not compile.

mod macros;
mod types;

use std::marker::PhantomData;

pub(crate) use macros::{choice, either, key_attribute, keys, kind, reference, section, terms};
pub use types::{
    HasKinds, Named, Plain, Quantified, Ratio, RawKind, RawTerms, Reference, Sampled, SectionKinds, Unit,
    units,
};

use super::{Kind, Param, Presence, Section, Table, Ty, Value, decode};

/// A type of the spec language and its type in Rust.
pub trait Typed {
    /// Its type in Rust, in SI units.
    type Value;
    /// The type when the key is present: itself, or the inner type of an optional one.
    type Present: Typed;
    /// Its type in the spec language.
    const TY: Ty;
    /// The same as a reference, for nested types.
    const TY_REF: &'static Ty = &Self::TY;
    /// Whether it is required. A default is an attribute of the key.
    const PRESENCE: Presence = Presence::Required;
    /// Converts a decoded value; `None` if it has another type.
    fn read(value: &Value) -> Option<Self::Value>;
    /// The value of an absent key; `None` if that is an error.
    fn absent() -> Option<Self::Value> {
        None
    }
}

/// A key of one declaration.
pub struct Key<Owner, T> {
    /// The name of the key, snake_case.
    pub name: &'static str,
    types: PhantomData<fn() -> (Owner, T)>,
}

impl<Owner, T> Key<Owner, T> {
    /// The key of this name. Only the macros call this.
    pub const fn new(name: &'static str) -> Self {
        Self { name, types: PhantomData }
    }

    /// Its path below a table: `reward.torque.k`.
    pub fn below(self, table: &str) -> String {
        super::marks::below(table, self.name)
    }
}

impl<Owner: InSection, T> Key<Owner, T> {
    /// Its path: `learn.samples`.
    pub fn path(self) -> String {
        self.below(Owner::SECTION)
    }
}

impl<Owner, T> Clone for Key<Owner, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<Owner, T> Copy for Key<Owner, T> {}

/// The keys of a table as a struct.
pub trait Keys: Sized {
    /// Its keys.
    const PARAMS: &'static [Param];
    /// The struct of a decoded table; `None` if a key is missing or of another type, which decoding rules
    /// out.
    fn of_table(table: &Table) -> Option<Self>;
}

/// Keys that belong to one section, whose name is part of their paths.
pub trait InSection {
    /// The section: `learn`.
    const SECTION: &'static str;
}

/// A whole section as a Rust type.
pub trait Part: InSection + Sized {
    /// The section of a decoded table; `None` if a key is missing or of another type, which decoding rules
    /// out.
    fn of_section(section: Section) -> Option<Self>;
}

/// A kind: its descriptor, and its keys as a struct.
pub trait Declared: Keys {
    /// Its descriptor.
    const KIND: &'static Kind;
}

impl Param {
    /// A key of a declared type.
    pub const fn of<T: Typed>(name: &'static str) -> Self {
        Self { name, ty: T::TY, presence: T::PRESENCE, doc: "", range: None, length: None }
    }
}

impl<'a> Section<'a> {
    /// The value of a key; `None` if it is absent and has no default.
    pub fn value<Owner, T: Typed>(self, key: Key<Owner, T>) -> Option<T::Value> {
        T::read(self.table().get(key.name)?)
    }

    /// Whether the key has a value.
    pub fn holds<Owner, T>(self, key: Key<Owner, T>) -> bool {
        self.table().contains_key(key.name)
    }

    /// The keys of the table as a struct.
    ///
    /// # Panics
    /// If a key is missing or of another type. Decoding checks both, so that is a bug in specforge.
    pub fn read<K: Keys>(self) -> K {
        K::of_table(self.table())
            .unwrap_or_else(|| panic!("decoding promised the keys of {}", std::any::type_name::<K>()))
    }

    /// The section of a declaration, given a view of the whole spec.
    pub fn within<Owner: InSection>(self) -> Option<Section<'a>> {
        self.section(Owner::SECTION)
    }

    /// The value of a key in its section, given a view of the whole spec.
    pub fn at<Owner: InSection, T: Typed>(self, key: Key<Owner, T>) -> Option<T::Value> {
        self.within::<Owner>()?.value(key)
    }

    /// Whether the table is of this kind.
    pub fn is<K: Declared>(self) -> bool {
        self.kind() == Some(K::KIND.name)
    }

    /// A section, given a view of the whole spec; `None` if the section or one of its keys is missing, as in
    /// a stage that declares only a part of it.
    pub fn part<P: Part>(self) -> Option<P> {
        P::of_section(self.section(P::SECTION)?)
    }

    /// A view of the table that a key holds.
    pub fn below<Owner, T>(self, key: Key<Owner, T>) -> Option<Section<'a>> {
        match self.table().get(key.name)? {
            Value::Table(table) => Some(Section::new(table)),
            _ => None,
        }
    }
}

/// The section of a declaration, to be changed, in the values of a whole spec.
pub fn section_mut<Owner: InSection>(fields: &mut Table) -> Option<&mut Table> {
    fields.get_mut(Owner::SECTION)?.as_table_mut()
}

/// Reads one key of a table. Only the macros call this. A missing key, as in the recipe of a stage or in a
/// policy of an earlier version, has its default if there is one.
pub fn read_key<T: Typed>(table: &Table, name: &str, params: &'static [Param]) -> Option<T::Value> {
    if let Some(value) = table.get(name) {
        return T::read(value);
    }
    let param = params.iter().find(|param| param.name == name)?;
    match param.presence {
        Presence::Default(_) => T::read(&decode::default_value(param)?),
        Presence::Required | Presence::Optional => T::absent(),
    }
}

/// The name of a key from the identifier that declares it: `move` is declared as `r#move`. Only the macros
/// call this.
pub const fn key_name(identifier: &'static str) -> &'static str {
    match identifier.as_bytes() {
        [b'r', b'#', ..] => identifier.split_at(2).1,
        _ => identifier,
    }
}

/// Total number of keys of the lists. Only the macros call this.
pub const fn count(lists: &[&[Param]]) -> usize {
    let (mut list, mut count) = (0, 0);
    while list < lists.len() {
        count += lists[list].len();
        list += 1;
    }
    count
}

/// Joins lists of keys. Only the macros call this.
pub const fn join<const COUNT: usize>(lists: &[&[Param]]) -> [Param; COUNT] {
    let mut all = [Param::required("", Ty::Flag); COUNT];
    let (mut list, mut count) = (0, 0);
    while list < lists.len() {
        let mut index = 0;
        while index < lists[list].len() {
            all[count] = lists[list][index];
            count += 1;
            index += 1;
        }
        list += 1;
    }
    all
}

/// Imports for files with declarations.
#[allow(unused_imports, reason = "no file needs all of it, and builds differ in the files that they have")]
pub(crate) mod prelude {
    pub use super::units::*;
    pub use super::{
        Declared, HasKinds, InSection, Key, Keys, Named, Part, Quantified, Ratio, RawKind, RawTerms, Sampled,
        SectionKinds,
    };
    pub(crate) use super::{choice, either, keys, kind, reference, section, terms};
    pub use crate::spec::Length;
}

#[cfg(test)]
pub(crate) mod sample {
    use super::SectionKinds;
    use crate::diag::{Sink, Sources};
    use crate::spec::{Section, decode};

    /// A section of a kind, from its text.
    pub fn part<S: SectionKinds>(text: &str) -> S {
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        let source = sources.add("part.toml", text);
        let decoded = decode::document_of_kind(&sources, source, &(S::KINDS.all)(), &mut sink);
        let decoded = decoded.unwrap_or_else(|| panic!("{text}: {:?}", sink.diagnostics));
        S::of_section(Section::new(&decoded.table)).expect("a decoded section")
    }
}

#[cfg(test)]
mod tests;
