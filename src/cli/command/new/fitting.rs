//! A motion for a robot that cannot make the one of its task (E0509): the shipped one in a smaller size.

use std::path::{Path, PathBuf};

use crate::check;
use crate::robot::{Kinematics, Robot, leg_length};
use crate::scaffold::Wish;
use crate::scaffold::motion::smaller;
use crate::spec::{LoadOptions, folder};
use crate::syntax::{Disk, Overlay};

/// The code of a motion that the robot cannot make.
const INFEASIBLE: &str = "E0509";
/// Length in m of the legs that the lengths of the shipped walk are for.
const REFERENCE: f64 = 0.7;

/// A new spec before it is written.
#[derive(Clone, Copy)]
pub struct Asked<'a> {
    /// The file to write.
    pub file: &'a Path,
    /// Its folder.
    pub folder: &'a Path,
    /// The robot, a user's own.
    pub robot: &'a Robot,
    /// The settings.
    pub wish: &'a Wish,
}

/// A motion within the robot's reach, and the spec that names it.
#[derive(Clone, Debug)]
pub struct Fitting {
    /// The motion's file.
    pub file: PathBuf,
    /// Its text.
    pub text: String,
    /// The text of the spec.
    pub spec: String,
    /// The size of the motion in percent of the shipped one.
    pub percent: f64,
}

/// The largest motion that the robot can make; `None` if it can make the task's own, or none of the smaller
/// ones, or if a file of that name exists.
pub fn motion(asked: &Asked, text: &str, written: impl Fn(&Wish) -> String) -> Option<Fitting> {
    let Asked { file, folder, robot, wish } = asked;
    if !is_infeasible(file, text, None) {
        return None;
    }
    let name = format!("{}_{}", wish.robot, wish.task);
    let root = folder::root(&Disk, &folder.join("new.toml")).unwrap_or_else(|| folder.to_path_buf());
    let place = root.join("specs/motions").join(format!("{name}.toml"));
    if place.symlink_metadata().is_ok() {
        return None;
    }
    let spec = written(&Wish { motion: Some(name), ..(*wish).clone() });
    let fits = |text: &str| !is_infeasible(file, &spec, Some((&place, text)));
    let fitting = smaller(&wish.task, spacing(robot)).into_iter().find(|motion| fits(&motion.text))?;
    Some(Fitting { file: place.clone(), text: fitting.text, spec: spec.clone(), percent: fitting.percent })
}

/// Whether a spec that is not written yet has a motion that its robot cannot make. `motion` is a file that
/// is not written yet, either: its path and its text.
fn is_infeasible(file: &Path, text: &str, motion: Option<(&Path, &str)>) -> bool {
    let mut files = Overlay::new(Disk);
    files.hold(file, text);
    if let Some((path, text)) = motion {
        files.hold(path, text);
    }
    let checked = check::checked_in(&files, file, &LoadOptions::default());
    checked.sink.diagnostics.iter().any(|found| found.code == INFEASIBLE)
}

/// Distance in m of a foot from the centre line in the default pose, for legs of the reference length.
fn spacing(robot: &Robot) -> Option<f64> {
    let leg = leg_length(robot).filter(|leg| *leg > 0.0)?;
    let kinematics = Kinematics::new(robot);
    let [left, right] = robot.feet.each_ref().map(|foot| (kinematics.pose(foot.link) * foot.centre).y);
    let half = 0.5 * (left - right);
    (half > 0.0).then(|| half / leg * REFERENCE)
}
