//! The digest of a report's record over its own content, by which an edit of the record itself is found.
//!
//! It is taken over the canonical JSON of the file without the field that holds it, as the file is and not as
//! this version of the program reads it: a field that a later version adds breaks no earlier record.

use serde_json::Value as Json;

use crate::plan::fingerprint::canonical_json;

/// The field of a record that holds its digest.
pub const FIELD: &str = "seal";

/// How a record stands to its own digest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seal {
    /// It is as it was written.
    Whole,
    /// It was changed after it was written.
    Broken,
    /// It has no digest, like those of earlier versions, so nobody can say.
    Absent,
}

/// The digest of a record's content, whatever digest it has now; `None` when the text is no JSON object.
pub fn of(record: &str) -> Option<String> {
    let mut json: Json = serde_json::from_str(record).ok()?;
    json.as_object_mut()?.shift_remove(FIELD);
    Some(blake3::hash(canonical_json(&json).as_bytes()).to_hex().to_string())
}

/// How the text of a record stands to the digest that it has.
pub fn state(record: &str) -> Seal {
    let json: Option<Json> = serde_json::from_str(record).ok();
    match json.as_ref().map(|json| json.get(FIELD)) {
        Some(None) => Seal::Absent,
        Some(Some(Json::String(digest))) if Some(digest) == of(record).as_ref() => Seal::Whole,
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
