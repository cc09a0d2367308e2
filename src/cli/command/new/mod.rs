//! `specforge new FILE`: writes a spec or a suite to start from.

mod fitting;

use std::path::{Component, Path, PathBuf};

use serde_json::json;

use self::fitting::{Asked, Fitting};
use crate::check;
use crate::cli::specs::{self, Findings, Variant};
use crate::cli::{Exit, Format, Global, output};
use crate::diag::{Severity, Sink, Sources};
use crate::escape::{self, shell};
use crate::robot::{self, Proportions, Robot};
use crate::safe_fs;
use crate::scaffold::{Wish, actions, alone, child, robots, suite, tasks};
use crate::spec::folder;
use crate::spec::suggest::{listed, nearest};
use crate::study::files::is_suite;
use crate::syntax::{Disk, Overlay, file};

/// Arguments of `new`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// The file to write; it must not be there yet
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The robot: one that comes with specforge, or `robots/NAME.toml` of the project
    #[arg(long, value_name = "NAME", default_value = "atlas")]
    robot: String,
    /// The task
    #[arg(long, value_name = "NAME", default_value = "run")]
    task: String,
    /// What the policy commands
    #[arg(long, value_name = "KIND", default_value = "torque")]
    action: String,
    /// Extends the parents in `base/` beside the file, or in `specs/base/`; the default where they are
    #[arg(long, conflicts_with = "standalone")]
    extends: bool,
    /// Writes everything into the one file; the default where there are no parents
    #[arg(long)]
    standalone: bool,
    /// Writes a suite over this spec instead: an axis of two values, seeds and two claims
    #[arg(long, value_name = "SPEC",
            conflicts_with_all = ["robot", "task", "action", "extends", "standalone"])]
    suite: Option<PathBuf>,
}

/// Writes the spec.
pub fn run(options: &Options, global: &Global) -> Exit {
    match write(options, global) {
        Err(Refusal { message, advice, exit, is_told }) => {
            // The document of the errors is the answer to a program.
            if !(is_told && global.format == Format::Json) {
                output::complain(global, &message, Some(&advice));
            }
            exit
        }
        Ok(form) => {
            let file = options.file.display();
            let argument = shell::argument(&options.file);
            if let Err(exit) = checked(options, global) {
                let message = format!(
                    "{file}: written, {form}; it has errors: `specforge check {argument}` shows them again"
                );
                output::note(global, &message);
                return exit;
            }
            if global.format == Format::Json {
                output::json(&json!({ "file": options.file, "form": form }));
            }
            let next = format!("specforge check {argument}, then specforge run {argument} --profile quick");
            output::note(global, &format!("{file}: written, {form}; next: {next}"));
            Exit::Ok
        }
    }
}

/// Checks the written file like `check` and prints the findings; `Err` is the exit code if it has errors.
fn checked(options: &Options, global: &Global) -> Result<(), Exit> {
    let variant = Variant::default();
    match &options.suite {
        Some(_) => specs::suite(&options.file, &variant, global).map(drop),
        None => specs::require(&options.file, &variant, global).map(drop),
    }
}

/// Why the file was not written.
struct Refusal {
    message: String,
    advice: String,
    exit: Exit,
    /// Whether diagnostics that say why were printed.
    is_told: bool,
}

fn refuse<T>(message: String, advice: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal { message, advice: advice.into(), exit: Exit::Usage, is_told: false })
}

