//! What checks of many specs have in common: the vocabulary, and what was read once.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::reference::References;
use crate::kinds::vocabulary::vocabulary;
use crate::robot::Robot;
use crate::spec::{Gathered, LoadOptions, Loaded, Vocabulary};
use crate::syntax::Files;

/// Checks many specs, and reads a robot that they share once. What it keeps changes no result: a robot
/// without findings is known by its whole text.
#[derive(Clone, Debug)]
pub struct Checker {
    pub(super) vocabulary: Vocabulary,
    /// The specs read since [`Checker::remember_specs`].
    pub(super) specs: Option<Specs>,
    pub(super) robots: BTreeMap<File, Robot>,
    pub(super) references: References<(File, File)>,
}

/// Specs that were read.
#[derive(Clone, Debug, Default)]
pub(super) struct Specs {
    read: BTreeMap<PathBuf, Gathered>,
    /// Baselines, loaded without a profile and without assignments.
    pub baselines: BTreeMap<PathBuf, Arc<Loaded>>,
}

/// The name and the text of a file.
pub(super) type File = (String, Arc<str>);

impl Default for Checker {
    fn default() -> Self {
        Self {
            vocabulary: vocabulary(),
            specs: None,
            robots: BTreeMap::new(),
            references: References::default(),
        }
    }
}

impl Checker {
    /// From now on, until this is called again, each spec is read once, however often it is checked: under
    /// each of its profiles, or because others compare themselves with it.
    pub fn remember_specs(&mut self) {
        self.specs = Some(Specs::default());
    }

    /// Loads a spec, which may have been read before.
    pub(super) fn load(&mut self, files: &dyn Files, path: &Path, options: &LoadOptions) -> Loaded {
        let read = || Gathered::read(files, path, &options.allow_outside, &self.vocabulary);
        match &mut self.specs {
            Some(specs) => {
                specs.read.entry(path.to_owned()).or_insert_with(read).load(files, options, &self.vocabulary)
            }
            None => read().load(files, options, &self.vocabulary),
        }
    }
}
