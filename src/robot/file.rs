//! Robot files: the descriptor of `robots/NAME.toml` and the robot it describes, checked.
//!
//! Works on decoded tables, not TOML; [`super::checks`] checks the finished model.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

use super::checks::{self, Issue};
use super::examine;
use super::kinematics::rotation_about;
use super::model::{Body, Collision, Foot, Joint, Link, Robot, Shape};
use super::symmetry::{self, Unpaired};
use crate::spec::typed::prelude::*;
use crate::spec::{Param, Table};

/// Three lengths: x, y and z.
type Point = Vec<Quantified<Metre>>;
/// Three angles: roll, pitch and yaw.
type Angles = Vec<Quantified<Radian>>;

keys! {
    /// An inertia tensor.
    pub struct Inertia {
        /// Moment about x.
        ixx: Quantified<KilogramSquareMetre>,
        /// Moment about y.
        iyy: Quantified<KilogramSquareMetre>,
        /// Moment about z.
        izz: Quantified<KilogramSquareMetre>,
        /// Off-diagonal element of the tensor.
        ixy: Quantified<KilogramSquareMetre>,
        /// Off-diagonal element of the tensor.
        ixz: Quantified<KilogramSquareMetre>,
        /// Off-diagonal element of the tensor.
        iyz: Quantified<KilogramSquareMetre>,
    }
}

choice! {
    /// A primitive shape.
    pub enum Primitive {
        /// A box.
        Box = "box",
        /// A cylinder between two half spheres.
        Capsule = "capsule",
        /// A cylinder.
        Cylinder = "cylinder",
        /// A sphere.
        Sphere = "sphere",
    }
}

keys! {
    /// A collision shape.
    pub struct CollisionKeys {
        /// The primitive.
        shape: Primitive,
        /// Half extents of a box along the axes of the body.
        half_extents: Option<Point>,
        /// Centre of a box or sphere in the body frame.
        centre: Option<Point>,
        /// Orientation of a box in the body frame: roll, pitch, yaw about the fixed axes x, y, z; without it
        /// along the axes.
        rotation: Option<Angles>,
        /// One end of the axis of a capsule (the centre of its half sphere) or cylinder (the centre of its
        /// face).
        from: Option<Point>,
        /// The other end of that axis.
        to: Option<Point>,
        /// Radius of a capsule, cylinder or sphere.
        #[range(1e-6, 1e3)]
        radius: Option<Quantified<Metre>>,
    }
}

keys! {
    /// What every body has.
    pub struct BodyKeys {
        /// Mass.
        mass: Quantified<Kilogram>,
        /// Centre of mass in the body frame.
        com: Point,
        /// Inertia about the centre of mass, axes of the body frame.
        inertia: Inertia,
        /// Collision shapes other than the soles, which `feet` gives.
        collisions: Option<Vec<CollisionKeys>>,
    }
}

keys! {
    /// The base.
    pub struct Base {
        /// Name of the body.
        name: String,
        ..body: BodyKeys,
    }
}

keys! {
    /// A joint.
    pub struct JointKeys {
        /// Name of the joint.
        name: String,
        /// Place of the joint in the parent's frame.
        origin: Point,
        /// Orientation of the joint in the parent's frame: roll, pitch, yaw about the fixed axes x, y, z.
        rotation: Option<Angles>,
        /// Axis of rotation in the joint frame.
        axis: Vec<f64>,
        /// Lower position limit.
        lower: Quantified<Radian>,
        /// Upper position limit.
        upper: Quantified<Radian>,
        /// Largest torque of the drive (E0403 without).
        effort_limit: Option<Quantified<NewtonMetre>>,
        /// Speed limit of the motor; enforced only where a spec asks for it.
        velocity_limit: Quantified<RadianPerSecond>,
        /// Viscous damping.
        damping: Quantified<NewtonMetreSecondPerRadian>,
        /// Coulomb friction.
        friction: Quantified<NewtonMetre>,
        /// Reflected inertia of the rotor.
        armature: Quantified<KilogramSquareMetre>,
        /// Proportional gain of position control at 100 % stiffness.
        stiffness_gain: Quantified<NewtonMetrePerRadian>,
        /// Derivative gain of position control at 100 % stiffness.
        damping_gain: Quantified<NewtonMetreSecondPerRadian>,
        /// Position in the default, knee-bent standing pose.
        default_position: Quantified<Radian>,
        /// The joint on the other side, with a minus when its coordinate changes sign; found without it, and
        /// checked.
        mirror: Option<String>,
    }
}

