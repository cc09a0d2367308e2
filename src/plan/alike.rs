//! Lists whose elements have much in common: parts that a saved plan repeats for every run are stored in
//! memory once.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::graph::{ArmRecord, Stage};

/// Number of preceding elements that are searched for equal parts: more than the stages of an arm.
const REACH: usize = 32;

/// A value that can share its parts with another one.
pub trait Alike {
    /// Whether the other value is of the same sort.
    fn is_like(&self, other: &Self) -> bool;

    /// Replaces own parts with equal ones of the other value.
    fn share(&mut self, other: &Self);
}

impl Alike for ArmRecord {
    fn is_like(&self, _: &Self) -> bool {
        true
    }

    fn share(&mut self, other: &Self) {
        self.fields.share(&other.fields);
        self.origins.share(&other.origins);
    }
}

impl Alike for Stage {
    fn is_like(&self, other: &Self) -> bool {
        self.kind == other.kind
    }

    fn share(&mut self, other: &Self) {
        self.fields.share(&other.fields);
        self.origins.share(&other.origins);
        self.recipe.fields.share(&other.recipe.fields);
        self.recipe.content.share(&other.recipe.content);
    }
}

/// Deserializes a list element by element, each sharing parts with the last one of its sort.
pub fn list<'de, D, T>(deserializer: D) -> Result<Vec<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de> + Alike,
{
    struct List<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de> + Alike> Visitor<'de> for List<T> {
        type Value = Vec<T>;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str("a list")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Vec<T>, A::Error> {
            let mut list: Vec<T> = Vec::new();
            while let Some(mut next) = sequence.next_element::<T>()? {
                if let Some(like) = list.iter().rev().take(REACH).find(|earlier| earlier.is_like(&next)) {
                    next.share(like);
                }
                list.push(next);
            }
            Ok(list)
        }
    }

    deserializer.deserialize_seq(List(PhantomData))
}
