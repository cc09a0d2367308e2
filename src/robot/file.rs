//! Robot files: the descriptor of `robots/NAME.toml` and the robot it describes, checked.
//!
//! Knows decoded tables, not TOML; [`super::checks`] judges the finished model.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

use super::checks::{self, Issue};
use super::examine;
use super::kinematics::rotation_about;
use super::model::{Body, Collision, Foot, Joint, Link, Robot, Shape};
use super::symmetry::{self, Unpaired};
use crate::quantity::Dimension;
use crate::spec::{Param, Section, Table, Ty, Value};

/// Three lengths.
static POINT: Ty = Ty::List(&Ty::Quantity(Dimension::LENGTH));

/// Three angles.
static ROTATION: Ty = Ty::List(&Ty::Quantity(Dimension::ANGLE));

/// Keys of an inertia.
static INERTIA: [Param; 6] = [
    Param::required("ixx", Ty::Quantity(Dimension::INERTIA)).doc("Moment about x."),
    Param::required("iyy", Ty::Quantity(Dimension::INERTIA)).doc("Moment about y."),
    Param::required("izz", Ty::Quantity(Dimension::INERTIA)).doc("Moment about z."),
    Param::required("ixy", Ty::Quantity(Dimension::INERTIA)).doc("Off-diagonal element of the tensor."),
    Param::required("ixz", Ty::Quantity(Dimension::INERTIA)).doc("Off-diagonal element of the tensor."),
    Param::required("iyz", Ty::Quantity(Dimension::INERTIA)).doc("Off-diagonal element of the tensor."),
];

/// Keys of a collision shape.
static COLLISION: [Param; 7] = [
    Param::required("shape", Ty::Choice(&["box", "capsule", "cylinder", "sphere"])).doc("The primitive."),
    Param::optional("half_extents", POINT).doc("Half extents of a box along the axes of the body."),
    Param::optional("centre", POINT).doc("Centre of a box or sphere in the body frame."),
    Param::optional("rotation", ROTATION)
        .doc("Orientation of a box in the body frame: roll, pitch, yaw about the fixed axes x, y, z; without it along the axes."),
    Param::optional("from", POINT)
        .doc("One end of the axis of a capsule (the centre of its half sphere) or cylinder (the centre of its face)."),
    Param::optional("to", POINT).doc("The other end of that axis."),
    Param::optional("radius", Ty::Quantity(Dimension::LENGTH))
        .doc("Radius of a capsule, cylinder or sphere.")
        .range(1e-6, 1e3),
];

static COLLISIONS: Ty = Ty::List(&Ty::Table(&COLLISION));

/// Keys of the base.
static BASE: [Param; 5] = [
    Param::required("name", Ty::Text).doc("Name of the body."),
    Param::required("mass", Ty::Quantity(Dimension::MASS)).doc("Mass."),
    Param::required("com", POINT).doc("Centre of mass in the body frame."),
    Param::required("inertia", Ty::Table(&INERTIA)).doc("Inertia about the centre of mass, axes of the body frame."),
    Param::optional("collisions", COLLISIONS).doc("Collision shapes other than the soles, which `feet` gives."),
];

/// Keys of a joint.
static JOINT: [Param; 15] = [
    Param::required("name", Ty::Text).doc("Name of the joint."),
    Param::required("origin", POINT).doc("Place of the joint in the parent's frame."),
    Param::optional("rotation", ROTATION)
        .doc("Orientation of the joint in the parent's frame: roll, pitch, yaw about the fixed axes x, y, z."),
    Param::required("axis", Ty::List(&Ty::Number)).doc("Axis of rotation in the joint frame."),
    Param::required("lower", Ty::Quantity(Dimension::ANGLE)).doc("Lower position limit."),
    Param::required("upper", Ty::Quantity(Dimension::ANGLE)).doc("Upper position limit."),
    Param::optional("effort_limit", Ty::Quantity(Dimension::TORQUE))
        .doc("Largest torque of the drive (E0403 without)."),
    Param::required("velocity_limit", Ty::Quantity(Dimension::ANGULAR_VELOCITY))
        .doc("Speed limit of the motor; enforced only where a spec asks for it."),
    Param::required("damping", Ty::Quantity(Dimension::DAMPING)).doc("Viscous damping."),
    Param::required("friction", Ty::Quantity(Dimension::TORQUE)).doc("Coulomb friction."),
    Param::required("armature", Ty::Quantity(Dimension::INERTIA)).doc("Reflected inertia of the rotor."),
    Param::required("stiffness_gain", Ty::Quantity(Dimension::STIFFNESS))
        .doc("Proportional gain of position control at 100 % stiffness."),
    Param::required("damping_gain", Ty::Quantity(Dimension::DAMPING))
        .doc("Derivative gain of position control at 100 % stiffness."),
    Param::required("default_position", Ty::Quantity(Dimension::ANGLE))
        .doc("Position in the default, knee-bent standing pose."),
    Param::optional("mirror", Ty::Text).doc(
        "The joint on the other side, with a minus when its coordinate changes sign; found without it, and checked.",
    ),
];

