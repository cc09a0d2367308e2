//! State shared by the checks of many specs: the vocabulary, and a cache of files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::reference::References;
use super::simulated::Known;
use crate::kinds::vocabulary::vocabulary;
use crate::robot::Robot;
use crate::spec::{Gathered, LoadOptions, Loaded, Vocabulary};
use crate::syntax::Files;

/// Checks many specs and reads shared robots once. The cache does not affect results: a robot without
/// findings is identified by its whole text.
#[derive(Clone, Debug)]
pub struct Checker {
    pub(super) vocabulary: Vocabulary,
    /// The specs read since [`Checker::remember_specs`].
    pub(super) specs: Option<Specs>,
    pub(super) robots: BTreeMap<File, Robot>,
    pub(super) references: References<(File, File)>,
    pub(super) simulated: Known,
}

/// Specs read so far.
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
            simulated: Known::default(),
        }
    }
}

impl Checker {
    /// From this call until the next, each spec is read once, however often it is checked: under each of its
    /// profiles, or as a baseline of others.
    pub fn remember_specs(&mut self) {
        self.specs = Some(Specs::default());
    }

    /// Loads a spec, possibly from the cache.
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
