//! The digest of a record over its own content, which detects edits of the record itself. Used for the
//! records of reports and of runs.
//!
//! It covers the file's canonical JSON without the digest field, including fields that this version does not
//! know, so fields added later do not invalidate earlier records. A record without a digest is either older
//! than digests ([`unsealed`]), or its digest was removed.

pub mod unsealed;

use serde_json::Value as Json;

use crate::plan::fingerprint::canonical_json;
use unsealed::{Earlier, Unsealed};

/// The field of a record that holds its digest.
pub const FIELD: &str = "seal";

/// The result of comparing a record with its digest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Seal {
    /// It is unchanged.
    Whole,
    /// It was changed after it was written.
    Broken,
    /// It is older than digests, and unchanged since the list of such records was made.
    Earlier(Earlier),
    /// It has no digest, and is not on that list.
    Absent,
}

/// What is wrong with a record without a digest.
pub const REMOVED: &str =
    "it has no digest of itself: the digest was removed, or the record is an old one and was edited";

/// The digest of a record's content, ignoring the one it has; `None` if the text is not a JSON object.
pub fn of(record: &str) -> Option<String> {
    let mut json: Json = serde_json::from_str(record).ok()?;
    json.as_object_mut()?.shift_remove(FIELD);
    Some(blake3::hash(canonical_json(&json).as_bytes()).to_hex().to_string())
}

/// Compares the text of a record with its digest or, without one, with the list of older records.
pub fn state(record: &str, unsealed: &Unsealed) -> Seal {
    let json: Option<Json> = serde_json::from_str(record).ok();
    let digest = of(record);
    match json.as_ref().map(|json| json.get(FIELD)) {
        Some(None) => digest.and_then(|digest| unsealed.find(&digest)).map_or(Seal::Absent, Seal::Earlier),
        Some(Some(Json::String(own))) if Some(own) == digest.as_ref() => Seal::Whole,
        _ => Seal::Broken,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_change_of_content_breaks_the_seal_and_one_of_layout_does_not() {
        let content = r#"{"report":"walk","claims":[{"p":0.012,"verdict":"PASS"}],"mine":null}"#;
        let none = Unsealed::default();
        let state = |record: &str| state(record, &none);
        assert_eq!(state(content), Seal::Absent);
        let digest = of(content).expect("an object");
        let sealed = content.replacen('{', &format!("{{\"seal\":\"{digest}\","), 1);
        assert_eq!(state(&sealed), Seal::Whole);
        let json: Json = serde_json::from_str(&sealed).expect("JSON");
        assert_eq!(state(&serde_json::to_string_pretty(&json).expect("JSON")), Seal::Whole);
        for (from, to) in
            [("0.012", "0.0120001"), ("PASS", "FAIL"), ("mine", "yours"), ("null", "0"), ("walk", "run")]
        {
            assert_eq!(state(&sealed.replacen(from, to, 1)), Seal::Broken, "{from}");
        }
        let cut = &sealed[..sealed.len() - 3];
        for broken in [cut, "{\"seal\": null}", "{\"seal\": 3}", "{\"seal\": \"\"}", "[]x"] {
            assert_eq!(state(broken), Seal::Broken, "{broken}");
        }
        assert_eq!((of("[]"), of("{")), (None, None));
    }

    #[test]
    fn a_record_without_a_digest_is_an_earlier_one_only_as_it_is_listed() {
        let record = r#"{"report":"walk","claims":[]}"#;
        let digest = of(record).expect("an object");
        let list = Unsealed::parse(&format!("# A list.\n{digest} paper/walk.json\n  12ab walk.md\n"));
        let Seal::Earlier(earlier) = state(record, &list) else { panic!("it is listed") };
        assert_eq!((earlier.path.as_str(), earlier.files["walk.md"].as_str()), ("paper/walk.json", "12ab"));
        assert_eq!(state(&record.replace("walk", "run"), &list), Seal::Absent);
        assert_eq!(state(record, &Unsealed::default()), Seal::Absent);
    }
}
