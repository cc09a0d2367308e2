//! MJCF text of a robot on its terrain, loaded by the MuJoCo engine and exported by deployment.
//!
//! Pure text, needs no library. The same parameters as every other engine: explicit inertias, armature,
//! damping, friction loss, limits, one box per sole; Newton solver with elliptic cones, as in the paper's
//! simulation. Units SI, angles in radians.

use std::fmt::Write;

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use super::scene::{EngineSettings, Terrain};
use super::terrain::Piece;
use crate::escape::xml::attribute;
use crate::robot::model::{Body, Joint};
use crate::robot::{Foot, Robot, Shape};

/// Name of the base body's free joint.
pub const FREE_JOINT: &str = "floating_base";
/// Names of the soles' geoms, left and right.
pub const SOLES: [&str; 2] = ["left_sole", "right_sole"];
/// The end of a document.
const CLOSING: &str = "</mujoco>\n";
/// Depth of a height field's solid below its lowest point, in m.
const FIELD_BASE: f64 = 0.1;

/// The MJCF document. Motors are in joint order, `ctrl` is a torque in N m.
pub fn document(robot: &Robot, terrain: &Terrain, settings: &EngineSettings) -> String {
    let mut text = String::with_capacity(16 * 1024);
    head(&mut text, robot, settings);
    assets(&mut text, terrain);
    text.push_str("  <worldbody>\n");
    ground(&mut text, terrain);
    base(&mut text, robot, settings.friction);
    text.push_str("  </worldbody>\n");
    motors(&mut text, robot);
    text.push_str(CLOSING);
    text
}

/// The robot alone on flat ground, for other programs: the document with the default pose as a key frame, and
/// with the parameters that MJCF does not support as named numbers, `JOINT.velocity_limit` in rad/s,
/// `JOINT.stiffness_gain` in N m/rad and `JOINT.damping_gain` in N m s/rad.
pub fn description(robot: &Robot) -> String {
    let settings = EngineSettings { step: 0.002, friction: 1.0, contact_time: None };
    let mut text = document(robot, &Terrain::Flat, &settings);
    text.truncate(text.len() - CLOSING.len());
    line(&mut text, format_args!("  <custom>"));
    for Joint { name, velocity_limit, stiffness_gain, damping_gain, .. } in
        robot.links.iter().map(|link| &link.joint)
    {
        let name = attribute(name);
        let figures = [
            ("velocity_limit", velocity_limit),
            ("stiffness_gain", stiffness_gain),
            ("damping_gain", damping_gain),
        ];
        for (key, figure) in figures {
            line(&mut text, format_args!("    <numeric name=\"{name}.{key}\" data=\"{figure}\"/>"));
        }
    }
    line(&mut text, format_args!("  </custom>"));
    let mut pose = vec![0.0, 0.0, robot.standing_height, 1.0, 0.0, 0.0, 0.0];
    pose.extend(depth_first(robot).map(|index| robot.links[index].joint.default_position));
    let pose: Vec<String> = pose.iter().map(f64::to_string).collect();
    line(&mut text, format_args!("  <keyframe>"));
    line(&mut text, format_args!("    <key name=\"default\" qpos=\"{}\"/>", pose.join(" ")));
    line(&mut text, format_args!("  </keyframe>"));
    text.push_str(CLOSING);
    text
}

/// The links in the order of the document.
fn depth_first(robot: &Robot) -> impl Iterator<Item = usize> {
    let below = move |parent: Option<usize>| {
        (0..robot.joints())
            .rev()
            .filter(move |index| robot.links[*index].parent == parent)
            .collect::<Vec<_>>()
    };
    let mut open = below(None);
    std::iter::from_fn(move || {
        let index = open.pop()?;
        open.extend(below(Some(index)));
        Some(index)
    })
}

fn line(text: &mut String, arguments: std::fmt::Arguments) {
    text.write_fmt(arguments).expect("writing to a String cannot fail");
    text.push('\n');
}

