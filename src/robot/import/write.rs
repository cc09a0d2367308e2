//! Writes the robot file of a welded tree: every value of the source, and a line to fill in for each missing
//! one.

use std::fmt::Write;

use nalgebra::{Isometry3, Matrix3, Point3, Unit, UnitQuaternion, Vector3};

use super::block::{Block, along_axes, around};
use super::fill::{FIGURES, Fill, filled, gives};
use super::naming::some;
use super::tree::Hinge;
use super::welded::{Moving, Welded};
use crate::escape;
use crate::robot::symmetry;
use crate::robot::urdf::fixed_angles;
use crate::robot::{Body, Collision, Kinematics, Shape};

/// The origin of the values, for the file's header.
#[derive(Clone, Debug)]
pub struct Origin<'a> {
    /// The robot's name: that of its file.
    pub name: &'a str,
    /// The file that was imported.
    pub source: &'a str,
    /// `URDF` or `MJCF`.
    pub format: &'a str,
    /// Values for joints that the source lacks; the last match counts.
    pub fills: &'a [Fill],
}

/// A robot file and what its author needs to know.
#[derive(Clone, Debug)]
pub struct Written {
    /// The text of the file.
    pub text: String,
    /// The keys to fill in (`left_knee: effort_limit`); at the end those whose value in the source is
    /// ignored.
    pub missing: Vec<String>,
    /// Remarks on what could not be imported unchanged, each once.
    pub notes: Vec<String>,
}

/// The robot file of a welded tree.
pub fn text(welded: &Welded, origin: &Origin) -> Written {
    let fills = origin.fills;
    let notes = welded.notes.clone();
    let mut writer = Writer { text: String::new(), missing: Vec::new(), void: Vec::new(), notes, fills };
    writer.base(welded);
    let images = writer.images(welded);
    for (index, link) in welded.links.iter().enumerate() {
        writer.link(link, welded);
        if let Some(image) = images.get(index) {
            writer.line(format_args!("mirror = {}", quoted(image)));
        }
    }
    for (side, (link, sole)) in ["left", "right"].into_iter().zip(&welded.feet) {
        let other = welded.feet.iter().find(|(other, _)| other != link);
        let image = other.and_then(|(other, sole)| image_of(welded, *other, *link, (*sole)?));
        writer.foot(side, &welded.links[*link].body.name, *sole, image);
    }
    let Writer { text: body, mut missing, void, notes, .. } = writer;
    let notes = each_once(&notes);
    let mut text = String::new();
    let _ = writeln!(text, "# Imported from {} ({}).", escape::toml::comment(origin.source), origin.format);
    let mut remark = |title: &str, lines: &[String]| {
        if !lines.is_empty() {
            let _ = writeln!(text, "#\n# {title}");
            lines.iter().for_each(|line| {
                let _ = writeln!(text, "# * {}", escape::toml::comment(line));
            });
        }
    };
    let title = if notes.iter().any(|note| note.starts_with("welded at the positions of the key frame")) {
        "Welded, at position zero where the remarks say nothing else:"
    } else {
        "Welded at position zero:"
    };
    remark(title, &welded.fixed);
    remark("Remarks:", &notes);
    remark("To be filled in, because the source does not say it:", &by_key(&missing, welded.links.len()));
    let title = "To be filled in, because the source's figure does not count (see the remarks):";
    remark(title, &by_key(&void, welded.links.len()));
    missing.extend(void);
    let total = welded.base.mass + welded.links.iter().map(|link| link.body.mass).sum::<f64>();
    let _ = writeln!(text, "\nname = {}", quoted(origin.name));
    let _ = writeln!(text, "source = {}", quoted(origin.source));
    let _ = writeln!(text, "# licence = \"\"    # under which terms the figures may be passed on");
    if !welded.weigh_base && welded.links.iter().all(|link| !link.weigh) {
        let _ = writeln!(text, "total_mass = \"{} kg\"", number(total));
    }
    text.push_str(&body);
    Written { text, missing, notes }
}

/// The lines without repetitions, with the number of occurrences of each.
fn each_once(lines: &[String]) -> Vec<String> {
    let mut counted: Vec<(&String, usize)> = Vec::new();
    for line in lines {
        match counted.iter_mut().find(|(known, _)| *known == line) {
            Some((_, count)) => *count += 1,
            None => counted.push((line, 1)),
        }
    }
    let shown = |(line, count): (&String, usize)| {
        if count > 1 { format!("{line} ({count} times)") } else { line.clone() }
    };
    counted.into_iter().map(shown).collect()
}