keys! {
    /// Which link it is.
    pub struct LinkName {
        /// Name of the link.
        name: String,
        /// Name of the link or base that carries it.
        parent: String,
    }
}

keys! {
    /// A link.
    pub struct LinkKeys {
        + own: LinkName,
        + body: BodyKeys,
        /// The joint between parent and link.
        joint: JointKeys,
    }
}

keys! {
    /// A foot.
    pub struct FootKeys {
        /// Name of the foot's link.
        link: String,
        /// Half extents of the sole's box along the axes of the link.
        half_extents: Point,
        /// Centre of the sole's box in the link frame; its lower face is the sole.
        centre: Point,
        /// Grip of the sole: factor on `terrain.friction` under this foot.
        #[range(0.0, 10.0)]
        #[default("1.0")]
        friction: f64,
    }
}

keys! {
    /// The feet.
    pub struct Feet {
        /// The left foot.
        left: FootKeys,
        /// The right foot.
        right: FootKeys,
    }
}

keys! {
    /// A robot file.
    pub struct RobotFile {
        /// The robot's name, that of its file.
        name: String,
        /// A description of one line.
        summary: Option<String>,
        /// Where the figures come from.
        source: Option<String>,
        /// Under which terms.
        licence: Option<String>,
        /// Checked against the sum of the masses.
        total_mass: Option<Quantified<Kilogram>>,
        /// The floating base.
        base: Base,
        /// The moving links in joint order, the order of all joint vectors; a parent stands before its
        /// children.
        links: Vec<LinkKeys>,
        /// Left and right foot.
        feet: Feet,
    }
}

/// The keys of a robot file.
pub static PARAMS: &[Param] = RobotFile::PARAMS;

/// The robot of a decoded file, and all findings. No robot if its model fails E0403 to E0408; a valid model
/// with other errors, such as one that falls over, is returned.
pub fn from_table(name: &str, table: &Table) -> (Option<Robot>, Vec<Issue>) {
    let mut issues = Vec::new();
    let Some(file) = RobotFile::of_table(table) else { return (None, issues) };
    let robot = Reader { issues: &mut issues }.robot(name, &file);
    let Some(mut robot) = robot else { return (None, issues) };
    if let Some(stated) = file.total_mass {
        issues.extend(checks::total_mass(&robot, stated));
    }
    issues.extend(checks::model(&robot));
    match symmetry::mirror_map(&robot) {
        Ok(mirror) => {
            issues.extend(other_images(&robot, &mirror, &file));
            robot.mirror = mirror;
        }
        Err(unpaired) => issues.push(unmirrored(&robot, &unpaired)),
    }
    if !issues.is_empty() {
        return (None, issues);
    }
    robot.standing_height = symmetry::standing_height(&robot);
    let issues = examine::issues(examine::all(&robot));
    (Some(robot), issues)
}

/// The error for sides that do not mirror each other. If the feet are on the wrong sides, that is the cause
/// of all other differences.
pub(super) fn unmirrored(robot: &Robot, unpaired: &Unpaired) -> Issue {
    examine::sides(robot).unwrap_or_else(|| no_image(robot, unpaired))
}

/// A joint without a mirror image.
fn no_image(robot: &Robot, unpaired: &Unpaired) -> Issue {
    let joint = &unpaired.joint;
    let message = format!("joint `{joint}` has no mirror image on the other side");
    let rule = "the axes of the two sides must be reflections of each other in the x-z plane, to within 2 mm \
        and 0.1 deg";
    let help = match &unpaired.nearest {
        Some(nearest) => format!("{rule}; {}", nearest.in_words()),
        None => rule.to_owned(),
    };
    Issue::model(joint_path(robot, joint), message, &help)
}

/// Joints whose image in the file differs from the one derived from geometry (E0408).
fn other_images(robot: &Robot, mirror: &[(usize, f64)], file: &RobotFile) -> Vec<Issue> {
    let stated = file.links.iter().map(|link| link.joint.mirror.as_deref());
    let wrong = stated.zip(mirror).enumerate().filter_map(|(index, (stated, (image, sign)))| {
        let (stated, right) = (stated?, symmetry::written(robot, *image, *sign));
        (stated.trim_start_matches('+') != right).then(|| Issue {
            code: "E0408",
            path: format!("links.{index}.joint.mirror"),
            message: format!(
                "`{stated}` is not the mirror image of joint `{}`",
                robot.links[index].joint.name
            ),
            help: format!("write `mirror = \"{right}\"`, or leave it out"),
        })
    });
    wrong.collect()
}

