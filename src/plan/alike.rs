//! Lists whose elements have much in common: what a saved plan repeats for every run is held once.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::graph::{ArmRecord, Stage};

/// How far back an element looks for one that it has something in common with: beyond the stages of an arm.
const REACH: usize = 32;

/// What can share its parts with another one.
pub trait Alike {
    /// Whether another one is of the same sort.
    fn is_like(&self, other: &Self) -> bool;

    /// Takes the parts of another one in the place of equal ones of its own.
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

/// Reads a list element by element, each sharing with the last one of its sort.
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
