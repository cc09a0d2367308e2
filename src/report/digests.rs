//! Digests of a report's page and figures, stored in its record: `specforge report --check` uses them to find
//! files that were edited after rendering.

use std::collections::BTreeMap;
use std::path::Path;

use super::file::ReportFile;
use super::policies;
use crate::bounded;
use crate::safe_fs;

/// Digests by path in the folder of reports.
pub type Digests = BTreeMap<String, String>;

/// A file of a report that was changed after rendering.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Its path in the folder of reports.
    pub file: String,
    /// What is wrong with it.
    pub reason: String,
}

/// The digests of a report's files.
pub fn of(files: &[ReportFile]) -> Digests {
    files.iter().map(|file| (file.path.display().to_string(), digest(file.text.as_bytes()))).collect()
}

/// The files that differ from the digests in their record. A copy of a policy may be missing.
pub fn differences(folder: &Path, digests: &Digests) -> Vec<Difference> {
    digests.iter().filter_map(|(file, digest)| difference(folder, file, digest)).collect()
}

fn difference(folder: &Path, file: &str, expected: &str) -> Option<Difference> {
    let found = |reason: String| Some(Difference { file: file.to_owned(), reason });
    let path = match safe_fs::inside(folder, file) {
        Ok(path) => path,
        Err(error) => return found(error.to_string()),
    };
    match bounded::bytes(&path, bounded::RECORD) {
        Err(error) if error.is_absence() && policies::is_copy(file) => None,
        Err(error) if error.is_absence() => found("it is missing".into()),
        Err(error) => found(error.to_string()),
        Ok(bytes) if digest(&bytes) != expected => found("it was changed after it was rendered".into()),
        Ok(_) => None,
    }
}

/// BLAKE3 of a file's content.
pub fn digest(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_file_that_was_edited_or_removed_differs() {
        let folder = tempfile::tempdir().expect("a folder");
        let page = "# walk\n\nIt walks at 0.70 m/s.\n";
        let file = |path: &str, text: &str| ReportFile { path: path.into(), text: text.into() };
        let files = [file("walk.md", page), file("walk/a.svg", "<svg/>")];
        fs::create_dir(folder.path().join("walk")).expect("a folder");
        let write =
            |path: &str, text: &str| fs::write(folder.path().join(path), text).expect("it can be written");
        files.iter().for_each(|file| write(&file.path.display().to_string(), &file.text));
        let digests = of(&files);
        let found = || differences(folder.path(), &digests);
        assert_eq!(found(), []);
        write("walk.md", &page.replace("0.70", "0.90"));
        fs::remove_file(folder.path().join("walk/a.svg")).expect("it is there");
        let files: Vec<String> =
            found().into_iter().map(|found| format!("{}: {}", found.file, found.reason)).collect();
        assert_eq!(files, ["walk.md: it was changed after it was rendered", "walk/a.svg: it is missing"]);
        let outside = Digests::from([("../walk.md".to_owned(), String::new())]);
        assert_eq!(differences(folder.path(), &outside).len(), 1);
    }
}
