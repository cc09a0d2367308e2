//! Diagnostics for people, in rustc's look.

use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Patch, Renderer, Snippet, normalize_untrusted_str};

use crate::diag::position::boundary;
use crate::diag::{Diagnostic, Fix, Label, Severity, SourceId, Sources, Span};

/// How it shall look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// With the terminal's colours.
    pub colors: bool,
    /// Characters per line.
    pub width: usize,
}

impl Default for Look {
    fn default() -> Self {
        Self { colors: false, width: 140 }
    }
}

/// The diagnostics one below the other, an empty line between them.
pub fn human(sources: &Sources, diagnostics: &[Diagnostic], look: Look) -> String {
    let renderer = if look.colors { Renderer::styled().hyperlink(false) } else { Renderer::plain() };
    let renderer = renderer.term_width(look.width);
    let mut text = String::new();
    for diagnostic in diagnostics {
        text.push_str(&renderer.render(&groups(sources, diagnostic)));
        text.push_str("\n\n");
    }
    text
}

/// The title with its snippets, then a group per advice. The edit is shown under the first advice.
fn groups<'a>(sources: &'a Sources, diagnostic: &'a Diagnostic) -> Vec<Group<'a>> {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let title = level.primary_title(diagnostic.message.as_str()).id(diagnostic.code);
    let mut groups = vec![Group::with_title(title).elements(snippets(sources, &diagnostic.labels))];
    let mut fix = diagnostic.fix.as_ref();
    for help in &diagnostic.help {
        let group = Group::with_title(Level::HELP.secondary_title(normalize_untrusted_str(help)));
        groups.push(match fix.take() {
            Some(fix) => group.element(patch(sources, fix)),
            None => group,
        });
    }
    if let Some(fix) = fix {
        groups.push(Group::with_title(Level::HELP.secondary_title("write")).element(patch(sources, fix)));
    }
    groups
}

/// One snippet per text, that of the mistake first.
fn snippets<'a>(sources: &'a Sources, labels: &'a [Label]) -> Vec<Snippet<'a, Annotation<'a>>> {
    let mut order: Vec<SourceId> = Vec::new();
    for label in labels.iter().filter(|label| label.primary).chain(labels) {
        if !order.contains(&label.span.source) {
            order.push(label.span.source);
        }
    }
    let of = |id: SourceId| labels.iter().filter(move |label| label.span.source == id);
    order
        .into_iter()
        .map(|id| {
            let source = sources.get(id);
            let part = Part::around(&source.text, of(id).map(|label| label.span));
            Snippet::source(part.text)
                .line_start(part.line)
                .path(source.name.display().to_string())
                .annotations(of(id).map(|label| annotation(part, label)))
        })
        .collect()
}

fn annotation<'a>(part: Part<'_>, label: &'a Label) -> Annotation<'a> {
    let kind = if label.primary { AnnotationKind::Primary } else { AnnotationKind::Context };
    let annotation = kind.span(part.range(label.span));
    if label.text.is_empty() { annotation } else { annotation.label(label.text.as_str()) }
}

fn patch<'a>(sources: &'a Sources, fix: &'a Fix) -> Snippet<'a, Patch<'a>> {
    let part = Part::around(&sources.get(fix.span.source).text, [fix.span]);
    Snippet::source(part.text).line_start(part.line).patch(Patch::new(part.range(fix.span), fix.replacement.as_str()))
}

/// Texts up to this size in bytes are handed to the renderer whole.
const SMALL: usize = 64 << 10;
/// Lines that a part of a larger text has around its labels.
const MARGIN: usize = 3;

/// The lines of a text that a snippet needs: the renderer works through all that it is given, once for each diagnostic.
#[derive(Clone, Copy)]
struct Part<'a> {
    text: &'a str,
    /// Where it begins in the whole text, in bytes.
    start: usize,
    /// Its first line, from 1.
    line: usize,
}

impl<'a> Part<'a> {
    fn around(text: &'a str, spans: impl IntoIterator<Item = Span>) -> Self {
        let whole = Self { text, start: 0, line: 1 };
        if text.len() <= SMALL {
            return whole;
        }
        let around = |spans: Option<(usize, usize)>, span: Span| {
            let (first, last) = spans.unwrap_or((span.start, span.end));
            Some((first.min(span.start), last.max(span.end)))
        };
        let Some((first, last)) = spans.into_iter().fold(None, around) else { return whole };
        let (first, last) = (boundary(text, first), boundary(text, last));
        let start = text[..first].rmatch_indices('\n').nth(MARGIN).map_or(0, |(at, _)| at + 1);
        let end = text[last..].match_indices('\n').nth(MARGIN).map_or(text.len(), |(at, _)| last + at + 1);
        Self { text: &text[start..end], start, line: text[..start].matches('\n').count() + 1 }
    }

