//! `specforge trace FIGURE`: which runs, stages, spec values and commits a figure or a table cell comes from.
//! Reads the record next to the report; needs neither the spec nor the store.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::cli::pages::CODE;
use crate::cli::specs::{self, Findings};
use crate::cli::{Exit, Format, Global, output};
use crate::diag::{Diagnostic, Sources};
use crate::escape;
use crate::escape::terminal::one_line;
use crate::report::digests::{self, Digests};
use crate::report::estimate::Estimate;
use crate::report::fields::lies_in;
use crate::report::policies;
use crate::report::sidecar::{ArmRecord, Item, RecordError, Sidecar, TracedCell};
use crate::report::source::Source;
use crate::report::table::Cell;
use crate::report::wording::with_interval;
use crate::safe_fs;

/// Arguments of `trace`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// A figure's file (reports/NAME/speed.svg), or a table or cell of a report (reports/NAME.md#evaluation,
    /// reports/NAME.md#evaluation.survival), with or without `reports/`; without `#` everything in the report
    /// is listed
    #[arg(value_name = "FIGURE")]
    target: String,
}

/// What to trace.
struct Target {
    /// The path of the report's record.
    sidecar: PathBuf,
    /// The item and, for a cell, its row.
    item: Option<(String, Option<String>)>,
    /// `figure`, `table` or `policy`, to tell items of the same name apart.
    kind: &'static str,
}

/// The item of this name; if there are two, the one of this kind.
fn named<'a>(sidecar: &'a Sidecar, id: &str, kind: &str) -> Option<&'a Item> {
    let named = || sidecar.items.iter().filter(|item| item.id == id);
    named().find(|item| item.kind == kind).or_else(|| named().next())
}

/// The cells of a row; for a claim without its own row, those of its comparisons (`CLAIM/CASE`).
fn cells_of<'a>(item: &'a Item, row: &str) -> Vec<&'a TracedCell> {
    let below = |cell: &TracedCell| cell.row.strip_prefix(row).is_some_and(|rest| rest.starts_with('/'));
    let own: Vec<&TracedCell> = item.cells.iter().filter(|cell| cell.row == row).collect();
    if own.is_empty() { item.cells.iter().filter(|cell| below(cell)).collect() } else { own }
}

/// Prints where a figure or a cell comes from.
pub fn run(options: &Options, global: &Global) -> Exit {
    let target = target(&options.target);
    let read = match read(&target.sidecar) {
        Ok(read) => read,
        Err(error) => {
            let advice = "name a figure (reports/NAME/speed.svg) or a report's cell \
                (reports/NAME.md#evaluation.survival)";
            if error.is_absence() {
                let named = escape::file(Path::new(&options.target));
                let record = escape::file(&target.sidecar);
                let message =
                    format!("file not found: `{record}`, the record of the report that `{named}` belongs to");
                let missing = Diagnostic::error("E0004", message).help(advice);
                specs::tell(
                    &[Findings::of(Sources::default(), vec![missing]).in_file(&target.sidecar)],
                    global,
                );
                return Exit::Invalid;
            }
            if matches!(error, RecordError::Changed { .. } | RecordError::Unsealed { .. }) {
                let advice = "restore it from version control; `specforge report --check` names all files \
                    that were changed";
                output::fault(global, Some(CODE), &error.to_string(), Some(advice));
                return Exit::StageFailed;
            }
            output::complain(global, &error.to_string(), Some(advice));
            return Exit::Usage;
        }
    };
    let page = format!("{}.md", read.record.report);
    let sidecar = &read.record;
    let figure = target.item.as_ref().and_then(|(id, _)| named(sidecar, id, target.kind));
    let file = figure.map(|item| &item.file).filter(|file| !file.is_empty()).unwrap_or(&page);
    if let Some(reason) = read.mismatch(file) {
        let message = format!("{}: {reason}", read.folder().join(file).display());
        let advice = "restore it from version control, or render the report again; `specforge report --check` \
            names all files that were changed";
        output::fault(global, Some(CODE), &message, Some(advice));
        return Exit::StageFailed;
    }
    let Some((id, row)) = target.item else {
        list(sidecar, global);
        return Exit::Ok;
    };
    let Some(item) = named(sidecar, &id, target.kind) else {
        output::complain(global, &format!("the report has no figure or table `{id}`"), Some(&known(sidecar)));
        return Exit::Usage;
    };
    let cells = row.as_ref().map_or_else(|| item.cells.iter().collect(), |row| cells_of(item, row));
    if let Some(row) = row.as_ref().filter(|_| cells.is_empty()) {
        let mut rows: Vec<&str> = item.cells.iter().map(|cell| cell.row.as_str()).collect();
        rows.dedup();
        rows.sort_unstable();
        rows.dedup();
        output::complain(
            global,
            &format!("`{id}` has no row `{row}`"),
            Some(&format!("there are {}", rows.join(", "))),
        );
        return Exit::Usage;
    }
    let cells = if row.is_some() { cells } else { Vec::new() };
    match global.format {
        Format::Json => output::json(&document(sidecar, item, &cells)),
        _ => {
            output::data(&text(sidecar, item, &cells, global.verbose > 0));
            if global.verbose == 0 {
                output::note(global, "`--verbose` lists the values of the inputs, too");
            }
        }
    }
    Exit::Ok
}

