//! XML as a tree of elements with their places in the text. Enforces the limits of robot descriptions,
//! independent of the meaning of elements.
//!
//! Document type declarations are rejected, so no entity is ever expanded or fetched.

use roxmltree::{Document, Node, ParsingOptions};

use crate::diag::{Diagnostic, SourceId, Sources, Span};

/// Maximum size of a description in bytes.
pub(super) const LARGEST_TEXT: u64 = 16 << 20;
/// Maximum number of elements of a description, including included files.
pub(super) const MOST_ELEMENTS: usize = 20_000;
/// Maximum number of attributes of an element.
const MOST_ATTRIBUTES: usize = 100;
/// Maximum nesting of elements.
const DEEPEST: usize = 200;

/// An element.
#[derive(Clone, Debug)]
pub(super) struct Element {
    /// Its name without the prefix.
    pub name: String,
    /// The URI of its namespace; empty for most.
    pub space: String,
    /// Its attributes, in the order of the text.
    pub attributes: Vec<Attribute>,
    /// The elements inside it.
    pub children: Vec<Element>,
    /// Place of its tag.
    pub span: Span,
}

/// An attribute.
#[derive(Clone, Debug)]
pub(super) struct Attribute {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: String,
    /// Place of the value.
    pub span: Span,
}

impl Element {
    /// An attribute by name.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// The value of an attribute.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.attribute(name).map(|attribute| attribute.value.as_str())
    }

    /// The first child with this name.
    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }

    /// All children with this name.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> + 'a {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// The place of an attribute's value, otherwise of the element.
    pub fn place(&self, name: &str) -> Span {
        self.attribute(name).map_or(self.span, |attribute| attribute.span)
    }
}

/// The root element of a text in the sources; `room` is the maximum number of elements.
pub(super) fn parse(sources: &Sources, source: SourceId, room: usize) -> Result<Element, Diagnostic> {
    let text = &*sources.get(source).text;
    if let Some(crowd) = crowded(text) {
        let start = crowd.as_ptr() as usize - text.as_ptr() as usize;
        let span = Span { source, start: start.saturating_sub(1), end: start };
        return Err(too_large(format!("an element has more than {MOST_ATTRIBUTES} attributes")).at(span, ""));
    }
    let options = ParsingOptions { nodes_limit: 8 * MOST_ELEMENTS as u32, ..ParsingOptions::default() };
    let document =
        Document::parse_with_options(text, options).map_err(|error| refused(text, source, &error))?;
    let root = document.root_element();
    if root.descendants().filter(Node::is_element).count() > room {
        let span = tag(&root, source);
        return Err(too_large(format!("the description has more than {MOST_ELEMENTS} elements")).at(span, ""));
    }
    element(&root, source, 0)
}

/// The first tag of a text with too many attributes. The parser compares all pairs of them, so their number
/// is checked beforehand.
pub(super) fn crowded(text: &str) -> Option<&str> {
    text.split('<').find(|piece| piece.matches('=').count() > 10 * MOST_ATTRIBUTES)
}

/// E0415: a description is too large for a robot.
pub(super) fn too_large(message: String) -> Diagnostic {
    Diagnostic::error("E0415", message)
        .help("leave out what is not the robot, or select the robot's own part of it")
}

/// A file that must be expanded first: the first place, and the number of places.
pub(super) fn unexpanded(first: Span, places: usize) -> Diagnostic {
    let more = if places > 1 { format!(" (and {} more places)", places - 1) } else { String::new() };
    Diagnostic::error("E0410", format!("this is a xacro file, from which URDF is made{more}"))
        .at(first, "")
        .help("expand it first: xacro robot.urdf.xacro > robot.urdf")
}

/// The parser's error at its place.
fn refused(text: &str, source: SourceId, error: &roxmltree::Error) -> Diagnostic {
    let at = offset(text, error.pos());
    let span =
        Span { source, start: at, end: text[at..].chars().next().map_or(at, |next| at + next.len_utf8()) };
    match error {
        roxmltree::Error::DtdDetected => Diagnostic::error(
            "E0410",
            "the file has a document type declaration (DOCTYPE), and with it entities",
        )
        .at(span, "")
        .help("take it out, and write in the place of every entity what it stands for"),
        roxmltree::Error::UnknownNamespace(prefix, _) if prefix == "xacro" => unexpanded(span, 1),
        roxmltree::Error::NodesLimitReached => {
            too_large(format!("the description has more than {MOST_ELEMENTS} elements")).at(span, "")
        }
        _ => {
            // The parser appends the position, which the snippet already shows.
            let said = error.to_string();
            let said = said.split(" at ").next().unwrap_or(&said).to_owned();
            Diagnostic::error("E0410", format!("this is not well-formed XML: {said}"))
                .at(span, "")
                .help("a robot is described by a URDF or MJCF file, which are XML")
        }
    }
}

