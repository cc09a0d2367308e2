//! MJCF: bodies with their inertials, hinges, geoms, actuators and a key frame.
//!
//! Includes are expanded, defaults completed and angles converted to rad before anything else reads them.

mod defaults;
mod drives;
mod geoms;
mod include;
mod inertia;
mod left_out;
mod settings;
mod ties;

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, Vector3};

use super::intake::{Intake, not_a_tree, value};
use super::naming::some;
use super::tree::{Hinge, MOST_BODIES, Part, Shapes, Tree, Weight, massless};
use super::xml::{self, Element};
use crate::diag::{Diagnostic, Span};
use crate::robot::Body;
use crate::robot::kinematics::rotation_about;
use crate::spec::suggest::listed;
use defaults::Defaults;
use drives::Drives;
use geoms::{Geoms, Meshes};
use inertia::Open;
use settings::{FromGeoms, Settings};

/// Elements that generate bodies which are not in the file.
const MACROS: &[&str] = &["replicate", "composite", "flexcomp", "attach"];

/// The tree of an MJCF file.
pub(super) fn tree(root: Element, from: &Path, intake: &mut Intake) -> Option<Tree> {
    let root = include::expanded(root, from, intake)?;
    let settings = Settings::read(&root, from, intake);
    let defaults = Defaults::read(&root, intake);
    let drives = Drives::read(&root, &settings, &defaults, intake);
    let paired = left_out::paired(&root);
    let geoms = Geoms { settings: &settings, meshes: Meshes::read(&root, &defaults, intake), paired };
    let open = BTreeMap::new();
    let mut walk = Walk {
        settings: &settings,
        defaults: &defaults,
        drives: &drives,
        geoms: &geoms,
        open,
        floats: false,
        is_free: false,
        chains: Vec::new(),
        intake,
    };
    let mut bodies = Vec::new();
    for world in root.all("worldbody") {
        bodies.extend(
            walk.contents(world, Around::default())
                .into_iter()
                .filter(|inside| inside.element.name == "body"),
        );
    }
    let base = walk.base(&root, &bodies)?;
    let mut tree =
        Tree { name: root.text("model").unwrap_or_default().to_owned(), format: "MJCF", ..Tree::default() };
    let mut addresses = BTreeMap::new();
    let mut next = 0;
    let mut start = 0;
    for (index, body) in bodies.iter().enumerate() {
        start = if index == base { next } else { start };
        walk.number(body, &mut next, &mut addresses);
    }
    drives.measure(next, walk.intake);
    // Its pose in the world is part of a key frame, not of the robot, but defines the up direction.
    let stands = settings.pose(bodies[base].element, walk.intake);
    tree.upright = (bodies[base].around.frame * stands).rotation;
    walk.body(&bodies[base], None, &addresses, &mut tree);
    tree.ties = ties::read(&root);
    tree.key = drives.keys().map(|(key, _)| key.to_owned());
    tree.stance = if walk.is_free { drives.attitude(start, walk.intake) } else { None };
    names_are_unique(&tree, walk.intake);
    scale(&mut tree, &settings, walk.intake);
    settings::suspect(&root, &tree, &settings, walk.intake);
    inertia::settle(&mut tree, walk.floats, &walk.open, walk.intake);
    remarks(&walk.chains, &drives, walk.intake);
    let left_out = left_out::lines(&root, bodies[base].element, &defaults, &geoms);
    left_out.into_iter().for_each(|line| walk.intake.note(line));
    Some(tree)
}

/// The context of an element: the class of its body and the pose of its frame in that body.
#[derive(Clone, Copy, Debug)]
struct Around<'a> {
    class: Option<&'a str>,
    frame: Isometry3<f64>,
}

impl Default for Around<'_> {
    fn default() -> Self {
        Self { class: None, frame: Isometry3::identity() }
    }
}

/// An element of a body with its context.
#[derive(Clone, Copy, Debug)]
struct Inside<'a> {
    element: &'a Element,
    around: Around<'a>,
}

