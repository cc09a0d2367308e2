//! `specforge robot import FILE`: a robot file from URDF or MJCF.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use regex_lite::Regex;

use crate::cli::specs::{self, Findings};
use crate::cli::{Exit, Format, Global, output};
use crate::diag::{Diagnostic, Severity, Sink, Sources};
use crate::escape::terminal::one_line;
use crate::escape::{self, shell};
use crate::format::{self, Order, Sort};
use crate::kinds::vocabulary::vocabulary;
use crate::quantity::parse::{quantity, quantity_of};
use crate::robot::import::{self, Draft, Fill, Folder, Origin, Selection, Welded, Written};
use crate::robot::summary::Finding;
use crate::robot::{self, Issue};
use crate::safe_fs;
use crate::spec::load;
use crate::spec::suggest::{listed, nearest};

/// Arguments of `robot import`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// The URDF or MJCF file
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Name of the robot [default: the file's name]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Joints to keep, as a regular expression over their names; all others are welded at zero, or at their
    /// position in the key frame [default: the joints between the base and the feet]
    #[arg(long, value_name = "REGEX")]
    joints: Option<Regex>,
    /// The left and the right foot's body [default: the two ends of the tree that reach lowest]
    #[arg(long, value_name = "LEFT,RIGHT", value_parser = pair)]
    feet: Option<[String; 2]>,
    /// The key frame of an MJCF file that gives the default pose, also of welded joints [default: the first
    /// one]
    #[arg(long, value_name = "NAME")]
    key: Option<String>,
    /// Replaces principal moments that are impossible for a rigid body by their mean, as MuJoCo's
    /// `balanceinertia` does
    #[arg(long)]
    balance_inertia: bool,
    /// The folder from which meshes and included files may be read [default: FILE's ROS package, otherwise
    /// FILE's folder]
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
    /// A value for joints that have none in FILE: `damping=0.3 N*m*s/rad` for all,
    /// `knee:default_position=0.6 rad` for those whose names match the regular expression; may be repeated,
    /// the last match counts
    #[arg(long, value_name = "[JOINTS:]KEY=VALUE", value_parser = fill)]
    fill: Vec<Fill>,
    /// The file to write [default: robots/NAME.toml]
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Imports a robot. Does not overwrite an existing file. A robot with errors is written, so that they can be
/// corrected in its file; the exit code is then 3.
pub fn run(options: &Options, global: &Global) -> Exit {
    let stem =
        || options.file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let name = options.name.clone().unwrap_or_else(stem);
    if name.is_empty()
        || !name.chars().all(|letter| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '-'))
    {
        let message = format!("`{name}` is not a name for a robot");
        output::complain(global, &message, Some("give one of letters, digits, - and _ with --name"));
        return Exit::Usage;
    }
    let path = options.output.clone().unwrap_or_else(|| PathBuf::from(format!("robots/{name}.toml")));
    let folder = match &options.root {
        Some(root) => Folder::new(root).map_err(|error| {
            (
                format!("--root `{}`: {error}", root.display()),
                "--root names the folder from which meshes and included files may be read, and no body: \
                 the base is the first body with \
                 mass, and --feet names the feet",
            )
        }),
        None => Folder::around(&options.file).map_err(|error| {
            (format!("{}: {error}", options.file.display()), "name a URDF or MJCF file that is there")
        }),
    };
    let folder = match folder {
        Ok(folder) => folder,
        Err((message, advice)) => {
            output::complain(global, &message, Some(advice));
            return Exit::Usage;
        }
    };
    let (format, welded) = match read(options, &folder, &path, global) {
        Ok(found) => found,
        Err(exit) => return exit,
    };
    if let Some(message) = misses(&options.fill, &welded) {
        output::complain(
            global,
            &message,
            Some("write a regular expression that fits joints which are kept"),
        );
        return Exit::Usage;
    }
    let source = options.file.file_name().unwrap_or_default().to_string_lossy();
    let written =
        import::text(&welded, &Origin { name: &name, source: &source, format, fills: &options.fill });
    let text = format::format(&written.text, Sort::Robot, &Order::of_this_edition());
    if let Err(error) = write_new(&path, &text) {
        let shown = escape::file(&path);
        let message = match error.kind() {
            ErrorKind::AlreadyExists => format!("`{shown}` is already there"),
            _ => format!("{shown}: {error}"),
        };
        output::complain(global, &message, Some("write elsewhere with --output, or move the file away"));
        return Exit::Usage;
    }
    let draft = Draft { name: &name, text: &text, is_whole: written.missing.is_empty() };
    let issues = import::issues(&welded, &options.fill, draft);
    match global.format {
        Format::Json => output::json(&serde_json::json!({
            "robot": path.display().to_string(),
            "joints": welded.links.iter().map(|link| &link.hinge.name).collect::<Vec<_>>(),
            "welded": welded.fixed,
            "missing": written.missing,
            "notes": written.notes,
            "findings": issues.iter().cloned().map(Finding::from).collect::<Vec<_>>(),
        })),
        _ => {
            let told = summary(&path, &welded, &written) + &findings(&issues);
            output::data(&(told + &next(&path, &written, &issues)));
        }
    }
    let is_sound = issues.iter().all(|issue| issue.severity() == Severity::Warning);
    if is_sound { Exit::Ok } else { Exit::Invalid }
}