/// Keys of a link.
static LINK: [Param; 7] = [
    Param::required("name", Ty::Text).doc("Name of the link."),
    Param::required("parent", Ty::Text).doc("Name of the link or base that carries it."),
    BASE[1],
    BASE[2],
    BASE[3],
    BASE[4],
    Param::required("joint", Ty::Table(&JOINT)).doc("The joint between parent and link."),
];

/// Keys of a foot.
static FOOT: [Param; 4] = [
    Param::required("link", Ty::Text).doc("Name of the foot's link."),
    Param::required("half_extents", POINT).doc("Half extents of the sole's box along the axes of the link."),
    Param::required("centre", POINT).doc("Centre of the sole's box in the link frame; its lower face is the sole."),
    Param::default("friction", Ty::Number, "1.0")
        .range(0.0, 10.0)
        .doc("Grip of the sole: factor on `terrain.friction` under this foot."),
];

static FEET: [Param; 2] = [
    Param::required("left", Ty::Table(&FOOT)).doc("The left foot."),
    Param::required("right", Ty::Table(&FOOT)).doc("The right foot."),
];

/// The keys of a robot file.
pub static PARAMS: &[Param] = &[
    Param::required("name", Ty::Text).doc("The robot's name, that of its file."),
    Param::optional("summary", Ty::Text).doc("One line on what it is."),
    Param::optional("source", Ty::Text).doc("Where the figures come from."),
    Param::optional("licence", Ty::Text).doc("Under which terms."),
    Param::optional("total_mass", Ty::Quantity(Dimension::MASS)).doc("Checked against the sum of the masses."),
    Param::required("base", Ty::Table(&BASE)).doc("The floating base."),
    Param::required("links", Ty::List(&Ty::Table(&LINK)))
        .doc("The moving links in joint order, the order of all joint vectors; a parent stands before its children."),
    Param::required("feet", Ty::Table(&FEET)).doc("Left and right foot."),
];

/// The robot that a decoded file describes, and everything that was found in it. There is no robot if its model is unsound
/// (E0403 to E0408); a sound one that cannot be used for other reasons, such as one that falls over, is there.
pub fn from_table(name: &str, table: &Table) -> (Option<Robot>, Vec<Issue>) {
    let mut issues = Vec::new();
    let robot = Reader { issues: &mut issues }.robot(name, Section::new(table));
    let Some(mut robot) = robot else { return (None, issues) };
    if let Some(stated) = Section::new(table).si_if("total_mass") {
        issues.extend(checks::total_mass(&robot, stated));
    }
    issues.extend(checks::model(&robot));
    match symmetry::mirror_map(&robot) {
        Ok(mirror) => {
            issues.extend(other_images(&robot, &mirror, Section::new(table)));
            robot.mirror = mirror;
        }
        // Feet that do not lie left and right are the cause of whatever else the sides do not have in common.
        Err(unpaired) => issues.push(examine::sides(&robot).unwrap_or_else(|| no_image(&robot, &unpaired))),
    }
    if !issues.is_empty() {
        return (None, issues);
    }
    robot.standing_height = symmetry::standing_height(&robot);
    let issues = examine::issues(examine::all(&robot));
    (Some(robot), issues)
}

/// A joint that has no image.
fn no_image(robot: &Robot, unpaired: &Unpaired) -> Issue {
    let joint = &unpaired.joint;
    let message = format!("joint `{joint}` has no mirror image on the other side");
    let rule =
        "the axes of the two sides must be reflections of each other in the x-z plane, to within 2 mm and 0.1 deg";
    let help = match &unpaired.nearest {
        Some(nearest) => format!("{rule}; {}", nearest.in_words()),
        None => rule.to_owned(),
    };
    Issue::model(joint_path(robot, joint), message, &help)
}

/// The joints whose image in the file is not the one that geometry gives (E0408).
fn other_images(robot: &Robot, mirror: &[(usize, f64)], file: Section) -> Vec<Issue> {
    let stated = tables(&file, "links").map(|link| link.section("joint").and_then(|joint| joint.text_if("mirror")));
    let wrong = stated.zip(mirror).enumerate().filter_map(|(index, (stated, image))| {
        let (stated, right) = (stated?, symmetry::written(robot, *image));
        (stated.trim_start_matches('+') != right).then(|| Issue {
            code: "E0408",
            path: format!("links.{index}.joint.mirror"),
            message: format!("`{stated}` is not the mirror image of joint `{}`", robot.links[index].joint.name),
            help: format!("write `mirror = \"{right}\"`, or leave it out"),
        })
    });
    wrong.collect()
}

