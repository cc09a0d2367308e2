//! Atomic file writes, and paths that stay in their folder. Does not interpret the content of files.
//!
//! A file is written under another name in the same folder, flushed to the disk and renamed: readers see
//! either the old bytes or the new ones, even after a full disk, a kill or a power cut. Inside a store or a
//! folder of reports, symbolic links are not followed, because they could make a command read or overwrite a
//! file elsewhere.

use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Write};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt, PermissionsExt};
use std::path::{Component, Path, PathBuf};

use tempfile::NamedTempFile;

/// Mode of a new file before applying the umask.
const NEW_FILE: u32 = 0o666;

/// A path that is refused.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// A symbolic link where none is allowed.
    #[error("`{}` is a symbolic link", crate::escape::file(.0))]
    Link(PathBuf),
    /// A path that is absolute or contains `..`.
    #[error("`{0}` leads out of its folder")]
    Outside(String),
}

impl From<Refused> for io::Error {
    fn from(refused: Refused) -> Self {
        Self::other(refused)
    }
}

/// The refusal that caused an error, if any.
pub fn refused(error: &io::Error) -> Option<&Refused> {
    error.get_ref()?.downcast_ref()
}

/// Whether a relative path stays below its folder: only names, no `..`, root or NUL byte.
pub fn is_plain(path: &str) -> bool {
    let is_name = |part| matches!(part, Component::Normal(_));
    !path.is_empty() && !path.contains('\0') && Path::new(path).components().all(is_name)
}

/// A relative path below a folder. The folder itself may be a symbolic link, but none of the path below it;
/// parts that do not exist yet are allowed.
pub fn inside(folder: &Path, path: &str) -> io::Result<PathBuf> {
    if !is_plain(path) {
        return Err(Refused::Outside(path.to_owned()).into());
    }
    let mut place = folder.to_owned();
    for part in Path::new(path).components() {
        place.push(part);
        refuse_link(&place)?;
    }
    Ok(place)
}

/// Refuses a path that is a symbolic link, dangling or not.
pub fn refuse_link(path: &Path) -> io::Result<()> {
    match fs::symlink_metadata(path) {
        Ok(found) if found.is_symlink() => Err(Refused::Link(path.to_owned()).into()),
        Ok(_) => Ok(()),
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(()),
        Err(error) => Err(error),
    }
}

/// Options that do not follow symbolic links.
pub fn no_follow() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.custom_flags(rustix::fs::OFlags::NOFOLLOW.bits().cast_signed());
    options
}

/// Writes a file named by the user, replacing an existing one and keeping its permissions. A symlink is kept,
/// and its target replaced. Other file types (a pipe, `/dev/stdout`) are written to directly.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let target = match fs::canonicalize(path) {
        Ok(target) => target,
        // A dangling link: its target is not created, because the user cannot see where that is.
        Err(error) if error.kind() == ErrorKind::NotFound => {
            refuse_link(path)?;
            path.to_owned()
        }
        Err(error) => return Err(error),
    };
    match fs::metadata(&target) {
        Ok(found) if found.is_file() => put(&target, bytes, Some(found.permissions())),
        Ok(found) if found.is_dir() => Err(ErrorKind::IsADirectory.into()),
        Ok(found) => {
            let _reader = if found.file_type().is_fifo() { Some(pipe(path)?) } else { None };
            OpenOptions::new().write(true).open(path)?.write_all(bytes)
        }
        Err(_) => put(&target, bytes, None),
    }
}

/// Opens a named pipe, which must have a reader: without one, opening it in the usual way would never return.
fn pipe(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.write(true).custom_flags(rustix::fs::OFlags::NONBLOCK.bits().cast_signed());
    options.open(path).map_err(|error| match error.raw_os_error() {
        Some(code) if code == rustix::io::Errno::NXIO.raw_os_error() => {
            io::Error::other("it is a named pipe that nothing reads, not a file")
        }
        _ => error,
    })
}

/// Writes a new file; fails with `AlreadyExists` if a file or a link of that name exists.
pub fn create(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let draft = draft(folder_of(path), bytes)?;
    draft.persist_noclobber(path).map_err(|error| error.error)?;
    sync_folder(folder_of(path));
    Ok(())
}

/// Writes a file below a folder, replacing an existing one. No part of its path may be a symlink.
pub fn replace_inside(folder: &Path, path: &str, bytes: &[u8]) -> io::Result<()> {
    put(&inside(folder, path)?, bytes, None)
}

/// The same by way of this temporary file, which a killed process may have left behind.
pub fn replace_through(draft: &Path, path: &Path, bytes: &[u8]) -> io::Result<()> {
    let written = no_follow()
        .write(true)
        .create(true)
        .truncate(true)
        .open(draft)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(draft, path));
    if written.is_err() {
        // The draft may fill the disk. Report the write error, not a failure to remove the draft.
        let _ = fs::remove_file(draft);
    }
    written?;
    sync_folder(folder_of(path));
    Ok(())
}

/// Flushes a folder's entries to the disk. Not every file system supports it; the files themselves are
/// flushed already.
pub fn sync_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}