/// Writes the file and returns a message about its form.
fn write(options: &Options, global: &Global) -> Result<String, Refusal> {
    let file = &options.file;
    let name = match file.file_stem().and_then(|stem| stem.to_str()) {
        Some(name) if file.extension().is_some_and(|ending| ending == "toml") => name.to_owned(),
        _ => {
            return refuse(
                format!("`{}` is not a name of a spec", escape::file(file)),
                "name a file that ends in `.toml`",
            );
        }
    };
    if !name.chars().all(|letter| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '-')) {
        return refuse(
            format!("`{}` is not a name of a spec", escape::file(Path::new(&name))),
            "use letters, digits, `_` and `-`",
        );
    }
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return refuse(
            format!("there is no folder `{}`", escape::file(folder)),
            format!("`mkdir -p {}` makes it", shell::argument(folder)),
        );
    }
    if let Some(spec) = &options.suite {
        return over(file, &name, folder, spec, global);
    }
    let robots = robots_of(folder);
    known("robot", &options.robot, robots.iter().map(String::as_str).collect())?;
    known("task", &options.task, tasks())?;
    known("action", &options.action, actions())?;
    let own = robot_of(&options.robot, folder)?;
    let build = own.as_ref().map(Proportions::of);
    let Options { robot, task, action, .. } = options;
    let (robot, task, action) = (robot.clone(), task.clone(), action.clone());
    let wish = Wish { name, robot, task, action, build, motion: None };
    let base = base_of(folder, &wish);
    let written = |wish: &Wish| match &base {
        Some(base) if !options.standalone => child(wish, base, schema_of(folder, base).as_deref()),
        _ => alone(wish),
    };
    match &base {
        None if options.extends => {
            let missing = format!(
                "there is no `base/task/{}.toml` beside `{}` or in `specs/`",
                wish.task,
                escape::file(file)
            );
            return refuse(missing, "leave `--extends` out: the spec then holds everything itself");
        }
        _ => {}
    }
    let text = written(&wish);
    let motion = own.filter(|_| is_absent(file)).and_then(|robot| {
        fitting::motion(&Asked { file, folder, robot: &robot, wish: &wish }, &text, written)
    });
    let more = match &motion {
        Some(motion) => {
            put_motion(motion)?;
            put(file, &motion.spec)?;
            format!(
                ", and a motion in reach of its legs, at {:.0} % of the usual size: {}",
                motion.percent,
                escape::file(&motion.file)
            )
        }
        None => {
            put(file, &text)?;
            String::new()
        }
    };
    Ok(match base.filter(|_| !options.standalone) {
        Some(base) => format!("with the parents in `{base}/`{more}"),
        None => format!("standing alone{more}"),
    })
}

/// Writes a suite based on a spec.
fn over(file: &Path, name: &str, folder: &Path, spec: &Path, global: &Global) -> Result<String, Refusal> {
    if !spec.is_file() {
        let advice = file::elsewhere(&Disk, spec).unwrap_or_else(|| {
            "name the spec that the suite varies; `specforge new SPEC.toml` writes one".to_owned()
        });
        return refuse(format!("file not found: `{}`", escape::file(spec)), advice);
    }
    variable(spec)?;
    let outside = |error: std::io::Error| Refusal {
        message: format!("{}: {error}", spec.display()),
        advice: "name a file that can be read".to_owned(),
        exit: Exit::Usage,
        is_told: false,
    };
    let (here, spec_at) = (folder.canonicalize().map_err(outside)?, spec.canonicalize().map_err(outside)?);
    let place = relative(&here, &spec_at);
    let schemas = here.ancestors().flat_map(|folder| ["schema", "specs/schema"].map(|sub| folder.join(sub)));
    let schema = schemas.map(|folder| folder.join("suite-1.json")).find(|schema| schema.is_file());
    let text = suite(name, &place, schema.map(|schema| relative(&here, &schema)).as_deref());
    if is_absent(file) {
        sound(file, &text, spec, global)?;
    }
    put(file, &text)?;
    Ok(format!("a suite over `{place}`"))
}

/// Checks that a spec is one that a suite can vary: neither a suite itself nor abstract.
fn variable(spec: &Path) -> Result<(), Refusal> {
    let shown = escape::file(spec);
    if is_suite(spec) {
        let advice = "name the spec that this suite extends, or copy the suite and change its sweep";
        return refuse(format!("`{shown}` is a suite, and a suite varies a single spec"), advice);
    }
    let options = Variant::default().options();
    let experiment = check::checked(spec, &options).experiment;
    if experiment.is_some_and(|experiment| experiment.is_abstract) {
        let advice = "name a spec that extends it; `specforge new SPEC.toml` writes one";
        return refuse(format!("`{shown}` is abstract and cannot be run, so a suite cannot vary it"), advice);
    }
    Ok(())
}

/// Checks the text of a suite before it is written and prints its errors.
fn sound(file: &Path, text: &str, spec: &Path, global: &Global) -> Result<(), Refusal> {
    let mut files = Overlay::new(Disk);
    files.hold(file, text);
    let checked = check::suite_in(&files, file, &Variant::default().options());
    if !checked.sink.has_errors() {
        return Ok(());
    }
    specs::tell(&[Findings::of(checked.sources, checked.sink.diagnostics).in_file(file)], global);
    let argument = shell::argument(spec);
    Err(Refusal {
        message: format!("`{}` is not written: the suite would have these errors", escape::file(file)),
        advice: format!(
            "correct the spec, `specforge check {argument}`; the suite varies `reward.torque.weight` and is \
             judged by `evaluate.nominal`, which the spec must have"
        ),
        exit: Exit::Invalid,
        is_told: true,
    })
}