fn head(text: &mut String, robot: &Robot, settings: &EngineSettings) {
    let (step, friction, time) = (settings.step, settings.friction, settings.contact_time.unwrap_or(0.02));
    line(text, format_args!("<mujoco model=\"{}\">", attribute(&robot.name)));
    line(text, format_args!("  <compiler angle=\"radian\" autolimits=\"true\" inertiafromgeom=\"false\"/>"));
    line(
        text,
        format_args!(
            "  <option timestep=\"{step}\" gravity=\"0 0 -9.81\" integrator=\"Euler\" solver=\"Newton\" \
             cone=\"elliptic\" iterations=\"50\" tolerance=\"1e-10\">"
        ),
    );
    line(text, format_args!("    <flag autoreset=\"disable\"/>"));
    line(text, format_args!("  </option>"));
    line(text, format_args!("  <default>"));
    line(
        text,
        format_args!(
            "    <geom contype=\"1\" conaffinity=\"0\" condim=\"3\" friction=\"{friction}\" solref=\"{time} \
             1\"/>"
        ),
    );
    line(
        text,
        format_args!("    <default class=\"ground\"><geom contype=\"0\" conaffinity=\"1\"/></default>"),
    );
    line(text, format_args!("  </default>"));
}

fn assets(text: &mut String, terrain: &Terrain) {
    for piece in terrain.pieces() {
        let Piece::Field { cell, counts: [along, across], heights } = piece else { continue };
        let (low, high) = extremes(heights);
        let half = |count: usize| (count - 1) as f64 * cell / 2.0;
        let size = format!("{} {} {} {FIELD_BASE}", half(along), half(across), (high - low).max(1e-6));
        line(text, format_args!("  <asset>"));
        let open = format!("    <hfield name=\"field\" nrow=\"{across}\" ncol=\"{along}\" size=\"{size}\"");
        line(text, format_args!("{open}"));
        // MuJoCo's rows run along y and its text begins with the largest y.
        line(text, format_args!("      elevation=\""));
        for y in (0..across).rev() {
            let row: Vec<String> = (0..along).map(|x| (heights[x * across + y] - low).to_string()).collect();
            line(text, format_args!("        {}", row.join(" ")));
        }
        line(text, format_args!("      \"/>"));
        line(text, format_args!("  </asset>"));
    }
}

fn ground(text: &mut String, terrain: &Terrain) {
    for (index, piece) in terrain.pieces().into_iter().enumerate() {
        let shape = match piece {
            Piece::Plane { point, normal } => {
                format!(
                    "type=\"plane\" size=\"0 0 1\" pos=\"{}\" zaxis=\"{}\"",
                    triple(point),
                    triple(normal)
                )
            }
            Piece::Box { centre, half } => {
                format!("type=\"box\" size=\"{}\" pos=\"{}\"", triple(half), triple(centre))
            }
            Piece::Field { heights, .. } => {
                format!("type=\"hfield\" hfield=\"field\" pos=\"0 0 {}\"", extremes(heights).0)
            }
        };
        line(text, format_args!("    <geom name=\"ground_{index}\" class=\"ground\" {shape}/>"));
    }
}

fn base(text: &mut String, robot: &Robot, friction: f64) {
    let height = robot.standing_height;
    line(text, format_args!("    <body name=\"{}\" pos=\"0 0 {height}\">", attribute(&robot.base.name)));
    line(text, format_args!("      <freejoint name=\"{FREE_JOINT}\"/>"));
    inertial(text, &robot.base, 6);
    shapes(text, &robot.base, 6);
    for (index, link) in robot.links.iter().enumerate() {
        if link.parent.is_none() {
            branch(text, robot, friction, index, 6);
        }
    }
    line(text, format_args!("    </body>"));
}

