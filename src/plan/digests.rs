//! The digests of a saved plan's parts. What follows from the rest of a plan is computed again when it is read; how the
//! user asked for it, and which warnings are meant, is said once, and an edit of that only a digest tells.

use std::collections::BTreeMap;

use serde::Serialize;

use super::graph::{ArmRecord, Stage};
use super::suite::SuiteRecord;

/// BLAKE3 digests by the place in the file: `arms[].request.spec`.
pub type Digests = BTreeMap<String, String>;

/// The digests of what a plan is made of.
pub fn of(arms: &[ArmRecord], suite: Option<&SuiteRecord>, stages: &[Stage]) -> Digests {
    let mut digests = Digests::new();
    let mut add = |place: &str, digest: String| drop(digests.insert(place.to_owned(), digest));
    add("arms[].name", each(arms, |arm| &arm.name));
    add("arms[].request.spec", each(arms, |arm| &arm.request.spec));
    add("arms[].request.place", each(arms, |arm| &arm.request.place));
    add("arms[].request.profile", each(arms, |arm| &arm.request.profile));
    add("arms[].request.assignments", each(arms, |arm| &arm.request.assignments));
    add("arms[].request.outside", each(arms, |arm| &arm.request.outside));
    add("arms[].fields", each(arms, |arm| &arm.fields));
    add("arms[].origins", each(arms, |arm| &arm.origins));
    add("arms[].stages", each(arms, |arm| &arm.stages));
    add("arms[].allow", each(arms, |arm| &arm.allow));
    add("arms[].run", each(arms, |arm| &arm.run));
    add("suite", each(suite.as_slice(), |suite| suite));
    add("stages", each(stages, |stage| stage));
    digests
}

/// The places whose digests differ or are missing.
pub fn differing(saved: &Digests, found: &Digests) -> Vec<String> {
    let places = found.keys().filter(|place| saved.get(*place) != found.get(*place));
    let unknown = saved.keys().filter(|place| !found.contains_key(*place));
    places.chain(unknown).map(|place| format!("`{place}`")).collect()
}

/// The digest of a part of each element, written into the hash as it is made: a plan of a thousand runs is long.
fn each<T, P: Serialize>(elements: &[T], part: impl Fn(&T) -> &P) -> String {
    let mut hasher = blake3::Hasher::new();
    for element in elements {
        serde_json::to_writer(&mut hasher, part(element))
            .expect("names, numbers and lists can be written as JSON");
        hasher.update(b"\n");
    }
    hasher.finalize().to_hex().to_string()
}
