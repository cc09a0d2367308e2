//! The decoded fields of an arm by section: the runs of a suite share all sections but the one with the
//! learning seed.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::shared::Shared;
use super::suite;
use crate::spec::{Table, Value};

/// The section that holds the learning seed.
const SEEDED: &str = "learn";

/// The fields of an arm. Serialized and compared like its table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Sections(BTreeMap<String, Shared<Value>>);

impl From<&Table> for Sections {
    fn from(table: &Table) -> Self {
        Self(table.iter().map(|(key, value)| (key.clone(), value.clone().into())).collect())
    }
}

impl Sections {
    /// The same fields with another learning seed; everything else is shared.
    pub fn seeded(&self, seed: u64) -> Self {
        let mut sections = self.clone();
        let own = suite::seeded(&self.only(&[SEEDED]), seed);
        sections.0.extend(own.into_iter().map(|(key, value)| (key, value.into())));
        sections
    }

    /// Shares every section that is equal in another one.
    pub fn share(&mut self, other: &Self) {
        for (key, own) in &mut self.0 {
            if let Some(others) = other.0.get(key) {
                own.share(others);
            }
        }
    }

    /// A section, or a value outside any section.
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.0.get(key).map(|value| &**value)
    }

    /// These sections alone, as far as they exist.
    pub fn only(&self, keys: &[&str]) -> Table {
        keys.iter().filter_map(|key| Some(((*key).to_owned(), self.get(key)?.clone()))).collect()
    }

    /// All fields.
    pub fn table(&self) -> Table {
        self.0.iter().map(|(key, value)| (key.clone(), (**value).clone())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_share_every_section_but_the_one_with_the_seed_and_are_written_as_their_tables() {
        let section =
            |key: &str, value: u64| Value::Table(Table::from([(key.to_owned(), Value::Count(value))]));
        let table = Table::from([
            ("action".to_owned(), section("delay", 4)),
            ("learn".to_owned(), section("seed", 1)),
            ("name".to_owned(), Value::Text("run".into())),
        ]);
        let arm = Sections::from(&table);
        let run = arm.seeded(7);
        assert_eq!((arm.table(), run.table()), (table.clone(), suite::seeded(&table, 7)));
        let is_shared =
            |key: &str| std::ptr::eq(arm.get(key).expect("it is there"), run.get(key).expect("it is there"));
        assert_eq!(["action", "name", "learn"].map(is_shared), [true, true, false]);
        let text = serde_json::to_string(&run).expect("plain data");
        assert_eq!(text, serde_json::to_string(&run.table()).expect("plain data"));
        assert_eq!(serde_json::from_str::<Sections>(&text).expect("it was just written"), run);
        assert_eq!(arm.only(&["learn", "none"]), Table::from([("learn".to_owned(), section("seed", 1))]));
    }
}
