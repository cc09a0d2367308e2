//! Renders a report: figures, Markdown and the record that `specforge trace` reads.

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, UndefinedBehavior, Value};

use super::estimate::Estimate;
use super::figure;
use super::file::ReportFile;
use super::model::ReportInput;
use super::page::{Page, figure_file};
use super::preflight::Preflight;
use super::sidecar::Sidecar;
use super::table::Cell;
use super::template::Templates;
use super::{digests, limits, policies, preflight, wording};
use crate::diag::{Diagnostic, Severity, Sources};
use crate::escape::markdown;

/// The files of a report, Markdown first. The same input gives the same bytes.
pub fn render(
    input: &ReportInput,
    templates: &Templates,
    sources: &mut Sources,
) -> Result<Vec<ReportFile>, Vec<Diagnostic>> {
    let mut figures = figure::all(input);
    let page = Page::new(input, &figures);
    let mut sidecar = Sidecar::new(input, &page, &figures);
    for figure in &mut figures {
        figure.drawing.metadata = sidecar.metadata(&figure.id);
    }
    let markdown = markdown(&input.template, &page, templates, sources)?;
    let mut files = vec![ReportFile { path: format!("{}.md", input.name).into(), text: markdown }];
    files.extend(
        figures.iter().map(|figure| ReportFile {
            path: figure_file(input, figure).into(),
            text: figure.drawing.to_svg(),
        }),
    );
    sidecar.digests = digests::of(&files);
    let policies = policies::copies(input).into_iter();
    sidecar.digests.extend(policies.map(|copy| (copy.file, digests::digest(copy.bytes))));
    files.insert(
        1,
        ReportFile { path: format!("{}.json", input.name).into(), text: sidecar.sealed().to_json() },
    );
    Ok(files)
}

/// The errors of a template and of those it uses, found before anything is run.
pub fn check(name: &str, templates: &Templates, sources: &mut Sources) -> Vec<Diagnostic> {
    // They have no errors, and parsing them takes a tenth of the time of `check`.
    if templates.is_embedded(name) { Vec::new() } else { errors(name, templates, sources) }
}

fn errors(name: &str, templates: &Templates, sources: &mut Sources) -> Vec<Diagnostic> {
    let environment = environment(templates);
    let page = Page::default();
    let found = preflights(&environment, name, &page, templates, sources);
    if found.iter().any(|diagnostic| diagnostic.severity == Severity::Error) {
        return found;
    }
    // Rendered once without arms: endless loops and templates that include or extend themselves show up even
    // so. All other errors are ignored, as missing arms may cause them.
    match limits::render(environment, name, Value::from(Serde(&page))) {
        Err(error) if is_endless(limits::cause(&error)) => {
            vec![failed(&error, name, templates, sources)]
        }
        Ok(_) | Err(_) => found,
    }
}

/// Whether a template goes on without an end, whatever the arms are.
fn is_endless(error: &minijinja::Error) -> bool {
    // minijinja has no kind of its own for it.
    limits::is_exceeded(error)
        || error.detail().is_some_and(|detail| detail.starts_with("cycle in template inheritance"))
}

/// The errors of a template and of all that it references, directly or indirectly.
fn preflights(
    environment: &Environment,
    name: &str,
    page: &Page,
    templates: &Templates,
    sources: &mut Sources,
) -> Vec<Diagnostic> {
    let first = match templates.get(name) {
        Ok(Some(template)) => template,
        Ok(None) => return vec![templates.not_found(name)],
        Err(error) => return vec![*error],
    };
    let variables = Value::from(Serde(page));
    let mut preflight =
        Preflight { environment, templates, syntax: syntax(), variables, sources, found: Vec::new() };
    let checked = limits::with_stack(|| preflight.all(name, first));
    let mut found = preflight.found;
    if let Err(error) = checked {
        found.push(Diagnostic::error("E0904", format!("cannot check the template: {error}")));
    }
    found
}