struct Walk<'a, 'b, 'c> {
    settings: &'a Settings,
    defaults: &'a Defaults,
    drives: &'a Drives,
    geoms: &'a Geoms<'a>,
    /// Properties of joints that depend on the masses, by name.
    open: BTreeMap<String, Open>,
    /// Whether the base is free to move in the file.
    floats: bool,
    /// Whether it has a free joint.
    is_free: bool,
    /// Names of bodies with several joints.
    chains: Vec<String>,
    intake: &'b mut Intake<'c>,
}

impl Walk<'_, '_, '_> {
    /// The elements of a body, including those in its frames.
    fn contents<'e>(&mut self, body: &'e Element, around: Around<'e>) -> Vec<Inside<'e>> {
        let mut contents = Vec::new();
        for element in &body.children {
            if element.name == "frame" {
                let frame = around.frame * self.settings.pose(element, self.intake);
                let class = element.text("childclass").or(around.class);
                contents.extend(self.contents(element, Around { class, frame }));
            } else if MACROS.contains(&element.name.as_str()) {
                let message = format!("<{}> makes bodies that are not in the file", element.name);
                let help =
                    "let MuJoCo write the file out in full: mj_saveLastXML, or `Save xml` in its viewer";
                self.intake.tell(Diagnostic::error("E0413", message).at(element.span, "").help(help));
            } else {
                contents.push(Inside { element, around });
            }
        }
        contents
    }

    /// The elements inside a body.
    fn inside<'e>(&mut self, body: &Inside<'e>) -> Vec<Inside<'e>> {
        let class = body.element.text("childclass").or(body.around.class);
        self.contents(body.element, Around { class, frame: Isometry3::identity() })
    }

    /// The joints of a body with all attributes of their class, and the places of its free joints.
    fn joints(&mut self, inside: &[Inside]) -> (Vec<(Element, Isometry3<f64>)>, Vec<Span>) {
        let mut free = Vec::new();
        let mut joints = Vec::new();
        for Inside { element, around } in inside {
            match element.name.as_str() {
                "freejoint" => free.push(element.span),
                "joint" => {
                    let joint = self.defaults.complete(element, around.class, self.intake);
                    if joint.text("type") == Some("free") {
                        free.push(element.span)
                    } else {
                        joints.push((joint, around.frame))
                    }
                }
                _ => {}
            }
        }
        (joints, free)
    }

    /// Reports free joints that MuJoCo does not allow: below the base, or next to other joints.
    fn refuse_free(&mut self, name: &str, free: &[Span], others: usize, is_base: bool) {
        let (message, place) = match free {
            [] => return,
            [place, ..] if !is_base => {
                (format!("`{name}` has a free joint and hangs on another body: only the base floats"), place)
            }
            [_, second, ..] => {
                (format!("`{name}` has {} free joints, and a body floats once", free.len()), second)
            }
            [place] if others > 0 => (format!("`{name}` has a free joint and other joints beside it"), place),
            [_] => return,
        };
        let help = "leave one free joint, that of the robot's base; what floats beside the robot is a \
         body of its own in <worldbody>";
        self.intake.tell(not_a_tree(message, *place).help(help));
    }

    /// Which body of the world is the robot's base.
    fn base(&mut self, root: &Element, bodies: &[Inside]) -> Option<usize> {
        let mut floating = Vec::new();
        for (index, body) in bodies.iter().enumerate() {
            let inside = self.inside(body);
            if !self.joints(&inside).1.is_empty() {
                floating.push(index);
            }
        }
        if floating.is_empty() {
            // Objects in the environment have no joints below them.
            floating.extend((0..bodies.len()).filter(|index| carries_joints(bodies[*index].element)));
            floating = if floating.len() == 1 { floating } else { Vec::new() };
        }
        let place = |index: usize| bodies[index].element.span;
        let error = match (floating.as_slice(), bodies) {
            ([base], _) => return Some(*base),
            ([], [_]) => return Some(0),
            ([], []) => not_a_tree("there is no body in the world".to_owned(), root.span)
                .help("a robot is a body of <worldbody>"),
            ([], _) => not_a_tree(
                "the base is not clear: no body of the world has a free joint".to_owned(),
                place(1),
            )
            .help("give the robot's base a <freejoint/>, or take the other bodies out"),
            ([first, second, ..], _) => not_a_tree(
                "the base is not clear: several bodies of the world have free joints".to_owned(),
                place(*second),
            )
            .note(place(*first), "the first one")
            .help("take the bodies that are not the robot out"),
        };
        self.intake.tell(error);
        None
    }

    /// Assigns positions of a key frame: the index of every named joint, in the order of the file.
    fn number(&mut self, body: &Inside, next: &mut usize, addresses: &mut BTreeMap<String, usize>) {
        let inside = self.inside(body);
        for Inside { element, around } in &inside {
            let joint = match element.name.as_str() {
                "joint" => self.defaults.complete(element, around.class, self.intake),
                "freejoint" => (*element).clone(),
                _ => continue,
            };
            if let Some(name) = joint.text("name") {
                addresses.insert(name.to_owned(), *next);
            }
            *next += match (element.name.as_str(), joint.text("type")) {
                ("freejoint", _) | (_, Some("free")) => 7,
                (_, Some("ball")) => 4,
                _ => 1,
            };
        }
        for inner in inside.iter().filter(|inner| inner.element.name == "body") {
            self.number(inner, next, addresses);
        }
    }

    /// Adds a body and its subtree.
    fn body(
        &mut self,
        body: &Inside,
        parent: Option<usize>,
        addresses: &BTreeMap<String, usize>,
        tree: &mut Tree,
    ) {
        let element = body.element;
        if tree.parts.len() > MOST_BODIES {
            if self.intake.sink.diagnostics.iter().all(|told| told.code != "E0415") {
                let message =
                    format!("the robot has more than the {MOST_BODIES} bodies that a robot may have");
                self.intake.tell(xml::too_large(message).at(element.span, ""));
            }
            return;
        }
        let name = match element.attribute("name") {
            Some(_) => self.intake.name(element, "name").unwrap_or_default(),
            None => format!("body_{}", tree.parts.len()),
        };
        let inside = self.inside(body);
        let (joints, free) = self.joints(&inside);
        self.refuse_free(&name, &free, joints.len(), parent.is_none());
        let floats = !free.is_empty();
        // The pose of the base in the world is part of a key frame, not of the robot.
        let mut pose = match parent {
            Some(_) => body.around.frame * self.settings.pose(element, self.intake),
            None => Isometry3::identity(),
        };
        let mut parent = parent;
        let mut last = None;
        let first = tree.parts.len();
        if parent.is_none() {
            self.floats = floats || !joints.is_empty();
            self.is_free = floats;
            if !self.floats {
                self.intake.note(format!(
                    "`{name}` is fixed to the world in the file (no freejoint): the base of a robot floats"
                ));
            }
        }
        if parent.is_none() && !floats {
            for (joint, _) in &joints {
                let joint = joint.text("name").unwrap_or("without a name");
                self.intake
                    .note(format!("the joint {joint} of the base is left out: the base of a robot floats"));
            }
        } else {
            for (number, (joint, frame)) in joints.iter().enumerate() {
                // Unnamed joints are named after their body.
                let own = if number == 0 {
                    format!("{name}_joint")
                } else {
                    format!("{name}_joint_{}", number + 1)
                };
                let Some(mut hinge) = self.hinge(joint, own, addresses) else { continue };
                hinge.anchor = (frame * Point3::from(hinge.anchor)).coords;
                hinge.axis = hinge.axis.map(|axis| frame.rotation * axis);
                if let Some((hinge, pose)) = last.replace(self.at_zero(joint, hinge, pose)) {
                    // Several joints of one body become a chain of massless frames.
                    let chained = format!("{name}_{}", hinge.name);
                    tree.parts.push(Part {
                        parent,
                        pose,
                        hinge: Some(hinge),
                        ..between(&chained, element.span)
                    });
                    self.chains.push(name.clone());
                    parent = Some(tree.parts.len() - 1);
                }
                pose = Isometry3::identity();
            }
        }
        let (hinge, pose) = last.map_or((None, pose), |(hinge, pose)| (Some(hinge), pose));
        let mut part = self.figures(&name, element, &inside);
        (part.parent, part.pose, part.hinge) = (parent, pose, hinge);
        share(&mut tree.parts[first..], &mut part);
        tree.parts.push(part);
        let index = tree.parts.len() - 1;
        for inner in inside.iter().filter(|inner| inner.element.name == "body") {
            self.body(inner, Some(index), addresses, tree);
        }
    }

    /// The pose of a body with its joint at zero; the file gives it at the joint's `ref`.
    fn at_zero(&mut self, joint: &Element, hinge: Hinge, pose: Isometry3<f64>) -> (Hinge, Isometry3<f64>) {
        let reference = self.intake.number(joint, "ref").unwrap_or(0.0);
        let Some(axis) = hinge.axis.filter(|_| reference != 0.0) else { return (hinge, pose) };
        let (reference, back): (f64, Isometry3<f64>) = match joint.text("type").unwrap_or("hinge") {
            "hinge" => {
                let angle = self.settings.angle * reference;
                let anchor = Translation3::from(hinge.anchor);
                (angle, anchor * rotation_about(&axis, -angle) * anchor.inverse())
            }
            "slide" => (reference, Translation3::from(axis.into_inner() * -reference).into()),
            _ => return (hinge, pose),
        };
        self.open.entry(hinge.name.clone()).or_default().reference = reference;
        (hinge, pose * back)
    }

    /// A body with its mass, centre of mass, inertia and shapes, and their places.
    fn figures(&mut self, name: &str, element: &Element, inside: &[Inside]) -> Part {
        let mut body = massless(name);
        let mut shapes = Shapes::default();
        let mut geoms = Vec::new();
        for Inside { element, around } in inside.iter().filter(|inside| inside.element.name == "geom") {
            let geom = self.defaults.complete(element, around.class, self.intake);
            geoms.push((geom, around.frame));
        }
        for (geom, frame) in &geoms {
            let collides = self.geoms.collides(geom);
            *if collides { &mut shapes.colliding } else { &mut shapes.idle } += 1;
            if let Some(mut collision) = self.geoms.collision(name, geom, self.intake) {
                collision.pose = frame * collision.pose;
                body.collisions.push(collision);
            }
        }
        let inertial = element.child("inertial");
        let mut weight = match (self.settings.from_geoms, inertial) {
            (FromGeoms::Always, _) | (FromGeoms::Missing, None) => {
                self.geoms.weigh(&mut body, &geoms, self.intake)
            }
            _ => Weight::Absent,
        };
        // Massless geoms do not replace the inertial, even if masses come from geoms.
        if let (Weight::Absent, Some(inertial)) = (weight, inertial) {
            weight = self.inertial(inertial, &mut body);
        }
        let [mass, moment] = self.settings.least;
        if weight == Weight::Absent && mass > 0.0 {
            weight = Weight::Given;
        }
        if weight == Weight::Given {
            body.mass = body.mass.max(mass);
            bounded(&mut body, moment, self.settings.balance);
        }
        let span = inertial.map_or(element.span, |inertial| inertial.span);
        Part {
            body,
            weight,
            parent: None,
            pose: Isometry3::identity(),
            hinge: None,
            span: Some(span),
            shapes,
        }
    }

    fn inertial(&mut self, inertial: &Element, body: &mut Body) -> Weight {
        let pose = self.settings.pose(inertial, self.intake);
        body.mass = self.intake.needed(inertial, "mass").map_or(0.0, |[mass]| mass);
        let own = if inertial.attribute("fullinertia").is_some() {
            let [xx, yy, zz, xy, xz, yz] = self.intake.vector(inertial, "fullinertia").unwrap_or_default();
            Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
        } else {
            Matrix3::from_diagonal(&Vector3::from(
                self.intake.needed(inertial, "diaginertia").unwrap_or_default(),
            ))
        };
        let turn = pose.rotation.to_rotation_matrix().into_inner();
        body.com = Point3::from(pose.translation.vector);
        body.inertia = turn * own * turn.transpose();
        Weight::Given
    }

    fn hinge(&mut self, joint: &Element, own: String, addresses: &BTreeMap<String, usize>) -> Option<Hinge> {
        let name = match joint.attribute("name") {
            Some(_) => self.intake.name(joint, "name")?,
            None => own,
        };
        let other = match joint.text("type").unwrap_or("hinge") {
            "hinge" => None,
            kind @ ("slide" | "ball") => Some(format!("a {kind} joint")),
            kind => {
                let error =
                    value(format!("joint `{name}` is of the unknown type `{kind}`"), joint.place("type"));
                self.intake.tell(error.help("the types are hinge, slide, ball and free"));
                return None;
            }
        };
        let (settings, intake) = (self.settings, &mut *self.intake);
        let axis =
            Unit::try_new(Vector3::from(intake.vector(joint, "axis").unwrap_or([0.0, 0.0, 1.0])), 1e-14);
        if axis.is_none() && other.is_none() {
            intake.tell(
                value(format!("the axis of joint `{name}` has no length"), joint.place("axis"))
                    .help("write it as 0 1 0"),
            );
        }
        let range = drives::limits("range", "limited", joint, settings, intake);
        let is_hinge = other.is_none();
        let angle = if joint.text("type") == Some("slide") { 1.0 } else { settings.angle };
        let given: Option<[f64; 2]> = intake.vector(joint, "range");
        let void_range = given
            .filter(|given| range.is_none() && given[0] < given[1])
            .map(|given| given.map(|end| angle * end));
        let own = drives::bound("actuatorfrcrange", "actuatorfrclimited", joint, settings, intake);
        let mut zero = |key: &str| {
            // Newer files may have a polynomial in the speed; a robot file only uses its first coefficient.
            let numbers = intake.numbers(joint, key).unwrap_or_default();
            if numbers.iter().skip(1).any(|number| *number != 0.0) {
                intake.note(format!("joint `{name}`: of its {key} only the linear part is taken"));
            }
            numbers.first().copied().unwrap_or(0.0)
        };
        let mut hinge = Hinge {
            other,
            anchor: Vector3::zeros(),
            axis,
            lower: range.map(|range| range[0] * angle),
            upper: range.map(|range| range[1] * angle),
            void_range: void_range.filter(|_| is_hinge),
            damping: Some(zero("damping")),
            friction: Some(zero("frictionloss")),
            armature: Some(zero("armature")),
            span: Some(joint.span),
            name,
            ..Hinge::default()
        };
        hinge.anchor = Vector3::from(intake.vector(joint, "pos").unwrap_or_default());
        let address = addresses.get(&hinge.name).copied().unwrap_or(usize::MAX);
        let before = hinge.damping.unwrap_or(0.0);
        let servos = self.drives.equip(&mut hinge, address, own, intake);
        let stiffness = intake.numbers(joint, "stiffness").unwrap_or_default();
        if hinge.passive && stiffness.iter().any(|number| *number > 0.0) {
            hinge.rest = intake.number(joint, "springref").map(|rest| angle * rest);
        }
        let passive = hinge.damping.unwrap_or(0.0) - before;
        // A time constant or ratio of zero means no spring.
        let spring = intake
            .vector(joint, "springdamper")
            .filter(|spring: &[f64; 2]| spring.iter().all(|part| *part > 0.0));
        self.open.insert(hinge.name.clone(), Open { reference: 0.0, spring, passive, servos });
        Some(hinge)
    }
}