/// A link with all its descendants.
fn branch(text: &mut String, robot: &Robot, friction: f64, index: usize, indent: usize) {
    let link = &robot.links[index];
    let name = attribute(&link.body.name);
    line(text, format_args!("{:indent$}<body name=\"{name}\" {}>", "", place(&link.joint.origin)));
    joint(text, &link.joint, indent + 2);
    inertial(text, &link.body, indent + 2);
    match robot.feet.iter().position(|foot| foot.link == index) {
        Some(side) => sole(text, SOLES[side], &robot.feet[side], friction, indent + 2),
        None => shapes(text, &link.body, indent + 2),
    }
    for (child, link) in robot.links.iter().enumerate() {
        if link.parent == Some(index) {
            branch(text, robot, friction, child, indent + 2);
        }
    }
    line(text, format_args!("{:indent$}</body>", ""));
}

/// The box of a sole. A foot's friction is a factor on the ground's; its priority makes the product the
/// pair's coefficient, because MuJoCo takes the larger of the two at equal priorities.
fn sole(text: &mut String, name: &str, foot: &Foot, friction: f64, indent: usize) {
    let (size, centre) = (vector(&foot.half_extents), vector(&foot.centre.coords));
    let own = match foot.friction {
        1.0 => String::new(),
        factor => format!(" priority=\"1\" friction=\"{}\"", factor * friction),
    };
    line(
        text,
        format_args!(
            "{:indent$}<geom name=\"{name}\" type=\"box\" size=\"{size}\" pos=\"{centre}\"{own}/>",
            ""
        ),
    );
}

fn joint(text: &mut String, joint: &Joint, indent: usize) {
    let (name, axis) = (attribute(&joint.name), vector(&joint.axis));
    let Joint { lower, upper, damping, friction, armature, .. } = joint;
    line(
        text,
        format_args!(
            "{:indent$}<joint name=\"{name}\" axis=\"{axis}\" range=\"{lower} \
             {upper}\" damping=\"{damping}\" \
             frictionloss=\"{friction}\" armature=\"{armature}\"/>",
            ""
        ),
    );
}

fn inertial(text: &mut String, body: &Body, indent: usize) {
    let (mass, com, tensor) = (body.mass, vector(&body.com.coords), tensor(&body.inertia));
    line(
        text,
        format_args!("{:indent$}<inertial mass=\"{mass}\" pos=\"{com}\" fullinertia=\"{tensor}\"/>", ""),
    );
}

fn shapes(text: &mut String, body: &Body, indent: usize) {
    for collision in &body.collisions {
        let (kind, size) = match &collision.shape {
            Shape::Box(half) => ("box", vector(half)),
            Shape::Capsule(half, radius) => ("capsule", format!("{radius} {half}")),
            Shape::Cylinder(half, radius) => ("cylinder", format!("{radius} {half}")),
            Shape::Sphere(radius) => ("sphere", radius.to_string()),
        };
        let place = place(&collision.pose);
        line(text, format_args!("{:indent$}<geom type=\"{kind}\" size=\"{size}\" {place}/>", ""));
    }
}

fn motors(text: &mut String, robot: &Robot) {
    line(text, format_args!("  <actuator>"));
    for link in &robot.links {
        let (name, limit) = (attribute(&link.joint.name), link.joint.effort_limit);
        line(
            text,
            format_args!("    <motor name=\"{name}\" joint=\"{name}\" ctrlrange=\"-{limit} {limit}\"/>"),
        );
    }
    line(text, format_args!("  </actuator>"));
}

fn extremes(heights: &[f64]) -> (f64, f64) {
    heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &z| (low.min(z), high.max(z)))
}

fn place(pose: &Isometry3<f64>) -> String {
    let position = vector(&pose.translation.vector);
    if pose.rotation == UnitQuaternion::identity() {
        return format!("pos=\"{position}\"");
    }
    let q = pose.rotation;
    format!("pos=\"{position}\" quat=\"{} {} {} {}\"", q.w, q.i, q.j, q.k)
}

fn triple([x, y, z]: [f64; 3]) -> String {
    format!("{x} {y} {z}")
}

fn vector(from: &Vector3<f64>) -> String {
    triple([from.x, from.y, from.z])
}

fn tensor(from: &Matrix3<f64>) -> String {
    let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    entries.map(|place| from[place].to_string()).join(" ")
}
