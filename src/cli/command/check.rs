//! `specforge check FILE...`: every check that does not need a simulator.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use crate::check::{Checked, CheckedSuite, Checker};
use crate::cli::specs::{self, Findings, Told, Variant};
use crate::cli::{Exit, Format, Global, output};
use crate::diag::{Diagnostic, Sink, Sources, Span, render};
use crate::report;
use crate::spec::section::Report;
use crate::spec::{LoadOptions, Section};
use crate::study::{compared, plan, suite};
use crate::syntax::Disk;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// Specs, or folders of specs
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    variant: Variant,
}

/// Checks every file, with its profiles, and prints the findings.
pub fn run(options: &Options, global: &Global) -> Exit {
    let files = match specs::files(&options.files, global) {
        Ok(files) => files,
        Err(exit) => return exit,
    };
    if files.is_empty() {
        output::complain(
            global,
            "there is no spec in the folders named",
            Some("a spec is a .toml file with `spec = 1`"),
        );
        return Exit::Usage;
    }
    let wanted = options.variant.options();
    let examined = examined(&files, &wanted);
    let without: Vec<String> = files
        .iter()
        .zip(&examined)
        .filter(|(_, looked)| looked.without)
        .map(|(file, _)| output::shown(file))
        .collect();
    let mut findings: Vec<Findings> = Vec::new();
    let mut told = Told::default();
    for (file, Looked { variants, seconds, .. }) in files.iter().zip(examined) {
        let before = findings.len();
        let found = variants
            .into_iter()
            .flat_map(|(findings, profile)| findings.into_iter().map(move |found| (found, profile.clone())));
        findings.extend(found.filter_map(|(found, profile)| fresh(found, profile, &mut told)));
        if global.verbose > 0 {
            let count = findings[before..].iter().map(|found| found.diagnostics.len()).sum::<usize>();
            output::note(
                global,
                &format!("{}: {count} findings in {:.1} ms", output::shown(file), 1e3 * seconds),
            );
        }
    }
    let failed = specs::print(&findings, global);
    if global.format == Format::Json {
        output::json(&specs::json(&findings));
    }
    if let (Some(name), [_, ..]) = (&wanted.profile, without.as_slice()) {
        let count = match without.len() {
            1 => "1 spec has".to_owned(),
            count => format!("{count} specs have"),
        };
        output::note(
            global,
            &format!("{count} no profile `{name}`, checked as they stand:\n  {}", without.join("\n  ")),
        );
    }
    summarise(&files, &findings, global);
    if failed { Exit::Invalid } else { Exit::Ok }
}

/// All findings, in the order of the files. Each thread caches the robots that it has read. If there are
/// several files, those without the chosen profile are checked without it, unless none of them has it.
fn examined(files: &[PathBuf], wanted: &LoadOptions) -> Vec<Looked> {
    let look = |lenient: bool| -> Vec<Looked> {
        let one = |checker: &mut Checker, file: &PathBuf| examine(file, wanted, lenient, checker);
        files.par_iter().map_init(Checker::default, one).collect()
    };
    let examined = look(files.len() > 1);
    if examined.iter().all(|looked| looked.without) { look(false) } else { examined }
}

/// The code of a key that the kind does not have; a profile may choose another kind that has it.
const FOREIGN_KEY: &str = "E0105";

/// Maximum number of profiles named in a message.
const NAMED: usize = 10;

/// The findings in a spec or a suite and in those it is compared with, the profiles that it could be checked
/// under, and its report's template.
struct Examined {
    sources: Sources,
    sink: Sink,
    compared: Vec<Findings>,
    profiles: Arc<[String]>,
    template: Option<Template>,
}

/// A template, the project to search for it, and where the spec names it.
struct Template {
    name: String,
    project: PathBuf,
    named: Option<Span>,
}

impl Examined {
    fn spec(file: &Path, options: &LoadOptions, checker: &mut Checker) -> Self {
        let checked = checker.check(&Disk, file, options);
        let compared = compared::findings(&checked, file, options, checker);
        let template = checked.sound().map(|(experiment, _)| Template {
            name: Section::new(&experiment.table).at(Report::template).unwrap_or_default(),
            project: plan::project(file, experiment.root.as_deref()),
            named: experiment.marks.get(&Report::template.path()).map(|mark| mark.value),
        });
        let Checked { sources, sink, experiment, .. } = checked;
        let profiles = experiment.map(|experiment| experiment.profiles).unwrap_or_default();
        Self { sources, sink, compared, profiles, template }
    }

    fn suite(file: &Path, options: &LoadOptions, checker: &mut Checker) -> Self {
        let mut checked = checker.suite(&Disk, file, options);
        let same = same_results(&checked, file, options, checker);
        let idle = suite::idle_axes(&checked);
        checked.sink.diagnostics.extend(same);
        checked.sink.diagnostics.extend(idle);
        let template = checked.sound().map(|(suite, arms)| Template {
            name: Section::new(&suite.report).value(Report::template).unwrap_or_default(),
            project: plan::project(file, arms.first().and_then(|arm| arm.arm.experiment.root.as_deref())),
            named: Some(suite.place),
        });
        let CheckedSuite { sources, sink, suite, .. } = checked;
        let profiles = suite.map(|suite| suite.profiles).unwrap_or_default().into();
        Self { sources, sink, compared: Vec::new(), profiles, template }
    }

    /// All findings, each with its sources.
    fn findings(self, file: &Path) -> Vec<Findings> {
        let own = Findings::of(self.sources, self.sink.diagnostics).in_file(file);
        std::iter::once(own).chain(self.compared).collect()
    }

