//! TOML text to the spanned tree, with all syntax errors of the text (E0001) and all repeated keys (E0104).

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::tree::{Entry, Item, Layer, Map, Node, Number};
use crate::diag::{Diagnostic, Sink, SourceId, Sources, Span};

/// Largest number of values in a document, including tables and lists.
const MOST_VALUES: usize = 50_000;

/// Parses a document in `sources`. `None` after a syntax error.
pub fn parse(sources: &Sources, source: SourceId, sink: &mut Sink) -> Option<Node> {
    let text = &*sources.get(source).text;
    let (tree, mut errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        let span = Span { source, start: 0, end: 0 };
        if let Some(extra) = one_too_many(tree.get_ref()) {
            let error = Diagnostic::error("E0009", format!("the file has more than {MOST_VALUES} values"));
            let place = Span { source, start: extra.start, end: extra.end };
            sink.emit(
                error
                    .at(place, "one too many")
                    .help("specs and robots have a few hundred values: check that this is the right file"),
            );
            return None;
        }
        return Some(Node { span, layer: Layer::File, item: Item::Table(map(tree.get_ref(), source)) });
    }
    errors.sort_by_key(|error| error.span().map_or(text.len(), |span| span.start));
    report(text, source, &errors, sink);
    None
}

/// Parses one TOML value, for example the default of a key. The value begins at `offset` of the source.
pub fn parse_value(text: &str, source: SourceId, offset: usize) -> Result<Node, String> {
    let value = DeValue::parse(text).map_err(|error| error.message().to_owned())?;
    let mut node = node(&value, source);
    shift(&mut node, offset);
    Ok(node)
}

/// The location of the first value beyond the limit.
fn one_too_many(table: &DeTable<'_>) -> Option<Range<usize>> {
    let mut places = Vec::new();
    places_in(table, &mut places);
    if places.len() <= MOST_VALUES {
        return None;
    }
    // Tables are sorted by their keys, not by their order in the text.
    places.sort_by_key(|place| place.start);
    places.into_iter().nth(MOST_VALUES)
}

fn places_in(table: &DeTable<'_>, found: &mut Vec<Range<usize>>) {
    table.iter().for_each(|(_, value)| places_of(value, found));
}

fn places_of(value: &Spanned<DeValue<'_>>, found: &mut Vec<Range<usize>>) {
    found.push(value.span());
    match value.get_ref() {
        DeValue::Array(items) => items.iter().for_each(|item| places_of(item, found)),
        DeValue::Table(table) => places_in(table, found),
        _ => {}
    }
}

/// Turns the parser's errors into diagnostics.
fn report(text: &str, source: SourceId, errors: &[toml::de::Error], sink: &mut Sink) {
    let mut repeated: Option<Range<usize>> = None;
    let mut broken: Option<usize> = None;
    for error in errors {
        if sink.is_full("E0001") || sink.is_full("E0104") {
            break;
        }
        let span = error.span().unwrap_or(text.len()..text.len());
        let place = Span { source, start: span.start.min(text.len()), end: span.end.min(text.len()) };
        if error.message() != "duplicate key" {
            // The parser continues after a mistake and may report another one in the same line.
            let line = line_of(text, place.start);
            if broken.replace(line.start) != Some(line.start) {
                let diagnostic = Diagnostic::error("E0001", format!("TOML syntax: {}", error.message()));
                sink.emit(advised(
                    diagnostic.at(place, ""),
                    error.message(),
                    &text[line.clone()],
                    source,
                    line.start,
                ));
            }
            continue;
        }
        // The keys of a repeated table are repeated with it: one cause, one error.
        if repeated.as_ref().is_some_and(|table| table.contains(&span.start)) {
            continue;
        }
        let line = line_of(text, span.start);
        if text[line.clone()].trim_start().starts_with('[') {
            let next = text[line.end..].find("\n[").map_or(text.len(), |offset| line.end + offset);
            repeated = Some(line.end..next);
        }
        let key = text.get(span.clone()).unwrap_or_default();
        let mut diagnostic =
            Diagnostic::error("E0104", format!("`{key}` is written twice")).at(place, "again here");
        if let Some(first) = first_occurrence(text, span.clone()) {
            diagnostic =
                diagnostic.note(Span { source, start: first.start, end: first.end }, "first written here");
        }
        sink.emit(diagnostic.help("keep one of the two"));
    }
}

