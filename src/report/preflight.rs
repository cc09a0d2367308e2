//! Checks a template before anything is run or rendered: syntax, variables and filters. Reports all errors at
//! once, with their locations.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, ErrorKind, Value};

use super::includes::{Named, Reference, references};
use super::limits;
use super::template::{Template, Templates};
use crate::diag::{Diagnostic, Sink, SourceId, Sources, Span};

/// Most templates in a report.
const MOST: usize = 100;

/// The context of the checks, and their findings.
pub struct Preflight<'a> {
    /// The template engine.
    pub environment: &'a Environment<'a>,
    /// The available templates.
    pub templates: &'a Templates,
    /// The tag syntax.
    pub syntax: SyntaxConfig,
    /// The variables that a template may use.
    pub variables: Value,
    /// The texts of the templates.
    pub sources: &'a mut Sources,
    /// The errors.
    pub found: Vec<Diagnostic>,
}

impl Preflight<'_> {
    /// Checks a template and all that it references, directly or indirectly, each once.
    pub fn all(&mut self, name: &str, first: Template) {
        let mut open = vec![(name.to_owned(), first)];
        let mut known = BTreeSet::from([name.to_owned()]);
        // Names that templates define before they include others.
        let mut bound = BTreeSet::new();
        while let Some((name, template)) = open.pop() {
            let source = self.sources.add(&template.path, template.text.as_str());
            if let Some((message, range)) = limits::crowded(&template.text, &self.syntax) {
                let place = Span { source, start: range.start, end: range.end };
                let error = Diagnostic::error("E0905", message).at(place, "");
                self.found.push(
                    error.help("split it: break lines, and assign parts to variables with `{% set %}`"),
                );
                continue;
            }
            let mistakes = check(self.environment, &name, &template, source, &self.variables, &bound);
            self.found.extend(mistakes);
            bound.extend(bound_names(&template.text));
            for reference in references(&template.text, &self.syntax) {
                open.extend(
                    self.named(reference, source).into_iter().filter(|(name, _)| known.insert(name.clone())),
                );
            }
            if known.len() > MOST {
                let error =
                    Diagnostic::error("E0905", format!("the report needs more than {MOST} templates"));
                self.found.push(error.help("include fewer templates"));
                return;
            }
        }
    }

    /// The existing templates of a reference, with their names.
    fn named(&mut self, reference: Reference, source: SourceId) -> Vec<(String, Template)> {
        let mut found = Vec::new();
        let mut missing = None;
        for Named { name, place } in reference.names {
            let span = Span { source, start: place.start, end: place.end };
            match self.templates.get(&name) {
                Ok(Some(template)) => found.push((name, template)),
                Ok(None) => missing = missing.or(Some((name, span))),
                Err(error) => self.found.push(error.at(span, "named here")),
            }
        }
        if let Some((name, span)) = missing.filter(|_| found.is_empty() && !reference.optional) {
            self.found.push(self.templates.not_found(&name).at(span, "named here"));
        }
        found
    }
}

