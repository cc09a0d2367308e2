//! Checks a record against itself, its page and its figures.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::{Fault, Found, Place, stem, without_record};
use crate::bounded;
use crate::report::agreement::disagreements;
use crate::report::digests;
use crate::report::paths::page_folder;
use crate::report::render_command::{UNKNOWN, render_command};
use crate::report::sidecar::{RULES, Sidecar};
use crate::seal::{REMOVED, Seal};

impl Place<'_> {
    /// Checks the name, place, digest and values of a record, and its page and figures.
    pub(super) fn record(
        &self,
        record: Sidecar,
        seal: Seal,
        path: &Path,
        found: &mut Found,
        listed: &mut BTreeSet<PathBuf>,
    ) {
        let page = path.with_extension("");
        let name = stem(path);
        let again = match seal {
            Seal::Broken | Seal::Absent => None,
            Seal::Whole => render_command(&record, self.below),
        };
        let again = again.map_or_else(|| UNKNOWN.to_owned(), |command| format!("`{command}`"));
        let own = |reason: String| self.fault(&page, path, reason, without_record(&again));
        if record.report != name {
            found.faults.push(own(format!("it is the record of another page, `{}`", record.report)));
        }
        found.faults.extend(self.misplaced(&record, seal, &page, path));
        match seal {
            Seal::Whole => {
                if record.is_by_other_rules() {
                    let reason = format!(
                        "its claims were judged by version {} of the rules, and this version of specforge \
                         judges by version {RULES}",
                        record.rules
                    );
                    let fix = format!("render it again: {again}");
                    found.out_of_date.push(self.fault(&page, path, reason, fix));
                } else {
                    found.faults.extend(disagreements(&record).into_iter().map(own));
                }
                if !record.digests.contains_key(&format!("{}.md", record.report)) {
                    found.faults.push(own("it has no digest of its page".to_owned()));
                }
            }
            Seal::Broken => {
                let reason = "it was changed after it was written: it does not have its own digest";
                found.faults.push(own(reason.to_owned()));
            }
            Seal::Absent => found.faults.push(own(REMOVED.to_owned())),
        }
        let fix = format!("restore it from version control, or render it again: {again}");
        for difference in digests::differences(self.below, &record.digests) {
            let file = self.below.join(&difference.file);
            found.faults.push(self.fault(&page, &file, difference.reason, fix.clone()));
        }
        found.faults.extend(self.missing(&record, &page, &fix));
        let figures = record.items.iter().map(|item| &item.file).chain(record.digests.keys());
        listed.extend(figures.filter(|file| !file.is_empty()).map(|file| self.below.join(file)));
        found.contents.insert(self.seen(&page), content(path, &record));
        found.commands.insert(self.seen(&page), again);
        found.records.insert(self.seen(&page), record);
    }

    /// Files without a digest must exist nevertheless.
    fn missing(&self, record: &Sidecar, page: &Path, fix: &str) -> Vec<Fault> {
        let figures = record.items.iter().map(|item| item.file.clone()).filter(|file| !file.is_empty());
        let own = page.file_name().unwrap_or_default().to_string_lossy();
        let files: BTreeSet<String> = figures.chain([format!("{own}.md")]).collect();
        let without_digest = files.into_iter().filter(|file| !record.digests.contains_key(file));
        let absent = without_digest.map(|file| self.below.join(file)).filter(|file| !file.is_file());
        let reason = "it is missing, and its record is there";
        absent.map(|file| self.fault(page, &file, reason, fix.to_owned())).collect()
    }

    /// A report belongs in the folder that corresponds to its spec below `specs/`, or, with `--reports`,
    /// directly in the folder of reports.
    fn misplaced(&self, record: &Sidecar, seal: Seal, page: &Path, path: &Path) -> Option<Fault> {
        let home = record
            .request
            .specs
            .first()
            .map(|spec| page_folder(spec))
            .filter(|home| !home.as_os_str().is_empty())?;
        let here = self.below.strip_prefix(self.folder).unwrap_or(Path::new(""));
        (!here.as_os_str().is_empty() && here != home).then(|| {
            let command = match seal {
                Seal::Broken | Seal::Absent => None,
                Seal::Whole => render_command(record, &self.folder.join(&home)),
            };
            let again = command.map_or_else(|| UNKNOWN.to_owned(), |command| format!("`{command}`"));
            let home = home.display();
            let reason = format!("it is the record of a page in `{home}/`, where its spec has it");
            let fix = format!(
                "restore it from version control, or move page, record and figures to `{home}/`; {again} writes \
                 the report where it belongs"
            );
            self.fault(page, path, reason, fix)
        })
    }
}

/// The digest of a record's content.
fn content(path: &Path, record: &Sidecar) -> String {
    let text = bounded::text(path, bounded::RECORD).unwrap_or_else(|_| record.to_json());
    crate::seal::of(&text).unwrap_or_default()
}
