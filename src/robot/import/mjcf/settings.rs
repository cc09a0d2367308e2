//! `<compiler>`: the interpretation of numbers in an MJCF file, and the orientations that depend on it.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use super::super::intake::{Intake, value};
use super::super::tree::Tree;
use super::super::xml::Element;
use crate::diag::Diagnostic;
use crate::robot::kinematics::rotation_about;

/// The settings of a file, merged from all `<compiler>` elements.
#[derive(Clone, Debug)]
pub(super) struct Settings {
    /// Conversion factor from the file's angles to rad.
    pub angle: f64,
    /// Whether a range implies a limit.
    pub autolimits: bool,
    /// Whether masses come from geoms: never, without an inertial, always.
    pub from_geoms: FromGeoms,
    /// First and last geom group whose masses count.
    pub groups: [f64; 2],
    /// Minimum mass of a body in kg, and minimum principal moment in kg m^2.
    pub least: [f64; 2],
    /// Mass in kg to which the whole model is scaled; no scaling unless positive.
    pub total_mass: f64,
    /// Whether impossible inertias become spheres.
    pub balance: bool,
    /// The folder of the meshes.
    pub meshes: PathBuf,
    /// Whether folders in mesh names are ignored.
    pub strip: bool,
    /// Sequence of Euler axes, one letter each; lower case for axes that rotate with the body.
    sequence: Vec<char>,
}

/// The source of masses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FromGeoms {
    Never,
    Missing,
    Always,
}

impl Settings {
    /// The settings of a file in a folder.
    pub fn read(root: &Element, from: &Path, intake: &mut Intake) -> Self {
        let mut settings = Self {
            angle: PI / 180.0,
            autolimits: true,
            from_geoms: FromGeoms::Missing,
            groups: [0.0, 5.0],
            least: [0.0; 2],
            total_mass: -1.0,
            balance: false,
            meshes: from.to_owned(),
            strip: false,
            sequence: vec!['x', 'y', 'z'],
        };
        for compiler in root.all("compiler") {
            settings.add(compiler, from, intake);
        }
        settings
    }

    fn add(&mut self, compiler: &Element, from: &Path, intake: &mut Intake) {
        if compiler.text("coordinate").is_some_and(|word| word != "local") {
            let error = value("global coordinates are not read".to_owned(), compiler.place("coordinate"));
            intake.tell(error.help("save the file with MuJoCo 2.3.3 or newer, which writes local ones"));
        }
        match compiler.text("angle") {
            Some("radian") => self.angle = 1.0,
            Some("degree") => self.angle = PI / 180.0,
            Some(_) => intake.tell(value("`angle` is degree or radian".to_owned(), compiler.place("angle"))),
            None => {}
        }
        match compiler.text("inertiafromgeom") {
            Some("true") => self.from_geoms = FromGeoms::Always,
            Some("false") => self.from_geoms = FromGeoms::Never,
            Some(_) => self.from_geoms = FromGeoms::Missing,
            None => {}
        }
        if let Some(sequence) = compiler.text("eulerseq") {
            self.sequence = sequence.chars().collect();
            if self.sequence.len() != 3 || !self.sequence.iter().all(|axis| "xyzXYZ".contains(*axis)) {
                intake.tell(value(
                    "`eulerseq` is three of x, y, z, X, Y, Z".to_owned(),
                    compiler.place("eulerseq"),
                ));
                self.sequence = vec!['x', 'y', 'z'];
            }
        }
        for (key, flag) in [
            ("autolimits", &mut self.autolimits),
            ("balanceinertia", &mut self.balance),
            ("strippath", &mut self.strip),
        ] {
            if let Some(word) = compiler.text(key) {
                *flag = word == "true";
            }
        }
        self.groups = intake.vector(compiler, "inertiagrouprange").unwrap_or(self.groups);
        self.total_mass = intake.number(compiler, "settotalmass").unwrap_or(self.total_mass);
        for (key, least) in ["boundmass", "boundinertia"].into_iter().zip(&mut self.least) {
            *least = intake.number(compiler, key).unwrap_or(*least);
        }
        if let Some(folder) = compiler.text("meshdir").or(compiler.text("assetdir")) {
            self.meshes = from.join(folder);
        }
    }

