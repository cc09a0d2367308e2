//! The last line of the index: digests of the page itself and of the records it was written from. They reveal
//! an edited index, and one that is older than a record.

use std::collections::BTreeMap;

/// The beginning of that line.
const BEGIN: &str = "<!-- Written by `specforge report --index`";

/// Sentences that identify an index without its last line.
const SENTENCES: [&str; 3] = [
    "What was claimed and what became of it, suite by suite.",
    "edits by hand are lost when it is written again",
    "The runs of a page are *today's* when",
];

/// The page with its last line; `records` are the digests of the records' contents by page path (no `.md`).
pub fn marked(page: &str, records: &BTreeMap<String, String>) -> String {
    format!("{page}\n{}\n", line(page, records))
}

/// What is wrong with an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flaw {
    /// It was edited; what shows that.
    Changed(&'static str),
    /// It is unchanged, and reports were added, rendered again or removed since it was written.
    OutOfDate,
}

/// Whether a page is an index, unchanged or not.
pub fn is_index(text: &str) -> bool {
    text.contains(&format!("\n{BEGIN}")) || SENTENCES.iter().any(|sentence| text.contains(sentence))
}

/// What is wrong with an index; `None` if it is unchanged and current, and for pages not written by
/// specforge.
pub fn flaw(text: &str, records: &BTreeMap<String, String>) -> Option<Flaw> {
    let Some((page, _)) = text.split_once(&format!("\n{BEGIN}")) else {
        let is_ours = SENTENCES.iter().any(|sentence| text.contains(sentence));
        let reason = "it is the index, and its last line with its digest is missing";
        return is_ours.then_some(Flaw::Changed(reason));
    };
    let last = text[page.len()..].trim_matches('\n');
    if !last.contains(&digest(page)) || last.lines().count() != 1 {
        let reason = "it was changed after it was written: it does not have its own digest";
        return Some(Flaw::Changed(reason));
    }
    (last != line(page, records)).then_some(Flaw::OutOfDate)
}

fn line(page: &str, records: &BTreeMap<String, String>) -> String {
    let lines: String = records.iter().map(|(name, content)| format!("{name} {content}\n")).collect();
    format!(
        "{BEGIN} from records with the digest {}; digest of this page: {} -->",
        digest(&lines),
        digest(page)
    )
}

fn digest(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_that_was_edited_cut_or_written_from_other_records_is_found() {
        let records = BTreeMap::from([("paper/walk".to_owned(), "12ab".to_owned())]);
        let page = format!("# Reports\n\n{}\n\n| walk | FAIL |\n", SENTENCES[0]);
        let index = marked(&page, &records);
        assert_eq!(flaw(&index, &records), None);
        let reason = "it was changed after it was written: it does not have its own digest";
        let changed = Some(Flaw::Changed(reason));
        assert_eq!(flaw(&index.replace("FAIL", "PASS"), &records), changed);
        assert_eq!(flaw(&format!("{index}\nMore.\n"), &records), changed);
        let missing = Some(Flaw::Changed("it is the index, and its last line with its digest is missing"));
        assert_eq!(flaw(&page, &records), missing);
        assert_eq!(flaw("# My notes\n", &records), None);
        let others = BTreeMap::from([("paper/walk".to_owned(), "34cd".to_owned())]);
        let older = Some(Flaw::OutOfDate);
        assert_eq!(flaw(&index, &others), older);
        assert_eq!(flaw(&index, &BTreeMap::new()), older);
    }
}