/// Missing values (`left_knee: effort_limit`) by their key: one line for what all joints lack.
fn by_key(missing: &[String], joints: usize) -> Vec<String> {
    let mut keys: Vec<(&str, Vec<&str>)> = Vec::new();
    for (owner, key) in missing.iter().filter_map(|entry| entry.split_once(": ")) {
        match keys.iter_mut().find(|(known, _)| *known == key) {
            Some((_, owners)) => owners.push(owner),
            None => keys.push((key, vec![owner])),
        }
    }
    let shown = |(key, owners): (&str, Vec<&str>)| {
        let of_joints = !matches!(key, "mass" | "com" | "inertia")
            && !owners.iter().any(|owner| owner.starts_with("feet."));
        let of = if owners.len() == joints && of_joints {
            format!("all {joints} joints")
        } else {
            owners.join(", ")
        };
        format!("{key} of {of}")
    };
    keys.into_iter().map(shown).collect()
}

struct Writer<'a> {
    text: String,
    missing: Vec<String>,
    /// The keys whose value in the source is ignored.
    void: Vec<String>,
    notes: Vec<String>,
    fills: &'a [Fill],
}

impl Writer<'_> {
    fn line(&mut self, line: std::fmt::Arguments) {
        self.text.write_fmt(line).expect("writing to a String cannot fail");
        self.text.push('\n');
    }

    fn base(&mut self, welded: &Welded) {
        self.line(format_args!("\n[base]\nname = {}", quoted(&welded.base.name)));
        self.body(&welded.base, welded.weigh_base.then(|| unknown(welded, None)));
    }

    /// A body; `unknown` are the parts without a mass if it has to be filled in.
    fn body(&mut self, body: &Body, unknown: Option<&[String]>) {
        if let Some(unknown) = unknown {
            self.unweighed(body, unknown);
        } else {
            self.line(format_args!("mass = \"{} kg\"", number(body.mass)));
            self.line(format_args!("com = {}", lengths(&body.com.coords)));
            self.line(format_args!("inertia = {}", inertia(&body.inertia)));
        }
        if body.collisions.is_empty() {
            return;
        }
        self.line(format_args!("collisions = ["));
        for collision in &body.collisions {
            self.line(format_args!("    {},", shape(collision)));
        }
        self.line(format_args!("]"));
    }

    /// The mirror image of every joint, if the two sides mirror each other.
    fn images(&mut self, welded: &Welded) -> Vec<String> {
        let skeleton = welded.skeleton();
        match symmetry::mirror_map(&skeleton) {
            Ok(mirror) => {
                mirror.into_iter().map(|(image, sign)| symmetry::written(&skeleton, image, sign)).collect()
            }
            Err(unpaired) => {
                let joint = unpaired.joint;
                let message = format!(
                    "left and right do not mirror each other: nothing is the image of joint `{joint}`"
                );
                self.notes.push(match unpaired.nearest {
                    Some(nearest) => format!("{message}; {}", nearest.in_words()),
                    None => message,
                });
                Vec::new()
            }
        }
    }

    /// The lines of a body with unknown mass, including the known masses of its parts.
    fn unweighed(&mut self, body: &Body, unknown: &[String]) {
        let moments = ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"]
            .map(|key| format!("{key} = \"... kg*m^2\""))
            .join(", ");
        let mut rows = [
            ("mass", "\"... kg\"".to_owned(), "mass".to_owned()),
            (
                "com",
                "[\"... m\", \"... m\", \"... m\"]".to_owned(),
                "centre of mass in the body's frame".to_owned(),
            ),
            ("inertia", format!("{{ {moments} }}"), "about the centre of mass, axes of the body".to_owned()),
        ];
        if body.mass > 0.0 {
            let parts: Vec<&str> = unknown.iter().map(String::as_str).collect();
            let parts = some(&parts);
            rows[0].1 = format!("\"{} kg\"", number(body.mass));
            rows[1].1 = lengths(&body.com.coords);
            rows[2].1 = self::inertia(&body.inertia);
            rows.iter_mut().for_each(|(.., meaning)| {
                *meaning +=
                    &format!("; this is that of the parts of which the source says it, without {parts}");
            });
            self.notes.push(format!(
                "`{}`: the source says the masses of some parts, {} kg together, and not those of {parts}; \
                 the sum stands in the lines \
                 to fill in",
                body.name,
                number(body.mass)
            ));
        }
        for (key, value, meaning) in rows {
            self.line(format_args!("# {key} = {value}    # fill in: {meaning}"));
            self.missing.push(format!("{}: {key}", body.name));
        }
    }

    fn link(&mut self, link: &Moving, welded: &Welded) {
        let parent = link.parent.map_or(&welded.base.name, |parent| &welded.links[parent].body.name);
        self.line(format_args!(
            "\n[[links]]\nname = {}\nparent = {}",
            quoted(&link.body.name),
            quoted(parent)
        ));
        self.body(
            &link.body,
            link.weigh.then(|| {
                unknown(welded, welded.links.iter().position(|own| own.body.name == link.body.name))
            }),
        );
        let (hinge, origin) = (&link.hinge, &link.origin);
        self.line(format_args!("\n[links.joint]\nname = {}", quoted(&hinge.name)));
        self.line(format_args!("origin = {}", lengths(&origin.translation.vector)));
        if origin.rotation.angle() > 1e-12 {
            self.line(format_args!("rotation = [{}]", angles(&origin.rotation)));
        }
        let axis = hinge.axis.unwrap_or(Unit::new_unchecked(Vector3::x()));
        let axis = [axis.x, axis.y, axis.z].map(decimal).join(", ");
        self.line(format_args!("axis = [{axis}]"));
        self.joint(hinge, welded);
    }

    fn joint(&mut self, hinge: &Hinge, welded: &Welded) {
        let known = figures(hinge);
        let [lower, upper] = hinge.void_range.map_or([None; 2], |range| range.map(Some));
        for ((key, unit, meaning), value) in FIGURES.into_iter().zip(known) {
            let void = match key {
                "lower" => lower,
                "upper" => upper,
                _ => None,
            };
            if let Some(value) = value {
                self.line(format_args!("{key} = \"{} {unit}\"", number(value)));
                continue;
            }
            match (filled(self.fills, hinge, key, welded), void) {
                (Some(fill), _) => {
                    self.line(format_args!("{key} = {}    # given at the import", quoted(&fill.value)))
                }
                (None, Some(void)) => {
                    let void = number(void);
                    self.line(format_args!(
                        "# {key} = \"{void} {unit}\"    # fill in: {meaning}; the source has this one for a \
                         joint that it does not limit"
                    ));
                    self.void.push(format!("{}: {key}", hinge.name));
                }
                (None, None) => {
                    self.line(format_args!("# {key} = \"... {unit}\"    # fill in: {meaning}"));
                    self.missing.push(format!("{}: {key}", hinge.name));
                }
            }
        }
    }

    /// A foot with its sole, or lines to fill in that suggest the mirror image of the other foot's.
    fn foot(&mut self, side: &str, link: &str, sole: Option<Block>, image: Option<Block>) {
        self.line(format_args!("\n[feet.{side}]\nlink = {}", quoted(link)));
        if let Some(Block { centre, half }) = sole {
            self.line(format_args!("half_extents = {}\ncentre = {}", lengths(&half), lengths(&centre)));
            return;
        }
        for key in ["half_extents", "centre"] {
            let (value, source) = match &image {
                Some(Block { centre, half }) => {
                    let figure = if key == "centre" { centre } else { half };
                    (lengths(figure), "; this is the mirror image of the other foot's")
                }
                None => ("[\"... m\", \"... m\", \"... m\"]".to_owned(), ""),
            };
            self.line(format_args!("# {key} = {value}    # fill in: the box of the sole{source}"));
            self.missing.push(format!("feet.{side}: {key}"));
        }
    }
}

