//! Errors of the store and of copying reports out of it, with their codes and fixes.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::mark::Flaw;
use crate::finite::NotFinite;
use crate::safe_fs::{self, Refused};

/// An error of the store.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The disk is full.
    #[error("the disk is full: cannot write {}", path.display())]
    Full {
        /// The path being written.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file would exceed this process's file size limit.
    #[error("the limit on the size of a file is reached: cannot write {}", path.display())]
    TooLarge {
        /// The path being written.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The store cannot be written.
    #[error("the store cannot be written: {}: {source}", path.display())]
    Unwritable {
        /// The path being written.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The store cannot be read.
    #[error("the store cannot be read: {}: {source}", path.display())]
    Unreadable {
        /// The path being read.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// An entry does not match its manifest.
    #[error("the artefact in {} was damaged: {reason}", path.display())]
    Damaged {
        /// The entry.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Something in a store or a folder of reports is a symbolic link.
    #[error("{} is a symbolic link, and nothing inside a store or a folder of reports may be \
        one", path.display())]
    Link {
        /// The link.
        path: PathBuf,
    },
    /// A report contains a file other than its page, its record and its figures.
    #[error("the report in {} has a file `{name}`, which is none of its own", path.display())]
    Foreign {
        /// The artefact.
        path: PathBuf,
        /// The file.
        name: String,
    },
    /// Something that is not part of a report has the name of one of its files.
    #[error("{} exists and is not a file of this report; nothing was written", path.display())]
    Occupied {
        /// The file or folder.
        path: PathBuf,
    },
    /// A folder holds something other than a store.
    #[error("{} is not a store: {reason}", path.display())]
    NotAStore {
        /// The folder.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A store's marker file is damaged or names another layout.
    #[error("the store {} cannot be used: {flaw}", path.display())]
    Mark {
        /// The store.
        path: PathBuf,
        /// What is wrong with the marker.
        flaw: Flaw,
    },
    /// The journal is not reliable enough to tell which artefacts are unused.
    #[error("the journal of {} does not prove what is unused: {reason}", path.display())]
    Journal {
        /// The store.
        path: PathBuf,
        /// What is wrong with the journal.
        reason: String,
    },
    /// The user interrupted the wait for another process.
    #[error("interrupted")]
    Interrupted,
    /// A result is NaN or infinite.
    #[error("{file}: {found}")]
    NotFinite {
        /// The file that was not written.
        file: String,
        /// Which number it is.
        found: NotFinite,
    },
    /// A report cannot be copied out of the store.
    #[error("the report cannot be written: {}: {source}", path.display())]
    Unpublished {
        /// The path being written.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Any other file system error.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

impl StoreError {
    /// The error for a failed write.
    pub fn writing(path: &Path, source: std::io::Error) -> Self {
        if let Some(fault) = Self::refusal(&source) {
            return fault;
        }
        let path = path.to_owned();
        match source.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => Self::Full { path, source },
            ErrorKind::FileTooLarge => Self::TooLarge { path, source },
            _ => Self::Unwritable { path, source },
        }
    }

    /// The error for a report file that cannot be written.
    pub fn publishing(path: &Path, source: std::io::Error) -> Self {
        Self::refusal(&source).unwrap_or_else(|| Self::Unpublished { path: path.to_owned(), source })
    }

    /// The error for a symbolic link that was not followed.
    fn refusal(source: &std::io::Error) -> Option<Self> {
        match safe_fs::refused(source)? {
            Refused::Link(path) => Some(Self::Link { path: path.clone() }),
            Refused::Outside(_) => None,
        }
    }

    /// The error for a failed read. If a parent of the path is a file, no store can exist there.
    pub fn reading(path: &Path, source: std::io::Error) -> Self {
        match source.kind() {
            ErrorKind::NotADirectory => Self::writing(path, source),
            _ => Self::Unreadable { path: path.to_owned(), source },
        }
    }

    /// The diagnostic's code.
    pub fn code(&self) -> Option<&'static str> {
        match self {
            Self::Full { .. }
            | Self::TooLarge { .. }
            | Self::Unwritable { .. }
            | Self::Unpublished { .. } => Some("R0004"),
            Self::Damaged { .. } => Some("R0003"),
            Self::Link { .. } => Some("R0011"),
            Self::Foreign { .. } => Some("R0012"),
            Self::NotAStore { .. } => Some("E0813"),
            Self::Journal { .. } => Some("E0814"),
            Self::Mark { .. } => Some("E0815"),
            Self::NotFinite { .. } => Some("R0007"),
            Self::Occupied { .. } | Self::Unreadable { .. } | Self::Interrupted | Self::Io { .. } => None,
        }
    }

    /// How to fix it.
    pub fn help(&self) -> Option<&'static str> {
        match self {
            Self::Full { .. } => {
                Some("free some space or choose another disk with `--store DIR`; finished stages stay usable")
            }
            Self::TooLarge { .. } => {
                Some("raise the limit (`ulimit -f`) and run again; finished stages stay usable")
            }
            Self::Unwritable { .. } => {
                Some("make the folder writable or choose another one with `--store DIR`")
            }
            Self::Unreadable { .. } => Some("make it readable, or choose another store with `--store DIR`"),
            Self::Damaged { .. } => Some("run again: the damaged artefact is moved aside and made anew"),
            Self::Link { .. } => Some(
                "replace the link by the folder or file that it names; the store's or the reports' folder \
                 itself may be a link",
            ),
            Self::Foreign { .. } => Some("remove the artefact and run again: the report is rendered anew"),
            Self::Occupied { .. } => Some(
                "move it away and render the report again with `specforge report`, or write the report elsewhere: \
                 `--reports DIR`",
            ),
            Self::NotAStore { .. } => Some(
                "name the store's folder with `--store DIR`, or a folder that is empty or does not exist yet: a new store \
                     is made there",
            ),
            Self::Mark { flaw: Flaw::Layout(_), .. } => {
                Some("use the version of specforge that made it, or another store: `--store DIR`")
            }
            Self::Mark { flaw: Flaw::Damaged(_), .. } => Some(
                "nothing was removed; if the folder is a store, delete its file `.specforge-store`: the next \
                 run writes it \
                 again",
            ),
            Self::Journal { .. } => Some(
                "nothing was removed; `--force` takes the journal as it is, and what it does not name for \
                 unused: look at \
                 `--force --dry-run` first",
            ),
            Self::NotFinite { .. } => Some("see `specforge explain R0007`"),
            Self::Unpublished { .. } => {
                Some("name a folder that can be written with `--reports DIR`; what was run is in the store")
            }
            Self::Interrupted | Self::Io { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_keeps_the_store_from_being_written_has_the_code_r0004() {
        let code = |kind: ErrorKind| StoreError::writing(Path::new("x"), kind.into()).code();
        let full = [ErrorKind::StorageFull, ErrorKind::QuotaExceeded, ErrorKind::ReadOnlyFilesystem];
        for kind in full.into_iter().chain([
            ErrorKind::FileTooLarge,
            ErrorKind::PermissionDenied,
            ErrorKind::NotFound,
        ]) {
            assert_eq!(code(kind), Some("R0004"), "{kind:?}");
        }
        let limited = StoreError::writing(Path::new("x"), ErrorKind::FileTooLarge.into());
        assert!(limited.to_string().starts_with("the limit on the size of a file is reached"), "{limited}");
    }
}
