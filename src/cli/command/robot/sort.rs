//! Recognises other files given in place of a robot file, and suggests the robot that was probably intended.

use std::path::Path;

use crate::escape::shell;
use crate::kinds::vocabulary::vocabulary;
use crate::robot;
use crate::spec::load::{self, robots};
use crate::spec::suggest::{listed, nearest};
use crate::spec::{Attachment, LoadOptions, Vocabulary, suite};
use crate::syntax::Disk;

/// A file that does not describe a robot.
pub struct Other {
    /// The error message.
    pub message: String,
    /// How to fix it.
    pub advice: String,
}

/// Recognises a spec, a suite or a motion by the keys before its first table.
pub fn other(path: &Path, text: &str, vocabulary: &Vocabulary) -> Option<Other> {
    let shown = path.display();
    let top = || text.lines().map(str::trim_start).take_while(|line| !line.starts_with('['));
    let assigns = |key: &str| {
        top().filter_map(|line| line.strip_prefix(key)).any(|rest| rest.trim_start().starts_with('='))
    };
    let is = |what: &str| format!("`{shown}` is {what}, not the file of a robot");
    let of = |robots: Vec<Attachment>| match robots.as_slice() {
        [] => "`[robot]` names the robot: give that name, or the robot's file".to_owned(),
        [robot] => format!("its robot is `{}`: {}", robot.name, show(robot)),
        several => format!("its robots are {}", listed(several.iter().map(|robot| robot.name.as_str()))),
    };
    if suite::is_suite(text) {
        let arms = suite::load(&Disk, path, &LoadOptions::default(), vocabulary).arms;
        let mut robots: Vec<Attachment> =
            arms.into_iter().filter_map(|arm| arm.arm.experiment.robot).collect();
        robots.sort_by(|a, b| a.name.cmp(&b.name));
        robots.dedup_by(|a, b| a.name == b.name);
        return Some(Other { message: is("a suite"), advice: of(robots) });
    }
    if assigns("spec") {
        let spec = load::load(path, &LoadOptions::default(), vocabulary).experiment;
        return Some(Other {
            message: is("a spec"),
            advice: of(spec.and_then(|spec| spec.robot).into_iter().collect()),
        });
    }
    assigns("kind").then(|| Other {
        message: is("a reference motion"),
        advice: format!("a motion is made for the robot of each spec; the robots here are {}", known()),
    })
}

/// The command that shows the robot of a spec.
fn show(robot: &Attachment) -> String {
    let place = robot.path.as_deref().unwrap_or(Path::new(&robot.name));
    format!("`specforge robot show {}`", shell::argument(place))
}

/// A suggestion for a word that does not name a robot.
pub fn instead(wanted: &str) -> String {
    let ending = Path::new(wanted).extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    if matches!(ending, "urdf" | "xml" | "mjcf" | "xacro") && Path::new(wanted).is_file() {
        let file = shell::argument(Path::new(wanted));
        return format!("`specforge robot import {file}` writes the robot's file, which can be shown");
    }
    let names = names();
    match nearest(wanted, names.iter().map(String::as_str)) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("the robots here are {}", known()),
    }
}

/// The robots of the working folder, and the built-in ones.
fn names() -> Vec<String> {
    robots(&vocabulary()).names(&Disk, Some(Path::new(".")))
}

fn known() -> String {
    let names = names();
    if names.is_empty() { listed(robot::names()) } else { listed(names.iter().map(String::as_str)) }
}
