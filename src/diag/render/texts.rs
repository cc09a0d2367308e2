//! The texts that diagnostics display: hidden characters are escaped, and spans are mapped to the result.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::diag::position::boundary;
use crate::diag::{Diagnostic, SourceId, Sources, Span};
use crate::escape::{is_hidden, terminal};

/// The texts of diagnostics.
pub struct Texts<'a> {
    /// The original texts.
    pub sources: &'a Sources,
    /// Those with hidden characters.
    changed: BTreeMap<SourceId, Changed>,
}

/// A text with its hidden characters escaped.
struct Changed {
    text: String,
    /// For each escaped character: the byte after it, and the number of bytes added so far.
    grown: Vec<(usize, usize)>,
}

impl<'a> Texts<'a> {
    /// The texts that the diagnostics refer to.
    pub fn of(sources: &'a Sources, diagnostics: &[Diagnostic]) -> Self {
        let labels = diagnostics.iter().flat_map(|found| found.labels.iter().map(|label| label.span));
        let spans =
            labels.chain(diagnostics.iter().filter_map(|found| found.fix.as_ref()).map(|fix| fix.span));
        let mut ids: Vec<SourceId> = spans.map(|span| span.source).collect();
        ids.sort_unstable();
        ids.dedup();
        let changed = ids.into_iter().filter_map(|id| Some((id, Changed::of(&sources.get(id).text)?)));
        Self { sources, changed: changed.collect() }
    }

    /// A text with hidden characters escaped.
    pub fn text(&self, id: SourceId) -> &str {
        self.changed.get(&id).map_or(&*self.sources.get(id).text, |changed| &changed.text)
    }

    /// A span's bytes in the displayed text, clamped to it and to character boundaries.
    pub fn range(&self, span: Span) -> Range<usize> {
        let text = &*self.sources.get(span.source).text;
        let start = boundary(text, span.start);
        let end = boundary(text, span.end).max(start);
        match self.changed.get(&span.source) {
            Some(changed) => changed.moved(start)..changed.moved(end),
            None => start..end,
        }
    }
}

impl Changed {
    /// `None` when there is nothing to escape.
    fn of(original: &str) -> Option<Self> {
        let is_plain = |byte: u8| matches!(byte, b' '..=b'~' | b'\n' | b'\t');
        if original.bytes().all(is_plain) && !original.contains(terminal::COMMAND) {
            return None;
        }
        let (mut text, mut grown, mut growth) = (String::with_capacity(original.len()), Vec::new(), 0);
        for (at, letter) in original.char_indices() {
            let end = at + letter.len_utf8();
            let ends_line = letter == '\r' && original[end..].starts_with('\n');
            let commands = original[at..].starts_with(terminal::COMMAND);
            if !(is_hidden(letter) || commands) || matches!(letter, '\n' | '\t') || ends_line {
                text.push(letter);
                continue;
            }
            let written = terminal::written_out(letter);
            growth += written.len() - letter.len_utf8();
            grown.push((end, growth));
            text += &written;
        }
        (!grown.is_empty()).then_some(Self { text, grown })
    }

    fn moved(&self, at: usize) -> usize {
        let before = self.grown.partition_point(|(end, _)| *end <= at);
        at + before.checked_sub(1).map_or(0, |last| self.grown[last].1)
    }
}
