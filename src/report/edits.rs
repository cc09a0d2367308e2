//! Keeps what people wrote into a rendered page, its record or its figures before another report replaces
//! them: the edited file is copied to `NAME.md.edited`.

use std::io;
use std::path::{Path, PathBuf};

use super::digests;
use super::sidecar::Sidecar;
use crate::seal::Seal;
use crate::{bounded, safe_fs};

/// The end of the copy's name; a second copy ends with `.edited-2`.
const ENDING: &str = ".edited";

/// Copies the files of a report that differ from the digests in its record, and returns the copies. A file
/// whose copy is there already, and one that `is_new` finds as it will be written, are not copied.
pub fn keep(folder: &Path, name: &str, is_new: &dyn Fn(&str, &[u8]) -> bool) -> io::Result<Vec<PathBuf>> {
    let Ok((record, seal)) = Sidecar::open(&Sidecar::path(folder, name)) else { return Ok(Vec::new()) };
    let mut edited: Vec<String> = digests::differences(folder, &record.digests)
        .into_iter()
        .map(|difference| difference.file)
        .filter(|file| file.strip_prefix(name).is_some_and(|rest| rest.starts_with(['.', '/'])))
        .collect();
    if seal == Seal::Broken {
        edited.push(format!("{name}.json"));
    }
    let mut kept = Vec::new();
    for file in edited {
        let Ok(path) = safe_fs::inside(folder, &file) else { continue };
        let bytes = match bounded::bytes(&path, bounded::RECORD) {
            Ok(bytes) => bytes,
            Err(error) if error.is_absence() => continue,
            Err(error) => return Err(error.into()),
        };
        if !is_new(&file, &bytes) {
            kept.extend(copied(&path, &bytes)?);
        }
    }
    Ok(kept)
}

/// Writes a copy of an edited file under the first free name; `None` if there is one already.
fn copied(path: &Path, bytes: &[u8]) -> io::Result<Option<PathBuf>> {
    for number in 1_u64.. {
        let mut copy = path.as_os_str().to_owned();
        copy.push(ENDING);
        if number > 1 {
            copy.push(format!("-{number}"));
        }
        let copy = PathBuf::from(copy);
        match safe_fs::create(&copy, bytes) {
            Ok(()) => return Ok(Some(copy)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                if bounded::bytes(&copy, bounded::RECORD).is_ok_and(|there| there == bytes) {
                    return Ok(None);
                }
            }
            Err(error) => return Err(error),
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::report::ReportFile;

    #[test]
    fn notes_in_a_page_are_kept_once_and_an_unchanged_page_has_none() {
        let outer = tempfile::tempdir().expect("a folder");
        let folder = outer.path();
        let file = |path: &str, text: &str| ReportFile { path: path.into(), text: text.into() };
        let files = [file("walk.md", "# walk\n"), file("walk/a.svg", "<svg/>")];
        fs::create_dir(folder.join("walk")).expect("a folder");
        files.iter().for_each(|file| fs::write(folder.join(&file.path), &file.text).expect("written"));
        let record = Sidecar { report: "walk".into(), digests: digests::of(&files), ..Sidecar::default() };
        fs::write(folder.join("walk.json"), record.sealed().to_json()).expect("written");
        let kept = || keep(folder, "walk", &|_, _| false).expect("it can be written");
        assert_eq!(kept(), Vec::<PathBuf>::new());
        fs::write(folder.join("walk.md"), "# walk\n\nMy note.\n").expect("written");
        fs::remove_file(folder.join("walk/a.svg")).expect("it is there");
        assert_eq!(keep(folder, "walk", &|_, _| true).expect("it can be read"), Vec::<PathBuf>::new());
        assert_eq!(kept(), [folder.join("walk.md.edited")]);
        assert_eq!(kept(), Vec::<PathBuf>::new());
        fs::write(folder.join("walk.md"), "# walk\n\nAnother note.\n").expect("written");
        fs::write(folder.join("walk/a.svg"), "<svg>mine</svg>").expect("written");
        assert_eq!(kept(), ["walk.md.edited-2", "walk/a.svg.edited"].map(|path| folder.join(path)));
        let first = fs::read_to_string(folder.join("walk.md.edited")).expect("a copy");
        assert!(first.contains("My note."), "{first}");
    }
}