/// Writes a file that does not exist yet.
fn put(file: &Path, text: &str) -> Result<(), Refusal> {
    match safe_fs::create(file, text.as_bytes()) {
        Ok(()) => Ok(()),
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => refuse(
            format!("`{}` is already there", escape::file(file)),
            "choose another name, or remove the file first",
        ),
        Err(error) => Err(Refusal {
            message: format!("`{}` cannot be written: {error}", escape::file(file)),
            advice: "choose a folder that you may write to".to_owned(),
            exit: Exit::StageFailed,
            is_told: false,
        }),
    }
}

/// Checks that a word is one of the known names.
fn known(noun: &str, word: &str, names: Vec<&str>) -> Result<(), Refusal> {
    if names.contains(&word) {
        return Ok(());
    }
    let advice = match nearest(word, names.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("the {noun}s are {}", listed(names)),
    };
    refuse(format!("there is no {noun} `{word}`"), advice)
}

/// The built-in robots and those of the project that contains a folder, sorted.
fn robots_of(folder: &Path) -> Vec<String> {
    use crate::kinds::vocabulary::vocabulary;
    use crate::spec::load::robots as shelf;
    let vocabulary = vocabulary();
    let root = folder::root(&Disk, &folder.join("new.toml"));
    let mut names = shelf(&vocabulary).names(&Disk, root.as_deref());
    names.extend(robots().into_iter().map(str::to_owned));
    names.sort();
    names.dedup();
    names
}

/// Whether there is no file yet, nor a link.
fn is_absent(file: &Path) -> bool {
    file.symlink_metadata().is_err()
}

/// Writes a motion into the project.
fn put_motion(motion: &Fitting) -> Result<(), Refusal> {
    let folder = motion.file.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|error| Refusal {
        message: format!("`{}` cannot be made: {error}", escape::file(folder)),
        advice: "choose a folder that you may write to".to_owned(),
        exit: Exit::StageFailed,
        is_told: false,
    })?;
    put(&motion.file, &motion.text)
}

/// A user's robot; `None` for built-in robots. The spec is adapted to the robot's weight and strength, so its
/// file must be valid. A file of the project takes precedence over a built-in robot of the same name.
fn robot_of(name: &str, folder: &Path) -> Result<Option<Robot>, Refusal> {
    let root = folder::root(&Disk, &folder.join("new.toml")).unwrap_or_else(|| folder.to_owned());
    let path = root.join("robots").join(format!("{name}.toml"));
    let shipped = robots().contains(&name);
    if shipped && !path.is_file() {
        return Ok(None);
    }
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let text = file::read(&Disk, &path).map_err(|error| sink.emit(error));
    let robot = text.ok().and_then(|text| {
        let source = sources.add(&path, text.as_str());
        robot::load(name, &sources, source, &mut sink)
    });
    match robot {
        // The check of the written spec prints the warnings.
        Some(robot) => Ok((!shipped).then_some(robot)),
        None => Err(unsound(&path, &sink)),
    }
}

/// The errors in a robot's file, as the reason for writing nothing.
fn unsound(path: &Path, sink: &Sink) -> Refusal {
    let errors: Vec<_> = sink.diagnostics.iter().filter(|found| found.severity == Severity::Error).collect();
    let first = errors.first().map(|found| format!(": {} [{}]", found.message, found.code));
    let more = match errors.len() {
        0 | 1 => String::new(),
        count => format!(" and {} more", count - 1),
    };
    Refusal {
        message: format!("the robot cannot be used{}{more}", first.unwrap_or_default()),
        advice: format!("`specforge robot show {}` says what to fix or to fill in", shell::argument(path)),
        exit: Exit::Invalid,
        is_told: false,
    }
}

/// The folder of parents, relative to the new spec's folder: `base` there, or in a `specs` folder above.
fn base_of(folder: &Path, wish: &Wish) -> Option<String> {
    // Resolved, as `..` and links in it would count as folders to go up from.
    let here = folder.canonicalize().ok()?;
    let complete = |base: &Path| wish.family().iter().all(|name| base.join(format!("{name}.toml")).is_file());
    let candidates = here.ancestors().flat_map(|folder| [folder.join("base"), folder.join("specs/base")]);
    let base = candidates.into_iter().find(|base| complete(base))?;
    Some(relative(&here, &base))
}

/// The schema next to the parents, relative to the new spec's folder.
fn schema_of(folder: &Path, base: &str) -> Option<String> {
    let schema = Path::new(base).parent()?.join("schema/spec-1.json");
    folder.join(&schema).is_file().then(|| schema.to_string_lossy().into_owned())
}

/// The relative path from one absolute folder to another, with `/`.
fn relative(from: &Path, to: &Path) -> String {
    let (from, to): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (from.components().collect(), to.components().collect());
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n("..".to_owned(), from.len() - shared);
    let down = to[shared..].iter().map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}