/// Reads the file's welded tree and its format, for writing to this path. Reports errors.
fn read(
    options: &Options,
    folder: &Folder,
    path: &Path,
    global: &Global,
) -> Result<(&'static str, Welded), Exit> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let selection = Selection {
        joints: options.joints.clone(),
        feet: options.feet.clone(),
        balance: options.balance_inertia,
        fills: options.fill.clone(),
    };
    let tree = import::read_with_key(&options.file, options.key.as_deref(), folder, &mut sources, &mut sink);
    let mut key = None;
    let welded = tree.and_then(|tree| {
        key.clone_from(&tree.key);
        Some((tree.format, import::weld(&tree, &selection, &mut sink)?))
    });
    for fill in welded.iter().flat_map(|(_, welded)| import::idle(welded, &options.fill)) {
        sink.emit(without_effect(&fill, key.as_deref()));
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    if welded.is_some() && robot::embedded(&name).is_some() {
        let found = load::robots(&vocabulary()).replaced(&name, path);
        sink.emit(found.help("give it another name with `--name`"));
    }
    specs::tell(&[Findings::of(sources, sink.diagnostics).in_file(&options.file)], global);
    welded.ok_or(Exit::Invalid)
}

/// A value that is filled in although the file has its own (W0420).
fn without_effect(fill: &str, key: Option<&str>) -> Diagnostic {
    let posed = key.filter(|_| fill.contains("default_position="));
    let says = match posed {
        Some(key) => format!("default positions are those of the key frame `{key}`"),
        None => "the file says this figure of every joint that it fits".to_owned(),
    };
    Diagnostic::warning("W0420", format!("--fill `{fill}` has no effect: {says}"))
        .help("leave it out, and change the figures in the robot's file after the import")
}

/// Parses two names separated by a comma.
fn pair(text: &str) -> Result<[String; 2], String> {
    match text.split(',').map(str::trim).collect::<Vec<_>>().as_slice() {
        [left, right] if !left.is_empty() && !right.is_empty() => {
            Ok([(*left).to_owned(), (*right).to_owned()])
        }
        _ => {
            Err("write the left and the right foot with a comma between them: left_foot,right_foot"
                .to_owned())
        }
    }
}

/// Parses a value and the joints that it applies to.
fn fill(text: &str) -> Result<Fill, String> {
    let (left, value) = text.split_once('=').ok_or("write KEY=VALUE, for example damping=0.3 N*m*s/rad")?;
    let (joints, key) = match left.rsplit_once(':') {
        Some((joints, key)) => (Some(Regex::new(joints).map_err(|error| error.to_string())?), key.trim()),
        None => (None, left.trim()),
    };
    let Some((_, unit)) = import::fillable().find(|(known, _)| *known == key) else {
        let known: Vec<&str> = import::fillable().map(|(known, _)| known).collect();
        return Err(match nearest(key, known.iter().copied()) {
            Some(near) => format!("a joint has no `{key}`: did you mean `{near}`?"),
            None => format!("a joint has no `{key}`; what can be filled in are {}", listed(known)),
        });
    };
    measures(value.trim(), unit)
        .map_err(|error| format!("{error}: write it in {unit}, `{key}=1.5 {unit}`"))?;
    Ok(Fill { joints, key: key.to_owned(), value: value.trim().to_owned() })
}

