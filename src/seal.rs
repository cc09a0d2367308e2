//! The digest of a record over its own content, which detects edits of the record itself. Used for the
//! records of reports and of runs.
//!
//! It covers the file's canonical JSON without the digest field, including fields that this version does not
//! know, so fields added later do not invalidate earlier records.

use serde_json::Value as Json;

use crate::plan::fingerprint::canonical_json;

/// The field of a record that holds its digest.
pub const FIELD: &str = "seal";

/// The result of comparing a record with its digest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seal {
    /// It is unchanged.
    Whole,
    /// It was changed after it was written.
    Broken,
    /// It has no digest: it was removed.
    Absent,
}

/// What is wrong with a record without a digest.
pub const REMOVED: &str = "it has no digest of itself: the digest was removed";

/// The digest of a record's content, ignoring the one it has; `None` if the text is not a JSON object.
pub fn of(record: &str) -> Option<String> {
    let mut json: Json = serde_json::from_str(record).ok()?;
    json.as_object_mut()?.shift_remove(FIELD);
    Some(blake3::hash(canonical_json(&json).as_bytes()).to_hex().to_string())
}

/// Compares the text of a record with its digest.
pub fn state(record: &str) -> Seal {
    let json: Option<Json> = serde_json::from_str(record).ok();
    match json.as_ref().map(|json| json.get(FIELD)) {
        Some(None) => Seal::Absent,
        Some(Some(Json::String(own))) if Some(own) == of(record).as_ref() => Seal::Whole,
        _ => Seal::Broken,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_change_of_content_breaks_the_seal_and_one_of_layout_does_not() {
        let content = r#"{"report":"walk","claims":[{"p":0.012,"verdict":"PASS"}],"mine":null}"#;
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
}
