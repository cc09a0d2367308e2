//! URDF: links and joints, inertials, limits, dynamics and collision shapes.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, Vector3};

use super::census;
use super::intake::{Intake, not_a_tree, value};
use super::origin::{origin, version};
use super::tree::{Hinge, MOST_BODIES, Part, Shapes, Tree, Weight, massless};
use super::xml::{self, Element};
use crate::robot::checks::positive;
use crate::robot::{Body, Collision, Shape};

/// The joints of a file with the links that they connect.
struct Graph<'a> {
    /// The links by name.
    links: &'a BTreeMap<String, &'a Element>,
    /// Every joint: its element, its parent and its child.
    joints: Vec<(&'a Element, String, String)>,
}

/// The tree of a URDF file, links in the order of their joints in the file.
pub(super) fn tree(root: &Element, from: &Path, intake: &mut Intake) -> Option<Tree> {
    // All links are read before the tree is checked, so that all mistakes are reported at once.
    let links = links(root, intake)?;
    let named = root.all("link").filter_map(|link| Some((link.text("name")?, link)));
    let mut parts: BTreeMap<&str, Part> =
        named.map(|(name, link)| (name, part(link, from, intake))).collect();
    let graph = Graph::read(root, &links, intake)?;
    let start = graph.root(root, intake)?;
    let mut tree =
        Tree { name: root.text("name").unwrap_or_default().to_owned(), format: "URDF", ..Tree::default() };
    let mut index = BTreeMap::new();
    let mut open = BinaryHeap::new();
    let mut next = Some((start, None));
    while let Some((link, joint)) = next {
        let mut part = parts.remove(link)?;
        if let Some(joint) = joint {
            let (element, parent, _): &(&Element, String, String) = &graph.joints[joint];
            part.parent = index.get(parent.as_str()).copied();
            part.pose = origin(element, intake);
            part.hinge = hinge(element, intake);
        }
        index.insert(link, tree.parts.len());
        tree.parts.push(part);
        let below = graph.joints.iter().enumerate().filter(|(_, (_, parent, _))| parent == link);
        open.extend(below.map(|(joint, _)| Reverse(joint)));
        // Of all possible next links, the one whose joint comes first in the file.
        next = open.pop().map(|Reverse(joint)| (graph.joints[joint].2.as_str(), Some(joint)));
    }
    if let Some((joint, ..)) = graph.joints.iter().find(|(_, parent, _)| !index.contains_key(parent.as_str()))
    {
        let message = format!("joint `{}` is part of a circle", joint.text("name").unwrap_or_default());
        let help = "every link but one hangs on another one, without a way back";
        intake.tell(not_a_tree(message, joint.span).help(help));
    }
    version(root, intake);
    census::urdf(root).into_iter().for_each(|line| intake.note(line));
    Some(tree)
}

/// The links of a file by name.
fn links<'a>(root: &'a Element, intake: &mut Intake) -> Option<BTreeMap<String, &'a Element>> {
    let mut links = BTreeMap::new();
    for link in root.all("link") {
        let Some(name) = intake.name(link, "name") else { continue };
        if let Some(first) = links.insert(name.clone(), link) {
            let twice = not_a_tree(format!("two links are called `{name}`"), link.place("name"));
            intake.tell(twice.note(first.place("name"), "the first one").help("give each link its own name"));
        }
    }
    if links.len() > MOST_BODIES {
        let message =
            format!("the robot has {} links, more than the {MOST_BODIES} that a robot may have", links.len());
        intake.tell(xml::too_large(message).at(root.span, ""));
        return None;
    }
    Some(links)
}

impl<'a> Graph<'a> {
    fn read(
        root: &'a Element,
        links: &'a BTreeMap<String, &'a Element>,
        intake: &mut Intake,
    ) -> Option<Self> {
        let mut graph = Self { links, joints: Vec::new() };
        let mut names: BTreeMap<String, &Element> = BTreeMap::new();
        let mut carried: BTreeMap<String, &Element> = BTreeMap::new();
        for joint in root.all("joint") {
            let (Some(name), Some(parent), Some(child)) = (
                intake.name(joint, "name"),
                graph.end(joint, "parent", intake),
                graph.end(joint, "child", intake),
            ) else {
                continue;
            };
            if let Some(first) = names.insert(name.clone(), joint) {
                let twice = not_a_tree(format!("two joints are called `{name}`"), joint.place("name"));
                intake.tell(
                    twice.note(first.place("name"), "the first one").help("give each joint its own name"),
                );
            }
            if let Some(first) = carried.insert(child.clone(), joint) {
                let twice = not_a_tree(format!("the link `{child}` hangs on two joints"), joint.span);
                intake.tell(
                    twice
                        .note(first.span, "the first one")
                        .help("a robot is a tree: cut the loop at one joint"),
                );
                continue;
            }
            graph.joints.push((joint, parent, child));
        }
        (!intake.sink.has_errors()).then_some(graph)
    }

