//! Publishes a report: copies its page, record, figures and policies out of the store to where people read them, all or
//! none.
//!
//! Everything is first written to a hidden folder, so a full disk changes nothing. Then the old page is
//! removed, figures and record are swapped, and the new page comes last: a page is never next to figures or a
//! record of another run. If a kill interrupts this, the next publication recovers.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::edits;
use super::integrity::is_figure;
use super::policies;
use super::sidecar::Sidecar;
use crate::bounded;
use crate::exec::StoreError;
use crate::exec::lock::{self, Lock, Wait};
use crate::exec::manifest::{self, Manifest};
use crate::safe_fs;

/// A file of a report with its path in the folder of reports.
struct Copy {
    path: String,
    bytes: Vec<u8>,
}

/// A published report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Publication {
    /// The path of its page, `NAME.md`.
    pub page: PathBuf,
    /// Copies of files of the earlier report that were edited by hand.
    pub kept: Vec<PathBuf>,
}

impl Publication {
    /// What to tell the user about the copies.
    pub fn warnings(&self) -> impl Iterator<Item = String> + '_ {
        self.kept.iter().map(|copy| {
            let file = copy.with_extension("");
            format!(
                "{} was edited after it was rendered: the edited file is kept as {}",
                file.display(),
                copy.display()
            )
        })
    }
}

/// A folder of reports (`reports/`), locked against other publishers for the lifetime of this value.
pub struct Publisher<'a> {
    folder: &'a Path,
    /// `None` if the file system does not support locks.
    _lock: Option<Lock>,
}

impl<'a> Publisher<'a> {
    /// Creates the folder if it is missing, and waits for its lock.
    pub fn lock(folder: &'a Path, wait: &Wait) -> Result<Self, StoreError> {
        fs::create_dir_all(folder).map_err(|error| StoreError::publishing(folder, error))?;
        Ok(Self { folder, _lock: lock::folder(folder, wait)? })
    }

    /// Copies a report's files into the folder. An identical report is left alone. Files of an earlier report
    /// that were edited by hand are copied aside first; any other file in the way is an error.
    pub fn publish(&self, artefact: &Path, name: &str) -> Result<Publication, StoreError> {
        let (folder, files) = (self.folder, read(artefact, name)?);
        let page = folder.join(format!("{name}.md"));
        let unwritten = |error| StoreError::publishing(&page, error);
        let stale = stale(folder, name, &files);
        if stale.is_empty() && files.iter().all(|file| is_there(folder, file)) {
            return Ok(Publication { page, kept: Vec::new() });
        }
        let exchange = Exchange { folder, staging: format!(".{name}.publishing"), name };
        exchange.recover().map_err(unwritten)?;
        if let Some(path) = in_the_way(folder, name, &files) {
            return Err(StoreError::Occupied { path });
        }
        exchange.stage(&files).map_err(unwritten)?;
        let is_new =
            |path: &str, bytes: &[u8]| files.iter().any(|file| file.path == path && file.bytes == bytes);
        let kept = edits::keep(folder, name, &is_new).map_err(unwritten)?;
        exchange.swap(&files, &stale).map_err(unwritten)?;
        Ok(Publication { page, kept })
    }
}

/// Locks the folder and publishes under a name; see [`Publisher::publish`].
pub fn publish(artefact: &Path, folder: &Path, name: &str) -> Result<Publication, StoreError> {
    Publisher::lock(folder, &Wait::default())?.publish(artefact, name)
}

/// The files of the artefact (page, record, figures). They must match its manifest and belong to this report.
fn read(artefact: &Path, name: &str) -> Result<Vec<Copy>, StoreError> {
    let path = artefact.join(manifest::FILE);
    let text = bounded::text(&path, bounded::RECORD)
        .map_err(|error| StoreError::Io { path: path.clone(), source: error.into() })?;
    let damaged = |reason: String| StoreError::Damaged { path: artefact.to_owned(), reason };
    let manifest = Manifest::from_text(&text).map_err(damaged)?;
    let mut files = Vec::new();
    for record in manifest.files {
        if !is_own(&record.path, name) {
            return Err(StoreError::Foreign { path: artefact.to_owned(), name: record.path });
        }
        let path = safe_fs::inside(artefact, &record.path).map_err(|error| damaged(error.to_string()))?;
        let bytes = bounded::bytes(&path, bounded::RECORD)
            .map_err(|error| StoreError::Io { path, source: error.into() })?;
        if blake3::hash(&bytes).to_hex().as_str() != record.blake3 {
            return Err(damaged(format!("the bytes of {} do not match their digest", record.path)));
        }
        files.push(Copy { path: record.path, bytes });
    }
    Ok(files)
}