/// A syntax error with advice, if the line shows what was probably intended.
fn advised(error: Diagnostic, message: &str, line: &str, source: SourceId, start: usize) -> Diagnostic {
    if let Some((key, value)) = assigned(line).filter(|(_, value)| is_plain(&line[value.clone()])) {
        let place = Span { source, start: start + value.start, end: start + value.end };
        return meant(error, key, &line[value], place);
    }
    if line.trim_start().starts_with('[') && !line.contains(']') {
        let header = line.split('#').next().unwrap_or_default().trim();
        let start = start + (line.len() - line.trim_start().len());
        let place = Span { source, start, end: start + header.len() };
        let closed = format!("{header}{}", if header.starts_with("[[") { "]]" } else { "]" });
        return error.help(format!("close the header: `{closed}`")).fix(place, closed);
    }
    if line.contains(|letter: char| letter.is_control() && letter != '\t') {
        return error.help("remove the control character, or write it as an escape such as `\\u0007`");
    }
    if message.contains("recursion") {
        return error.help("specs and robots have a few levels: check that this is the right file");
    }
    if message.contains("string") {
        return error.help("close the string on the same line with the same quote");
    }
    if !line.contains('=') && !line.trim().is_empty() {
        return error.help("write `key = value`, or a table header such as `[action]`");
    }
    error
}

/// The key of a line and the range of its value.
fn assigned(line: &str) -> Option<(&str, Range<usize>)> {
    let (key, rest) = line.split_once('=')?;
    let value = rest.split('#').next().unwrap_or_default();
    let start = line.len() - rest.len() + (value.len() - value.trim_start().len());
    Some((key.trim(), start..start + value.trim().len()))
}

/// Whether a value that is not TOML is empty, or a single word or quantity.
fn is_plain(value: &str) -> bool {
    let begins = value.starts_with(|c: char| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.'));
    let single = begins && !value.contains(['"', '\'', '[', ']', '{', '}', ',', '=']);
    value.is_empty() || (single && DeValue::parse(value).is_err())
}

/// Advice for a value that is empty, a word of another language, or only lacks its quotes: `4 ms`, `torque`.
fn meant(error: Diagnostic, key: &str, value: &str, place: Span) -> Diagnostic {
    if value.is_empty() {
        return error.help(format!("`{key}` has no value: write one, or remove the line"));
    }
    if matches!(value, "None" | "null" | "nil" | "NULL") {
        return error.help(format!("TOML has no `{value}`: remove the line, or write the word as a string"));
    }
    if let Some(written) = literal(value) {
        return error.help(format!("TOML writes it as `{key} = {written}`")).fix(place, written);
    }
    let written = super::tree::quoted(value);
    error.help(format!("words and quantities are strings: `{key} = {written}`")).fix(place, written)
}

/// The boolean or the number that a word represents: `true` for `True`, `0.99` for `.99`.
pub fn literal(word: &str) -> Option<String> {
    match word.to_ascii_lowercase().as_str() {
        "true" | "yes" | "on" => return Some("true".to_owned()),
        "false" | "no" | "off" => return Some("false".to_owned()),
        _ => {}
    }
    let (sign, digits) = word.split_at(word.len() - word.trim_start_matches(['+', '-']).len());
    let (mantissa, exponent) = digits.split_at(digits.find(['e', 'E']).unwrap_or(digits.len()));
    let (whole, fraction) =
        mantissa.split_once('.').map_or((mantissa, None), |(whole, rest)| (whole, Some(rest)));
    let whole = Some(whole.trim_start_matches('0')).filter(|whole| !whole.is_empty()).unwrap_or("0");
    let fraction = fraction.map(|digits| format!(".{}", if digits.is_empty() { "0" } else { digits }));
    let written = format!("{sign}{whole}{}{exponent}", fraction.unwrap_or_default());
    let number = word.parse::<f64>().is_ok_and(f64::is_finite);
    (number && DeValue::parse(&written).is_ok()).then_some(written)
}

/// The line around a byte, without its line break.
fn line_of(text: &str, at: usize) -> Range<usize> {
    let start = text[..at].rfind('\n').map_or(0, |index| index + 1);
    let end = text[at..].find('\n').map_or(text.len(), |index| at + index);
    start..end
}

/// Location of the first occurrence of a repeated key or table header.
fn first_occurrence(text: &str, again: Range<usize>) -> Option<Range<usize>> {
    let line = line_of(text, again.start);
    let left = text[line.start..again.start].trim();
    let key = text.get(again.clone())?;
    let mut end = line.start.checked_sub(1)?;
    let header = left.starts_with('[');
    loop {
        let earlier = line_of(text, end);
        let written = &text[earlier.clone()];
        let same = if header {
            written.trim() == text[line.clone()].trim()
        } else {
            written.trim_start().strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('='))
        };
        if same {
            let start = earlier.start + written.rfind(key).filter(|_| header).or(written.find(key))?;
            return Some(start..start + key.len());
        }
        end = earlier.start.checked_sub(1)?;
    }
}

