//! Copies of the exported policies beside a page, `NAME/policies/ARM.safetensors`, tracked like its figures. A
//! page of single runs links them; the page of a suite does not, so it has none.

use std::path::Path;

use super::model::{Policy, ReportInput};
use super::source::Source;
use crate::bounded;
use crate::learn::file;

/// The folder of a page's copies, in the folder of its figures.
const FOLDER: &str = "policies";
/// The end of a copy's name.
const ENDING: &str = ".safetensors";

/// A copy of a policy.
pub struct PolicyCopy<'a> {
    /// Its name: that of the arm, with the export's name if the arm has several.
    pub id: String,
    /// Its path relative to the page.
    pub file: String,
    /// The arm and stage that exported it.
    pub source: Source,
    /// Its content.
    pub bytes: &'a [u8],
}

/// The copies that belong to a page.
pub fn copies(input: &ReportInput) -> Vec<PolicyCopy<'_>> {
    let mut copies = Vec::new();
    for arm in &input.arms {
        for Policy { stage, bytes } in &arm.policies {
            let export = stage.strip_prefix("deploy.").unwrap_or(stage);
            let id =
                if arm.policies.len() == 1 { arm.name.clone() } else { format!("{}_{export}", arm.name) };
            let file = format!("{}/{FOLDER}/{id}{ENDING}", input.name);
            let source = Source { arm: arm.name.clone(), stage: stage.clone() };
            copies.push(PolicyCopy { id, file, source, bytes });
        }
    }
    copies
}

/// Whether a path relative to the folder of a page is that of a copy. Pages may be passed on without their
/// policies, which the store has too.
pub fn is_copy(file: &str) -> bool {
    file.ends_with(ENDING) && file.rsplit('/').nth(1) == Some(FOLDER)
}

/// Whether a folder is named like that of a page's copies.
pub fn is_folder(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == FOLDER)
}

/// Whether a file is a policy written by specforge.
pub fn is_policy(path: &Path) -> bool {
    let header = bounded::bytes(path, bounded::RECORD).ok().and_then(|bytes| file::header(&bytes).ok());
    header.is_some_and(|header| header.contains_key("contract"))
}
