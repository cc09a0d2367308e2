//! Checks that redundant parts of a manifest agree. The manifest's digest only detects accidental damage;
//! this also detects manifests that were edited and given a new digest.

use super::manifest::{FILE, Manifest};
use crate::plan::StageKind;
use crate::spec::{Table, Value};

/// Checks a manifest against the kind it is stored under.
pub fn agrees(manifest: &Manifest, kind: StageKind) -> Result<(), String> {
    let stage = &manifest.stage;
    if stage.kind != kind || stage.recipe.stage != kind.name() {
        return Err(format!("{FILE} is that of a stage of another kind"));
    }
    if stage.recipe.fingerprint() != stage.fingerprint {
        return Err(format!("{FILE} belongs to another stage"));
    }
    if let Some(path) = stage.hidden_field() {
        return Err(format!("{FILE}: `{path}` has another value in its fields than in its recipe"));
    }
    match denied(&stage.fields, "") {
        Some(path) => Err(format!("{FILE}: the text of `{path}` says another number")),
        None => Ok(()),
    }
}

/// The path of a quantity whose text and number disagree.
fn denied(table: &Table, above: &str) -> Option<String> {
    table.iter().find_map(|(key, value)| match value {
        Value::Quantity(quantity) if quantity.denies_its_number() => Some(format!("{above}{key}")),
        Value::Table(inner) => denied(inner, &format!("{above}{key}.")),
        _ => None,
    })
}
