//! Diagnostics for people, in rustc's style.

use std::ops::Range;

use annotate_snippets::{
    Annotation, AnnotationKind, Group, Level, Origin, Patch, Renderer, Snippet, normalize_untrusted_str,
};

use super::texts::Texts;
use crate::diag::position::boundary;
use crate::diag::{Diagnostic, Fix, Label, Severity, SourceId, Sources};
use crate::escape::terminal;

/// How to render them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// Whether to use terminal colours.
    pub colors: bool,
    /// Characters per line.
    pub width: usize,
}

impl Default for Look {
    fn default() -> Self {
        Self { colors: false, width: 140 }
    }
}

/// The diagnostics, separated by blank lines.
pub fn human(sources: &Sources, diagnostics: &[Diagnostic], look: Look) -> String {
    let renderer = if look.colors { Renderer::styled().hyperlink(false) } else { Renderer::plain() };
    let renderer = renderer.term_width(look.width);
    let texts = Texts::of(sources, diagnostics);
    let mut text = String::new();
    for diagnostic in diagnostics {
        text.push_str(&renderer.render(&groups(&texts, &shown(diagnostic))));
        text.push_str("\n\n");
    }
    text
}

/// The diagnostic with its text made safe for a terminal.
fn shown(diagnostic: &Diagnostic) -> Diagnostic {
    let mut shown = diagnostic.clone();
    shown.message = terminal::line(&diagnostic.message).into_owned();
    shown.labels.iter_mut().for_each(|label| label.text = terminal::line(&label.text).into_owned());
    shown.help.iter_mut().for_each(|help| *help = terminal::line(help).into_owned());
    shown.fix.iter_mut().for_each(|fix| fix.replacement = terminal::lines(&fix.replacement).into_owned());
    shown
}

/// The title with its snippets, then one group per help line. The edit is shown under the first one.
fn groups<'a>(texts: &'a Texts<'_>, diagnostic: &'a Diagnostic) -> Vec<Group<'a>> {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let title = level.primary_title(diagnostic.message.as_str()).id(diagnostic.code);
    let mut groups = vec![with_snippets(Group::with_title(title), texts, &diagnostic.labels)];
    let mut fix = diagnostic.fix.as_ref().filter(|fix| !texts.sources.get(fix.span.source).private);
    for help in &diagnostic.help {
        let group = Group::with_title(Level::HELP.secondary_title(normalize_untrusted_str(help)));
        groups.push(match fix.take() {
            Some(fix) => group.element(patch(texts, fix)),
            None => group,
        });
    }
    if let Some(fix) = fix {
        groups.push(Group::with_title(Level::HELP.secondary_title("write")).element(patch(texts, fix)));
    }
    groups
}

/// One snippet per text, the mistake's first. Private texts show only the position.
fn with_snippets<'a>(mut group: Group<'a>, texts: &'a Texts<'_>, labels: &'a [Label]) -> Group<'a> {
    let mut order: Vec<SourceId> = Vec::new();
    for label in labels.iter().filter(|label| label.primary).chain(labels) {
        if !order.contains(&label.span.source) {
            order.push(label.span.source);
        }
    }
    let of = |id: SourceId| labels.iter().filter(move |label| label.span.source == id);
    for id in order {
        let path = terminal::line(&texts.sources.get(id).name.display().to_string()).into_owned();
        if texts.sources.get(id).private {
            for label in of(id) {
                let [start, _] = texts.sources.positions(label.span);
                let place = Origin::path(path.clone()).line(start.line).char_column(start.column);
                group = group.element(place);
            }
        } else {
            let part = Part::around(texts.text(id), of(id).map(|label| texts.range(label.span)));
            let annotations = of(id).map(|label| annotation(part, texts, label));
            group = group.element(
                Snippet::source(part.text).line_start(part.line).path(path).annotations(annotations),
            );
        }
    }
    group
}

fn annotation<'a>(part: Part<'_>, texts: &Texts<'_>, label: &'a Label) -> Annotation<'a> {
    let kind = if label.primary { AnnotationKind::Primary } else { AnnotationKind::Context };
    let annotation = kind.span(part.range(texts.range(label.span)));
    if label.text.is_empty() { annotation } else { annotation.label(label.text.as_str()) }
}

fn patch<'a>(texts: &'a Texts<'_>, fix: &'a Fix) -> Snippet<'a, Patch<'a>> {
    let range = texts.range(fix.span);
    let part = Part::around(texts.text(fix.span.source), [range.clone()]);
    Snippet::source(part.text)
        .line_start(part.line)
        .patch(Patch::new(part.range(range), fix.replacement.as_str()))
}

/// Texts up to this size in bytes are passed to the renderer whole.
const SMALL: usize = 64 << 10;
/// Lines of context kept around the labels of a larger text.
const MARGIN: usize = 3;

/// The lines of a text that a snippet needs. The renderer processes all it is given, once per diagnostic.
#[derive(Clone, Copy)]
struct Part<'a> {
    text: &'a str,
    /// Byte offset of its start in the whole text.
    start: usize,
    /// Its first line, from 1.
    line: usize,
}

