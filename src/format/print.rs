//! Lines to text: alignment, columns of comments, blank lines.

use super::lines::{Document, Line, Table, Trivia};

/// Column of a comment after code, from 0.
const COMMENT: usize = 46;

/// The text of a document.
pub fn print(document: &Document<'_>, align: bool) -> String {
    let mut page = Page::default();
    page.trivia(&document.top);
    let mut section: Option<&str> = None;
    for table in &document.tables {
        if let Some(header) = &table.header {
            let own = header.path.first().map(String::as_str);
            let begins = page.has_tail || (page.has_code && section != own);
            section = own;
            page.header(header, begins);
        }
        page.entries(table, align);
    }
    page.trivia(&document.end);
    page.finish(document.line_end)
}

/// Lines without line endings.
#[derive(Default)]
struct Page {
    lines: Vec<String>,
    /// Whether a line of code was printed.
    has_code: bool,
    /// Whether the last line is a comment that belongs to the code above it.
    has_tail: bool,
}

impl Page {
    fn header(&mut self, header: &Line<'_>, begins_a_section: bool) {
        if begins_a_section && header.lead.first() != Some(&Trivia::Blank) {
            self.trivia(&[Trivia::Blank]);
        }
        self.trivia(&header.lead);
        self.code(header.text.clone(), header);
    }

    fn entries(&mut self, table: &Table<'_>, align: bool) {
        let adjacent = |_: &Line<'_>, next: &Line<'_>| !next.lead.contains(&Trivia::Blank);
        // A table begins directly below its header.
        let mut is_first = table.header.as_ref().is_some_and(|header| header.tail.is_empty());
        for group in table.entries.chunk_by(adjacent) {
            let longest = group.iter().map(|entry| entry.text.chars().count()).max().unwrap_or(0);
            let width = if align { longest } else { 0 };
            for entry in group {
                let lead = entry.lead.iter().skip_while(|trivia| is_first && **trivia == Trivia::Blank);
                self.trivia(&lead.copied().collect::<Vec<_>>());
                is_first = false;
                self.code(format!("{:<width$} = {}", entry.text, entry.value.unwrap_or_default()), entry);
            }
        }
    }

    /// A line of code with the comments after and directly below it.
    fn code(&mut self, code: String, line: &Line<'_>) {
        let last = code.rsplit('\n').next().unwrap_or_default().chars().count();
        let gap = if last < COMMENT { COMMENT - last } else { 2 };
        self.lines.push(match line.comment {
            Some(comment) => format!("{code}{}{comment}", " ".repeat(gap)),
            None => code,
        });
        self.has_code = true;
        self.has_tail = !line.tail.is_empty();
        self.lines.extend(line.tail.iter().map(|comment| (*comment).to_owned()));
    }

    fn trivia(&mut self, trivia: &[Trivia<'_>]) {
        for line in trivia {
            match line {
                Trivia::Comment(text) => self.lines.push((*text).to_owned()),
                Trivia::Blank if self.lines.last().is_some_and(|last| !last.is_empty()) => {
                    self.lines.push(String::new());
                }
                Trivia::Blank => {}
            }
        }
    }

    fn finish(mut self, line_end: &str) -> String {
        while self.lines.last().is_some_and(String::is_empty) {
            self.lines.pop();
        }
        self.lines.iter().flat_map(|line| [line.as_str(), line_end]).collect()
    }
}
