//! Shared by the commands that read specs: the options that choose a variant, finding the files for the
//! arguments, and printing the findings.

use std::path::{Path, PathBuf};

use super::{Exit, Format, Global, output};
use crate::check::{Checked, CheckedSuite};
use crate::diag::render::{self, Look};
use crate::diag::{Diagnostic, Sources};
use crate::spec::LoadOptions;
pub use crate::study::files::is_suite;
pub use crate::study::findings::{Findings, Told};
use crate::study::{self, Log, Refusal, files};

/// Options that choose a variant of a spec.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Variant {
    /// Applies the spec's overlay `[profile.NAME]`
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
    /// The options for loading.
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

/// Runs something that keeps a log; prints the log and, on failure, the reason.
pub fn told<T>(work: impl FnOnce(&mut Log) -> Result<T, Refusal>, global: &Global) -> Result<T, Exit> {
    let mut log = Log::default();
    let result = work(&mut log);
    let failed = tell(&log.findings, global);
    log.notes.iter().filter(|_| !failed).for_each(|note| output::note(global, note));
    match result {
        Ok(result) => Ok(result),
        Err(Refusal::Usage { message, advice }) if !failed => {
            output::complain(global, &message, Some(&advice));
            Err(Exit::Usage)
        }
        Err(_) => Err(Exit::Invalid),
    }
}

/// Loads and checks a suite and prints the findings. Reports errors; `Err` is the exit code.
pub fn suite(path: &Path, variant: &Variant, global: &Global) -> Result<CheckedSuite, Exit> {
    told(|log| study::suite::checked(path, &variant.options(), log), global)
}

/// Loads and checks a spec and prints the findings; `Err` is the exit code if it has errors. With `--format
/// json`, errors go to standard output as the document of `check`.
pub fn require(path: &Path, variant: &Variant, global: &Global) -> Result<Checked, Exit> {
    told(|log| study::spec::checked(path, &variant.options(), log), global)
}

/// Prints diagnostics. With `--format json` errors are printed to standard output as the document of `check`;
/// warnings alone go to standard error on one line, because standard output then has another document.
/// Returns whether there are errors.
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

/// Prints diagnostics: for people to standard error, for programs to standard output. Returns whether there
/// are errors.
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

/// All diagnostics as one JSON document, as from `check`.
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

/// A diagnostic without a location is about the file that was read.
fn in_file(mut entry: serde_json::Value, file: Option<&Path>) -> serde_json::Value {
    if let Some(file) = file.filter(|_| entry["file"].is_null()) {
        entry["file"] = file.display().to_string().into();
    }
    entry
}

/// The spec files for the arguments. Reports errors; `Err` is the exit code.
pub fn files(arguments: &[PathBuf], global: &Global) -> Result<Vec<PathBuf>, Exit> {
    found(files::specs(arguments), global)
}

/// The TOML files for the arguments. Reports errors; `Err` is the exit code.
pub fn toml_files(arguments: &[PathBuf], global: &Global) -> Result<Vec<PathBuf>, Exit> {
    found(files::toml_files(arguments), global)
}

fn found(files: Result<Vec<PathBuf>, Diagnostic>, global: &Global) -> Result<Vec<PathBuf>, Exit> {
    files.map_err(|error| {
        tell(&[Findings::of(Sources::default(), vec![error])], global);
        Exit::Invalid
    })
}