/// The mirror image of a foot's sole in the frame of the other foot, joints at zero.
fn image_of(welded: &Welded, from: usize, to: usize, sole: Block) -> Option<Block> {
    let skeleton = welded.skeleton();
    let mut kinematics = Kinematics::new(&skeleton);
    kinematics.place(&Isometry3::identity(), &vec![0.0; skeleton.joints()]);
    let reflection = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
    let pose = |link: usize| *kinematics.pose(link);
    let centre = reflection * (pose(from) * Point3::from(sole.centre)).coords;
    let turn = |link: usize| pose(link).rotation.to_rotation_matrix().into_inner();
    let axes = turn(to).transpose() * reflection * turn(from);
    // Extents along other axes than those of the other foot cannot be used.
    let along = axes.iter().all(|entry| entry.abs() < 0.01 || entry.abs() > 0.99);
    along.then(|| Block {
        centre: (pose(to).inverse() * Point3::from(centre)).coords,
        half: axes.map(f64::round).abs() * sole.half,
    })
}

/// Filled-in values without effect, and the file's values that take precedence.
pub fn idle(welded: &Welded, fills: &[Fill]) -> Vec<String> {
    let known = |fill: &Fill, hinge: &Hinge| {
        FIGURES.iter().zip(figures(hinge)).any(|((key, ..), value)| *key == fill.key && value.is_some())
    };
    let idle = fills.iter().filter(|fill| {
        let is_for = |hinge: &&Hinge| gives(fill, &fill.key, hinge, welded.hinges());
        let mut hinges = welded.hinges().filter(is_for).peekable();
        hinges.peek().is_some() && hinges.all(|hinge| known(fill, hinge))
    });
    idle.map(Fill::to_string).collect()
}