fn joint_path(robot: &Robot, joint: &str) -> String {
    let index = robot.links.iter().position(|link| link.joint.name == joint).unwrap_or(0);
    format!("links.{index}.joint")
}

/// Reads the tables and collects errors.
struct Reader<'a> {
    issues: &'a mut Vec<Issue>,
}

impl Reader<'_> {
    fn robot(&mut self, name: &str, file: &RobotFile) -> Option<Robot> {
        let base = self.body("base", &file.base.name, &file.base.body)?;
        let mut indices = BTreeMap::from([(base.name.clone(), None)]);
        let mut joints = BTreeSet::new();
        let mut links = Vec::new();
        let mut complete = true;
        if let Some(issue) = checks::size(file.links.len()) {
            self.issues.push(issue);
            return None;
        }
        for (index, keys) in file.links.iter().enumerate() {
            let path = format!("links.{index}");
            let link = self.link(&path, keys, &indices);
            let link_name = &keys.own.name;
            if indices.insert(link_name.clone(), Some(index)).is_some() {
                self.issues.push(Issue::model(
                    format!("{path}.name"),
                    format!("two bodies are called `{link_name}`"),
                    "give each body its own name",
                ));
                complete = false;
            }
            let joint_name = &keys.joint.name;
            if !joints.insert(joint_name) {
                self.issues.push(Issue::model(
                    format!("{path}.joint.name"),
                    format!("two joints are called `{joint_name}`"),
                    "give each joint its own name",
                ));
                complete = false;
            }
            match link {
                Some(link) => links.push(link),
                None => complete = false,
            }
        }
        let left = self.foot("feet.left", &file.feet.left, &indices);
        let right = self.foot("feet.right", &file.feet.right, &indices);
        let feet = [left?, right?];
        let name = name.to_owned();
        complete.then_some(Robot { name, base, links, feet, mirror: Vec::new(), standing_height: 0.0 })
    }

    fn body(&mut self, path: &str, name: &str, keys: &BodyKeys) -> Option<Body> {
        let com = self.triple(path, BodyKeys::com.name, &keys.com)?;
        let shapes = keys.collisions.iter().flatten().enumerate();
        let collisions = shapes
            .filter_map(|(index, shape)| self.collision(&format!("{path}.collisions.{index}"), shape))
            .collect();
        Some(Body {
            name: name.to_owned(),
            mass: keys.mass,
            com: Point3::from(com),
            inertia: tensor(&keys.inertia),
            collisions,
        })
    }

    fn link(&mut self, path: &str, keys: &LinkKeys, known: &BTreeMap<String, Option<usize>>) -> Option<Link> {
        let body = self.body(path, &keys.own.name, &keys.body);
        let joint = self.joint(&format!("{path}.joint"), &keys.joint);
        let parent = self.known(&format!("{path}.parent"), &keys.own.parent, known);
        Some(Link { body: body?, parent: parent?, joint: joint? })
    }

    fn joint(&mut self, path: &str, keys: &JointKeys) -> Option<Joint> {
        let name = keys.name.clone();
        let origin = self.triple(path, JointKeys::origin.name, &keys.origin)?;
        let axis = self.triple(path, JointKeys::axis.name, &keys.axis)?;
        let Some(axis) = Unit::try_new(axis, 1e-6) else {
            self.issues.push(Issue::model(
                format!("{path}.axis"),
                format!("the axis of joint `{name}` has no length"),
                "write it as a direction such as [0.0, 1.0, 0.0]",
            ));
            return None;
        };
        let rotation = self.rotation(path, keys.rotation.as_deref())?;
        let Some(effort_limit) = keys.effort_limit else {
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
            lower: keys.lower,
            upper: keys.upper,
            effort_limit,
            velocity_limit: keys.velocity_limit,
            damping: keys.damping,
            friction: keys.friction,
            armature: keys.armature,
            stiffness_gain: keys.stiffness_gain,
            damping_gain: keys.damping_gain,
            default_position: keys.default_position,
        })
    }

    fn foot(&mut self, path: &str, keys: &FootKeys, known: &BTreeMap<String, Option<usize>>) -> Option<Foot> {
        let half_extents = self.triple(path, FootKeys::half_extents.name, &keys.half_extents)?;
        let centre = Point3::from(self.triple(path, FootKeys::centre.name, &keys.centre)?);
        let link = self.known(&format!("{path}.link"), &keys.link, known)?;
        let Some(link) = link else {
            self.issues.push(Issue::model(
                format!("{path}.link"),
                "the base cannot be a foot".to_owned(),
                "name a moving link",
            ));
            return None;
        };
        Some(Foot { link, half_extents, centre, friction: keys.friction })
    }

    /// Finds a body among the preceding ones: `None` inside is the base.
    fn known(
        &mut self,
        path: &str,
        name: &str,
        known: &BTreeMap<String, Option<usize>>,
    ) -> Option<Option<usize>> {
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

    fn collision(&mut self, path: &str, keys: &CollisionKeys) -> Option<Collision> {
        match keys.shape {
            Primitive::Box => {
                let half =
                    self.needed(path, CollisionKeys::half_extents.name, keys.half_extents.as_deref())?;
                let centre = self.needed(path, CollisionKeys::centre.name, keys.centre.as_deref())?;
                let turn = self.rotation(path, keys.rotation.as_deref())?;
                let centre = Translation3::from(centre);
                Some(Collision { shape: Shape::Box(half), pose: Isometry3::from_parts(centre, turn) })
            }
            Primitive::Sphere => {
                let shape = Shape::Sphere(self.radius(path, keys)?);
                let centre = self.needed(path, CollisionKeys::centre.name, keys.centre.as_deref())?;
                Some(Collision { shape, pose: Translation3::from(centre).into() })
            }
            Primitive::Capsule | Primitive::Cylinder => {
                let from = self.needed(path, CollisionKeys::from.name, keys.from.as_deref())?;
                let to = self.needed(path, CollisionKeys::to.name, keys.to.as_deref())?;
                let radius = self.radius(path, keys)?;
                let half = 0.5 * (to - from).norm();
                if keys.shape == Primitive::Capsule {
                    return Some(Collision {
                        shape: Shape::Capsule(half, radius),
                        pose: between(&from, &to),
                    });
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

    /// Roll, pitch and yaw of a table; if absent no rotation.
    fn rotation(&mut self, path: &str, angles: Option<&[f64]>) -> Option<UnitQuaternion<f64>> {
        let angles = angles.map(|angles| self.triple(path, "rotation", angles));
        Some(orientation(&angles.unwrap_or_else(|| Some(Vector3::zeros()))?))
    }

    fn radius(&mut self, path: &str, keys: &CollisionKeys) -> Option<f64> {
        if keys.radius.is_none() {
            self.missing(path, CollisionKeys::radius.name);
        }
        keys.radius
    }

    /// Three numbers required by this collision shape.
    fn needed(&mut self, path: &str, key: &str, numbers: Option<&[f64]>) -> Option<Vector3<f64>> {
        if numbers.is_none() {
            self.missing(path, key);
        }
        self.triple(path, key, numbers?)
    }

    fn triple(&mut self, path: &str, key: &str, numbers: &[f64]) -> Option<Vector3<f64>> {
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
            "a box has half_extents and centre, a sphere centre and radius, a capsule or cylinder from, to \
             and radius",
        ));
    }
}

/// The symmetric matrix of an inertia table.
fn tensor(inertia: &Inertia) -> Matrix3<f64> {
    let Inertia { ixx, iyy, izz, ixy, ixz, iyz } = *inertia;
    Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz)
}

/// Roll, pitch, yaw about fixed axes, as in URDF.
fn orientation(angles: &Vector3<f64>) -> UnitQuaternion<f64> {
    rotation_about(&Vector3::z(), angles.z)
        * rotation_about(&Vector3::y(), angles.y)
        * rotation_about(&Vector3::x(), angles.x)
}

/// The pose midway between two points whose z axis points from the first to the second.
pub(super) fn between(from: &Vector3<f64>, to: &Vector3<f64>) -> Isometry3<f64> {
    let direction = Unit::try_new(to - from, 1e-9).unwrap_or_else(Vector3::z_axis);
    let turn = UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), &direction)
        .unwrap_or_else(|| rotation_about(&Vector3::x(), std::f64::consts::PI));
    Isometry3::from_parts(Translation3::from(0.5 * (from + to)), turn)
}
