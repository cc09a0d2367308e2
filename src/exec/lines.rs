//! JSON lines with chained digests, for files that grow line by line. Each digest also covers all lines
//! before it, so an edited, removed, added or moved line is detected at the first line that follows it.

/// Hex digits of a digest.
const DIGITS: usize = 32;
/// Separates a line's JSON from its digest.
const KEY: &str = ",\"check\":\"";

/// The digest of a text, as the start of a chain of lines.
pub fn begin(text: &[u8]) -> String {
    short(blake3::Hasher::new_derive_key("specforge lines, begin v1").update(text))
}

/// The digest of a line's JSON (without its digest) and, through `before`, of everything before it.
fn after(before: &str, body: &str) -> String {
    let mut hasher = blake3::Hasher::new_derive_key("specforge lines, next v1");
    short(hasher.update(before.as_bytes()).update(b"\n").update(body.as_bytes()))
}

fn short(hasher: &blake3::Hasher) -> String {
    hasher.finalize().to_hex()[..DIGITS].to_owned()
}

/// Adds the digest to a line of JSON; also returns the digest, which is `before` for the next line.
pub fn seal(before: &str, body: &str) -> (String, String) {
    let digest = after(before, body);
    let open = body.strip_suffix('}').unwrap_or(body);
    (format!("{open}{KEY}{digest}\"}}"), digest)
}

/// Splits a line into JSON and digest without checking the digest; `None` for a line without a digest.
pub fn split(line: &str) -> Option<(String, &str)> {
    let rest = line.strip_suffix("\"}")?;
    let (open, digest) = rest.split_at_checked(rest.len().checked_sub(DIGITS)?)?;
    let is_digest = digest.bytes().all(|byte| byte.is_ascii_hexdigit());
    let open = open.strip_suffix(KEY).filter(|_| is_digest)?;
    Some((format!("{open}}}"), digest))
}

/// The JSON of a line and its digest; `None` if the digest does not match.
pub fn open<'a>(before: &str, line: &'a str) -> Option<(String, &'a str)> {
    split(line).filter(|(body, digest)| after(before, body) == *digest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_opens_only_unchanged_and_in_its_place() {
        let start = begin(b"heading\n");
        let (first, digest) = seal(&start, r#"{"a":1}"#);
        let (second, _) = seal(&digest, r#"{"b":"x\"}"}"#);
        assert!(serde_json::from_str::<serde_json::Value>(&first).is_ok(), "{first}");
        assert_eq!(open(&start, &first), Some((r#"{"a":1}"#.to_owned(), digest.as_str())));
        assert_eq!(open(&digest, &second).map(|(body, _)| body).as_deref(), Some(r#"{"b":"x\"}"}"#));
        for changed in
            [first.replace('1', "2"), first.replace("\"a\"", "\"c\""), second.clone(), String::new()]
        {
            assert_eq!(open(&start, &changed), None, "{changed}");
        }
        assert_eq!(open(&begin(b"other"), &first), None);
        assert_eq!(split(r#"{"a":1}"#), None);
    }
}
