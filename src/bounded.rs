//! The bounded reader, through which the program reads all files. Does not interpret their content.
//!
//! The limit applies to the bytes read, not to the reported size: a device has no size, files in `/proc`
//! report 0, and a file can grow while it is read. After resolving symlinks, only regular files are read.
//! Anything else may block indefinitely (a named pipe), never end (`/dev/zero`) or act on being opened (a
//! tape).

use std::fs::{File, FileType, Metadata};
use std::io::{self, Read};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;

/// Maximum size in bytes of a file that people write: specs, robots, motions, templates.
pub const WRITTEN: u64 = 1 << 20;
/// Maximum size in bytes of a record that the program writes: plans, manifests, reports' records, metrics.
pub const RECORD: u64 = 256 << 20;
/// Maximum size in bytes of an artefact, such as a checkpoint with the actions of all running episodes.
pub const ARTEFACT: u64 = 4 << 30;

/// Why a file was not read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The system returned an error.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// It is a folder.
    #[error("it is a folder")]
    Folder,
    /// It is neither a file nor a folder.
    #[error("it is a {0}, not a file")]
    Special(&'static str),
    /// It is larger than the limit.
    #[error("it has {}more than the {} allowed", size.map(|size| format!("{}, \
        ", more_than(size, *limit))).unwrap_or_default(), mebibytes(*limit))]
    TooLarge {
        /// The reported size in bytes, if it is above the limit.
        size: Option<u64>,
        /// The limit in bytes.
        limit: u64,
    },
    /// It is not UTF-8.
    #[error("it is not UTF-8 (byte {at})")]
    NotUtf8 {
        /// Offset of the first invalid byte.
        at: usize,
    },
}

impl ReadError {
    /// Whether the file does not exist.
    pub fn is_absence(&self) -> bool {
        matches!(self, Self::Io(error) if error.kind() == io::ErrorKind::NotFound)
    }
}

/// For callers that report I/O errors. A file above the limit does not become `FileTooLarge`, which writers
/// report as a full disk.
impl From<ReadError> for io::Error {
    fn from(error: ReadError) -> Self {
        match error {
            ReadError::Io(error) => error,
            ReadError::Folder => Self::new(io::ErrorKind::IsADirectory, error.to_string()),
            _ => Self::new(io::ErrorKind::InvalidData, error.to_string()),
        }
    }
}

/// A size above a limit; in bytes if both would show as the same number of MiB.
fn more_than(size: u64, limit: u64) -> String {
    let written = mebibytes(size);
    let is_same =
        written.trim_end_matches(" MiB").parse::<f64>() == mebibytes(limit).trim_end_matches(" MiB").parse();
    if is_same { format!("{size} bytes") } else { written }
}

/// A size for people: `1 MiB`, `2.5 MiB`.
fn mebibytes(bytes: u64) -> String {
    let size = bytes as f64 / f64::from(1 << 20);
    if size.fract() == 0.0 { format!("{size} MiB") } else { format!("{size:.1} MiB") }
}

/// The name of a file type other than regular file and folder.
fn special(kind: FileType) -> &'static str {
    match kind {
        _ if kind.is_fifo() => "named pipe",
        _ if kind.is_socket() => "socket",
        _ if kind.is_char_device() || kind.is_block_device() => "device",
        _ => "special file",
    }
}

fn regular(metadata: &Metadata) -> Result<(), ReadError> {
    let kind = metadata.file_type();
    match kind {
        _ if kind.is_file() => Ok(()),
        _ if kind.is_dir() => Err(ReadError::Folder),
        _ => Err(ReadError::Special(special(kind))),
    }
}

/// Opens a regular file. Checks its type before opening, because opening a device can have effects, and again
/// afterwards, because the path may point elsewhere by then.
pub fn open(path: &Path) -> Result<File, ReadError> {
    regular(&std::fs::metadata(path)?)?;
    // Non-blocking: opening a named pipe would wait for a writer.
    let flags = rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOCTTY | rustix::fs::OFlags::CLOEXEC;
    let file = File::options().read(true).custom_flags(flags.bits().cast_signed()).open(path)?;
    regular(&file.metadata()?)?;
    Ok(file)
}

