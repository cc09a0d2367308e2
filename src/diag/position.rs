//! Converts byte offsets to lines and columns.

use super::{Sources, Span};

/// A position as editors count it: lines and columns from 1, columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl Position {
    /// The position of a byte; a byte past the end or inside a character counts as the nearest one before.
    pub fn of(text: &str, byte: usize) -> Self {
        let before = &text[..boundary(text, byte)];
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        Self { line: before.matches('\n').count() + 1, column: before[start..].chars().count() + 1 }
    }
}

impl Sources {
    /// The position of a span's first character and the position after its last.
    pub fn positions(&self, span: Span) -> [Position; 2] {
        let text = &self.get(span.source).text;
        [Position::of(text, span.start), Position::of(text, span.end.max(span.start))]
    }

    /// A position as text: `specs/walk.toml:6:14`.
    pub fn place(&self, span: Span) -> String {
        let [start, _] = self.positions(span);
        format!("{}:{}:{}", self.get(span.source).name.display(), start.line, start.column)
    }
}

/// The byte itself, or the nearest earlier character boundary.
pub(super) fn boundary(text: &str, byte: usize) -> usize {
    (0..=byte.min(text.len())).rev().find(|&byte| text.is_char_boundary(byte)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters_and_lines_count_from_one() {
        let text = "a = 1\nµ = \"4 ms\"\n";
        let quote = text.find('"').expect("the text has a quote");
        assert_eq!(Position::of(text, 0), Position { line: 1, column: 1 });
        assert_eq!(Position::of(text, quote), Position { line: 2, column: 5 });
        assert_eq!(
            Position::of(text, 7),
            Position { line: 2, column: 1 },
            "inside the first character of line 2"
        );
        assert_eq!(Position::of(text, 999), Position { line: 3, column: 1 });
    }
}