fn markdown(
    name: &str,
    page: &Page,
    templates: &Templates,
    sources: &mut Sources,
) -> Result<String, Vec<Diagnostic>> {
    let environment = environment(templates);
    let diagnostics = preflights(&environment, name, page, templates, sources);
    if diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error) {
        return Err(diagnostics);
    }
    let rendered = limits::render(environment, name, Value::from(Serde(page))).map(tidied);
    rendered.map_err(|error| vec![failed(&error, name, templates, sources)])
}

/// Why a template could not be rendered, located in the template that failed.
fn failed(error: &minijinja::Error, name: &str, templates: &Templates, sources: &mut Sources) -> Diagnostic {
    let error = limits::cause(error);
    let read = |name: &str| templates.get(name).ok().flatten();
    let template = error.name().and_then(read).or_else(|| read(name));
    let (path, text) = template.map_or_else(Default::default, |template| (template.path, template.text));
    let source = sources.add(path, text.as_str());
    preflight::place(error, source, &text)
}

/// The tag syntax.
fn syntax() -> SyntaxConfig {
    let syntax =
        SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).keep_trailing_newline(true).build();
    syntax.expect("the usual delimiters are valid")
}

/// The template engine with specforge's filters, strict about undefined values.
fn environment(templates: &Templates) -> Environment<'static> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_syntax(syntax());
    limits::apply(&mut environment);
    // A value is escaped when printed. Output of specforge's macros and filters is not escaped again.
    environment.set_auto_escape_callback(|_| AutoEscape::Custom("markdown".into()));
    environment.set_formatter(|out, _, value| {
        let text = match value.as_str() {
            Some(text) if value.is_safe() => text.to_owned(),
            Some(text) => markdown::inline(text),
            None => markdown::inline(&value.to_string()),
        };
        Ok(std::fmt::Write::write_str(out, &text)?)
    });
    let found = templates.clone();
    environment.set_loader(move |name| match found.get(name) {
        Ok(template) => Ok(template.map(|template| template.text)),
        Err(error) => Err(minijinja::Error::new(minijinja::ErrorKind::BadInclude, error.message)),
    });
    environment.add_filter("pm", |estimate: Serde<Estimate>| wording::with_interval(&estimate, true));
    environment.add_filter("number", |value: f64| wording::number(value));
    environment.add_filter("cell", |cell: Serde<Cell>| Value::from_safe_string(written(&cell)));
    environment.add_filter("alt", |text: String| Value::from_safe_string(markdown::label(&text)));
    environment.add_filter("url", |path: String| Value::from_safe_string(markdown::target(&path)));
    environment.add_filter("verbatim", |text: String| Value::from_safe_string(markdown::verbatim(&text)));
    environment.add_filter("fenced", |text: String| Value::from_safe_string(markdown::fenced(&text)));
    environment.add_filter("code", |text: String| Value::from_safe_string(markdown::code(&text)));
    environment.add_filter("count", |value: u64| wording::count(value));
    environment.add_filter("duration", |value: f64| wording::duration(value));
    environment.add_filter("short", |value: String| wording::short(&value).to_string());
    environment
}

/// A cell of a Markdown table: text, or a number without its unit, which is in the row label.
fn written(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => markdown::cell(text),
        Cell::Number(estimate) => wording::with_interval(estimate, false),
    }
}

/// Removes trailing spaces and repeated empty lines from Markdown.
fn tidied(text: String) -> String {
    let mut lines: Vec<&str> = Vec::new();
    for line in text.lines().map(str::trim_end) {
        if !line.is_empty() || lines.last().is_some_and(|last| !last.is_empty()) {
            lines.push(line);
        }
    }
    format!("{}\n", lines.join("\n").trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_embedded_templates_have_no_errors() {
        let templates = Templates::default();
        for name in templates.names() {
            let found = errors(&name, &templates, &mut Sources::default());
            assert!(templates.is_embedded(&name) && found.is_empty(), "{name}: {found:?}");
        }
    }
}