fn joint_path(robot: &Robot, joint: &str) -> String {
    let index = robot.links.iter().position(|link| link.joint.name == joint).unwrap_or(0);
    format!("links.{index}.joint")
}

/// Reads the tables and collects what is wrong.
struct Reader<'a> {
    issues: &'a mut Vec<Issue>,
}

impl Reader<'_> {
    fn robot(&mut self, name: &str, file: Section) -> Option<Robot> {
        let base_section = file.section("base")?;
        let base = self.body("base", base_section)?;
        let mut indices = BTreeMap::from([(base.name.clone(), None)]);
        let mut links = Vec::new();
        let mut complete = true;
        if let Some(issue) = checks::size(tables(&file, "links").count()) {
            self.issues.push(issue);
            return None;
        }
        for (index, section) in tables(&file, "links").enumerate() {
            let path = format!("links.{index}");
            let link = self.link(&path, section, &indices);
            if let Some(link_name) = section.text_if("name")
                && indices.insert(link_name.to_owned(), Some(index)).is_some()
            {
                self.issues.push(Issue::model(
                    format!("{path}.name"),
                    format!("two bodies are called `{link_name}`"),
                    "give each body its own name",
                ));
                complete = false;
            }
            match link {
                Some(link) => links.push(link),
                None => complete = false,
            }
        }
        let feet = file.section("feet")?;
        let left = self.foot("feet.left", feet.section("left")?, &indices);
        let right = self.foot("feet.right", feet.section("right")?, &indices);
        let feet = [left?, right?];
        let name = name.to_owned();
        complete.then_some(Robot { name, base, links, feet, mirror: Vec::new(), standing_height: 0.0 })
    }

    fn body(&mut self, path: &str, section: Section) -> Option<Body> {
        let com = self.triple(path, "com", section)?;
        let inertia = section.section("inertia")?;
        let shapes = tables(&section, "collisions").enumerate();
        let collisions =
            shapes.filter_map(|(index, shape)| self.collision(&format!("{path}.collisions.{index}"), shape)).collect();
        Some(Body {
            name: section.text("name").to_owned(),
            mass: section.si("mass"),
            com: Point3::from(com),
            inertia: tensor(inertia),
            collisions,
        })
    }

    fn link(&mut self, path: &str, section: Section, known: &BTreeMap<String, Option<usize>>) -> Option<Link> {
        let body = self.body(path, section);
        let joint = self.joint(&format!("{path}.joint"), section.section("joint")?);
        let parent = self.known(&format!("{path}.parent"), section.text("parent"), known);
        Some(Link { body: body?, parent: parent?, joint: joint? })
    }

    fn joint(&mut self, path: &str, section: Section) -> Option<Joint> {
        let name = section.text("name").to_owned();
        let origin = self.triple(path, "origin", section)?;
        let axis = self.triple(path, "axis", section)?;
        let Some(axis) = Unit::try_new(axis, 1e-6) else {
            self.issues.push(Issue::model(
                format!("{path}.axis"),
                format!("the axis of joint `{name}` has no length"),
                "write it as a direction such as [0.0, 1.0, 0.0]",
            ));
            return None;
        };
        let rotation = self.rotation(path, section)?;
        let Some(effort_limit) = section.si_if("effort_limit") else {
            self.issues.push(Issue {
                code: "E0403",
                path: path.to_owned(),
                message: format!("joint `{name}` has no effort limit"),
                help: "add `effort_limit = \"100 N*m\"`; torque actions are scaled by it".to_owned(),
            });
            return None;
        };
        Some(Joint {
            name,
            origin: Isometry3::from_parts(Translation3::from(origin), rotation),
            axis,
            lower: section.si("lower"),
            upper: section.si("upper"),
            effort_limit,
            velocity_limit: section.si("velocity_limit"),
            damping: section.si("damping"),
            friction: section.si("friction"),
            armature: section.si("armature"),
            stiffness_gain: section.si("stiffness_gain"),
            damping_gain: section.si("damping_gain"),
            default_position: section.si("default_position"),
        })
    }

    fn foot(&mut self, path: &str, section: Section, known: &BTreeMap<String, Option<usize>>) -> Option<Foot> {
        let half_extents = self.triple(path, "half_extents", section)?;
        let centre = Point3::from(self.triple(path, "centre", section)?);
        let link = self.known(&format!("{path}.link"), section.text("link"), known)?;
        let Some(link) = link else {
            self.issues.push(Issue::model(
                format!("{path}.link"),
                "the base cannot be a foot".to_owned(),
                "name a moving link",
            ));
            return None;
        };
        let friction = section.si("friction");
        Some(Foot { link, half_extents, centre, friction })
    }

    /// Looks a body up among those written so far: `None` inside is the base.
    fn known(&mut self, path: &str, name: &str, known: &BTreeMap<String, Option<usize>>) -> Option<Option<usize>> {
        let found = known.get(name).copied();
        if found.is_none() {
            let near = known.keys().max_by(|a, b| strsim::jaro(a, name).total_cmp(&strsim::jaro(b, name)));
            self.issues.push(Issue {
                code: "E0404",
                path: path.to_owned(),
                message: format!("there is no body `{name}` before this one"),
                help: match near {
                    Some(near) => format!("did you mean `{near}`? A parent stands before its children"),
                    None => "a parent stands before its children".to_owned(),
                },
            });
        }
        found
    }

    fn collision(&mut self, path: &str, section: Section) -> Option<Collision> {
        let centre = |reader: &mut Self| reader.triple(path, "centre", section);
        match section.text("shape") {
            "box" => {
                let half = self.triple(path, "half_extents", section)?;
                let centre = Translation3::from(centre(self)?);
                let turn = self.rotation(path, section)?;
                Some(Collision { shape: Shape::Box(half), pose: Isometry3::from_parts(centre, turn) })
            }
            "sphere" => {
                let shape = Shape::Sphere(self.radius(path, section)?);
                Some(Collision { shape, pose: Translation3::from(centre(self)?).into() })
            }
            kind => {
                let (from, to) = (self.triple(path, "from", section)?, self.triple(path, "to", section)?);
                let radius = self.radius(path, section)?;
                let half = 0.5 * (to - from).norm();
                if kind == "capsule" {
                    return Some(Collision { shape: Shape::Capsule(half, radius), pose: between(&from, &to) });
                }
                if half <= 0.0 {
                    let help = "`from` and `to` are the centres of its two faces";
                    self.issues.push(Issue::model(path, "this cylinder has no length", help));
                    return None;
                }
                Some(Collision { shape: Shape::Cylinder(half, radius), pose: between(&from, &to) })
            }
        }
    }

    /// Roll, pitch and yaw of a table; without them no rotation.
    fn rotation(&mut self, path: &str, section: Section) -> Option<UnitQuaternion<f64>> {
        let angles = if section.has("rotation") { self.triple(path, "rotation", section)? } else { Vector3::zeros() };
        Some(orientation(&angles))
    }

    fn radius(&mut self, path: &str, section: Section) -> Option<f64> {
        let radius = section.si_if("radius");
        if radius.is_none() {
            self.missing(path, "radius");
        }
        radius
    }

    fn triple(&mut self, path: &str, key: &str, section: Section) -> Option<Vector3<f64>> {
        if !section.has(key) {
            self.missing(path, key);
            return None;
        }
        let numbers = section.numbers(key);
        if numbers.len() != 3 {
            self.issues.push(Issue::model(
                format!("{path}.{key}"),
                format!("`{key}` needs three numbers, found {}", numbers.len()),
                "write x, y and z",
            ));
            return None;
        }
        Some(Vector3::new(numbers[0], numbers[1], numbers[2]))
    }

    fn missing(&mut self, path: &str, key: &str) {
        self.issues.push(Issue::model(
            path.to_owned(),
            format!("this collision shape needs `{key}`"),
            "a box has half_extents and centre, a sphere centre and radius, a capsule or cylinder from, to and radius",
        ));
    }
}