    /// The bytes of a span of the whole text in this part, kept inside it and on characters.
    fn range(self, span: Span) -> std::ops::Range<usize> {
        let inside = |byte: usize| boundary(self.text, byte.saturating_sub(self.start));
        let start = inside(span.start);
        start..inside(span.end).max(start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sources() -> (Sources, SourceId, SourceId) {
        let mut sources = Sources::default();
        let parent = sources.add("specs/base/run.toml", "[terminate.joint_error]\nlimit = \"2 rad\"\n");
        let child = sources.add("specs/run.toml", "spec = 1\n\n[terminate.joint_error]\nlimit = \"0.8 rad/s\"\n");
        (sources, parent, child)
    }

    fn span(sources: &Sources, source: SourceId, words: &str) -> Span {
        let start = sources.get(source).text.find(words).expect("the words are in the text");
        Span { source, start, end: start + words.len() }
    }

    #[test]
    fn a_mismatch_is_shown_in_its_line_with_advice_below() {
        let (sources, _, child) = sources();
        let diagnostic = Diagnostic::error("E0203", "unit mismatch: expected an angle, found an angular velocity")
            .at(span(&sources, child, "rad/s"), "`rad/s` is an angular velocity")
            .help("write the limit as an angle");
        let expected = "\
error[E0203]: unit mismatch: expected an angle, found an angular velocity
 --> specs/run.toml:4:14
  |
4 | limit = \"0.8 rad/s\"
  |              ^^^^^ `rad/s` is an angular velocity
  |
help: write the limit as an angle

";
        assert_eq!(human(&sources, &[diagnostic], Look::default()), expected);
    }

    #[test]
    fn labels_in_two_files_make_two_snippets_with_the_mistake_first() {
        let (sources, parent, child) = sources();
        let diagnostic = Diagnostic::error("E0203", "unit mismatch")
            .note(span(&sources, parent, "2 rad"), "the parent's value")
            .at(span(&sources, child, "rad/s"), "");
        let text = human(&sources, &[diagnostic], Look::default());
        let (mistake, parent) = (text.find("specs/run.toml:4:14"), text.find("::: specs/base/run.toml:2:10"));
        assert!(mistake.is_some() && parent.is_some() && mistake < parent, "{text}");
    }

    #[test]
    fn an_edit_is_shown_as_the_line_before_and_after() {
        let (sources, _, child) = sources();
        let place = span(&sources, child, "rad/s");
        let diagnostic = Diagnostic::error("E0203", "unit mismatch").at(place, "").help("write").fix(place, "rad");
        let text = human(&sources, &[diagnostic], Look::default());
        assert!(text.contains("4 - limit = \"0.8 rad/s\"\n4 + limit = \"0.8 rad\"\n"), "{text}");
    }

    #[test]
    fn a_part_of_a_large_text_is_rendered_as_the_whole_is() {
        let mut texts: Vec<String> = Vec::new();
        for filling in ["", &"# filling\n".repeat(SMALL / 5)] {
            // As many lines before the place in both, so that its number is the same.
            let before = "x = 1\n".repeat(SMALL / 10 / 6);
            let mut sources = Sources::default();
            let text = format!("{before}[action]\ndelay = \"4 m\"\n\nstd = \"é 1 Hz\"\n{filling}");
            let source = sources.add("large.toml", text);
            let [delay, std] = ["4 m", "é 1 Hz"].map(|words| span(&sources, source, words));
            let found = Diagnostic::error("E0203", "unit mismatch").at(std, "here").note(delay, "there");
            texts.push(human(&sources, &[found.help("write").fix(std, "1 %")], Look::default()));
        }
        assert_eq!(texts[0], texts[1]);
        assert!(texts[0].contains("large.toml:") && texts[0].contains("there"), "{}", texts[0]);
    }

    #[test]
    fn a_span_outside_the_text_does_not_panic() {
        let mut sources = Sources::default();
        let source = sources.add("empty.toml", "");
        let diagnostic =
            Diagnostic::error("E0002", "no edition").at(Span { source, start: 7, end: 3 }, "write `spec = 1`");
        assert!(human(&sources, &[diagnostic], Look::default()).contains("empty.toml:1:1"));
    }

    #[test]
    fn colours_appear_only_when_asked_for() {
        let (sources, _, child) = sources();
        let diagnostic = Diagnostic::warning("W0501", "no weight").at(span(&sources, child, "limit"), "");
        let plain = human(&sources, std::slice::from_ref(&diagnostic), Look::default());
        let colored = human(&sources, &[diagnostic], Look { colors: true, ..Look::default() });
        assert!(!plain.contains('\x1b') && colored.contains('\x1b'));
    }
}
