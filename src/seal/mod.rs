//! The digest of a record over its own content, by which an edit of the record itself is found: of the record of a
//! report and of that of a run.
//!
//! It is taken over the canonical JSON of the file without the field that holds it, as the file is and not as
//! this version of the program reads it: a field that a later version adds breaks no earlier record. A record
//! without a digest is one of the few of before there were any ([`unsealed`]), or its digest was removed.

pub mod unsealed;

use serde_json::Value as Json;

use crate::plan::fingerprint::canonical_json;
use unsealed::{Earlier, Unsealed};

/// The field of a record that holds its digest.
pub const FIELD: &str = "seal";

/// How a record stands to its own digest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Seal {
    /// It is as it was written.
    Whole,
    /// It was changed after it was written.
    Broken,
    /// It is of before records had a digest, and as it was when the list of those was made.
    Earlier(Earlier),
    /// It has no digest, and is none of before there were any.
    Absent,
}

/// What is wrong with a record without a digest.
pub const REMOVED: &str =
    "it has no digest of itself, which every record has that this version writes: it was removed";

/// The digest of a record's content, whatever digest it has now; `None` when the text is no JSON object.
pub fn of(record: &str) -> Option<String> {
    let mut json: Json = serde_json::from_str(record).ok()?;
    json.as_object_mut()?.shift_remove(FIELD);
    Some(blake3::hash(canonical_json(&json).as_bytes()).to_hex().to_string())
}

/// How the text of a record stands to the digest that it has, or to the list of records without one.
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