/// The errors of a template, given the variables that it may use. `bound` are names that another template
/// defines before including this one.
fn check(
    environment: &Environment,
    name: &str,
    template: &Template,
    source: SourceId,
    variables: &Value,
    bound: &BTreeSet<String>,
) -> Vec<Diagnostic> {
    let parsed = match environment.template_from_named_str(name, &template.text) {
        Ok(parsed) => parsed,
        Err(error) => return vec![place(&error, source, &template.text)],
    };
    let tags = tags(&template.text);
    let mut undeclared: Vec<String> = parsed.undeclared_variables(true).into_iter().collect();
    undeclared.sort();
    let is_function = |name: &str| environment.globals().any(|(known, _)| known == name);
    let mut sink = Sink::default();
    for path in undeclared.iter().filter(|path| !is_function(path) && !bound.contains(first(path))) {
        if sink.is_full("E0902") {
            break;
        }
        if let Some(known) = undefined(path, variables) {
            sink.emit(undefined_at(path, &known, source, &template.text, &tags));
        }
    }
    for tag in tags.iter().filter(|tag| is_arithmetic(&template.text[(*tag).clone()])) {
        let computed = environment.compile_expression(template.text[tag.clone()].trim());
        if let Err(error) = computed.and_then(|expression| expression.eval(())) {
            let message = error.detail().map_or_else(|| error.kind().to_string(), String::from);
            let place = Span { source, start: tag.start, end: tag.end };
            sink.emit(Diagnostic::error("E0904", message).at(place, "always fails"));
        }
    }
    let mut probed: BTreeMap<&str, bool> = BTreeMap::new();
    for range in filters(&template.text, &tags) {
        let filter = &template.text[range.clone()];
        let unknown = *probed.entry(filter).or_insert_with(|| {
            let probe = environment.render_str(&format!("{{{{ 0|{filter} }}}}"), ());
            matches!(probe, Err(error) if error.kind() == ErrorKind::UnknownFilter)
        });
        if unknown {
            sink.emit(unknown_filter(filter, Span { source, start: range.start, end: range.end }));
        }
        if sink.is_full("E0903") {
            break;
        }
    }
    sink.diagnostics.sort_by_key(|diagnostic| diagnostic.labels.first().map(|label| label.span.start));
    sink.diagnostics
}

/// Whether a tag contains only numbers, so that its value is known in advance.
fn is_arithmetic(code: &str) -> bool {
    code.contains(|c: char| c.is_ascii_digit())
        && code.chars().all(|c| c.is_ascii_digit() || " .()+-*/%".contains(c))
}

/// The names that a template defines itself: loop variables, `set`, macro arguments.
fn bound_names(text: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for tag in tags(text) {
        let code = &text[tag];
        let mut words =
            code.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty());
        match words.next() {
            Some("for") => names.extend(words.take_while(|word| *word != "in").map(String::from)),
            Some("set") => names.extend(words.next().map(String::from)),
            _ => {}
        }
    }
    names
}

fn first(path: &str) -> &str {
    path.split('.').next().unwrap_or(path)
}

/// Possible names for the first unknown part of a path; `None` if all parts are known.
fn undefined(path: &str, variables: &Value) -> Option<Vec<String>> {
    let mut value = variables.clone();
    for part in path.split('.') {
        let next = value.get_attr(part).unwrap_or(Value::UNDEFINED);
        if next.is_undefined() {
            let keys =
                value.try_iter().into_iter().flatten().filter_map(|key| key.as_str().map(String::from));
            return Some(keys.collect());
        }
        if next.is_none() {
            return None;
        }
        value = next;
    }
    None
}

fn undefined_at(
    path: &str,
    known: &[String],
    source: SourceId,
    text: &str,
    tags: &[Range<usize>],
) -> Diagnostic {
    let place = word_in_tags(text, tags, path).or_else(|| word_in_tags(text, tags, first(path)));
    let mut diagnostic = Diagnostic::error("E0902", format!("undefined variable `{path}`"));
    if let Some(place) = place {
        diagnostic =
            diagnostic.at(Span { source, start: place.start, end: place.end }, "not a variable of a report");
    }
    let part = path.rsplit('.').next().unwrap_or(path);
    let near = known.iter().max_by(|a, b| strsim::jaro(a, part).total_cmp(&strsim::jaro(b, part)));
    match near.filter(|near| strsim::jaro(near, part) > 0.8) {
        Some(near) => diagnostic.help(format!("did you mean `{near}`?")),
        None => diagnostic.help(format!("known here: {}", known.join(", "))),
    }
}

fn unknown_filter(filter: &str, span: Span) -> Diagnostic {
    Diagnostic::error("E0903", format!("unknown filter `{filter}`")).at(span, "no such filter").help(
        "specforge adds `pm`, `number`, `cell`, `count`, `duration`, `short`, `alt`, `url`, \
         `verbatim`, `code` and `fenced` to those of Jinja",
    )
}