fn span(range: Range<usize>, source: SourceId) -> Span {
    Span { source, start: range.start, end: range.end }
}

fn map(table: &DeTable<'_>, source: SourceId) -> Map {
    let entries = table.iter().map(|(key, value)| {
        let entry = Entry { key: span(key.span(), source), node: node(value, source) };
        (key.get_ref().to_string(), entry)
    });
    Map { entries: entries.collect(), ..Map::default() }
}

fn node(value: &Spanned<DeValue<'_>>, source: SourceId) -> Node {
    let item = match value.get_ref() {
        DeValue::String(text) => Item::Text(text.to_string()),
        DeValue::Integer(integer) => {
            let whole = i64::from_str_radix(integer.as_str(), integer.radix()).ok();
            let value =
                whole.map_or_else(|| integer.as_str().parse().unwrap_or(f64::INFINITY), |whole| whole as f64);
            Item::Number(Number { text: integer.to_string(), value, whole })
        }
        DeValue::Float(float) => {
            let value = float.as_str().parse().unwrap_or(f64::NAN);
            Item::Number(Number { text: float.as_str().to_owned(), value, whole: None })
        }
        DeValue::Boolean(flag) => Item::Flag(*flag),
        DeValue::Datetime(_) => Item::Datetime,
        DeValue::Array(items) => Item::List(items.iter().map(|item| node(item, source)).collect()),
        DeValue::Table(table) => Item::Table(map(table, source)),
    };
    Node { span: span(value.span(), source), layer: Layer::File, item }
}