/// The bytes of a file, if there are at most `limit`.
pub fn bytes(path: &Path, limit: u64) -> Result<Vec<u8>, ReadError> {
    let file = open(path)?;
    let size = file.metadata()?.len();
    if size > limit {
        return Err(ReadError::TooLarge { size: Some(size), limit });
    }
    let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or_default());
    read_into(file, &mut bytes, limit)?;
    Ok(bytes)
}

/// The first bytes of a file, at most `limit`.
pub fn head(path: &Path, limit: u64) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    open(path)?.take(limit).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a file, if it has at most `limit` bytes.
pub fn text(path: &Path, limit: u64) -> Result<String, ReadError> {
    utf8(bytes(path, limit)?)
}

/// The text of a stream, such as standard input, if it has at most `limit` bytes.
pub fn text_of(stream: impl Read, limit: u64) -> Result<String, ReadError> {
    let mut bytes = Vec::new();
    read_into(stream, &mut bytes, limit)?;
    utf8(bytes)
}

/// Reads at most one byte more than the limit, to detect longer files.
fn read_into(stream: impl Read, bytes: &mut Vec<u8>, limit: u64) -> Result<(), ReadError> {
    stream.take(limit.saturating_add(1)).read_to_end(bytes)?;
    if bytes.len() as u64 > limit { Err(ReadError::TooLarge { size: None, limit }) } else { Ok(()) }
}

fn utf8(bytes: Vec<u8>) -> Result<String, ReadError> {
    String::from_utf8(bytes).map_err(|error| ReadError::NotUtf8 { at: error.utf8_error().valid_up_to() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(path: &Path, limit: u64) -> String {
        text(path, limit).expect_err("it is refused").to_string()
    }

    #[test]
    fn only_regular_files_are_read_also_through_symlinks() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("a"), "text").unwrap();
        std::os::unix::fs::symlink(path("a"), path("link")).unwrap();
        std::os::unix::fs::symlink("loop", path("loop")).unwrap();
        std::os::unix::fs::symlink("/dev/zero", path("zero")).unwrap();
        rustix::fs::mkfifoat(rustix::fs::CWD, path("pipe"), rustix::fs::Mode::RUSR).unwrap();
        let _socket = std::os::unix::net::UnixListener::bind(path("socket")).unwrap();
        assert_eq!(text(&path("link"), 4).unwrap(), "text");
        assert_eq!(said(folder.path(), 9), "it is a folder");
        assert_eq!(said(&path("pipe"), 9), "it is a named pipe, not a file");
        assert_eq!(said(&path("socket"), 9), "it is a socket, not a file");
        assert_eq!(said(&path("zero"), 9), "it is a device, not a file");
        assert_eq!(said(Path::new("/dev/tty"), 9), "it is a device, not a file");
        assert!(text(&path("loop"), 9).is_err_and(|error| !error.is_absence()));
        assert!(text(&path("none"), 9).is_err_and(|error| error.is_absence()));
    }

    #[test]
    fn the_limit_applies_to_what_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(bytes(&path, 5).unwrap(), b"12345");
        assert!(matches!(bytes(&path, 4), Err(ReadError::TooLarge { size: Some(5), limit: 4 })));
        // Files in /proc report size 0.
        let maps = Path::new("/proc/self/maps");
        assert_eq!(std::fs::metadata(maps).unwrap().len(), 0);
        assert!(matches!(bytes(maps, 16), Err(ReadError::TooLarge { size: None, limit: 16 })));
        assert!(matches!(text_of(io::repeat(b'a'), 16), Err(ReadError::TooLarge { size: None, limit: 16 })));
    }

    #[test]
    fn other_bytes_than_utf_8_are_named() {
        let error = text_of(&b"ab\xff"[..], 9).expect_err("it is refused");
        assert_eq!(error.to_string(), "it is not UTF-8 (byte 2)");
    }
}
