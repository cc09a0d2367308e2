//! Finds files without a record: pages, figures, figures and policies that no record lists, and copies of
//! reports.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::{Fault, Found, Place, markdown, record_of, stem, without_record};
use crate::bounded;
use crate::escape::xml;
use crate::report::index::FILE;
use crate::report::listing;
use crate::report::paths::page_folder;
use crate::report::policies;
use crate::report::render_command::UNKNOWN;

/// A sentence at the end of pages by the shipped templates.
const RENDERED: &str = "Rendered by specforge ";

/// A line above their table of stages.
const STAGES: &str = "<summary>Stages and their fingerprints</summary>";

/// The beginning of a figure's metadata.
const FIGURE: &str = "<metadata>{\"report\":";

/// File extensions of pictures.
const PICTURES: [&str; 7] = ["svg", "png", "jpg", "jpeg", "gif", "webp", "pdf"];

impl Place<'_> {
    /// Finds specforge pages without a record. Other Markdown files are ignored.
    pub(super) fn pages_without_record(&self, found: &mut Found) {
        for path in listing::files(self.below, "md") {
            let page = path.with_extension("");
            let is_index = path.file_name().is_some_and(|name| name.eq_ignore_ascii_case(FILE));
            if is_index || record_of(&page).symlink_metadata().is_ok() {
                continue;
            }
            let text = bounded::text(&path, bounded::RECORD).unwrap_or_default();
            let is_ours = [RENDERED, STAGES].iter().any(|mark| text.contains(mark));
            if is_ours || self.figures_of(&page).next().is_some() {
                let reason = "it is the page of a report, and its record is missing";
                found.faults.push(self.fault(&page, &path, reason, without_record(UNKNOWN)));
            }
        }
    }

    /// Finds specforge figures without page and record.
    pub(super) fn figures_without_report(&self, found: &mut Found) {
        if self.below == self.folder || self.has_report() {
            return;
        }
        for file in self.figures_of(self.below) {
            let reason = "it is the figure of a report, and page and record are missing";
            let fix =
                format!("restore them from version control, render them again ({UNKNOWN}), or delete it");
            found.faults.push(self.fault(self.below, &file, reason, fix));
        }
    }

    /// Whether this folder holds a report's figures.
    fn has_report(&self) -> bool {
        let has = |file: PathBuf| file.symlink_metadata().is_ok();
        has(markdown(self.below)) || has(record_of(self.below))
    }

    /// Finds pictures that no record lists: any picture in a report's folder of figures or next to pages,
    /// elsewhere only those whose metadata name a report.
    pub(super) fn unlisted_figures(&self, listed: &BTreeSet<PathBuf>, found: &mut Found) {
        // An unreadable or missing record, which is already reported, hides which figures it lists.
        let is_known = self.below == self.folder || found.records.contains_key(&self.seen(self.below));
        if self.has_report() && !is_known {
            return;
        }
        let has_pages = || {
            listing::files(self.below, "json").iter().any(|path| markdown(&path.with_extension("")).is_file())
        };
        let is_of_reports = self.below != self.folder && self.has_report() || has_pages();
        let known: BTreeSet<&str> = found.faults.iter().map(|fault| fault.file.as_str()).collect();
        let mut strays = Vec::new();
        for file in PICTURES.into_iter().flat_map(|ending| listing::files(self.below, ending)) {
            if listed.contains(&file)
                || known.contains(self.seen(&file).as_str())
                || !(is_of_reports || is_figure(&file))
            {
                continue;
            }
            let reason = "it is not a figure of any report here: no record lists it";
            let page = if self.has_report() { self.below.to_owned() } else { file.with_extension("") };
            let again = found.commands.get(&self.seen(&page)).map_or(UNKNOWN, String::as_str);
            let fix = format!(
                "delete it, or restore the record that lists it from version control; {again} renders the \
                 figures of the report"
            );
            strays.push(self.fault(&page, &file, reason, fix));
        }
        found.faults.extend(strays);
    }

    /// Finds policies beside a page that no record lists.
    pub(super) fn unlisted_policies(&self, listed: &BTreeSet<PathBuf>, found: &mut Found) {
        let Some(page) = self.below.parent().filter(|_| policies::is_folder(self.below)) else { return };
        let Some(again) = found.commands.get(&self.seen(page)) else { return };
        let files = listing::files(self.below, "safetensors").into_iter();
        let strays = files.filter(|file| !listed.contains(file)).map(|file| {
            let reason = "it is not a policy of this report: no record lists it";
            let fix = format!(
                "delete it, or restore the record that lists it from version control; {again} copies the \
                 policies of the report"
            );
            self.fault(page, &file, reason, fix)
        });
        found.faults.extend(strays.collect::<Vec<_>>());
    }

    /// The figures in a page's folder whose metadata name this page.
    fn figures_of<'p>(&self, page: &'p Path) -> impl Iterator<Item = PathBuf> + use<'p> {
        let name = serde_json::Value::from(stem(&markdown(page))).to_string();
        let mark = format!("{FIGURE}{}", xml::text(&name));
        let is_own =
            move |path: &PathBuf| bounded::text(path, bounded::RECORD).is_ok_and(|text| text.contains(&mark));
        listing::files(page, "svg").into_iter().filter(is_own)
    }
}

/// Whether a file is a figure of some report, by its metadata.
pub fn is_figure(path: &Path) -> bool {
    bounded::text(path, bounded::RECORD).is_ok_and(|text| text.contains(FIGURE))
}

/// Finds duplicate reports. The one in the folder of its spec is the original.
pub(super) fn copies(found: &mut Found) {
    let mut places: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (name, content) in &found.contents {
        places.entry(content).or_default().push(name);
    }
    let mut copies = Vec::new();
    for names in places.into_values().filter(|names| names.len() > 1) {
        let folder = |name: &str| Path::new(name).parent().unwrap_or(Path::new("")).to_owned();
        let is_home = |name: &&&str| {
            let spec = found.records.get(**name).and_then(|record| record.request.specs.first());
            spec.is_some_and(|spec| page_folder(spec) == folder(name))
        };
        let own = names.iter().find(is_home).copied();
        for name in names.iter().filter(|name| Some(**name) != own) {
            let other =
                own.or_else(|| names.iter().find(|other| *other != name).copied()).unwrap_or_default();
            copies.push(Fault {
                report: (*name).to_owned(),
                file: format!("{name}.json"),
                reason: format!("it is the same record as that of `{other}`: one of the reports is a copy"),
                fix: format!(
                    "delete page, record and figures of the copy, or restore both from version control; {} \
                     writes the report where it belongs",
                    found.commands.get(other).map_or(UNKNOWN, String::as_str)
                ),
            });
        }
    }
    found.faults.retain(|fault| {
        !copies.iter().any(|copy| copy.file == fault.file && fault.reason.contains("a page in"))
    });
    found.faults.extend(copies);
}