impl<'a> Part<'a> {
    fn around(text: &'a str, ranges: impl IntoIterator<Item = Range<usize>>) -> Self {
        let whole = Self { text, start: 0, line: 1 };
        if text.len() <= SMALL {
            return whole;
        }
        let around = |ends: Option<(usize, usize)>, range: Range<usize>| {
            let (first, last) = ends.unwrap_or((range.start, range.end));
            Some((first.min(range.start), last.max(range.end)))
        };
        let Some((first, last)) = ranges.into_iter().fold(None, around) else { return whole };
        let (first, last) = (boundary(text, first), boundary(text, last));
        let start = text[..first].rmatch_indices('\n').nth(MARGIN).map_or(0, |(at, _)| at + 1);
        let end = text[last..].match_indices('\n').nth(MARGIN).map_or(text.len(), |(at, _)| last + at + 1);
        Self { text: &text[start..end], start, line: text[..start].matches('\n').count() + 1 }
    }

    /// A range of the whole text relative to this part, clamped to it and to character boundaries.
    fn range(self, range: Range<usize>) -> Range<usize> {
        let inside = |byte: usize| boundary(self.text, byte.saturating_sub(self.start));
        let start = inside(range.start);
        start..inside(range.end).max(start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diag::Span;

    fn sources() -> (Sources, SourceId, SourceId) {
        let mut sources = Sources::default();
        let parent = sources.add("specs/base/run.toml", "[terminate.joint_error]\nlimit = \"2 rad\"\n");
        let child =
            sources.add("specs/run.toml", "spec = 1\n\n[terminate.joint_error]\nlimit = \"0.8 rad/s\"\n");
        (sources, parent, child)
    }

    fn span(sources: &Sources, source: SourceId, words: &str) -> Span {
        let start = sources.get(source).text.find(words).expect("the words are in the text");
        Span { source, start, end: start + words.len() }
    }

    #[test]
    fn a_mismatch_is_shown_in_its_line_with_advice_below() {
        let (sources, _, child) = sources();
        let diagnostic =
            Diagnostic::error("E0203", "wrong dimension: expected an angle, found an angular velocity")
                .at(span(&sources, child, "rad/s"), "`rad/s` is an angular velocity")
                .help("write the limit as an angle");
        let expected = "\
error[E0203]: wrong dimension: expected an angle, found an angular velocity
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
        let diagnostic =
            Diagnostic::error("E0203", "unit mismatch").at(place, "").help("write").fix(place, "rad");
        let text = human(&sources, &[diagnostic], Look::default());
        assert!(text.contains("4 - limit = \"0.8 rad/s\"\n4 + limit = \"0.8 rad\"\n"), "{text}");
    }

    #[test]
    fn a_part_of_a_large_text_is_rendered_as_the_whole_is() {
        let mut texts: Vec<String> = Vec::new();
        for filling in ["", &"# filling\n".repeat(SMALL / 5)] {
            // Same number of lines before the mistake in both, so that its line number is the same.
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
        let diagnostic = Diagnostic::error("E0002", "no edition")
            .at(Span { source, start: 7, end: 3 }, "write `spec = 1`");
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

    #[test]
    fn nothing_in_a_text_reaches_the_terminal_as_a_control_and_the_place_is_right() {
        let mut sources = Sources::default();
        let text = "##[group]\na = \"\x1b[31m\u{9b}2J\u{202e}\"\r\nb = \"\u{200b}x\" # \u{2028}\n";
        let source = sources.add("h\x1b[2J\nostile.toml", text);
        let diagnostic = Diagnostic::error("E0203", "wrong \x1b[31m\nerror: forged")
            .at(span(&sources, source, "x\" #"), "here \u{9b}1m")
            .note(span(&sources, source, "2J"), "and here\n::error::x")
            .help("write\n\u{202e} ##[error]x")
            .fix(span(&sources, source, "x\""), "\x1b]0;title\x07");
        let text = human(&sources, &[diagnostic], Look::default());
        let acts = |letter: char| letter != '\n' && crate::escape::is_hidden(letter);
        assert!(!text.contains(acts) && !text.contains("##["), "{text:?}");
        assert!(!text.lines().any(|line| line.trim_start().starts_with("::error")), "{text}");
        assert!(text.starts_with("error[E0203]: wrong \\u001b[31m\\u000aerror: forged\n"), "{text}");
        let (lines, column) = (text.lines().collect::<Vec<_>>(), |line: &str, words: &str| line.find(words));
        let row = lines.iter().position(|line| line.contains("\\u200bx")).expect("the line is shown");
        assert_eq!(column(lines[row], "x\" #"), column(lines[row + 1], "^^^^"), "{text}");
    }

    #[test]
    fn a_private_text_is_named_and_not_quoted() {
        let mut sources = Sources::default();
        let source = sources.add_private("/elsewhere/a.toml", "a = 1\nsecret = 2\n");
        let place = span(&sources, source, "secret");
        let diagnostic =
            Diagnostic::error("E0102", "unknown key").at(place, "secret").help("x").fix(place, "secrets");
        let text = human(&sources, &[diagnostic], Look::default());
        assert_eq!(text, "error[E0102]: unknown key\n--> /elsewhere/a.toml:2:1\n |\nhelp: x\n\n");
    }
}
