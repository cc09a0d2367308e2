//! Diagnostics as GitHub workflow commands, which appear next to the lines of a pull request.

use crate::diag::{Diagnostic, Severity, Sources};
use crate::escape::terminal;

/// One `::error file=...::message` per line.
pub fn github(sources: &Sources, diagnostics: &[Diagnostic]) -> String {
    diagnostics.iter().map(|diagnostic| one(sources, diagnostic) + "\n").collect()
}

fn one(sources: &Sources, diagnostic: &Diagnostic) -> String {
    let command = match diagnostic.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    let primary = diagnostic.labels.iter().find(|label| label.primary).or(diagnostic.labels.first());
    let place = primary.map(|label| {
        let [start, end] = sources.positions(label.span);
        let file = property(&sources.get(label.span.source).name.display().to_string());
        let (line, end_line) = (start.line, end.line);
        format!("file={file},line={line},endLine={end_line},col={},endColumn={},", start.column, end.column)
    });
    let title = property(&format!("{}: {}", diagnostic.code, diagnostic.message));
    let details = primary.map(|label| label.text.clone()).filter(|text| !text.is_empty());
    let lines: Vec<String> =
        details.into_iter().chain(diagnostic.help.iter().map(|help| format!("help: {help}"))).collect();
    let message = if lines.is_empty() { diagnostic.message.clone() } else { lines.join("\n") };
    format!("::{command} {}title={title}::{}", place.unwrap_or_default(), escaped(&message))
}

/// Escapes the text after the second `::` for GitHub's runner.
fn escaped(text: &str) -> String {
    let lines: Vec<_> = text.split('\n').map(terminal::line).collect();
    lines.join("\n").replace('%', "%25").replace('\n', "%0A")
}

/// Escapes a property for GitHub's runner.
fn property(text: &str) -> String {
    escaped(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diag::Span;

    #[test]
    fn a_command_stands_on_one_line_with_its_place() {
        let mut sources = Sources::default();
        let source = sources.add("a.toml", "std = 10\n");
        let diagnostic = Diagnostic::error("E0201", "unit missing: a ratio needs a unit")
            .at(Span { source, start: 6, end: 8 }, "no unit")
            .help("write \"10 %\"");
        assert_eq!(
            github(&sources, &[diagnostic]),
            "::error file=a.toml,line=1,endLine=1,col=7,endColumn=9,title=E0201%3A unit missing%3A a ratio \
             needs a unit\
             ::no unit%0Ahelp: write \"10 %25\"\n"
        );
    }
}