/// Parses `reports/NAME/FIGURE.svg`, `reports/NAME/policies/ARM.safetensors`, `reports/NAME.md#ITEM.ROW`, or the same with `.json`.
fn target(argument: &str) -> Target {
    let (file, place) =
        argument.split_once('#').map_or((argument, None), |(file, place)| (file, Some(place)));
    let path = Path::new(file);
    let folder = path.parent().filter(|folder| folder.file_name().is_some());
    if let (Some(folder), true) = (folder, path.extension().is_some_and(|ending| ending == "svg")) {
        let id = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        return Target { sidecar: appended(folder), item: Some((id, None)), kind: "figure" };
    }
    if let (Some(folder), true) = (folder.and_then(Path::parent), policies::is_copy(file)) {
        let id = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        return Target { sidecar: appended(folder), item: Some((id, None)), kind: "policy" };
    }
    let item = place.map(|place| match place.split_once('.') {
        Some((item, row)) => (item.to_owned(), Some(row.to_owned())),
        None => (place.to_owned(), None),
    });
    let is_file = path.extension().is_some_and(|ending| ending == "md" || ending == "json");
    Target {
        sidecar: if is_file { path.with_extension("json") } else { appended(path) },
        item,
        kind: "table",
    }
}

/// The record of a report, whose name may contain dots.
fn appended(report: &Path) -> PathBuf {
    let mut name = report.as_os_str().to_owned();
    name.push(".json");
    name.into()
}

/// A record and its path.
struct Read {
    path: PathBuf,
    record: Sidecar,
}

impl Read {
    fn folder(&self) -> &Path {
        safe_fs::folder_of(&self.path)
    }

    /// Why a file does not match its record; `None` if it does.
    fn mismatch(&self, file: &str) -> Option<String> {
        let Self { path, record } = self;
        if path.file_stem().is_none_or(|name| name != record.report.as_str()) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            return Some(format!("`{name}` is the record of another page, `{}`", record.report));
        }
        let Some(digest) = record.digests.get(file) else {
            return Some("it does not match its record, which has no digest of it".to_owned());
        };
        let found = digests::differences(self.folder(), &Digests::from([(file.to_owned(), digest.clone())]));
        found.into_iter().next().map(|found| format!("it does not match its record: {}", found.reason))
    }
}

/// Reads a report's record from this path or, if it does not exist, from the same path below `reports`.
fn read(path: &Path) -> Result<Read, RecordError> {
    let beside = Path::new("reports").join(path);
    let path = if !path.is_file() && beside.is_file() { beside.as_path() } else { path };
    Ok(Read { path: path.to_owned(), record: Sidecar::read_whole(path)? })
}

fn known(sidecar: &Sidecar) -> String {
    format!("there are {}", sidecar.items.iter().map(|item| item.id.as_str()).collect::<Vec<_>>().join(", "))
}

/// Lists everything that can be traced.
fn list(sidecar: &Sidecar, global: &Global) {
    if global.format == Format::Json {
        let items =
            sidecar.items.iter().map(|item| json!({ "id": item.id, "kind": item.kind, "title": item.title }));
        output::json(&json!({ "report": sidecar.report, "items": items.collect::<Vec<_>>() }));
        return;
    }
    let width = sidecar.items.iter().map(|item| item.id.len()).max().unwrap_or(0);
    let lines = sidecar
        .items
        .iter()
        .map(|item| one_line(&format!("{:<6}  {:<width$}  {}", item.kind, item.id, item.title)));
    output::data(&lines.collect::<String>());
}

fn text(sidecar: &Sidecar, item: &Item, cells: &[&TracedCell], all: bool) -> String {
    let mut text = one_line(&format!("{} `{}` of {}: {}", item.kind, item.id, sidecar.report, item.title));
    let sources: Vec<&Source> = if cells.is_empty() {
        item.sources.iter().collect()
    } else {
        for cell in cells {
            text += &one_line(&format!("  {} of {}: {}", cell.row, cell.column, written(&cell.value)));
        }
        sources_of(item, cells)
    };
    for source in sources {
        text += &one_line(&format!("\n{} {}", source.arm, source.stage));
        for (depth, stage) in chain(sidecar, source) {
            text += &stage_line(sidecar, &source.arm, &stage, depth);
            if depth == 0 || all {
                text += &field_lines(sidecar, &source.arm, &stage, depth);
            }
        }
    }
    let renderer = format!("rendered by specforge {}, commit {}", sidecar.tool_version, sidecar.commit);
    text + &one_line(&format!("\n{renderer}")) + &one_line(&format!("again with: {}", sidecar.command()))
}