/// An error of the template engine with its code and location.
pub fn place(error: &minijinja::Error, source: SourceId, text: &str) -> Diagnostic {
    let code = match error.kind() {
        _ if limits::is_exceeded(error) => "E0905",
        ErrorKind::TemplateNotFound | ErrorKind::BadInclude => "E0901",
        ErrorKind::UndefinedError => "E0902",
        ErrorKind::UnknownFilter => "E0903",
        _ => "E0904",
    };
    let message = error.detail().map_or_else(|| error.kind().to_string(), String::from);
    let message = limits::in_words(error).unwrap_or(message);
    let mut diagnostic = Diagnostic::error(code, message.trim_end_matches('.'));
    if code == "E0905" {
        diagnostic = diagnostic.help(
            "a report is a few hundred kilobytes: look for a loop without an end \
            and for a template that includes itself",
        );
    }
    if error.kind() == ErrorKind::SyntaxError {
        diagnostic = diagnostic.help(
            "write expressions in `{{ }}`; a `{% for %}` or `{% if %}` ends with `{% endfor %}` or \
             `{% endif %}`",
        );
    }
    let whole_line = |line: usize| {
        let start: usize = text.split_inclusive('\n').take(line - 1).map(str::len).sum();
        let length = text[start.min(text.len())..].lines().next().map_or(0, str::len);
        start..start + length
    };
    let range = error.range().or_else(|| error.line().filter(|line| *line > 0).map(whole_line));
    if let Some(range) = range.filter(|range| range.end <= text.len()) {
        diagnostic = diagnostic.at(Span { source, start: range.start, end: range.end }, "");
    }
    diagnostic
}

/// The contents of `{{ }}` and `{% %}`, excluding comments.
fn tags(text: &str) -> Vec<Range<usize>> {
    let mut tags = Vec::new();
    let mut at = 0;
    while let Some(open) = text[at..].find('{').map(|found| at + found) {
        let close = match text.as_bytes().get(open + 1) {
            Some(b'{') => "}}",
            Some(b'%') => "%}",
            Some(b'#') => "#}",
            _ => {
                at = open + 1;
                continue;
            }
        };
        let end = text[open + 2..].find(close).map_or(text.len(), |found| open + 2 + found);
        if close != "#}" {
            tags.push(open + 2..end);
        }
        at = (end + 2).min(text.len());
    }
    tags
}

/// The first occurrence of a word in the tags.
fn word_in_tags(text: &str, tags: &[Range<usize>], word: &str) -> Option<Range<usize>> {
    let is_part = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == '.');
    tags.iter().find_map(|tag| {
        let code = &text[tag.clone()];
        code.match_indices(word).find_map(|(at, _)| {
            let (before, after) = (code[..at].chars().next_back(), code[at + word.len()..].chars().next());
            let alone = !is_part(before) && !after.is_some_and(|c| c.is_alphanumeric() || c == '_');
            alone.then_some(tag.start + at..tag.start + at + word.len())
        })
    })
}

/// The positions of filter names: words after a single `|` outside strings.
fn filters<'a>(text: &'a str, tags: &'a [Range<usize>]) -> impl Iterator<Item = Range<usize>> + 'a {
    tags.iter().flat_map(move |tag| {
        let code = &text[tag.clone()];
        let mut quote = None;
        let mut found = Vec::new();
        for (at, character) in code.char_indices() {
            match (quote, character) {
                (Some(open), _) if open == character => quote = None,
                (None, '"' | '\'') => quote = Some(character),
                (None, '|') => {
                    let rest = &code[at + 1..];
                    let start = at + 1 + (rest.len() - rest.trim_start().len());
                    let length = code[start..].find(|c: char| !(c.is_alphanumeric() || c == '_'));
                    let end = start + length.unwrap_or(code.len() - start);
                    if end > start {
                        found.push(tag.start + start..tag.start + end);
                    }
                }
                _ => {}
            }
        }
        found
    })
}
