//! Diagnostics for programs: the JSON of `check --format json`, stable within the edition.

use serde_json::{Map, Value, json};

use super::count;
use crate::diag::{Diagnostic, Severity, Sources, Span};

/// `{"diagnostics": [...], "errors": N, "warnings": N}`. Lines and columns count from 1, columns in
/// characters; an end is the position after the last character. `file` and the positions are null if unknown.
pub fn json(sources: &Sources, diagnostics: &[Diagnostic]) -> Value {
    let (errors, warnings) = count(diagnostics);
    let diagnostics: Vec<Value> = diagnostics.iter().map(|diagnostic| one(sources, diagnostic)).collect();
    json!({ "diagnostics": diagnostics, "errors": errors, "warnings": warnings })
}

fn one(sources: &Sources, diagnostic: &Diagnostic) -> Value {
    let severity = match diagnostic.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    let mut object = Map::new();
    object.insert("code".into(), json!(diagnostic.code));
    object.insert("severity".into(), json!(severity));
    object.insert("message".into(), json!(diagnostic.message));
    let primary = diagnostic.labels.iter().find(|label| label.primary).or(diagnostic.labels.first());
    object.extend(place(sources, primary.map(|label| label.span)));
    let labels: Vec<Value> = diagnostic
        .labels
        .iter()
        .map(|label| {
            let mut object = place(sources, Some(label.span));
            object.insert("text".into(), json!(label.text));
            object.insert("primary".into(), json!(label.primary));
            Value::Object(object)
        })
        .collect();
    object.insert("labels".into(), json!(labels));
    object.insert("help".into(), json!(diagnostic.help));
    let fix = diagnostic.fix.as_ref().map(|fix| {
        let mut object = place(sources, Some(fix.span));
        object.insert("replacement".into(), json!(fix.replacement));
        object
    });
    object.insert("fix".into(), json!(fix));
    Value::Object(object)
}

fn place(sources: &Sources, span: Option<Span>) -> Map<String, Value> {
    let file = span.map(|span| sources.get(span.source).name.display().to_string());
    let positions = span.map(|span| sources.positions(span));
    let value = json!({
        "file": file,
        "line": positions.map(|[start, _]| start.line),
        "column": positions.map(|[start, _]| start.column),
        "end_line": positions.map(|[_, end]| end.line),
        "end_column": positions.map(|[_, end]| end.column),
    });
    match value {
        Value::Object(object) => object,
        _ => Map::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_from_one_and_ends_are_exclusive() {
        let mut sources = Sources::default();
        let source = sources.add("a.toml", "spec = 1\nlimit = \"0.8 rad/s\"\n");
        let place = Span { source, start: 22, end: 27 };
        let diagnostic =
            Diagnostic::error("E0203", "unit mismatch").at(place, "not an angle").help("x").fix(place, "rad");
        let expected = json!({
            "diagnostics": [{
                "code": "E0203", "severity": "error", "message": "unit mismatch",
                "file": "a.toml", "line": 2, "column": 14, "end_line": 2, "end_column": 19,
                "labels": [{
                    "file": "a.toml", "line": 2, "column": 14, "end_line": 2, "end_column": 19,
                    "text": "not an angle", "primary": true,
                }],
                "help": ["x"],
                "fix": {
                    "file": "a.toml", "line": 2, "column": 14, "end_line": 2, "end_column": 19,
                    "replacement": "rad",
                },
            }],
            "errors": 1,
            "warnings": 0,
        });
        assert_eq!(json(&sources, &[diagnostic]), expected);
    }

    #[test]
    fn without_a_place_the_positions_are_null() {
        let value = json(&Sources::default(), &[Diagnostic::warning("W0501", "no weight")]);
        assert_eq!(value["diagnostics"][0]["file"], Value::Null);
        assert_eq!(value["diagnostics"][0]["line"], Value::Null);
        assert_eq!((&value["errors"], &value["warnings"]), (&json!(0), &json!(1)));
    }
}