    /// The pose from an element's `pos` and orientation.
    pub fn pose(&self, element: &Element, intake: &mut Intake) -> Isometry3<f64> {
        let place = intake.vector(element, "pos").unwrap_or_default();
        let turn = self.orientation(element, intake).unwrap_or_else(UnitQuaternion::identity);
        Isometry3::from_parts(Translation3::from(Vector3::from(place)), turn)
    }

    /// The orientation of an element; `None` if it has none.
    fn orientation(&self, element: &Element, intake: &mut Intake) -> Option<UnitQuaternion<f64>> {
        let other = |name: &&str| element.attribute(name).is_some();
        // Other forms take precedence over a quaternion, as in MuJoCo if a default has one form and the
        // element another.
        let form = ["axisangle", "euler", "xyaxes", "zaxis", "quat"].into_iter().find(other)?;
        let turn = match form {
            "axisangle" => {
                let [x, y, z, angle] = intake.vector(element, form)?;
                let axis = Unit::try_new(Vector3::new(x, y, z), 1e-14)?;
                rotation_about(&axis, angle * self.angle)
            }
            "euler" => self.euler(intake.vector(element, form)?),
            "xyaxes" => {
                let [a, b, c, d, e, f] = intake.vector(element, form)?;
                let x = Vector3::new(a, b, c).try_normalize(1e-14)?;
                let y = Vector3::new(d, e, f);
                let y = (y - x * x.dot(&y)).try_normalize(1e-14)?;
                let frame = Matrix3::from_columns(&[x, y, x.cross(&y)]);
                UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(frame))
            }
            "zaxis" => upright(&Vector3::from(intake.vector::<3>(element, form)?))?,
            _ => {
                let [w, x, y, z] = intake.vector(element, form)?;
                UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-14)?
            }
        };
        Some(turn)
    }

    fn euler(&self, angles: [f64; 3]) -> UnitQuaternion<f64> {
        let mut turn = UnitQuaternion::identity();
        for (axis, angle) in self.sequence.iter().zip(angles) {
            let direction = match axis.to_ascii_lowercase() {
                'x' => Vector3::x(),
                'y' => Vector3::y(),
                _ => Vector3::z(),
            };
            let step = rotation_about(&direction, angle * self.angle);
            turn = if axis.is_lowercase() { turn * step } else { step * turn };
        }
        turn
    }
}

/// Ranges in rad do not exceed this, so that larger values are degrees.
const WHOLE_TURN: f64 = 6.3;

/// Warns of ranges in degrees that look like radians (W0425): degrees are the default unit of a file.
pub(super) fn suspect(root: &Element, tree: &Tree, settings: &Settings, intake: &mut Intake) {
    let hinges =
        tree.parts.iter().filter_map(|part| part.hinge.as_ref()).filter(|hinge| hinge.other.is_none());
    let ranges: Vec<f64> = hinges
        .flat_map(|hinge| [hinge.lower, hinge.upper])
        .flatten()
        .map(|limit| limit.abs() / settings.angle)
        .collect();
    let most = ranges.iter().copied().fold(0.0, f64::max);
    if settings.angle == 1.0 || ranges.is_empty() || most > WHOLE_TURN {
        return;
    }
    let compiler = root.all("compiler").last();
    let says = root.all("compiler").any(|compiler| compiler.text("angle").is_some());
    let unit = if says {
        "`angle` is degree"
    } else {
        "<compiler> says no `angle`, and without it MuJoCo takes degrees"
    };
    let message = format!("no joint turns further than {most} degrees: {unit}");
    let warning = Diagnostic::warning("W0425", message)
        .at(compiler.map_or(root.span, |compiler| compiler.span), "")
        .help("write angle=\"radian\" into <compiler> if the ranges are in radians, and import again");
    intake.tell(warning);
}

/// The smallest rotation from z to a direction.
pub(super) fn upright(direction: &Vector3<f64>) -> Option<UnitQuaternion<f64>> {
    let direction = Unit::try_new(*direction, 1e-14)?;
    let half_turn = || rotation_about(&Vector3::x(), PI);
    Some(UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), &direction).unwrap_or_else(half_turn))
}