/// The tables of a list.
fn tables<'a>(section: &Section<'a>, key: &str) -> impl Iterator<Item = Section<'a>> + use<'a> {
    let items = match section.get(key) {
        Some(Value::List(items)) => items.as_slice(),
        _ => &[],
    };
    items.iter().filter_map(|item| if let Value::Table(table) = item { Some(Section::new(table)) } else { None })
}

/// The symmetric matrix of an inertia table.
fn tensor(inertia: Section) -> Matrix3<f64> {
    let [xx, yy, zz, xy, xz, yz] = ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"].map(|key| inertia.si(key));
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// Roll, pitch, yaw about fixed axes, as in URDF.
fn orientation(angles: &Vector3<f64>) -> UnitQuaternion<f64> {
    rotation_about(&Vector3::z(), angles.z)
        * rotation_about(&Vector3::y(), angles.y)
        * rotation_about(&Vector3::x(), angles.x)
}

/// The pose in the middle of two points whose z axis points from the first to the second.
pub(super) fn between(from: &Vector3<f64>, to: &Vector3<f64>) -> Isometry3<f64> {
    let direction = Unit::try_new(to - from, 1e-9).unwrap_or_else(Vector3::z_axis);
    let turn = UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), &direction)
        .unwrap_or_else(|| rotation_about(&Vector3::x(), std::f64::consts::PI));
    Isometry3::from_parts(Translation3::from(0.5 * (from + to)), turn)
}