/// Whether a file is a report's page or record, or lies in its folder of figures.
fn is_own(path: &str, name: &str) -> bool {
    let Some(rest) = path.strip_prefix(name).filter(|_| safe_fs::is_plain(path) && safe_fs::is_plain(name))
    else {
        return false;
    };
    rest == ".md" || rest == ".json" || rest.len() > 1 && rest.starts_with('/')
}

/// What lies where a file of the new report would be written and is not of a report: a folder, or a file that
/// is not empty, that no record lists, and that is not a figure or policy of specforge. Links are refused elsewhere.
fn in_the_way(folder: &Path, name: &str, files: &[Copy]) -> Option<PathBuf> {
    let record = Sidecar::path(folder, name);
    let earlier = Sidecar::open(&record).ok();
    let listed: BTreeSet<String> = match &earlier {
        Some((earlier, _)) => {
            let figures = earlier.items.iter().map(|item| item.file.clone());
            let page = format!("{name}.md");
            figures.chain(earlier.digests.keys().cloned()).chain([page]).collect()
        }
        None => BTreeSet::new(),
    };
    let is_ours = |file: &Copy, path: &Path| {
        let is_record = file.path == format!("{name}.json") && earlier.is_some();
        let is_output = || match policies::is_copy(&file.path) {
            true => policies::is_policy(path),
            false => is_figure(path),
        };
        is_record || listed.contains(&file.path) || is_there(folder, file) || is_output()
    };
    let occupied = |file: &Copy| {
        let path = folder.join(&file.path);
        let found = fs::symlink_metadata(&path).ok().filter(|found| !found.is_symlink())?;
        let is_free = found.is_file() && (found.len() == 0 || is_ours(file, &path));
        (!is_free).then_some(path)
    };
    files.iter().find_map(occupied)
}

/// Figures and policies in the earlier report's record that the new report lacks. Any other files in the folder of figures
/// stay.
fn stale(folder: &Path, name: &str, files: &[Copy]) -> Vec<String> {
    let Ok(earlier) = Sidecar::read(&Sidecar::path(folder, name)) else { return Vec::new() };
    let gone = |file: &String| {
        let is_figure = file.starts_with(&format!("{name}/")) && is_own(file, name);
        is_figure && !files.iter().any(|new| new.path == *file) && folder.join(file).is_file()
    };
    earlier.items.into_iter().map(|item| item.file).filter(gone).collect()
}

fn is_there(folder: &Path, file: &Copy) -> bool {
    let present =
        safe_fs::inside(folder, &file.path).and_then(|path| Ok(bounded::bytes(&path, bounded::RECORD)?));
    present.is_ok_and(|present| present == file.bytes)
}

/// The replacement of a report by a new one.
struct Exchange<'a> {
    folder: &'a Path,
    /// The hidden folder, which contains `new/` and `old/`.
    staging: String,
    name: &'a str,
}

