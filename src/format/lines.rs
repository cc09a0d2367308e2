//! A TOML text as lines: headers, entries, comments and blank lines, each with its own text.

use std::ops::Range;

use toml_parser::Source;
use toml_parser::parser::{Event, EventKind, parse_document};

/// A file, line by line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Document<'a> {
    /// Lines before everything else, which stay there.
    pub top: Vec<Trivia<'a>>,
    /// The keys before the first header, then a table per header.
    pub tables: Vec<Table<'a>>,
    /// Lines after the last line of code.
    pub end: Vec<Trivia<'a>>,
    /// The line ending.
    pub line_end: &'static str,
}

/// A header with the entries below it; the first table of a document has no header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table<'a> {
    /// The header.
    pub header: Option<Line<'a>>,
    /// The entries.
    pub entries: Vec<Line<'a>>,
}

/// A header or an entry, with the comments that belong to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Line<'a> {
    /// Lines above it.
    pub lead: Vec<Trivia<'a>>,
    /// Its keys; for a header, the table's path.
    pub path: Vec<String>,
    /// A header as a whole, or the key of an entry.
    pub text: String,
    /// The value of an entry, verbatim.
    pub value: Option<&'a str>,
    /// The comment at its end.
    pub comment: Option<&'a str>,
    /// Comments directly below it that do not belong to the next line.
    pub tail: Vec<&'a str>,
}

/// A line without code.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trivia<'a> {
    /// An empty line.
    Blank,
    /// A line of comment.
    Comment(&'a str),
}

impl Table<'_> {
    /// The path of the table; empty before the first header.
    pub fn path(&self) -> &[String] {
        self.header.as_ref().map_or(&[], |header| header.path.as_slice())
    }
}

impl Line<'_> {
    /// Whether there is a comment directly above it.
    pub fn is_explained(&self) -> bool {
        matches!(self.lead.last(), Some(Trivia::Comment(_)))
    }
}

/// Reads a text that is valid TOML.
pub fn read(text: &str) -> Document<'_> {
    let body = text.strip_prefix('\u{feff}').unwrap_or(text);
    let source = Source::new(body);
    let tokens = source.lex().into_vec();
    let mut reader =
        Reader { text: body, source, lines: Vec::new(), lead: Vec::new(), open: Open::default(), depth: 0 };
    parse_document(&tokens, &mut |event: Event| reader.take(&event), &mut ());
    reader.end_line();
    let first = body.find('\n').is_some_and(|at| body[..at].ends_with('\r'));
    assemble(reader.lines, reader.lead, if first { "\r\n" } else { "\n" })
}

/// A line during reading.
#[derive(Default)]
struct Open<'a> {
    /// The opening and closing brackets of a header.
    header: Option<(&'static str, &'static str)>,
    path: Vec<String>,
    keys: Vec<&'a str>,
    value: Option<Range<usize>>,
    comment: Option<&'a str>,
}

struct Reader<'a> {
    text: &'a str,
    source: Source<'a>,
    lines: Vec<Line<'a>>,
    lead: Vec<Trivia<'a>>,
    open: Open<'a>,
    /// Number of open arrays and inline tables.
    depth: usize,
}

impl Reader<'_> {
    fn take(&mut self, event: &Event) {
        let range = event.span().start()..event.span().end();
        match event.kind() {
            EventKind::StdTableOpen => self.open.header = Some(("[", "]")),
            EventKind::ArrayTableOpen => self.open.header = Some(("[[", "]]")),
            EventKind::SimpleKey if self.depth == 0 => {
                let mut name = String::new();
                if let Some(raw) = self.source.get(event) {
                    raw.decode_key(&mut name, &mut ());
                }
                self.open.path.push(name);
                self.open.keys.push(&self.text[range]);
            }
            EventKind::Scalar => self.value(range),
            EventKind::ArrayOpen | EventKind::InlineTableOpen => {
                self.value(range);
                self.depth += 1;
            }
            EventKind::ArrayClose | EventKind::InlineTableClose => {
                self.depth = self.depth.saturating_sub(1);
                self.value(range);
            }
            EventKind::Comment if self.depth == 0 => self.open.comment = Some(self.text[range].trim_end()),
            EventKind::Newline if self.depth == 0 => self.end_of_line(),
            _ => {}
        }
    }

    /// Extends the value of the open line.
    fn value(&mut self, range: Range<usize>) {
        let start = self.open.value.as_ref().map_or(range.start, |value| value.start);
        self.open.value = Some(start..range.end);
    }

    fn end_of_line(&mut self) {
        if self.open.keys.is_empty() && self.open.comment.is_none() {
            self.lead.push(Trivia::Blank);
        } else {
            self.end_line();
        }
    }

    /// Ends a line that is not empty.
    fn end_line(&mut self) {
        let open = std::mem::take(&mut self.open);
        if open.keys.is_empty() {
            self.lead.extend(open.comment.map(Trivia::Comment));
            return;
        }
        let keys = open.keys.join(".");
        let text =
            open.header.map_or_else(|| keys.clone(), |(before, after)| format!("{before}{keys}{after}"));
        let value = open.value.map(|range| &self.text[range]);
        let lead = std::mem::take(&mut self.lead);
        self.lines.push(Line { lead, path: open.path, text, value, comment: open.comment, tail: Vec::new() });
    }
}

/// Distributes lines to tables and comments to the lines that they belong to.
fn assemble<'a>(lines: Vec<Line<'a>>, rest: Vec<Trivia<'a>>, line_end: &'static str) -> Document<'a> {
    let mut document = Document { tables: vec![Table::default()], line_end, ..Document::default() };
    for (index, mut line) in lines.into_iter().enumerate() {
        let lead = std::mem::take(&mut line.lead);
        if index == 0 {
            document.top = lead;
        } else {
            line.lead = give_back(lead, &mut document.tables);
        }
        if line.value.is_none() {
            document.tables.push(Table { header: Some(line), entries: Vec::new() });
        } else if let Some(table) = document.tables.last_mut() {
            table.entries.push(line);
        }
    }
    // The end of the file separates like a blank line.
    let rest: Vec<Trivia<'a>> = rest.into_iter().chain([Trivia::Blank]).collect();
    document.end = give_back(rest, &mut document.tables);
    document
}

/// Comments directly below a line and before a blank line belong to that line; the others belong to the next.
fn give_back<'a>(lead: Vec<Trivia<'a>>, tables: &mut [Table<'a>]) -> Vec<Trivia<'a>> {
    let Some(blank) = lead.iter().position(|trivia| *trivia == Trivia::Blank) else { return lead };
    let last = tables.last_mut().and_then(|table| table.entries.last_mut().or(table.header.as_mut()));
    let Some(line) = last else { return lead };
    let comments = lead[..blank].iter().filter_map(|trivia| match trivia {
        Trivia::Comment(text) => Some(*text),
        Trivia::Blank => None,
    });
    line.tail.extend(comments);
    lead[blank..].to_vec()
}
