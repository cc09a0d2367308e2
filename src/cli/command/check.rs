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
use crate::syntax::{Disk, Files, Snapshot};

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
/// Maximum number of profiles that are checked before it is known whether the spec has a mistake.
const FEW: usize = 10;

/// The findings in a spec or a suite, in those it is compared with and in its report's template, and the
/// profiles that it could be checked under.
struct Examined {
    sources: Sources,
    sink: Sink,
    /// In its template, unless this is a check under one of several profiles.
    in_template: Vec<Diagnostic>,
    compared: Vec<Findings>,
    profiles: Arc<[String]>,
}

/// A template, the project to search for it, and where the spec names it.
struct Template {
    name: String,
    project: PathBuf,
    named: Option<Span>,
}

impl Template {
    /// The errors in it, which would otherwise be found only after the training.
    fn check(self, sources: &mut Sources) -> Vec<Diagnostic> {
        let Self { name, project, named } = self;
        let found = report::render::check(&name, &plan::templates(&project), sources);
        let placed = found.into_iter().map(|diagnostic| match named {
            Some(place) if diagnostic.labels.is_empty() => diagnostic.at(place, "named here"),
            _ => diagnostic,
        });
        placed.collect()
    }
}

/// What is read for a check.
struct Look<'a> {
    files: &'a dyn Files,
    /// The spec or suite.
    file: &'a Path,
    /// Whether its template is checked, too.
    template: bool,
}

impl Look<'_> {
    fn spec(&self, options: &LoadOptions, checker: &mut Checker) -> Examined {
        let Self { files, file, template } = *self;
        let checked = checker.check(files, file, options);
        let template = checked.sound().filter(|_| template).map(|(experiment, _)| Template {
            name: Section::new(&experiment.table).at(Report::template).unwrap_or_default(),
            project: plan::project(file, experiment.root.as_deref()),
            named: experiment.marks.get(&Report::template.path()).map(|mark| mark.value),
        });
        let mut sources = checked.sources.clone();
        let (in_template, compared) = rayon::join(
            || template.map(|template| template.check(&mut sources)).unwrap_or_default(),
            || compared::findings(&checked, file, options, files, checker),
        );
        let Checked { sink, experiment, .. } = checked;
        let profiles = experiment.map(|experiment| experiment.profiles).unwrap_or_default();
        Examined { sources, sink, in_template, compared, profiles }
    }

    fn suite(&self, options: &LoadOptions, checker: &mut Checker) -> Examined {
        let Self { files, file, template } = *self;
        let mut checked = checker.suite(files, file, options);
        let same = same_results(&checked, self, options, checker);
        let idle = suite::idle_axes(&checked);
        checked.sink.diagnostics.extend(same);
        checked.sink.diagnostics.extend(idle);
        let template = checked.sound().filter(|_| template).map(|(suite, arms)| Template {
            name: Section::new(&suite.report).value(Report::template).unwrap_or_default(),
            project: plan::project(file, arms.first().and_then(|arm| arm.arm.experiment.root.as_deref())),
            named: Some(suite.place),
        });
        let CheckedSuite { mut sources, sink, suite, .. } = checked;
        let in_template = template.map(|template| template.check(&mut sources)).unwrap_or_default();
        let profiles = suite.map(|suite| suite.profiles).unwrap_or_default().into();
        Examined { sources, sink, in_template, compared: Vec::new(), profiles }
    }
}

impl Examined {
    /// All findings, each with its sources.
    fn findings(self, file: &Path) -> Vec<Findings> {
        let own = [self.sink.diagnostics, self.in_template].concat();
        let own = Findings::of(self.sources, own).in_file(file);
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
}

/// Claims of a suite that compare a result with itself both without a profile and under each profile, as a
/// suite may vary something that only a profile enables. Under a chosen profile such a claim is judged as not
/// established.
fn same_results(
    checked: &CheckedSuite,
    of: &Look,
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
        let under = suite::same_results(&checker.suite(of.files, of.file, &options));
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
    let files = Snapshot::new(Disk);
    let suite = specs::is_suite(file);
    let look = |checker: &mut Checker, options: &LoadOptions, template: bool| {
        let look = Look { files: &files, file, template };
        if suite { look.suite(options, checker) } else { look.spec(options, checker) }
    };
    // Keep nothing of a spec that has no errors under a profile: there may be a thousand profiles.
    let under = |checker: &mut Checker, profile: &String| {
        let options = LoadOptions { profile: Some(profile.clone()), ..options.clone() };
        let other = look(checker, &options, false);
        let is_sound = !other.sink.has_errors();
        let found = other.findings(file).into_iter().filter(|found| !found.diagnostics.is_empty()).collect();
        Under { profile: profile.clone(), is_sound, found }
    };
    let each = |profiles: &[String], checker: &Checker| -> Vec<Under> {
        profiles.par_iter().map_init(|| checker.clone(), under).collect()
    };
    // Most specs have no mistake, so a few profiles are checked at the same time; everything about them is
    // found there.
    let all_profiles = options.profile.is_none();
    let early = if all_profiles && !suite { checker.profiles(&files, file, options) } else { Arc::default() };
    let early = if early.len() <= FEW { early } else { Arc::default() };
    let (other, alone) = (checker.clone(), LoadOptions { without_profiles: all_profiles, ..options.clone() });
    let (mut plain, early) = rayon::join(|| look(checker, &alone, true), || each(&early, &other));
    let lacks = |name: &String| lenient && !plain.profiles.contains(name);
    let without = options.profile.as_ref().is_some_and(lacks);
    if without {
        plain = look(checker, &LoadOptions { profile: None, ..options.clone() }, true);
    }
    let names = if all_profiles { plain.profiles.clone() } else { Arc::default() };
    let mut profiles = match plain.sink.has_errors() {
        true => Vec::new(),
        false if early.is_empty() => each(&names, checker),
        false => early,
    };
    let mut foreign = false;
    if all_profiles && (plain.sink.has_errors() || profiles.iter().any(|under| !under.is_sound)) {
        // A mistake in the text of a profile is one of the spec's own.
        plain = look(checker, options, true);
        foreign = plain.sink.diagnostics.iter().any(|found| found.code == FOREIGN_KEY);
        profiles = if foreign || !plain.sink.has_errors() { each(&names, checker) } else { Vec::new() };
    }
    let sound = profiles.iter().filter(|under| foreign && under.is_sound).map(|under| under.profile.clone());
    plain.name_sound(&sound.collect::<Vec<String>>());
    let others = profiles.into_iter().filter(|_| !foreign).map(|under| (under.found, Some(under.profile)));
    let variants = std::iter::once((plain.findings(file), None)).chain(others).collect();
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