/// A joint's values in the file, in the order of [`FIGURES`].
fn figures(hinge: &Hinge) -> [Option<f64>; 10] {
    [
        hinge.lower,
        hinge.upper,
        hinge.effort_limit,
        hinge.velocity_limit,
        hinge.damping,
        hinge.friction,
        hinge.armature,
        hinge.stiffness_gain,
        hinge.damping_gain,
        hinge.default_position,
    ]
}

/// The parts of a body with unknown mass.
fn unknown(welded: &Welded, owner: Option<usize>) -> &[String] {
    welded.unweighed.get(&owner).map_or(&[], Vec::as_slice)
}

fn shape(collision: &Collision) -> String {
    let centre = collision.pose.translation.vector;
    match &collision.shape {
        Shape::Box(_) if along_axes(collision) => {
            let block = around(collision);
            let (half, centre) = (lengths(&block.half), lengths(&block.centre));
            format!("{{ shape = \"box\", half_extents = {half}, centre = {centre} }}")
        }
        Shape::Box(half) => {
            let (half, centre, turn) = (lengths(half), lengths(&centre), angles(&collision.pose.rotation));
            format!("{{ shape = \"box\", half_extents = {half}, centre = {centre}, rotation = [{turn}] }}")
        }
        Shape::Sphere(radius) => {
            format!(
                "{{ shape = \"sphere\", centre = {}, radius = \"{} m\" }}",
                lengths(&centre),
                number(*radius)
            )
        }
        Shape::Capsule(half, radius) | Shape::Cylinder(half, radius) => {
            let kind = if matches!(collision.shape, Shape::Capsule(..)) { "capsule" } else { "cylinder" };
            let arm = collision.pose.rotation * Vector3::z() * *half;
            let (from, to) = (lengths(&(centre - arm)), lengths(&(centre + arm)));
            format!("{{ shape = \"{kind}\", from = {from}, to = {to}, radius = \"{} m\" }}", number(*radius))
        }
    }
}

fn inertia(tensor: &Matrix3<f64>) -> String {
    let entries = [
        ("ixx", tensor.m11),
        ("iyy", tensor.m22),
        ("izz", tensor.m33),
        ("ixy", tensor.m12),
        ("ixz", tensor.m13),
        ("iyz", tensor.m23),
    ];
    // What is small for this body, which may be small itself.
    let none = (1e-10 * tensor.amax()).min(NONE);
    let entries = entries.map(|(key, value)| format!("{key} = \"{} kg*m^2\"", number_above(value, none)));
    format!("{{ {} }}", entries.join(", "))
}

fn lengths(vector: &Vector3<f64>) -> String {
    let parts = [vector.x, vector.y, vector.z].map(|part| format!("\"{} m\"", number(part)));
    format!("[{}]", parts.join(", "))
}

/// Roll, pitch and yaw about fixed axes.
fn angles(turn: &UnitQuaternion<f64>) -> String {
    fixed_angles(turn).map(|angle| format!("\"{} rad\"", number(angle))).join(", ")
}

/// Rounding errors of rotations, far below a micrometre and a microgram square metre.
const NONE: f64 = 1e-13;

/// A number with twelve significant digits.
fn number(value: f64) -> String {
    number_above(value, NONE)
}

/// A number with twelve significant digits; 0 if it is smaller than a rounding error.
fn number_above(value: f64, none: f64) -> String {
    let rounded: f64 = format!("{value:.11e}").parse().unwrap_or(value);
    if rounded.abs() < none { "0".to_owned() } else { rounded.to_string() }
}

/// A number that TOML parses as a float.
fn decimal(value: f64) -> String {
    let text = number(value);
    if text.contains('.') { text } else { text + ".0" }
}

fn quoted(text: &str) -> String {
    escape::toml::string(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_inertia_is_kept_and_a_rounding_error_is_not() {
        let tensor = |most: f64| inertia(&Matrix3::from_diagonal(&Vector3::new(most, most, 1e-17)));
        assert!(tensor(1.0).contains("izz = \"0 kg*m^2\""), "{}", tensor(1.0));
        assert!(tensor(1e-14).contains("ixx = \"0.00000000000001 kg*m^2\""), "{}", tensor(1e-14));
        assert!(tensor(1e-14).contains("izz = \"0.00000000000000001 kg*m^2\""), "{}", tensor(1e-14));
        assert!(tensor(1e-14).contains("ixy = \"0 kg*m^2\""), "{}", tensor(1e-14));
    }

    #[test]
    fn what_all_joints_lack_is_one_line_and_feet_are_no_joints() {
        let missing = ["a: damping", "b: damping", "base: mass", "feet.left: centre", "feet.right: centre"];
        let lines = by_key(&missing.map(String::from), 2);
        assert_eq!(lines, ["damping of all 2 joints", "mass of base", "centre of feet.left, feet.right"]);
    }
}
