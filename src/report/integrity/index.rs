//! Checks the index of a folder: it must be unchanged and agree with the current records.

use std::path::Path;

use super::{Found, Place, mark};
use crate::bounded;
use crate::report::index::FILE;
use crate::report::index::mark::Flaw;

impl Place<'_> {
    /// Compares the index of this folder with its own digest and with the records in and below it.
    pub(super) fn index(&self, found: &mut Found) {
        let path = self.below.join(FILE);
        let Ok(text) = bounded::text(&path, bounded::RECORD) else { return };
        let here = self.below.strip_prefix(self.folder).unwrap_or(Path::new(""));
        let below = found.contents.iter().filter_map(|(name, content)| {
            let name = Path::new(name).strip_prefix(here).ok()?;
            Some((name.display().to_string(), content.clone()))
        });
        let (place, reason) = match mark::flaw(&text, &below.collect()) {
            None => return,
            Some(Flaw::Changed(reason)) => (&mut found.unwritten, reason),
            Some(Flaw::OutOfDate) => {
                let reason =
                    "it is out of date: it was written from other records than those that are here now";
                (&mut found.out_of_date, reason)
            }
        };
        let fix = format!("`{}` writes it again", self.index_command());
        place.push(self.fault(&path.with_extension(""), &path, reason, fix));
    }
}
