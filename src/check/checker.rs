//! State shared by the checks of many specs: the vocabulary, and a cache of files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::attached::{File, Robots};
use super::once::Once;
use super::reference::References;
use super::simulated::Known;
use crate::kinds::vocabulary::vocabulary;
use crate::spec::{Gathered, LoadOptions, Loaded, Vocabulary};
use crate::syntax::Files;

/// Checks many specs and reads shared robots once. The cache does not affect results: a robot without
/// findings is identified by its whole text. Clones share it, so that threads can check specs side by side.
#[derive(Clone, Debug)]
pub struct Checker {
    pub(super) vocabulary: Vocabulary,
    /// The specs read since [`Checker::remember_specs`].
    pub(super) specs: Option<Specs>,
    pub(super) robots: Robots,
    pub(super) references: References<(File, File)>,
    pub(super) simulated: Known,
}

/// Specs read so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Specs {
    read: Once<PathBuf, Arc<Gathered>>,
    /// Baselines, loaded without a profile and without assignments.
    pub baselines: Once<PathBuf, Arc<Loaded>>,
}

impl Default for Checker {
    fn default() -> Self {
        Self {
            vocabulary: vocabulary(),
            specs: None,
            robots: Robots::default(),
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

    /// The names of a spec's profiles; none if it has a mistake that hides them.
    pub fn profiles(&self, files: &dyn Files, path: &Path, options: &LoadOptions) -> Arc<[String]> {
        self.gathered(files, path, options).profiles()
    }

    /// Loads a spec, possibly from the cache.
    pub(super) fn load(&self, files: &dyn Files, path: &Path, options: &LoadOptions) -> Loaded {
        self.gathered(files, path, options).load(files, options, &self.vocabulary)
    }

    fn gathered(&self, files: &dyn Files, path: &Path, options: &LoadOptions) -> Arc<Gathered> {
        let read = || Arc::new(Gathered::read(files, path, &options.allow_outside, &self.vocabulary));
        match &self.specs {
            Some(specs) => specs.read.get(path.to_owned(), read),
            None => read(),
        }
    }
}