/// Moves spans by an offset.
fn shift(node: &mut Node, offset: usize) {
    let moved = |span: Span| Span { start: span.start + offset, end: span.end + offset, ..span };
    node.span = moved(node.span);
    match &mut node.item {
        Item::List(items) => items.iter_mut().for_each(|item| shift(item, offset)),
        Item::Table(map) => map.entries.values_mut().for_each(|entry| {
            entry.key = moved(entry.key);
            shift(&mut entry.node, offset);
        }),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> (Option<Node>, Vec<Diagnostic>) {
        let mut sources = Sources::default();
        let source = sources.add("a.toml", text);
        let mut sink = Sink::default();
        (parse(&sources, source, &mut sink), sink.diagnostics)
    }

    #[test]
    fn keys_and_values_know_their_places() {
        let text = "[learn]\nsamples = \"80 M\"\nvalue.hidden = [1, 2]\n";
        let (node, diagnostics) = parsed(text);
        assert_eq!(diagnostics, []);
        let root = node.expect("no errors");
        let learn = &root.table().expect("a table").entries["learn"];
        assert_eq!(&text[learn.key.start..learn.key.end], "learn");
        assert_eq!(&text[learn.node.span.start..learn.node.span.end], "[learn]");
        let samples = &learn.node.table().expect("a table").entries["samples"];
        assert_eq!(&text[samples.key.start..samples.key.end], "samples");
        assert_eq!(&text[samples.node.span.start..samples.node.span.end], "\"80 M\"");
        let value = &learn.node.table().expect("a table").entries["value"].node;
        let hidden = value.table().expect("a dotted table").get("hidden").expect("the key");
        let Item::List(items) = &hidden.item else { panic!("a list") };
        assert_eq!(&text[items[1].span.start..items[1].span.end], "2");
    }

    #[test]
    fn every_syntax_error_of_a_text_is_reported() {
        let (node, diagnostics) = parsed("a = \nb = 1\nc = [1,\nd = \"x\n");
        assert!(node.is_none());
        assert!(diagnostics.len() >= 2, "{diagnostics:?}");
        assert!(diagnostics.iter().all(|diagnostic| diagnostic.code == "E0001"));
        let lines: Vec<_> = diagnostics.iter().map(|diagnostic| diagnostic.labels[0].span.start).collect();
        assert!(lines.is_sorted() && lines[0] <= 4, "{diagnostics:#?}");
    }

    #[test]
    fn missing_quotes_are_seen_and_one_line_is_one_error() {
        let (_, diagnostics) = parsed("[action]\ndelay = 4 ms  # later\nkind = torque\n");
        let fixes: Vec<_> =
            diagnostics.iter().filter_map(|found| Some(found.fix.as_ref()?.replacement.as_str())).collect();
        assert_eq!((diagnostics.len(), fixes), (2, vec!["\"4 ms\"", "\"torque\""]));
        assert_eq!(diagnostics[0].help, ["words and quantities are strings: `delay = \"4 ms\"`"]);
    }

    #[test]
    fn words_and_numbers_of_other_languages_are_mended_at_once() {
        let advice = |value: &str| {
            let (_, diagnostics) = parsed(&format!("a = {value}\n"));
            assert_eq!(diagnostics.len(), 1, "{value}: {diagnostics:?}");
            let fix = diagnostics[0].fix.as_ref().map(|fix| fix.replacement.clone());
            fix.unwrap_or_else(|| diagnostics[0].help[0].clone())
        };
        for (written, meant) in [
            ("True", "true"),
            ("off", "false"),
            (".99", "0.99"),
            ("-.5", "-0.5"),
            ("1.", "1.0"),
            ("1.e-4", "1.0e-4"),
            ("007", "7"),
            ("4 ms", "\"4 ms\""),
            ("", "`a` has no value: write one, or remove the line"),
            ("null", "TOML has no `null`: remove the line, or write the word as a string"),
        ] {
            assert_eq!(advice(written), meant, "{written}");
        }
    }

    #[test]
    fn a_term_written_twice_is_one_error_that_names_both_places() {
        let text = "[reward.torque]\nweight = 1\n[reward.x]\nk = 1\n[reward.torque]\nweight = 2\n";
        let (_, diagnostics) = parsed(text);
        assert_eq!(diagnostics.len(), 1, "{diagnostics:?}");
        assert_eq!(diagnostics[0].code, "E0104");
        assert_eq!(diagnostics[0].labels[0].span.start, text.rfind("torque").expect("there"));
        assert_eq!(diagnostics[0].labels[1].span.start, text.find("torque").expect("there"));
    }

    #[test]
    fn a_key_written_twice_names_the_first() {
        let (_, diagnostics) = parsed("a = 1\nb = 2\na = 3\n");
        assert_eq!((diagnostics.len(), diagnostics[0].code), (1, "E0104"));
        assert_eq!(diagnostics[0].labels[1].span.start, 0);
    }
}