/// Share of a body's mass and inertia that each frame between its joints gets: bodies of a robot need some of
/// both, and the total is unchanged.
const BETWEEN: f64 = 1e-6;

/// Gives the frames between the joints of a body their share of it.
fn share(frames: &mut [Part], whole: &mut Part) {
    if whole.weight != Weight::Given || whole.body.mass <= 0.0 {
        return;
    }
    let (mass, inertia) = (whole.body.mass * BETWEEN, whole.body.inertia * BETWEEN);
    for frame in frames.iter_mut() {
        (frame.body.mass, frame.body.com, frame.body.inertia) = (mass, whole.body.com, inertia);
        frame.weight = Weight::Given;
        whole.body.mass -= mass;
        whole.body.inertia -= inertia;
    }
}

/// A body that is a frame between two joints.
fn between(name: &str, span: Span) -> Part {
    Part {
        body: massless(name),
        weight: Weight::Absent,
        parent: None,
        pose: Isometry3::identity(),
        hinge: None,
        span: Some(span),
        shapes: Shapes::default(),
    }
}

fn names_are_unique(tree: &Tree, intake: &mut Intake) {
    let mut known = BTreeMap::new();
    let bodies = tree.parts.iter().map(|part| ("bodies", &part.body.name, part.span));
    let joints = tree.parts.iter().filter_map(|part| part.hinge.as_ref());
    for (what, name, span) in bodies.chain(joints.map(|hinge| ("joints", &hinge.name, hinge.span))) {
        if let (Some(_), Some(span)) = (known.insert((what, name), span), span) {
            intake.tell(
                not_a_tree(format!("two {what} are called `{name}`"), span).help("give each its own name"),
            );
        }
    }
}

