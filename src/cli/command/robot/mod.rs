//! `specforge robot show NAME`: masses, limits, symmetry and checks of a robot; `robot import FILE`.

mod import;
mod sort;

use std::path::PathBuf;

use crate::cli::specs::{self, Findings};
use crate::cli::{Exit, Format, Global, output};
use crate::diag::{Diagnostic, Sink, Sources};
use crate::escape::terminal::one_line;
use crate::kinds::vocabulary::vocabulary;
use crate::robot::summary::{Summary, summary};
use crate::robot::{self, Robot, urdf};
use crate::sim::mjcf;
use crate::spec::load;
use crate::syntax::file;
use crate::syntax::files::{Disk, Files};

/// Arguments of `robot`.
#[derive(Debug, clap::Args)]
pub struct Options {
    #[command(subcommand)]
    action: Action,
}

/// What to do.
#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Prints masses, limits, symmetry and checks of a robot; with `--format mjcf` or `urdf` the robot itself
    Show {
        /// A robot's name (tocabi) or a robot file (robots/tocabi.toml)
        #[arg(value_name = "NAME|FILE")]
        robot: String,
    },
    /// Writes robots/NAME.toml from a URDF or MJCF file, welding what is not selected
    Import(Box<import::Options>),
}

/// Shows or imports a robot.
pub fn run(options: &Options, global: &Global) -> Exit {
    match &options.action {
        Action::Show { robot } => look_up(robot, global),
        Action::Import(options) => import::run(options, global),
    }
}

fn look_up(wanted: &str, global: &Global) -> Exit {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let (name, place, text) = match find(wanted) {
        Ok(found) => found,
        Err(Lost::Nowhere(message)) => {
            output::complain(global, &message, Some(&sort::instead(wanted)));
            return Exit::Usage;
        }
        Err(Lost::Unreadable(diagnostic)) => {
            specs::tell(&[Findings::of(sources, vec![*diagnostic])], global);
            return Exit::Invalid;
        }
    };
    let vocabulary = vocabulary();
    if let Some(other) = sort::other(&place, &text, &vocabulary) {
        output::complain(global, &other.message, Some(&other.advice));
        return Exit::Usage;
    }
    let shelf = load::robots(&vocabulary);
    let replaces = shelf.replaces(&name, &text);
    if replaces {
        sink.emit(shelf.replaced(&name, &place));
    }
    let source = sources.add(place.clone(), text);
    let robot = robot::read(&name, &sources, source, &mut sink);
    let failed = sink.has_errors();
    if let Some(robot) = &robot {
        show(robot, replaces, global);
    }
    // With the robot, its findings are already part of the JSON output.
    if robot.is_none() || global.format != Format::Json {
        specs::tell(&[Findings::of(sources, sink.diagnostics).in_file(&place)], global);
    }
    if failed { Exit::Invalid } else { Exit::Ok }
}

/// Why a robot cannot be read.
enum Lost {
    /// It does not exist.
    Nowhere(String),
    /// Its file is too large, not text, or not a regular file.
    Unreadable(Box<Diagnostic>),
}

/// Name, path and text of a robot: a file, `robots/NAME.toml` in the working folder, or a built-in one.
fn find(wanted: &str) -> Result<(String, PathBuf, String), Lost> {
    let is_path = wanted.ends_with(".toml") || wanted.contains(std::path::MAIN_SEPARATOR);
    let path = if is_path { PathBuf::from(wanted) } else { PathBuf::from(format!("robots/{wanted}.toml")) };
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    match (Disk.sort(&path), robot::embedded(wanted)) {
        (Ok(_), _) => match file::read(&Disk, &path) {
            Ok(text) => Ok((name, path, text)),
            Err(diagnostic) => Err(Lost::Unreadable(Box::new(diagnostic))),
        },
        (Err(_), Some(text)) => Ok((name, path, text.to_owned())),
        (Err(error), None) if is_path => Err(Lost::Nowhere(format!("`{wanted}` cannot be read: {error}"))),
        (Err(_), None) => Err(Lost::Nowhere(format!("there is no robot `{wanted}`"))),
    }
}

/// Prints a robot; `replaces` means that its file hides a built-in robot of the same name.
fn show(robot: &Robot, replaces: bool, global: &Global) {
    match global.format {
        Format::Json => {
            let mut facts = serde_json::json!(summary(robot));
            facts["replaces_shipped"] = replaces.into();
            output::json(&facts);
        }
        Format::Mjcf => output::data(&mjcf::description(robot)),
        Format::Urdf => output::data(&urdf::document(robot)),
        _ => output::data(&text(&summary(robot))),
    }
}

/// The values as tables for people.
fn text(summary: &Summary) -> String {
    let [x, y, z] = summary.com;
    let mut text =
        one_line(&format!("{}: {:.5} kg, {} joints", summary.name, summary.total_mass, summary.joints.len()));
    text += &one_line(&format!(
        "base stands {:.4} m high, centre of mass {x:.4} {y:.4} {z:.4} m from it",
        summary.standing_height
    ));
    if let Some(length) = summary.leg_length {
        text += &one_line(&format!("legs are {length:.4} m long, hip to ankle"));
    }
    text += &one_line(&format!(
        "\n{:<28} {:>17} {:>7} {:>7} {:>8} {:>8} {:>8} {:>12} {:>8}  mirror",
        "joint", "limits rad", "N m", "rad/s", "damping", "friction", "armature", "gains", "default"
    ));
    for joint in &summary.joints {
        let limits = format!("{:.3} .. {:.3}", joint.lower, joint.upper);
        let gains = format!("{:.1} {:.2}", joint.stiffness_gain, joint.damping_gain);
        let sign = if joint.mirror_sign < 0.0 { "-" } else { "+" };
        text += &one_line(&format!(
            "{:<28} {limits:>17} {:>7.1} {:>7.2} {:>8.3} {:>8.2} {:>8.4} {gains:>12} {:>8.3}  {sign}{}",
            joint.name,
            joint.effort_limit,
            joint.velocity_limit,
            joint.damping,
            joint.friction,
            joint.armature,
            joint.default_position,
            joint.mirror
        ));
    }
    text += &one_line(&format!(
        "\n{:<28} {:>10} {:>30} {:>32}  shapes",
        "body", "kg", "centre of mass m", "principal moments kg m^2"
    ));
    for link in &summary.links {
        let triple =
            |values: [f64; 3], digits: usize| values.map(|value| format!("{value:.digits$}")).join(" ");
        let (com, moments) = (triple(link.com, 5), triple(link.principal_moments, 6));
        text += &one_line(&format!(
            "{:<28} {:>10.5} {com:>30} {moments:>32}  {}",
            link.name, link.mass, link.shapes
        ));
    }
    text.push('\n');
    for check in &summary.checks {
        let mark = match (check.passed, check.findings.is_empty()) {
            (false, _) => "FAIL",
            (true, false) => "warn",
            (true, true) => "ok  ",
        };
        text += &one_line(&format!("{mark} {}: {}", check.name, check.detail));
    }
    text
}
