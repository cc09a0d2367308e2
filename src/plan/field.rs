//! The fields of a spec that a stage reads, by the declarations of their keys.

use crate::spec::section::Header;
use crate::spec::typed::{InSection, Key};
use crate::spec::value::KIND;
use crate::spec::{Table, Value};

/// A section of a spec or one key in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Names of the tables around it, from the outside, and its own; the first `depth` count.
    names: [&'static str; 3],
    depth: usize,
}

impl Field {
    /// A whole section.
    pub const fn section<S: InSection>() -> Self {
        Self { names: [S::SECTION, "", ""], depth: 1 }
    }

    /// The kind of a section.
    pub const fn kind<S: InSection>() -> Self {
        Self { names: [S::SECTION, KIND, ""], depth: 2 }
    }

    /// A key of a section.
    pub const fn key<S: InSection, T>(key: Key<S, T>) -> Self {
        Self { names: [S::SECTION, key.name, ""], depth: 2 }
    }

    /// A key of a table in a section.
    pub const fn within<S: InSection, T, Inner, U>(table: Key<S, T>, key: Key<Inner, U>) -> Self {
        Self { names: [S::SECTION, table.name, key.name], depth: 3 }
    }

    /// A key of the spec's header.
    pub const fn header<T>(key: Key<Header, T>) -> Self {
        Self { names: [key.name, "", ""], depth: 1 }
    }

    fn names(&self) -> &[&'static str] {
        &self.names[..self.depth]
    }

    /// Its own name.
    pub const fn name(self) -> &'static str {
        self.names[self.depth - 1]
    }

    /// Its dotted path: `learn.value.privileged`.
    pub fn path(self) -> String {
        self.names().join(".")
    }

    /// Whether a path is the field's own or lies below it.
    pub fn covers(self, path: &str) -> bool {
        let mut parts = path.split('.');
        self.names().iter().all(|name| parts.next() == Some(name))
    }

    /// Copies its value, if there is one.
    pub fn copy(self, from: &Table, to: &mut Table) {
        copy(self.names(), from, to);
    }
}

fn copy(names: &[&str], from: &Table, to: &mut Table) {
    let Some((name, rest)) = names.split_first() else { return };
    let Some(value) = from.get(*name) else { return };
    if rest.is_empty() {
        to.insert((*name).to_owned(), value.clone());
        return;
    }
    let Value::Table(inner) = value else { return };
    let mut copied = match to.remove(*name) {
        Some(Value::Table(table)) => table,
        _ => Table::new(),
    };
    copy(rest, inner, &mut copied);
    if !copied.is_empty() {
        to.insert((*name).to_owned(), Value::Table(copied));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::learn::Ppo;
    use crate::kinds::learn::ppo::Critic;

    #[test]
    fn a_field_covers_its_own_path_and_those_below_it() {
        let value = Field::key(Ppo::value);
        assert_eq!(value.path(), "learn.value");
        assert!(value.covers("learn.value") && value.covers("learn.value.privileged"));
        assert!(!value.covers("learn") && !value.covers("learn.values"));
        assert_eq!(Field::within(Ppo::value, Critic::privileged).path(), "learn.value.privileged");
    }

    #[test]
    fn fields_of_one_section_are_copied_side_by_side() {
        let table = |pairs: &[(&str, Value)]| -> Table {
            pairs.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect()
        };
        let value = table(&[("privileged", Value::Flag(true)), ("coefficient", Value::Count(1))]);
        let learn =
            table(&[("seed", Value::Count(3)), ("epochs", Value::Count(4)), ("value", Value::Table(value))]);
        let spec = table(&[("learn", Value::Table(learn))]);
        let mut copied = Table::new();
        for field in
            [Field::within(Ppo::value, Critic::privileged), Field::key(Ppo::seed), Field::key(Ppo::backend)]
        {
            field.copy(&spec, &mut copied);
        }
        let value = Value::Table(table(&[("privileged", Value::Flag(true))]));
        let learn = Value::Table(table(&[("seed", Value::Count(3)), ("value", value)]));
        assert_eq!(copied, table(&[("learn", learn)]));
    }
}
