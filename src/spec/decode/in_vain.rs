//! W0524: assignments of the command line to a table that is disabled.

use crate::diag::{Diagnostic, Sink, Span};
use crate::spec::marks::below;
use crate::syntax::{Layer, Map, Node};

/// Warns of assignments below a disabled table, unless one of them disables it.
pub fn assigned_in_vain(node: &Node, path: &str, sink: &mut Sink) {
    let Some((map, switch)) = node.table().and_then(|map| Some((map, map.get("enabled")?))) else { return };
    if switch.layer == Layer::Set {
        return;
    }
    let mut found = Vec::new();
    assigned(map, path, &mut found);
    for (key, place) in found {
        let message = format!("`{key}` has no effect: `{path}` is disabled");
        let help = format!("add `--set {path}.enabled=true`, or leave the assignment out");
        let warning = Diagnostic::warning("W0524", message).at(place, "not read");
        sink.emit(warning.note(switch.span, "disabled here").help(help));
    }
}

/// The assigned keys of a table, with the places of their values.
fn assigned(map: &Map, path: &str, found: &mut Vec<(String, Span)>) {
    for (key, entry) in &map.entries {
        let path = below(path, key);
        match entry.node.table() {
            Some(table) => assigned(table, &path, found),
            None if entry.node.layer == Layer::Set => found.push((path, entry.node.span)),
            None => {}
        }
    }
}
