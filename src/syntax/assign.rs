//! `--set path=value`: an assignment on the command line as a small tree that is merged over a spec.

use super::parse::parse_value;
use super::tree::{Entry, Item, Layer, Map, Node};
use crate::diag::{Diagnostic, Sink, SourceId, Sources, Span};

/// Parses an assignment. The value is TOML; anything else is taken as a string, so that `--set
/// action.kind=torque` and `--set "action.std=10 %"` need no inner quotes.
pub fn assignment(argument: &str, sources: &mut Sources, sink: &mut Sink) -> Option<Map> {
    assignment_of(&SET, argument, sources, sink)
}

/// An option of the command line whose value has assignments.
#[derive(Clone, Copy, Debug)]
pub struct Assigning<'a> {
    /// Its name, `--set`, which stands for a file in messages.
    pub option: &'a str,
    /// The help for an invalid assignment: how to write the option.
    pub usage: &'a str,
}

/// The option `--set`.
pub const SET: Assigning =
    Assigning { option: "--set", usage: "write `--set path=value`, for example `--set learn.seed=2`" };

/// The same for any option; messages refer to it.
pub fn assignment_of(
    option: &Assigning,
    argument: &str,
    sources: &mut Sources,
    sink: &mut Sink,
) -> Option<Map> {
    let source = sources.add(option.option, argument);
    let whole = Span { source, start: 0, end: argument.len() };
    let Some(equals) = argument.find('=') else {
        let error = Diagnostic::error(
            "E0607",
            format!(
                "invalid assignment \
                 `{argument}`"
            ),
        )
        .at(whole, "`=` is missing");
        sink.emit(error.help(option.usage));
        return None;
    };
    let mut keys = Vec::new();
    let mut at = 0;
    for key in argument[..equals].split('.') {
        let start = at + (key.len() - key.trim_start().len());
        let name = key.trim();
        if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-')) {
            let path = Span { source, start: 0, end: equals };
            sink.emit(
                Diagnostic::error("E0607", "invalid path of an assignment: join keys by dots")
                    .at(path, "")
                    .help(option.usage),
            );
            return None;
        }
        keys.push((name.to_owned(), Span { source, start, end: start + name.len() }));
        at += key.len() + 1;
    }
    let value = value(&argument[equals + 1..], source, equals + 1, sink)?;
    let nest = |node: Node, (name, key): (String, Span)| {
        let map = Map { entries: [(name, Entry { key, node })].into(), ..Map::default() };
        Node { span: key, layer: Layer::Set, item: Item::Table(map) }
    };
    let mut root = keys.into_iter().rev().fold(value, nest);
    root.stamp(Layer::Set);
    root.table().cloned()
}

/// The value of an assignment.
fn value(text: &str, source: SourceId, offset: usize, sink: &mut Sink) -> Option<Node> {
    let trimmed = text.trim();
    let start = offset + (text.len() - text.trim_start().len());
    let span = Span { source, start, end: start + trimmed.len() };
    match parse_value(trimmed, source, start) {
        Ok(mut node) => {
            node.span = span;
            Some(node)
        }
        Err(message) if trimmed.starts_with(['"', '\'', '[', '{']) => {
            let error = Diagnostic::error("E0001", format!("TOML syntax: {message}")).at(span, "");
            sink.emit(error.help("write the value as in a spec: `\"text\"`, `[1, 2]`, `{ key = 1 }`"));
            None
        }
        Err(_) => Some(Node { span, layer: Layer::Set, item: Item::Text(trimmed.to_owned()) }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assigned(argument: &str) -> Result<Map, &'static str> {
        let mut sink = Sink::default();
        assignment(argument, &mut Sources::default(), &mut sink).ok_or_else(|| sink.diagnostics[0].code)
    }

    fn leaf(argument: &str) -> Node {
        let mut map = assigned(argument).expect("an assignment");
        loop {
            let (_, entry) = map.entries.pop_first().expect("one key");
            match entry.node.item {
                Item::Table(below) if !below.entries.contains_key("uniform") => map = below,
                _ => return entry.node,
            }
        }
    }

    #[test]
    fn values_are_toml_or_bare_words() {
        assert_eq!(leaf("learn.samples=2 M").text(), Some("2 M"));
        assert_eq!(leaf("action.kind = torque").text(), Some("torque"));
        assert_eq!(leaf("action.std=\"10 %\"").text(), Some("10 %"));
        assert_eq!(leaf("action.phase_modulation=false").item, Item::Flag(false));
        assert!(leaf("x.y={ uniform = [1, 2] }").table().is_some());
        let node = leaf("learn.seed=2");
        assert_eq!((node.span.start, node.span.end, node.layer), (11, 12, Layer::Set));
    }

    #[test]
    fn what_is_no_assignment_is_refused() {
        assert_eq!(assigned("learn.seed"), Err("E0607"));
        assert_eq!(assigned("learn..seed=1"), Err("E0607"));
        assert_eq!(assigned("=1"), Err("E0607"));
        assert_eq!(assigned("learn.seed=[1"), Err("E0001"));
    }
}
