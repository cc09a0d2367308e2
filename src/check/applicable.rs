//! Which assignments of the command line apply to a spec that another one is compared with. `--set` applies to
//! the spec that was named; a compared spec takes only the values whose keys it has.

use std::path::Path;

use super::Checker;
use crate::diag::Severity;
use crate::spec::LoadOptions;
use crate::syntax::Files;
use crate::syntax::assign::SET;

impl Checker {
    /// The options for a compared spec: those of the named one without the assignments that this spec has no
    /// key for, or none of this kind of value. Semantic mistakes in the others are left to the checks.
    pub fn applicable(&mut self, files: &dyn Files, path: &Path, options: &LoadOptions) -> LoadOptions {
        let mut options = options.clone();
        while !options.sets.is_empty() {
            let loaded = self.load(files, path, &options);
            let errors = loaded.sink.diagnostics.iter().filter(|found| found.severity == Severity::Error);
            let places = errors.filter_map(|found| found.labels.first());
            let sources = places.map(|label| loaded.sources.get(label.span.source));
            let refused = sources.filter(|source| source.name == Path::new(SET.option));
            let refused: Vec<String> = refused.map(|source| source.text.to_string()).collect();
            let before = options.sets.len();
            options.sets.retain(|set| !refused.contains(set));
            if options.sets.len() == before {
                break;
            }
        }
        options
    }
}