/// Scales all masses to the total that the file specifies.
fn scale(tree: &mut Tree, settings: &Settings, intake: &mut Intake) {
    if settings.total_mass <= 0.0 {
        return;
    }
    if tree.parts.iter().any(|part| part.weight == Weight::Unknown) {
        intake.note("settotalmass is left out, because not all masses are known".to_owned());
        return;
    }
    let factor = settings.total_mass / tree.parts.iter().map(|part| part.body.mass).sum::<f64>();
    for body in tree.parts.iter_mut().map(|part| &mut part.body).filter(|_| factor.is_finite()) {
        body.mass *= factor;
        body.inertia *= factor;
    }
}

/// Whether a body has a joint below it.
fn carries_joints(body: &Element) -> bool {
    let below = |inner: &Element| {
        inner.children.iter().any(|element| element.name == "joint") || carries_joints(inner)
    };
    body.children.iter().any(|inner| matches!(inner.name.as_str(), "body" | "frame") && below(inner))
}

/// Raises principal moments to a minimum and, if `balance`, replaces impossible ones by a sphere's.
fn bounded(body: &mut Body, least: f64, balance: bool) {
    let mut own = body.inertia.symmetric_eigen();
    own.eigenvalues.apply(|moment| *moment = moment.max(least));
    let [low, middle, high] = {
        let mut sorted: [f64; 3] = own.eigenvalues.into();
        sorted.sort_by(f64::total_cmp);
        sorted
    };
    let impossible = balance && high > low + middle;
    if impossible {
        own.eigenvalues.fill((low + middle + high) / 3.0);
    }
    if impossible || least > 0.0 {
        body.inertia = own.recompose();
    }
}

/// Remarks on values from other elements, and on bodies with several joints.
fn remarks(chains: &[String], drives: &Drives, intake: &mut Intake) {
    if let Some((key, others)) = drives.keys() {
        let more = if others.is_empty() {
            String::new()
        } else {
            format!("; --key takes {} instead", listed(others.iter().map(String::as_str)))
        };
        intake.note(format!("default positions are those of the key frame `{key}`{more}"));
    }
    let mut names: Vec<&str> = chains.iter().map(String::as_str).collect();
    names.dedup();
    if !names.is_empty() {
        intake.note(format!(
            "{} have several joints, of which each became a body of its own: those between have {:.0} % of \
             the mass and inertia each, \
             taken from the body, so that the sum is the file's",
            some(&names),
            100.0 * BETWEEN
        ));
    }
}