/// Checks that a text is a quantity with this unit's dimension.
fn measures(text: &str, unit: &str) -> Result<(), String> {
    let one = quantity(&format!("1 {unit}")).map_err(|error| error.to_string())?;
    quantity_of(text, one.dimension).map(drop).map_err(|error| error.to_string())
}

/// The first value given for joints that the robot does not have, as an error message.
fn misses(fills: &[Fill], welded: &Welded) -> Option<String> {
    let names = || welded.links.iter().map(|link| link.hinge.name.as_str());
    let fits =
        |fill: &&Fill| fill.joints.as_ref().is_none_or(|joints| names().any(|name| joints.is_match(name)));
    let joints = fills.iter().find(|fill| !fits(fill))?.joints.as_ref()?;
    // Names of joints that are not hinges are followed by their kind, `knee (prismatic)`.
    let is_fixed = |name: &&String| joints.is_match(name.rsplit_once(" (").map_or(name, |(joint, _)| joint));
    let fixed = welded.fixed.iter().find(is_fixed).map(|name| format!(", and {name} is welded"));
    let fixed = fixed.unwrap_or_default();
    Some(format!("--fill `{joints}` matches no moving joint; there are {}{fixed}", listed(names())))
}

/// Up to so many meshes that became boxes are printed one by one.
const FEW_BOXES: usize = 4;

fn summary(path: &Path, welded: &Welded, written: &Written) -> String {
    let shown = escape::file(path);
    let mut text =
        one_line(&format!("wrote {shown}: {} joints, {} welded", welded.links.len(), welded.fixed.len()));
    for joint in &welded.links {
        text += &one_line(&format!("  {}", joint.hinge.name));
    }
    if !written.notes.is_empty() {
        text += "remarks:\n";
        let (boxes, others): (Vec<&String>, Vec<&String>) =
            written.notes.iter().partition(|note| note.ends_with(" m") && note.contains(": the mesh "));
        if boxes.len() > FEW_BOXES {
            let count = boxes.len();
            text += &format!("  {count} meshes became the boxes around them; the file lists their sizes\n");
        } else {
            boxes.into_iter().for_each(|note| text += &one_line(&format!("  {note}")));
        }
        others.into_iter().for_each(|note| text += &one_line(&format!("  {note}")));
    }
    text
}

/// The next steps for the user.
fn next(path: &Path, written: &Written, issues: &[Issue]) -> String {
    let show = format!("`specforge robot show {}`", shell::argument(path));
    let errors = issues.iter().filter(|issue| issue.severity() == Severity::Error).count();
    let warnings = issues.len() - errors;
    let counted = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    if !written.missing.is_empty() {
        return format!(
            "missing in the source: {}; commented lines in the file, listed at its head.\nFill \
             them in, then {show} \
             checks the robot; `--fill KEY=VALUE` sets a value for all joints.\n",
            counted(written.missing.len(), "value")
        );
    }
    one_line(&match (errors, warnings) {
        (0, 0) => format!("nothing is missing, and {show} passes"),
        (0, _) => format!("nothing is missing; {show} passes with {}", counted(warnings, "warning")),
        (1, _) => {
            format!("the robot cannot be used yet: fix the error in the file, then {show} checks it again")
        }
        _ => format!(
            "the robot cannot be used yet: fix the {errors} errors in the file, then {show} checks it again"
        ),
    })
}

/// The findings of the robot's checks, each with its fix.
fn findings(issues: &[Issue]) -> String {
    let line = |issue: &Issue| {
        let severity = if issue.severity() == Severity::Error { "error" } else { "warning" };
        let Issue { code, path, message, help } = issue;
        one_line(&format!("  {severity}[{code}] {path}: {message}")) + &one_line(&format!("    help: {help}"))
    };
    let lines: String = issues.iter().map(line).collect();
    if lines.is_empty() { lines } else { format!("findings:\n{lines}") }
}

/// Writes a new file atomically.
fn write_new(path: &Path, text: &str) -> std::io::Result<()> {
    std::fs::create_dir_all(safe_fs::folder_of(path))?;
    safe_fs::create(path, text.as_bytes())
}