/// The byte offset of a line and column, both from 1 and in characters.
fn offset(text: &str, position: roxmltree::TextPos) -> usize {
    let (row, column) = (position.row.max(1) as usize, position.col.max(1) as usize);
    let start = match row {
        1 => 0,
        _ => text.match_indices('\n').nth(row - 2).map_or(text.len(), |(newline, _)| newline + 1),
    };
    text[start..].char_indices().nth(column - 1).map_or(text.len(), |(byte, _)| start + byte)
}

fn tag(node: &Node, source: SourceId) -> Span {
    let range = node.range();
    // `<` and the name without its prefix: the place of an element is its tag, not its contents.
    Span { source, start: range.start, end: (range.start + 1 + node.tag_name().name().len()).min(range.end) }
}

fn element(node: &Node, source: SourceId, depth: usize) -> Result<Element, Diagnostic> {
    let span = tag(node, source);
    if depth > DEEPEST {
        return Err(too_large(format!("elements are nested more than {DEEPEST} deep")).at(span, ""));
    }
    if node.attributes().len() > MOST_ATTRIBUTES {
        return Err(too_large(format!("an element has more than {MOST_ATTRIBUTES} attributes")).at(span, ""));
    }
    let attributes = node.attributes().map(|attribute| {
        let range = attribute.range_value();
        let span = Span { source, start: range.start, end: range.end };
        Attribute { name: attribute.name().to_owned(), value: attribute.value().to_owned(), span }
    });
    let children = node.children().filter(Node::is_element).map(|child| element(&child, source, depth + 1));
    Ok(Element {
        name: node.tag_name().name().to_owned(),
        space: node.tag_name().namespace().unwrap_or_default().to_owned(),
        attributes: attributes.collect(),
        children: children.collect::<Result<_, _>>()?,
        span,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Element, Diagnostic> {
        let mut sources = Sources::default();
        let source = sources.add("robot.xml", text);
        parse(&sources, source, MOST_ELEMENTS)
    }

    #[test]
    fn elements_and_values_know_their_places() {
        let text = "<?xml version=\"1.0\"?>\n<robot name=\"a\">\n  <link name=\"b&amp;c\"/>\n</robot>";
        let root = parsed(text).unwrap();
        assert_eq!(&text[root.span.start..root.span.end], "<robot");
        let link = root.child("link").unwrap();
        assert_eq!(link.text("name"), Some("b&c"));
        let place = link.place("name");
        assert_eq!(&text[place.start..place.end], "b&amp;c");
    }

    #[test]
    fn a_broken_text_is_refused_where_it_breaks() {
        let text = "<robot>\n  <link>\n</robot>";
        let error = parsed(text).unwrap_err();
        assert_eq!(error.code, "E0410");
        assert!(text[error.labels[0].span.start..].starts_with("</robot>"), "{error:?}");
    }

    #[test]
    fn entities_are_refused_and_not_expanded() {
        let bomb = "<!DOCTYPE a [<!ENTITY b \"bbb\"><!ENTITY c SYSTEM \
            \"file:///etc/passwd\">]>\n<robot>&b;&c;</robot>";
        let error = parsed(bomb).unwrap_err();
        assert!(error.code == "E0410" && error.message.contains("DOCTYPE"), "{error:?}");
    }

    #[test]
    fn a_deep_nest_and_a_crowd_of_elements_are_refused() {
        let deep = format!("{}{}", "<a>".repeat(100_000), "</a>".repeat(100_000));
        assert_eq!(parsed(&deep).unwrap_err().code, "E0415");
        let wide = format!("<a>{}</a>", "<b/>".repeat(MOST_ELEMENTS));
        assert_eq!(parsed(&wide).unwrap_err().code, "E0415");
    }
}
