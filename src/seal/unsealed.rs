//! Records from before digests were introduced, the only ones that may lack one. They are identified by the
//! digest of their content, so a newer record whose digest was removed is not accepted.

use std::collections::BTreeMap;
use std::sync::LazyLock;

/// The records of this project's reports. A page leaves the list when it is rendered again; none is added.
const LIST: &str = include_str!("unsealed.txt");

static KNOWN: LazyLock<Unsealed> = LazyLock::new(|| Unsealed::parse(LIST));

/// A record from before digests.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Earlier {
    /// Its path in the folder of the reports.
    pub path: String,
    /// The digests of its page and figures, by path relative to the record's folder.
    pub files: BTreeMap<String, String>,
}

/// Such records, by the digest of their content.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Unsealed {
    records: BTreeMap<String, Earlier>,
}

impl Unsealed {
    /// The list built into this version.
    pub fn known() -> &'static Self {
        &KNOWN
    }

    /// Parses a list: lines with a record's digest and path, each followed by indented ones for its files.
    pub fn parse(text: &str) -> Self {
        let (mut records, mut last) = (BTreeMap::new(), String::new());
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let Some((digest, path)) = line.trim_start().split_once(' ') else { continue };
            let (digest, path) = (digest.to_owned(), path.to_owned());
            if !line.starts_with(' ') {
                records.insert(digest.clone(), Earlier { path, files: BTreeMap::new() });
                last = digest;
            } else if let Some(record) = records.get_mut(&last) {
                record.files.insert(path, digest);
            }
        }
        Self { records }
    }

    /// The record whose content has this digest.
    pub fn find(&self, digest: &str) -> Option<Earlier> {
        self.records.get(digest).cloned()
    }
}