    /// The link at one end of a joint.
    fn end(&self, joint: &Element, end: &str, intake: &mut Intake) -> Option<String> {
        let Some(element) = joint.child(end) else {
            let name = joint.text("name").unwrap_or_default();
            intake.tell(
                value(format!("joint `{name}` has no <{end}>"), joint.span)
                    .help(format!("add <{end} link=\"...\"/>")),
            );
            return None;
        };
        let link = intake.name(element, "link")?;
        if self.links.contains_key(&link) {
            return Some(link);
        }
        if intake.has_told_enough("E0412") {
            return None;
        }
        let near = self.links.keys().max_by(|a, b| strsim::jaro(a, &link).total_cmp(&strsim::jaro(b, &link)));
        let error = not_a_tree(format!("there is no link `{link}`"), element.place("link"));
        intake.tell(match near {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error.help("add the link"),
        });
        None
    }

    /// The only link without a parent.
    fn root(&self, robot: &Element, intake: &mut Intake) -> Option<&str> {
        let hangs = |name: &str| self.joints.iter().any(|(_, _, child)| child == name);
        let roots: Vec<(&String, &&Element)> = self.links.iter().filter(|(name, _)| !hangs(name)).collect();
        match roots.as_slice() {
            [(name, _)] => return Some(name),
            [] if self.links.is_empty() => {
                intake.tell(
                    not_a_tree("the robot has no link".to_owned(), robot.span)
                        .help("a robot has links and joints"),
                );
            }
            [] => {
                let place = self.joints.first().map_or(robot.span, |(joint, ..)| joint.span);
                let help = "one link, the base, is not a child of any joint";
                intake.tell(not_a_tree("the joints form a circle".to_owned(), place).help(help));
            }
            [(first, place), (second, other), ..] => {
                let message =
                    format!("{} links hang on nothing, `{first}` and `{second}` among them", roots.len());
                let error = not_a_tree(message, place.span).note(other.span, "");
                intake.tell(error.help("a robot is one tree: join them by a joint, or take one out"));
            }
        }
        None
    }
}

/// A link without its joint.
fn part(link: &Element, from: &Path, intake: &mut Intake) -> Part {
    let name = link.text("name").unwrap_or_default();
    let mut body = massless(name);
    let inertial = link.child("inertial");
    let weight = match inertial {
        Some(inertial) => inertia(inertial, &mut body, intake),
        None => Weight::Absent,
    };
    let mut shapes = Shapes::default();
    for collision in link.all("collision") {
        shapes.colliding += 1;
        body.collisions.extend(shape(name, collision, from, intake));
    }
    let span =
        inertial.map_or(link.span, |inertial| inertial.child("mass").map_or(inertial.span, |mass| mass.span));
    Part { body, weight, parent: None, pose: Isometry3::identity(), hinge: None, span: Some(span), shapes }
}

fn inertia(inertial: &Element, body: &mut Body, intake: &mut Intake) -> Weight {
    let pose = origin(inertial, intake);
    let (Some(mass), Some(tensor)) = (inertial.child("mass"), inertial.child("inertia")) else {
        let missing = if inertial.child("mass").is_none() { "mass" } else { "inertia" };
        let message = format!("the inertial of `{}` has no <{missing}>", body.name);
        intake.tell(value(message, inertial.span).help("give mass and inertia, or no inertial at all"));
        return Weight::Absent;
    };
    body.mass = intake.needed(mass, "value").map_or(0.0, |[mass]| mass);
    let [xx, yy, zz] =
        ["ixx", "iyy", "izz"].map(|key| intake.needed(tensor, key).map_or(0.0, |[entry]| entry));
    let [xy, xz, yz] = ["ixy", "ixz", "iyz"].map(|key| intake.number(tensor, key).unwrap_or(0.0));
    let own = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let turn = pose.rotation.to_rotation_matrix().into_inner();
    body.com = Point3::from(pose.translation.vector);
    body.inertia = turn * own * turn.transpose();
    Weight::Given
}

