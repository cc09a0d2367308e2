//! What the commands that read specs share: the options that choose a variant, the files behind the
//! arguments, and printing what was found.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::{Exit, Format, Global, output, walk};
use crate::bounded;
use crate::check::{Checked, checked};
use crate::diag::render::{self, Look};
use crate::diag::{Diagnostic, Sources};
use crate::spec::{LoadOptions, suite};

/// Options that choose a variant of a spec.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Variant {
    /// Lays an overlay of the spec, `[profile.NAME]`, over it
    #[arg(long, value_name = "NAME")]
    pub profile: Option<String>,
    /// Sets a value: `--set learn.seed=2`, `--set "action.std=5 %"`; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub sets: Vec<String>,
    /// Treats warnings as errors
    #[arg(long, value_name = "WHAT", value_parser = ["warnings"])]
    pub deny: Option<String>,
    /// Lets a spec name files in this folder outside of its project; may be repeated
    #[arg(long, value_name = "DIR")]
    pub allow_outside: Vec<PathBuf>,
}

impl Variant {
    /// Whether anything but the spec as it stands is meant.
    pub fn varies(&self) -> bool {
        self.profile.is_some() || !self.sets.is_empty()
    }

    /// As loading takes them.
    pub fn options(&self) -> LoadOptions {
        LoadOptions {
            profile: self.profile.clone(),
            sets: self.sets.clone(),
            deny_warnings: self.deny.is_some(),
            allow_outside: self.allow_outside.clone(),
            without_profiles: false,
        }
    }
}

/// Diagnostics and the texts that they point into.
pub struct Findings {
    /// The texts.
    pub sources: Sources,
    /// What was found.
    pub diagnostics: Vec<Diagnostic>,
    /// The file that was read: what has no place of its own is about it.
    pub file: Option<PathBuf>,
}

impl Findings {
    /// What was found in texts.
    pub fn of(sources: Sources, diagnostics: Vec<Diagnostic>) -> Self {
        Self { sources, diagnostics, file: None }
    }

    /// The same of a file.
    pub fn in_file(self, file: &Path) -> Self {
        Self { file: Some(file.to_owned()), ..self }
    }
}

/// What was told of several specs or variants: a finding in what they share is told once.
#[derive(Default)]
pub struct Told(BTreeSet<String>);

impl Told {
    /// Whether a finding was not told yet. It is then.
    pub fn is_new(&mut self, sources: &Sources, found: &Diagnostic) -> bool {
        let place = found.labels.first().map(|label| sources.place(label.span)).unwrap_or_default();
        self.0.insert(format!("{} {place} {}", found.code, found.message))
    }
}

/// Loads and checks one spec and prints what was found; `Err` is the exit code when there are errors. With
/// `--format json` errors go to standard output as the document of `check`.
pub fn require(path: &Path, variant: &Variant, global: &Global) -> Result<Checked, Exit> {
    require_among(path, variant, &mut Told::default(), global)
}

/// The same of one of several specs: prints what was not told of the others.
pub fn require_among(
    path: &Path,
    variant: &Variant,
    told: &mut Told,
    global: &Global,
) -> Result<Checked, Exit> {
    if is_suite(path) {
        let message = format!("{} is a suite, and this takes a single spec", path.display());
        output::complain(
            global,
            &message,
            Some("name a spec; `specforge show SUITE --arm ARM` shows one arm of a suite"),
        );
        return Err(Exit::Usage);
    }
    let checked = checked(path, &variant.options());
    let mut diagnostics = checked.sink.diagnostics.clone();
    diagnostics.retain(|found| told.is_new(&checked.sources, found));
    tell(&[Findings::of(checked.sources.clone(), diagnostics).in_file(path)], global);
    if checked.sink.has_errors() || checked.experiment.is_none() { Err(Exit::Invalid) } else { Ok(checked) }
}

/// Prints diagnostics, with `--format json` as the document of `check`: errors on standard output, warnings
/// alone as one line on standard error, for standard output has another document then. Whether any is an
/// error.
pub fn tell(findings: &[Findings], global: &Global) -> bool {
    let failed = print(findings, global);
    let warned = !global.errors_only && findings.iter().any(|found| !found.diagnostics.is_empty());
    match global.format {
        Format::Json if failed => output::json(&json(findings)),
        Format::Json if warned => output::message(&json(findings).to_string()),
        _ => {}
    }
    failed
}

/// Prints diagnostics: for people to standard error, for programs to standard output. Whether any is an
/// error.
pub fn print(findings: &[Findings], global: &Global) -> bool {
    let look = Look { colors: output::colored(global), ..Look::default() };
    for Findings { sources, diagnostics, .. } in findings {
        if global.errors_only && render::count(diagnostics).0 == 0 {
            continue;
        }
        match global.format {
            Format::Github => output::commands(&render::github(sources, diagnostics)),
            Format::Json => {}
            _ => output::diagnostics(&render::human(sources, diagnostics, look)),
        }
    }
    findings.iter().any(|findings| render::count(&findings.diagnostics).0 > 0)
}

/// All diagnostics as the one JSON document of `check`.
pub fn json(findings: &[Findings]) -> serde_json::Value {
    let mut all = Vec::new();
    let (mut errors, mut warnings) = (0, 0);
    for Findings { sources, diagnostics, file } in findings {
        let (some_errors, some_warnings) = render::count(diagnostics);
        errors += some_errors;
        warnings += some_warnings;
        if let serde_json::Value::Array(list) = render::json(sources, diagnostics)["diagnostics"].take() {
            all.extend(list.into_iter().map(|entry| in_file(entry, file.as_deref())));
        }
    }
    serde_json::json!({ "diagnostics": all, "errors": errors, "warnings": warnings })
}

/// A diagnostic without a place is about the file that was read.
fn in_file(mut entry: serde_json::Value, file: Option<&Path>) -> serde_json::Value {
    if let Some(file) = file.filter(|_| entry["file"].is_null()) {
        entry["file"] = file.display().to_string().into();
    }
    entry
}

/// Whether a file is a suite; one that cannot be read is none.
pub fn is_suite(path: &Path) -> bool {
    bounded::text(path, bounded::WRITTEN).is_ok_and(|text| suite::is_suite(&text))
}

/// The spec files behind arguments: files as they are, folders as the specs below them, sorted. TOML files
/// without an edition (motions, suites' data) are not specs. `Err` is the exit code; everything has been said
/// then.
pub fn files(arguments: &[PathBuf], global: &Global) -> Result<Vec<PathBuf>, Exit> {
    let is_spec = |path: &PathBuf| arguments.contains(path) || may_be_spec(path);
    Ok(toml_files(arguments, global)?.into_iter().filter(is_spec).collect())
}

/// The TOML files behind arguments. `Err` is the exit code; everything has been said then.
pub fn toml_files(arguments: &[PathBuf], global: &Global) -> Result<Vec<PathBuf>, Exit> {
    walk::toml_files(arguments).map_err(|error| {
        tell(&[Findings::of(Sources::default(), vec![error])], global);
        Exit::Invalid
    })
}

/// Whether a file has an edition. One that is there and cannot be read may have one, and what it is will be
/// told.
fn may_be_spec(path: &Path) -> bool {
    match bounded::head(path, bounded::WRITTEN) {
        Ok(bytes) => String::from_utf8_lossy(&bytes).lines().any(says_edition),
        Err(error) => !error.is_absence(),
    }
}

fn says_edition(line: &str) -> bool {
    line.trim_start().strip_prefix("spec").is_some_and(|rest| rest.trim_start().starts_with('='))
}