impl Exchange<'_> {
    /// Restores the earlier report if a publication was killed during the swap, and removes its hidden
    /// folder.
    fn recover(&self) -> io::Result<()> {
        let staging = safe_fs::inside(self.folder, &self.staging)?;
        if !staging.exists() {
            return Ok(());
        }
        let (new, old) = (below(&staging.join("new"))?, below(&staging.join("old"))?);
        // If no new files are left, the swap was complete.
        if !new.is_empty() {
            for path in old {
                let target = self.target(&path)?;
                fs::rename(staging.join("old").join(&path), target)?;
            }
        }
        fs::remove_dir_all(staging)
    }

    /// Writes the new report to the hidden folder and syncs it to disk.
    fn stage(&self, files: &[Copy]) -> io::Result<()> {
        let new = safe_fs::inside(self.folder, &self.staging)?.join("new");
        let write = |file: &Copy| {
            let path = new.join(&file.path);
            fs::create_dir_all(safe_fs::folder_of(&path))?;
            let mut draft = File::create(&path)?;
            draft.write_all(&file.bytes)?;
            draft.sync_all()
        };
        let staged = files.iter().try_for_each(|file| {
            // Finds links at the target before anything is moved.
            safe_fs::inside(self.folder, &file.path)?;
            write(file)
        });
        if staged.is_err() {
            let _ = fs::remove_dir_all(self.folder.join(&self.staging));
        }
        staged
    }

    /// Swaps the reports: the old page is removed first, the new one comes last. If a step fails, all are
    /// undone.
    fn swap(&self, files: &[Copy], stale: &[String]) -> io::Result<()> {
        let staging = self.folder.join(&self.staging);
        let (old, new) = (staging.join("old"), staging.join("new"));
        let mut all: Vec<&str> = files.iter().map(|file| file.path.as_str()).collect();
        // Figures, then record, then page.
        all.sort_by_key(|path| [!path.contains('/'), path.ends_with(".md")]);
        let going = all.iter().rev().copied().chain(stale.iter().map(String::as_str));
        let mut steps: Vec<(PathBuf, PathBuf)> = Vec::new();
        let moved = self.moved(going, &old, &mut steps).and_then(|()| {
            all.iter().try_for_each(|path| {
                let step = (new.join(path), self.target(path)?);
                fs::rename(&step.0, &step.1)?;
                steps.push(step);
                Ok(())
            })
        });
        if moved.is_err() {
            for (from, to) in steps.iter().rev() {
                let _ = fs::rename(to, from);
            }
        }
        safe_fs::sync_folder(&self.folder.join(self.name));
        safe_fs::sync_folder(self.folder);
        let _ = fs::remove_dir_all(staging);
        moved
    }

    /// Moves existing files of the earlier report away.
    fn moved<'p>(
        &self,
        paths: impl Iterator<Item = &'p str>,
        old: &Path,
        steps: &mut Vec<(PathBuf, PathBuf)>,
    ) -> io::Result<()> {
        for path in paths {
            let step = (safe_fs::inside(self.folder, path)?, old.join(path));
            fs::create_dir_all(safe_fs::folder_of(&step.1))?;
            match fs::rename(&step.0, &step.1) {
                Ok(()) => steps.push(step),
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// The target of a file of the report, whose folder is created.
    fn target(&self, path: &str) -> io::Result<PathBuf> {
        let target = safe_fs::inside(self.folder, path)?;
        fs::create_dir_all(safe_fs::folder_of(&target))?;
        Ok(target)
    }
}

/// The files below a folder as relative paths; empty if it does not exist. Links are not followed.
fn below(folder: &Path) -> io::Result<Vec<String>> {
    fn walk(root: &Path, folder: &Path, found: &mut Vec<String>) -> io::Result<()> {
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            match entry.file_type()?.is_dir() {
                true => walk(root, &entry.path(), found)?,
                false => found
                    .push(entry.path().strip_prefix(root).unwrap_or(folder).to_string_lossy().into_owned()),
            }
        }
        Ok(())
    }
    let mut found = Vec::new();
    match walk(folder, folder, &mut found) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(found),
        walked => walked.map(|()| found),
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;
    use crate::plan::{Fingerprint, Recipe, Stage, StageKind};
    use crate::report::sidecar::Item;

    /// A report's artefact with these files; the record lists its figures.
    fn artefact(folder: &Path, files: &[(&str, &str)]) {
        let _ = fs::remove_dir_all(folder);
        for (path, text) in files {
            let path = folder.join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let recipe = Recipe {
            stage: "report".into(),
            epoch: 1,
            fields: serde_json::json!({}).into(),
            content: serde_json::json!({}).into(),
            inputs: Default::default(),
            numeric: Vec::new(),
        };
        let fingerprint: Fingerprint = recipe.fingerprint();
        let (fields, origins) = (crate::spec::Table::new().into(), std::collections::BTreeMap::new().into());
        let stage =
            Stage { kind: StageKind::Report, fingerprint, users: Vec::new(), fields, origins, recipe };
        let provenance = manifest::Provenance::now(Default::default());
        let manifest = Manifest::describe(folder, &stage, provenance).unwrap();
        fs::write(folder.join(manifest::FILE), manifest.to_text()).unwrap();
    }

    fn record(figures: &[&str]) -> String {
        let item = |file: &&str| Item { kind: "figure".into(), file: (*file).into(), ..Item::default() };
        Sidecar { items: figures.iter().map(item).collect(), ..Sidecar::default() }.to_json()
    }

    fn first(folder: &Path) {
        let record = record(&["walk/a.svg", "walk/b.svg", "../outside.svg", "other/c.svg"]);
        let files =
            [("walk.md", "page 1"), ("walk.json", &record), ("walk/a.svg", "a 1"), ("walk/b.svg", "b 1")];
        artefact(folder, &files);
    }

    fn second(folder: &Path) {
        artefact(
            folder,
            &[("walk.md", "page 2"), ("walk.json", &record(&["walk/a.svg"])), ("walk/a.svg", "a 2")],
        );
    }

    fn text(path: PathBuf) -> String {
        fs::read_to_string(path).unwrap_or_else(|error| error.kind().to_string())
    }

    #[test]
    fn a_report_takes_the_place_of_another_with_all_its_files_and_nothing_of_anyone_else() {
        let outer = tempfile::tempdir().unwrap();
        let (store, reports) = (outer.path().join("artefact"), outer.path().join("reports"));
        first(&store);
        assert_eq!(publish(&store, &reports, "walk").unwrap().page, reports.join("walk.md"));
        fs::write(reports.join("walk/mine.svg"), "drawn by hand").unwrap();
        fs::write(outer.path().join("outside.svg"), "not ours").unwrap();
        fs::create_dir(reports.join("other")).unwrap();
        fs::write(reports.join("other/c.svg"), "not ours").unwrap();
        second(&store);
        publish(&store, &reports, "walk").unwrap();
        let expected = [
            ("walk.md", "page 2"),
            ("walk/a.svg", "a 2"),
            ("walk/b.svg", "entity not found"),
            ("walk/mine.svg", "drawn by hand"),
            ("other/c.svg", "not ours"),
            ("../outside.svg", "not ours"),
        ];
        for (path, content) in expected {
            assert_eq!(text(reports.join(path)), content, "{path}");
        }
        assert!(!reports.join(".walk.publishing").exists());
    }

    #[test]
    fn a_file_of_somebody_else_in_place_of_any_part_of_a_report_stays_and_nothing_is_written() {
        let outer = tempfile::tempdir().unwrap();
        let store = outer.path().join("artefact");
        for path in ["walk/a.svg", "walk/b.svg", "walk.md", "walk.json"] {
            let reports = outer.path().join(path.replace('/', "-"));
            fs::create_dir_all(reports.join("walk")).unwrap();
            fs::write(reports.join(path), "<svg>drawn by hand</svg>").unwrap();
            first(&store);
            let error = publish(&store, &reports, "walk").unwrap_err();
            assert!(error.to_string().contains(&format!("{path} exists and is not")), "{error}");
            assert_eq!(below(&reports).unwrap(), [path]);
            assert_eq!(text(reports.join(path)), "<svg>drawn by hand</svg>");
            // An empty file is nobody's work, and neither is a figure whose record is gone.
            let figure = "<svg><metadata>{\"report\":\"walk\"}</metadata></svg>";
            let content = if path.ends_with(".svg") { figure } else { "" };
            fs::write(reports.join(path), content).unwrap();
            publish(&store, &reports, "walk").unwrap();
            assert_eq!(text(reports.join("walk/a.svg")), "a 1");
        }
        // Neither is a folder moved away.
        let reports = outer.path().join("folder");
        fs::create_dir_all(reports.join("walk/a.svg")).unwrap();
        fs::write(reports.join("walk/a.svg/mine.txt"), "mine").unwrap();
        publish(&store, &reports, "walk").unwrap_err();
        assert_eq!(text(reports.join("walk/a.svg/mine.txt")), "mine");
        // A new figure of a report that was published before.
        let reports = outer.path().join("earlier");
        second(&store);
        publish(&store, &reports, "walk").unwrap();
        fs::write(reports.join("walk/b.svg"), "drawn by hand").unwrap();
        first(&store);
        publish(&store, &reports, "walk").unwrap_err();
        assert_eq!(text(reports.join("walk.md")), "page 2");
        assert_eq!(text(reports.join("walk/b.svg")), "drawn by hand");
    }

    #[test]
    fn a_publication_that_was_killed_in_its_exchange_is_taken_back_by_the_next() {
        let outer = tempfile::tempdir().unwrap();
        let (store, reports) = (outer.path().join("artefact"), outer.path().join("reports"));
        first(&store);
        publish(&store, &reports, "walk").unwrap();
        // The page is moved away and one figure is swapped.
        let staging = reports.join(".walk.publishing");
        fs::create_dir_all(staging.join("old/walk")).unwrap();
        fs::create_dir_all(staging.join("new")).unwrap();
        fs::rename(reports.join("walk.md"), staging.join("old/walk.md")).unwrap();
        fs::rename(reports.join("walk/a.svg"), staging.join("old/walk/a.svg")).unwrap();
        fs::write(reports.join("walk/a.svg"), "a 2").unwrap();
        fs::write(staging.join("new/walk.md"), "page 2").unwrap();
        let exchange = Exchange { folder: &reports, staging: ".walk.publishing".into(), name: "walk" };
        exchange.recover().unwrap();
        assert_eq!(
            (text(reports.join("walk.md")), text(reports.join("walk/a.svg"))),
            ("page 1".into(), "a 1".into())
        );
        assert!(!staging.exists());
    }

    #[test]
    fn a_step_that_fails_takes_the_others_back() {
        let outer = tempfile::tempdir().unwrap();
        let (store, reports) = (outer.path().join("artefact"), outer.path().join("reports"));
        first(&store);
        publish(&store, &reports, "walk").unwrap();
        // A folder at the new figure's place can be moved away and replaced by a file. A file missing from
        // the staged ones cannot be moved.
        let files = [Copy { path: "walk.md".into(), bytes: b"page 2".into() }];
        let lost = Copy { path: "walk/lost.svg".into(), bytes: b"never staged".into() };
        let exchange = Exchange { folder: &reports, staging: ".walk.publishing".into(), name: "walk" };
        exchange.stage(&files).unwrap();
        let [page] = files;
        exchange.swap(&[page, lost], &["walk/b.svg".into()]).expect_err("a file is missing");
        assert_eq!(
            (text(reports.join("walk.md")), text(reports.join("walk/b.svg"))),
            ("page 1".into(), "b 1".into())
        );
        assert!(!reports.join(".walk.publishing").exists());
    }

    #[test]
    fn files_that_are_not_the_reports_own_are_refused_and_nothing_is_copied() {
        let outer = tempfile::tempdir().unwrap();
        let (store, reports) = (outer.path().join("artefact"), outer.path().join("reports"));
        for foreign in ["README.md", "walk.txt", "walking.md", "other/a.svg"] {
            artefact(&store, &[("walk.md", "page"), (foreign, "x")]);
            let error = publish(&store, &reports, "walk").expect_err(foreign);
            assert_eq!(error.code(), Some("R0012"), "{foreign}: {error}");
        }
        // A manifest that was sealed again with a path outside the folder.
        artefact(&store, &[("walk.md", "page")]);
        let sealed = fs::read_to_string(store.join(manifest::FILE)).unwrap();
        let mut manifest = Manifest::from_text(&sealed).unwrap();
        for path in ["../../x", "/etc/hostname", "walk/../../x"] {
            manifest.files[0].path = path.into();
            fs::write(store.join(manifest::FILE), manifest.to_text()).unwrap();
            let error = publish(&store, &reports, "walk").expect_err(path);
            assert_eq!(error.code(), Some("R0003"), "{path}: {error}");
        }
        assert_eq!(fs::read_dir(&reports).unwrap().count(), 0);
    }

    #[test]
    fn links_in_the_folder_of_reports_and_in_the_artefact_are_refused_and_the_folder_may_be_one() {
        let outer = tempfile::tempdir().unwrap();
        let (store, real, reports) =
            (outer.path().join("artefact"), outer.path().join("real"), outer.path().join("reports"));
        let elsewhere = outer.path().join("elsewhere");
        fs::create_dir(&real).unwrap();
        fs::create_dir(&elsewhere).unwrap();
        symlink(&real, &reports).unwrap();
        first(&store);
        for link in ["walk", "walk.json", "walk.md", ".walk.publishing"] {
            for target in [elsewhere.clone(), elsewhere.join("nothing")] {
                symlink(&target, real.join(link)).unwrap();
                let error = publish(&store, &reports, "walk").expect_err(link);
                assert_eq!(error.code(), Some("R0011"), "{link}: {error}");
                fs::remove_file(real.join(link)).unwrap();
            }
        }
        assert_eq!(fs::read_dir(&elsewhere).unwrap().count(), 0);
        assert_eq!(fs::read_dir(&real).unwrap().count(), 0);
        fs::write(elsewhere.join("a.svg"), "a 1").unwrap();
        fs::remove_file(store.join("walk/a.svg")).unwrap();
        symlink(elsewhere.join("a.svg"), store.join("walk/a.svg")).unwrap();
        assert_eq!(publish(&store, &reports, "walk").expect_err("a link").code(), Some("R0003"));
        first(&store);
        publish(&store, &reports, "walk").unwrap();
        assert_eq!(text(real.join("walk/a.svg")), "a 1");
    }
}