fn shape(link: &str, collision: &Element, from: &Path, intake: &mut Intake) -> Option<Collision> {
    let mut pose = origin(collision, intake);
    let Some(element) = collision.child("geometry").and_then(|geometry| geometry.children.first()) else {
        intake.note(format!(
            "`{link}`: a collision without a shape is left out; give the body a box or capsules"
        ));
        return None;
    };
    let mut one = |key: &str| intake.needed(element, key).map(|[number]| number);
    let shape = match element.name.as_str() {
        "box" => Shape::Box(0.5 * Vector3::from(intake.needed::<3>(element, "size")?)),
        "capsule" => Shape::Capsule(0.5 * one("length")?, one("radius")?),
        "cylinder" => Shape::Cylinder(0.5 * one("length")?, one("radius")?),
        "sphere" => Shape::Sphere(one("radius")?),
        "mesh" => {
            let named = intake.name(element, "filename")?;
            let scale = intake.vector(element, "scale").unwrap_or([1.0; 3]);
            let block = intake.mesh(link, from, &named, element.place("filename"), scale)?;
            pose *= Translation3::from(block.centre);
            Shape::Box(block.half)
        }
        other => {
            intake.note(format!("`{link}`: the {other} is left out; give the body a box or capsules"));
            return None;
        }
    };
    let collision = Collision { shape, pose };
    if !positive(&collision.shape) {
        let message = format!("the {} of `{link}` has a length that is not positive", element.name);
        intake.tell(super::physical::impossible(message, element.span).help("lengths are positive"));
        return None;
    }
    Some(collision)
}

fn hinge(joint: &Element, intake: &mut Intake) -> Option<Hinge> {
    let name = joint.text("name").unwrap_or_default().to_owned();
    let kind = intake.name(joint, "type")?;
    let other = match kind.as_str() {
        "fixed" => return None,
        "revolute" | "continuous" => joint.child("mimic").map(|mimic| match mimic.text("joint") {
            Some(leader) => format!("driven by `{leader}`"),
            None => "driven by another joint".to_owned(),
        }),
        "prismatic" | "floating" | "planar" | "spherical" => Some(kind.clone()),
        _ => {
            let message = format!("joint `{name}` is of the unknown type `{kind}`");
            let help = "the types are revolute, continuous, fixed, prismatic, floating and planar";
            intake.tell(value(message, joint.place("type")).help(help));
            return None;
        }
    };
    let axis = joint.child("axis").map_or(Some([1.0, 0.0, 0.0]), |axis| intake.needed(axis, "xyz"))?;
    let direction = Unit::try_new(Vector3::from(axis), 1e-9);
    if direction.is_none() && other.is_none() {
        let place = joint.child("axis").map_or(joint.span, |axis| axis.place("xyz"));
        intake.tell(
            value(format!("the axis of joint `{name}` has no length"), place).help("write it as 0 1 0"),
        );
    }
    let mut hinge = Hinge { name, other, axis: direction, span: Some(joint.span), ..Hinge::default() };
    if let Some(limit) = joint.child("limit") {
        limits(limit, kind == "continuous", &mut hinge, intake);
    }
    if let Some(dynamics) = joint.child("dynamics") {
        // A missing attribute is zero in URDF; if the element is missing, the value is unknown.
        hinge.damping = Some(intake.number(dynamics, "damping").unwrap_or(0.0));
        hinge.friction = Some(intake.number(dynamics, "friction").unwrap_or(0.0));
    }
    Some(hinge)
}

/// Reads limits. In many files an effort or velocity of zero stands for unknown, and so does a range of two
/// zeros.
fn limits(limit: &Element, is_continuous: bool, hinge: &mut Hinge, intake: &mut Intake) {
    let range = [intake.number(limit, "lower"), intake.number(limit, "upper")];
    match range {
        [Some(0.0), Some(0.0)] if is_continuous => {}
        [Some(0.0), Some(0.0)] => hinge.zeros.push("range"),
        [lower, upper] if is_continuous => {
            let given = lower.is_some() || upper.is_some();
            // A missing attribute is zero in URDF.
            hinge.void_range = given.then(|| range.map(|limit| limit.unwrap_or(0.0)));
        }
        [lower, upper] => (hinge.lower, hinge.upper) = (lower, upper),
    }
    let mut given = |key: &'static str| {
        let value = intake.number(limit, key);
        hinge.zeros.extend(value.filter(|value| *value == 0.0).map(|_| key));
        value.filter(|value| *value != 0.0)
    };
    (hinge.effort_limit, hinge.velocity_limit) = (given("effort"), given("velocity"));
}
