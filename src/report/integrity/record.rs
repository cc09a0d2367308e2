//! Checks a record against itself, its page and its figures.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::{Fault, Found, Place, Unverifiable, markdown, stem, without_record};
use crate::bounded;
use crate::report::claim::disagreements;
use crate::report::digests::{self, Digests};
use crate::report::earlier;
use crate::report::paths::page_folder;
use crate::report::render_command::{UNKNOWN, render_command};
use crate::report::sidecar::{RULES, Sidecar};
use crate::seal::{REMOVED, Seal};

impl Place<'_> {
    /// Checks the name, place, digest and values of a record, and its page and figures.
    pub(super) fn record(
        &self,
        record: Sidecar,
        seal: &Seal,
        path: &Path,
        found: &mut Found,
        listed: &mut BTreeSet<PathBuf>,
    ) {
        let page = path.with_extension("");
        let name = stem(path);
        let again = match seal {
            Seal::Broken | Seal::Absent => None,
            Seal::Whole | Seal::Earlier(_) => render_command(&record, self.below),
        };
        let again = again.map_or_else(|| UNKNOWN.to_owned(), |command| format!("`{command}`"));
        let own = |reason: String| self.fault(&page, path, reason, without_record(&again));
        if record.report != name {
            found.faults.push(own(format!("it is the record of another page, `{}`", record.report)));
        }
        found.faults.extend(self.misplaced(&record, seal, &page, path));
        let digests = record.digests_by(seal);
        match seal {
            Seal::Whole => {
                found.faults.extend(claims(&record).into_iter().map(own));
                if !digests.contains_key(&format!("{}.md", record.report)) {
                    found.faults.push(own("it has no digest of its page".to_owned()));
                }
            }
            Seal::Broken => {
                let reason = "it was changed after it was written: it does not have its own digest";
                found.faults.push(own(reason.to_owned()));
            }
            Seal::Absent => found.faults.push(own(REMOVED.to_owned())),
            Seal::Earlier(_) => {
                let reason = "the record is of before records had a digest of themselves";
                found.unverifiable.push(Unverifiable { report: self.seen(&page), reason });
            }
        }
        let fix = format!("restore it from version control, or render it again: {again}");
        for difference in digests::differences(self.below, &digests) {
            let file = self.below.join(&difference.file);
            found.faults.push(self.fault(&page, &file, difference.reason, fix.clone()));
        }
        found.faults.extend(self.missing(&record, &digests, &page, &fix));
        let figures = record.items.iter().map(|item| &item.file).chain(digests.keys());
        listed.extend(figures.filter(|file| !file.is_empty()).map(|file| self.below.join(file)));
        self.notice(&record, &page, &fix, found);
        found.contents.insert(self.seen(&page), content(path, &record));
        found.commands.insert(self.seen(&page), again);
        found.records.insert(self.seen(&page), record);
    }

    /// Files without a digest must exist nevertheless.
    fn missing(&self, record: &Sidecar, digests: &Digests, page: &Path, fix: &str) -> Vec<Fault> {
        let figures = record.items.iter().map(|item| item.file.clone()).filter(|file| !file.is_empty());
        let own = page.file_name().unwrap_or_default().to_string_lossy();
        let files: BTreeSet<String> = figures.chain([format!("{own}.md")]).collect();
        let without_digest = files.into_iter().filter(|file| !digests.contains_key(file));
        let absent = without_digest.map(|file| self.below.join(file)).filter(|file| !file.is_file());
        let reason = "it is missing, and its record is there";
        absent.map(|file| self.fault(page, &file, reason, fix.to_owned())).collect()
    }

    /// A report belongs in the folder that corresponds to its spec below `specs/`, or, with `--reports`,
    /// directly in the folder of reports.
    fn misplaced(&self, record: &Sidecar, seal: &Seal, page: &Path, path: &Path) -> Option<Fault> {
        let home =
            record.specs.first().map(|spec| page_folder(spec)).filter(|home| !home.as_os_str().is_empty())?;
        let here = self.below.strip_prefix(self.folder).unwrap_or(Path::new(""));
        (!here.as_os_str().is_empty() && here != home).then(|| {
            let command = match seal {
                Seal::Broken | Seal::Absent => None,
                Seal::Whole | Seal::Earlier(_) => render_command(record, &self.folder.join(&home)),
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

    /// Pages judged by earlier rules must have the notice, and no other page may have it.
    fn notice(&self, record: &Sidecar, page: &Path, fix: &str, found: &mut Found) {
        let file = markdown(page);
        let Ok(text) = bounded::text(&file, bounded::RECORD) else { return };
        match (record.is_by_earlier_rules(), text.lines().any(|line| line == earlier::NOTICE)) {
            (true, false) => {
                let reason = "it does not say that it was judged by earlier rules";
                let fix = format!("`{}` writes that sentence below its title", self.index_command());
                found.unwritten.push(self.fault(page, &file, reason, fix));
            }
            (false, true) => {
                let reason = "it says that it was judged by earlier rules, and its record does not";
                found.faults.push(self.fault(page, &file, reason, fix.to_owned()));
            }
            (true, true) | (false, false) => {}
        }
    }
}

/// What is wrong with the claims of an unchanged record.
fn claims(record: &Sidecar) -> Vec<String> {
    match record.rules > RULES {
        true => {
            let rules = record.rules;
            vec![format!(
                "it was judged by rules {rules}, and this version of specforge knows those up to {RULES}"
            )]
        }
        false => disagreements(record),
    }
}

/// The digest of a record's content.
fn content(path: &Path, record: &Sidecar) -> String {
    let text = bounded::text(path, bounded::RECORD).unwrap_or_else(|_| record.to_json());
    crate::seal::of(&text).unwrap_or_default()
}