/// The stages behind some cells, without duplicates.
fn sources_of<'a>(item: &'a Item, cells: &[&'a TracedCell]) -> Vec<&'a Source> {
    let mut sources: Vec<&Source> = Vec::new();
    for source in cells.iter().flat_map(|cell| item.sources_of(cell)) {
        if !sources.contains(&source) {
            sources.push(source);
        }
    }
    sources
}

/// The stage and everything it was made from, without duplicates, each with its distance.
fn chain(sidecar: &Sidecar, source: &Source) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = vec![(0, source.stage.clone())];
    let mut next = 0;
    while let Some((depth, stage)) = found.get(next).cloned() {
        let record = sidecar.record(&Source { arm: source.arm.clone(), stage });
        for input in record.into_iter().flat_map(|record| &record.inputs) {
            if !found.iter().any(|(_, known)| known == input) {
                found.push((depth + 1, input.clone()));
            }
        }
        next += 1;
    }
    found
}

fn stage_line(sidecar: &Sidecar, arm: &str, stage: &str, depth: usize) -> String {
    let indent = "  ".repeat(depth + 1);
    match sidecar.record(&Source { arm: arm.to_owned(), stage: stage.to_owned() }) {
        Some(record) => {
            let (fingerprint, commit) = (&record.fingerprint, &record.commit);
            let version = &record.tool_version;
            let finished =
                if record.finished.is_empty() { String::new() } else { format!(", {}", record.finished) };
            one_line(&format!("{indent}{stage}  {fingerprint}"))
                + &one_line(&format!("{indent}  specforge {version}, commit {commit}{finished}"))
        }
        None => one_line(&format!("{indent}{stage}  not in the store when the report was rendered")),
    }
}

/// The spec values that a stage reads, with their origins.
fn field_lines(sidecar: &Sidecar, arm: &str, stage: &str, depth: usize) -> String {
    let indent = "  ".repeat(depth + 2);
    let fields = values(sidecar, arm, stage);
    let width = fields.iter().map(|(path, value, _)| path.len() + value.len() + 3).max().unwrap_or(0);
    let line = |(path, value, origin): &(String, String, String)| {
        let left = format!("{path} = {value}");
        one_line(format!("{indent}{left:<width$}  {origin}").trim_end())
    };
    fields.iter().map(line).collect()
}

/// Path, value and origin of the spec values that a stage declares.
fn values(sidecar: &Sidecar, arm: &str, stage: &str) -> Vec<(String, String, String)> {
    let record = sidecar.record(&Source { arm: arm.to_owned(), stage: stage.to_owned() });
    let arm: Option<&ArmRecord> = sidecar.arms.iter().find(|record| record.name == arm);
    let (Some(record), Some(arm)) = (record, arm) else { return Vec::new() };
    let declared = sidecar.fields(arm).into_iter().filter(|(path, _)| lies_in(path, &record.fields));
    declared.map(|(path, field)| (path.clone(), field.value.clone(), field.origin.clone())).collect()
}

fn written(cell: &Cell) -> String {
    let with_n = |estimate: &Estimate| match estimate.n {
        Some(n) => format!("{}, n = {n}", with_interval(estimate, true)),
        None => with_interval(estimate, true),
    };
    match cell {
        Cell::Text(text) => text.clone(),
        Cell::Number(estimate) => with_n(estimate),
    }
}

fn document(sidecar: &Sidecar, item: &Item, cells: &[&TracedCell]) -> Value {
    let sources = if cells.is_empty() { item.sources.iter().collect() } else { sources_of(item, cells) };
    let runs = sources.into_iter().map(|source| {
        let stages = chain(sidecar, source).into_iter().map(|(depth, stage)| {
            let record = sidecar.record(&Source { arm: source.arm.clone(), stage: stage.clone() });
            let fields = values(sidecar, &source.arm, &stage);
            let fields = fields
                .into_iter()
                .map(|(path, value, origin)| json!({ "path": path, "value": value, "origin": origin }));
            json!({ "stage": stage, "depth": depth, "record": record, "fields": fields.collect::<Vec<_>>() })
        });
        json!({ "arm": source.arm, "stage": source.stage, "stages": stages.collect::<Vec<_>>() })
    });
    json!({
        "report": sidecar.report,
        "id": item.id,
        "kind": item.kind,
        "title": item.title,
        "cells": cells,
        "runs": runs.collect::<Vec<_>>(),
        "specforge": sidecar.tool_version,
        "commit": sidecar.commit,
        "command": sidecar.command(),
    })
}