    /// Names the profiles without errors in the message about a key that the kind does not have.
    fn name_sound(&mut self, sound: &[String]) {
        let named: Vec<String> =
            sound.iter().take(NAMED).map(|profile| format!("`--profile {profile}`")).collect();
        let foreign = self.sink.diagnostics.iter_mut().find(|found| found.code == FOREIGN_KEY);
        if let (Some(found), false) = (foreign, named.is_empty()) {
            let named = named.join(" or ");
            found.help.push(format!(
                "there are no errors with {named}: choose one, or write the key into its table"
            ));
        }
    }

    /// Adds the errors of its template, which would otherwise be found only after the training.
    fn with_template(mut self) -> Self {
        let Some(Template { name, project, named }) = self.template.take() else { return self };
        let found = report::render::check(&name, &plan::templates(&project), &mut self.sources);
        self.sink.diagnostics.extend(found.into_iter().map(|diagnostic| match named {
            Some(place) if diagnostic.labels.is_empty() => diagnostic.at(place, "named here"),
            _ => diagnostic,
        }));
        self
    }
}

/// Claims of a suite that compare a result with itself both without a profile and under each profile, as a
/// suite may vary something that only a profile enables. Under a chosen profile such a claim is judged as not
/// established.
fn same_results(
    checked: &CheckedSuite,
    file: &Path,
    options: &LoadOptions,
    checker: &mut Checker,
) -> Vec<Diagnostic> {
    if options.profile.is_some() || !options.sets.is_empty() {
        return Vec::new();
    }
    let mut same = suite::same_results(checked);
    for profile in checked.suite.iter().flat_map(|suite| &suite.profiles) {
        if same.is_empty() {
            break;
        }
        let options = LoadOptions { profile: Some(profile.clone()), ..options.clone() };
        let under = suite::same_results(&checker.suite(&Disk, file, &options));
        same.retain(|found| under.iter().any(|other| other.message == found.message));
    }
    same
}

/// A file with its findings without and with each profile, and how long checking took.
struct Looked {
    variants: Vec<(Vec<Findings>, Option<String>)>,
    /// Whether it lacks the chosen profile and was checked without it.
    without: bool,
    seconds: f64,
}

/// The findings in a file under a profile.
struct Under {
    profile: String,
    is_sound: bool,
    found: Vec<Findings>,
}

/// Checks a file without a profile and, unless one is chosen, under each of its profiles. With `lenient`, a
/// file that lacks the chosen profile is checked without it.
fn examine(file: &Path, options: &LoadOptions, lenient: bool, checker: &mut Checker) -> Looked {
    let start = Instant::now();
    checker.remember_specs();
    let suite = specs::is_suite(file);
    let look = |checker: &mut Checker, options: &LoadOptions| match suite {
        true => Examined::suite(file, options, checker),
        false => Examined::spec(file, options, checker),
    };
    let mut plain = look(checker, options);
    let lacks = |name: &String| lenient && !plain.profiles.contains(name);
    let without = options.profile.as_ref().is_some_and(lacks);
    if without {
        plain = look(checker, &LoadOptions { profile: None, ..options.clone() });
    }
    let foreign = plain.sink.diagnostics.iter().any(|found| found.code == FOREIGN_KEY);
    let profiles = match options.profile.is_none() && (foreign || !plain.sink.has_errors()) {
        true => std::mem::take(&mut plain.profiles).to_vec(),
        false => Vec::new(),
    };
    // Keep nothing of a spec that has no errors under a profile: there may be a thousand profiles.
    let under = |checker: &mut Checker, profile: String| {
        let other = look(checker, &LoadOptions { profile: Some(profile.clone()), ..options.clone() });
        let is_sound = !other.sink.has_errors();
        let found = other.findings(file).into_iter().filter(|found| !found.diagnostics.is_empty()).collect();
        Under { profile, is_sound, found }
    };
    // Each thread starts with what the check without a profile has read.
    let known = &*checker;
    let profiles: Vec<Under> = profiles.into_par_iter().map_init(|| known.clone(), under).collect();
    let sound = profiles.iter().filter(|under| foreign && under.is_sound).map(|under| under.profile.clone());
    plain.name_sound(&sound.collect::<Vec<String>>());
    let others = profiles.into_iter().filter(|_| !foreign).map(|under| (under.found, Some(under.profile)));
    let variants = std::iter::once((plain.with_template().findings(file), None)).chain(others).collect();
    Looked { variants, without, seconds: start.elapsed().as_secs_f64() }
}

/// The findings not reported yet. An error in a parent is reported once, whichever specs extend it; of a
/// profile's findings only those that the spec does not have without it are reported.
fn fresh(findings: Findings, profile: Option<String>, told: &mut Told) -> Option<Findings> {
    let Findings { sources, mut diagnostics, file } = findings;
    diagnostics.retain(|found| told.is_new(&sources, found));
    if let Some(profile) = profile {
        diagnostics
            .iter_mut()
            .for_each(|found| found.help.push(format!("this is so with `--profile {profile}`")));
    }
    (!diagnostics.is_empty()).then_some(Findings { sources, diagnostics, file })
}

fn summarise(files: &[PathBuf], findings: &[Findings], global: &Global) {
    let (errors, warnings) = findings
        .iter()
        .map(|found| render::count(&found.diagnostics))
        .fold((0, 0), |sum, count| (sum.0 + count.0, sum.1 + count.1));
    let what = match files {
        [file] => output::shown(file),
        _ => format!("{} specs", files.len()),
    };
    let tally = render::tally(errors, warnings);
    let verdict = if tally.is_empty() { "no errors, no warnings".to_owned() } else { tally };
    let code = findings.iter().flat_map(|found| &found.diagnostics).map(|diagnostic| diagnostic.code).next();
    let more = code.map(|code| format!("; `specforge explain {code}` says more")).unwrap_or_default();
    output::note(global, &format!("{what}: {verdict}{more}"));
}