fn put(target: &Path, bytes: &[u8], permissions: Option<Permissions>) -> io::Result<()> {
    let draft = draft(folder_of(target), bytes)?;
    if let Some(permissions) = permissions {
        draft.as_file().set_permissions(permissions)?;
    }
    draft.persist(target).map_err(|error| error.error)?;
    sync_folder(folder_of(target));
    Ok(())
}

/// A temporary file with these bytes in a folder, flushed to the disk; removed when dropped.
fn draft(folder: &Path, bytes: &[u8]) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(DRAFT[0]).suffix(DRAFT[1]).permissions(Permissions::from_mode(NEW_FILE));
    let mut file = builder.tempfile_in(folder).map_err(nameless)?;
    file.as_file_mut().write_all(bytes)?;
    file.as_file().sync_all()?;
    Ok(file)
}

/// The same error without the name of the temporary file, which the user did not choose.
fn nameless(error: io::Error) -> io::Error {
    if error.raw_os_error().is_some() { error } else { error.kind().into() }
}

/// Whether files can be written into a folder or, if it does not exist, into the nearest one above it.
pub fn is_writable(folder: &Path) -> io::Result<()> {
    let above = folder.ancestors().find(|above| above.exists()).unwrap_or(Path::new("."));
    tempfile::Builder::new().prefix(DRAFT[0]).suffix(DRAFT[1]).tempfile_in(above).map_err(nameless).map(drop)
}

/// Prefix and suffix of the names of temporary files.
const DRAFT: [&str; 2] = [".specforge-", ".draft"];

/// Whether a name is that of a temporary file, possibly left behind by a killed process.
pub fn is_draft(name: &str) -> bool {
    name.starts_with(DRAFT[0]) && name.ends_with(DRAFT[1])
}

/// The parent folder of a file.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = entries.collect();
        names.sort();
        names
    }

    #[test]
    fn paths_that_lead_out_of_their_folder_are_not_plain() {
        for path in ["a", "a/b.svg", "a..b", "..a/b", "./a".trim_start_matches("./")] {
            assert!(is_plain(path), "{path}");
        }
        for path in ["", "..", "../a", "a/../../b", "/etc/passwd", "./a", "a\0b"] {
            assert!(!is_plain(path), "{path}");
        }
    }

    #[test]
    fn a_file_is_replaced_with_its_permissions_and_a_link_to_it_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        replace(&file, b"one").unwrap();
        assert_ne!(
            fs::metadata(&file).unwrap().permissions().mode() & 0o044,
            0,
            "others may read a new file"
        );
        fs::set_permissions(&file, Permissions::from_mode(0o640)).unwrap();
        symlink("file", &link).unwrap();
        replace(&link, b"two").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"two");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
        assert_eq!(names(folder.path()), ["file", "link"], "no draft is left");
    }

    #[test]
    fn a_pipe_is_written_to_when_something_reads_it() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR)
            .unwrap();
        let error = replace(&pipe, b"x").expect_err("nothing reads it");
        assert!(error.to_string().contains("named pipe that nothing reads"), "{error}");
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read(pipe).unwrap()
        });
        // The reader may not have opened it yet.
        while replace(&pipe, b"x").is_err() {
            std::thread::yield_now();
        }
        assert_eq!(reader.join().unwrap(), b"x");
    }

    #[test]
    fn a_device_is_written_to_and_a_link_to_nothing_is_refused() {
        replace(Path::new("/dev/null"), b"gone").unwrap();
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        symlink(folder.path().join("nothing"), &link).unwrap();
        let error = replace(&link, b"x").expect_err("nobody sees where that would be");
        assert!(matches!(refused(&error), Some(Refused::Link(path)) if *path == link), "{error}");
        assert_eq!(create(&link, b"x").expect_err("it is there").kind(), ErrorKind::AlreadyExists);
        assert_eq!(names(folder.path()), ["link"]);
    }

    #[test]
    fn a_file_that_is_there_is_not_created_again() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        create(&file, b"one").unwrap();
        assert_eq!(create(&file, b"two").expect_err("it is there").kind(), ErrorKind::AlreadyExists);
        assert_eq!(fs::read(&file).unwrap(), b"one");
        assert_eq!(names(folder.path()), ["file"], "no draft is left");
    }

    #[test]
    fn the_folder_may_be_a_link_and_nothing_inside() {
        let outer = tempfile::tempdir().unwrap();
        let (real, elsewhere) = (outer.path().join("real"), outer.path().join("elsewhere"));
        fs::create_dir_all(real.join("sub")).unwrap();
        fs::create_dir(&elsewhere).unwrap();
        let folder = outer.path().join("folder");
        symlink(&real, &folder).unwrap();
        replace_inside(&folder, "sub/file", b"one").unwrap();
        symlink(&elsewhere, real.join("away")).unwrap();
        symlink(elsewhere.join("nothing"), real.join("dangling")).unwrap();
        for path in ["away/file", "dangling"] {
            let error = replace_inside(&folder, path, b"two").expect_err("a link");
            assert!(matches!(refused(&error), Some(Refused::Link(_))), "{path}: {error}");
        }
        let error = replace_inside(&folder, "../file", b"two").expect_err("outside");
        assert!(matches!(refused(&error), Some(Refused::Outside(_))), "{error}");
        assert_eq!(names(&elsewhere), Vec::<String>::new());
        assert!(no_follow().read(true).open(folder.join("away")).is_err());
    }
}
