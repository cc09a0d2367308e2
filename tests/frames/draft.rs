//! A biped whose frames can be turned at will, written as URDF or MJCF: the same robot each time.

use std::fmt::Write;
use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use specforge::robot::Shape;
use specforge::stream::Stream;

/// A robot as a file has it.
#[derive(Clone)]
pub struct Draft {
    /// The base first, parents before children.
    pub bodies: Vec<Drawn>,
    /// World from base in the file: MJCF writes it as the pose of the base, URDF as the joint below a
    /// massless root.
    pub root: Isometry3<f64>,
    /// Frames without mass between the root and the base, by their names; empty for a file whose root is the
    /// base.
    pub footprints: Vec<&'static str>,
    /// How the base leans in the key frame of an MJCF file, from the pose in which it stands there.
    pub lean: UnitQuaternion<f64>,
}

/// A body and its joint.
#[derive(Clone)]
pub struct Drawn {
    pub name: String,
    pub parent: usize,
    pub mass: f64,
    pub com: Point3<f64>,
    pub inertia: Matrix3<f64>,
    pub solids: Vec<(Solid, Isometry3<f64>)>,
    pub joint: Option<Pin>,
    /// Pose in the parent's frame.
    pub pose: Isometry3<f64>,
}

/// A revolute joint.
#[derive(Clone)]
pub struct Pin {
    pub name: String,
    pub axis: Vector3<f64>,
    pub range: [f64; 2],
    pub effort: f64,
    /// Default position in rad.
    pub rest: f64,
}

#[derive(Clone)]
pub enum Solid {
    Shape(Shape),
    /// Corners of a mesh.
    Mesh(Vec<Vector3<f64>>),
}

/// What the feet stand on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sole {
    Box,
    HeelAndToe,
    Balls,
    Skids,
    Mesh,
}

/// The soles of both feet.
pub const SOLES: [Sole; 5] = [Sole::Box, Sole::HeelAndToe, Sole::Balls, Sole::Skids, Sole::Mesh];

/// A joint of a leg.
struct Hinge {
    name: &'static str,
    /// Height above its parent in m.
    up: f64,
    axis: [f64; 3],
    range: [f64; 2],
    effort: f64,
    rest: f64,
}

/// Yaw, roll, pitch, knee, pitch, roll.
const LEG: [Hinge; 6] = [
    Hinge { name: "hip_yaw", up: -0.05, axis: [0.0, 0.0, 1.0], range: [-0.6, 0.6], effort: 40.0, rest: 0.0 },
    Hinge { name: "hip_roll", up: -0.03, axis: [1.0, 0.0, 0.0], range: [-0.6, 0.6], effort: 60.0, rest: 0.0 },
    Hinge { name: "hip_pitch", up: 0.0, axis: [0.0, 1.0, 0.0], range: [-1.6, 0.8], effort: 80.0, rest: -0.3 },
    Hinge { name: "knee", up: -0.28, axis: [0.0, 1.0, 0.0], range: [0.0, 2.3], effort: 80.0, rest: 0.6 },
    Hinge {
        name: "ankle_pitch",
        up: -0.27,
        axis: [0.0, 1.0, 0.0],
        range: [-1.1, 0.8],
        effort: 40.0,
        rest: -0.3,
    },
    Hinge { name: "ankle_roll", up: 0.0, axis: [1.0, 0.0, 0.0], range: [-0.4, 0.4], effort: 25.0, rest: 0.0 },
];

fn at(x: f64, y: f64, z: f64) -> Isometry3<f64> {
    Isometry3::translation(x, y, z)
}

/// The bottom of a foot.
fn solids(sole: Sole) -> Vec<(Solid, Isometry3<f64>)> {
    let block = |x, y, z| Solid::Shape(Shape::Box(Vector3::new(x, y, z)));
    let corners = |x: f64, y: f64| [(x, y), (x, -y), (-x, y), (-x, -y)];
    match sole {
        Sole::Box => vec![(block(0.1, 0.045, 0.01), at(0.03, 0.0, -0.045))],
        Sole::HeelAndToe => vec![
            (block(0.05, 0.045, 0.01), at(0.09, 0.0, -0.045)),
            (block(0.05, 0.04, 0.02), at(-0.02, 0.0, -0.035)),
            (Solid::Shape(Shape::Cylinder(0.01, 0.03)), at(0.0, 0.0, -0.01)),
        ],
        Sole::Balls => {
            let ball = |(x, y)| (Solid::Shape(Shape::Sphere(0.01)), at(0.03 + x, y, -0.045));
            corners(0.09, 0.035).map(ball).to_vec()
        }
        Sole::Skids => {
            let lying = UnitQuaternion::rotation_between(&Vector3::z(), &Vector3::x()).unwrap();
            let skid = |y| {
                let pose = Isometry3::from_parts(Translation3::new(0.03, y, -0.045), lying);
                (Solid::Shape(Shape::Capsule(0.09, 0.01)), pose)
            };
            vec![skid(0.035), skid(-0.035)]
        }
        Sole::Mesh => {
            let mut points: Vec<Vector3<f64>> =
                corners(0.1, 0.045).map(|(x, y)| Vector3::new(0.03 + x, y, -0.055)).into();
            points.extend(corners(0.04, 0.03).map(|(x, y)| Vector3::new(0.01 + x, y, -0.015)));
            vec![(Solid::Mesh(points), Isometry3::identity())]
        }
    }
}

/// A biped of 19 kg: a torso and two legs of six joints, with inertias that have no symmetry but left and
/// right.
pub fn stork(sole: Sole) -> Draft {
    let mut bodies = vec![Drawn {
        name: "torso".into(),
        parent: 0,
        mass: 9.0,
        com: Point3::new(0.01, 0.0, 0.15),
        inertia: Matrix3::new(0.15, 0.0, -0.002, 0.0, 0.12, 0.0, -0.002, 0.0, 0.06),
        solids: vec![(Solid::Shape(Shape::Box(Vector3::new(0.1, 0.125, 0.175))), at(0.0, 0.0, 0.15))],
        joint: None,
        pose: Isometry3::identity(),
    }];
    for (side, y) in [("left", 1.0), ("right", -1.0)] {
        let mut parent = 0;
        for (index, Hinge { name, up, axis, range, effort, rest }) in LEG.into_iter().enumerate() {
            let foot = index == 5;
            let bar = Solid::Shape(Shape::Cylinder(0.1, 0.03));
            bodies.push(Drawn {
                name: format!("{side}_{}", if foot { "foot".to_owned() } else { format!("{name}_link") }),
                parent,
                mass: [0.8, 0.6, 1.9, 1.2, 0.2, 0.7][index],
                com: Point3::new(0.01, 0.005 * y, -0.03),
                inertia: Matrix3::new(
                    0.01,
                    0.0002 * y,
                    0.0006,
                    0.0002 * y,
                    0.0105,
                    0.0003 * y,
                    0.0006,
                    0.0003 * y,
                    0.003,
                ),
                solids: match index {
                    2 | 3 => vec![(bar, at(0.0, 0.0, -0.13))],
                    5 => solids(sole),
                    _ => Vec::new(),
                },
                joint: Some(Pin {
                    name: format!("{side}_{name}"),
                    axis: Vector3::from(axis),
                    range,
                    effort,
                    rest,
                }),
                pose: at(0.0, if index == 0 { 0.09 * y } else { 0.0 }, up),
            });
            parent = bodies.len() - 1;
        }
    }
    Draft { bodies, root: Isometry3::identity(), footprints: Vec::new(), lean: UnitQuaternion::identity() }
}

/// Any rotation.
pub fn anyhow(stream: &mut Stream) -> UnitQuaternion<f64> {
    let [w, x, y, z] = [(); 4].map(|()| stream.normal());
    UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z))
}

impl Draft {
    /// The index of a body.
    pub fn find(&self, name: &str) -> usize {
        self.bodies.iter().position(|body| body.name == name).expect("the body is there")
    }

    /// The same robot with the frame of a body at another pose, given in the old frame; where joints are,
    /// only turned.
    pub fn reframe(&mut self, index: usize, frame: &Isometry3<f64>) {
        let back = frame.inverse();
        let body = &mut self.bodies[index];
        let turn = back.rotation.to_rotation_matrix().into_inner();
        body.com = back * body.com;
        body.inertia = turn * body.inertia * turn.transpose();
        for (solid, pose) in &mut body.solids {
            match solid {
                Solid::Shape(_) => *pose = back * *pose,
                // A mesh is drawn in the frame of its body.
                Solid::Mesh(points) => {
                    points.iter_mut().for_each(|point| *point = (back * Point3::from(*point)).coords)
                }
            }
        }
        if let Some(joint) = &mut body.joint {
            assert!(frame.translation.vector.norm() == 0.0, "a joint's frame is on its axis");
            joint.axis = back.rotation * joint.axis;
        }
        body.pose *= frame;
        if index == 0 {
            self.root *= frame;
            self.bodies[0].pose = Isometry3::identity();
        }
        let children =
            (1..self.bodies.len()).filter(|child| self.bodies[*child].parent == index).collect::<Vec<_>>();
        children.into_iter().for_each(|child| self.bodies[child].pose = back * self.bodies[child].pose);
    }

    /// The same robot with the origin of a body's joint moved along its own axis.
    pub fn slide(&mut self, index: usize, by: f64) {
        let axis = self.bodies[index].joint.as_ref().map_or(Vector3::zeros(), |joint| joint.axis);
        let frame = Isometry3::from(Translation3::from(axis * by));
        let joint = self.bodies[index].joint.take();
        self.reframe(index, &frame);
        self.bodies[index].joint = joint;
    }

    /// The same robot with the frame of a body turned.
    pub fn turn(&mut self, index: usize, turn: UnitQuaternion<f64>) {
        self.reframe(index, &Isometry3::from_parts(Translation3::identity(), turn));
    }

    /// The same robot with other names for left and right.
    pub fn renamed(mut self, left: &str, right: &str) -> Self {
        let renamed = |name: &str| name.replace("left", left).replace("right", right);
        for body in &mut self.bodies {
            body.name = renamed(&body.name);
            body.joint.iter_mut().for_each(|joint| joint.name = renamed(&joint.name));
        }
        self
    }

    /// Writes `NAME.urdf` with its meshes.
    pub fn urdf(&self, folder: &Path, name: &str) {
        let mut text = format!("<?xml version=\"1.0\"?>\n<robot name=\"{name}\">\n");
        for (index, footprint) in self.footprints.iter().enumerate() {
            let child = self.footprints.get(index + 1).copied().unwrap_or("torso");
            let pose = if index + 1 == self.footprints.len() { self.root } else { Isometry3::identity() };
            let _ = writeln!(
                text,
                "<link name=\"{footprint}\"/><joint name=\"{footprint}_joint\" type=\"fixed\">{}<parent \
                 link=\"{footprint}\"/>\
                 <child link=\"{child}\"/></joint>",
                origin(&pose)
            );
        }
        for body in &self.bodies {
            let i = &body.inertia;
            let _ = write!(
                text,
                "<link name=\"{}\"><inertial>{}<mass value=\"{}\"/><inertia \
                 ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" \
                 izz=\"{}\"/></inertial>",
                body.name,
                origin(&Isometry3::from_parts(body.com.coords.into(), UnitQuaternion::identity())),
                body.mass,
                i.m11,
                i.m12,
                i.m13,
                i.m22,
                i.m23,
                i.m33
            );
            for (solid, pose) in &body.solids {
                let geometry = match solid {
                    Solid::Mesh(points) => {
                        std::fs::write(folder.join(format!("{}.stl", body.name)), stl(points)).unwrap();
                        format!("<mesh filename=\"{}.stl\"/>", body.name)
                    }
                    Solid::Shape(Shape::Box(half)) => format!("<box size=\"{}\"/>", triple(&(2.0 * half))),
                    Solid::Shape(Shape::Sphere(radius)) => format!("<sphere radius=\"{radius}\"/>"),
                    Solid::Shape(Shape::Capsule(half, radius)) => {
                        format!("<capsule radius=\"{radius}\" length=\"{}\"/>", 2.0 * half)
                    }
                    Solid::Shape(Shape::Cylinder(half, radius)) => {
                        format!("<cylinder radius=\"{radius}\" length=\"{}\"/>", 2.0 * half)
                    }
                };
                let _ =
                    write!(text, "<collision>{}<geometry>{geometry}</geometry></collision>", origin(pose));
            }
            text += "</link>\n";
            if let Some(Pin { name, axis, range: [lower, upper], effort, .. }) = &body.joint {
                let _ = writeln!(
                    text,
                    "<joint name=\"{name}\" type=\"revolute\">{}<parent link=\"{}\"/><child \
                     link=\"{}\"/><axis xyz=\"{}\"/>\
                     <limit lower=\"{lower}\" upper=\"{upper}\" effort=\"{effort}\" velocity=\"10\"/>\
                     <dynamics damping=\"0.3\" friction=\"0.2\"/></joint>",
                    origin(&body.pose),
                    self.bodies[body.parent].name,
                    body.name,
                    triple(axis)
                );
            }
        }
        std::fs::write(folder.join(format!("{name}.urdf")), text + "</robot>\n").unwrap();
    }

    /// Writes `NAME.xml` with its meshes: the default pose is a key frame.
    pub fn mjcf(&self, folder: &Path, name: &str) {
        let mut text = "<mujoco><compiler angle=\"radian\"/>\n<asset>".to_owned();
        for body in &self.bodies {
            if let Some((Solid::Mesh(points), _)) = body.solids.first() {
                std::fs::write(folder.join(format!("{}.stl", body.name)), stl(points)).unwrap();
                let _ = write!(text, "<mesh name=\"{0}\" file=\"{0}.stl\"/>", body.name);
            }
        }
        text += "</asset>\n<worldbody>\n";
        for footprint in &self.footprints {
            let floats = if *footprint == self.footprints[0] { "<freejoint/>" } else { "" };
            let _ = writeln!(text, "<body name=\"{footprint}\">{floats}");
        }
        self.body(0, &mut text);
        text += &"</body>\n".repeat(self.footprints.len());
        text += "</worldbody>\n<actuator>";
        let joints = || self.bodies.iter().filter_map(|body| body.joint.as_ref());
        for Pin { name, effort, .. } in joints() {
            let _ = write!(text, "<motor joint=\"{name}\" ctrlrange=\"-{effort} {effort}\"/>");
        }
        let rest: Vec<String> = joints().map(|joint| joint.rest.to_string()).collect();
        let stands = if self.footprints.is_empty() { self.root.rotation } else { UnitQuaternion::identity() };
        let turn = self.lean * stands;
        let _ = write!(
            text,
            "</actuator>\n<keyframe><key name=\"home\" qpos=\"0 0 1 {} {} {} {} {}\"/></keyframe></mujoco>",
            turn.w,
            turn.i,
            turn.j,
            turn.k,
            rest.join(" ")
        );
        std::fs::write(folder.join(format!("{name}.xml")), text).unwrap();
    }

    fn body(&self, index: usize, text: &mut String) {
        let body = &self.bodies[index];
        let pose = if index == 0 { self.root } else { body.pose };
        let i = &body.inertia;
        let _ = write!(text, "<body name=\"{}\" {}>", body.name, placed(&pose));
        match &body.joint {
            Some(Pin { name, axis, range: [lower, upper], .. }) => {
                let _ = write!(
                    text,
                    "<joint name=\"{name}\" axis=\"{}\" range=\"{lower} \
                     {upper}\" damping=\"0.3\" frictionloss=\"0.2\" armature=\"0.02\"/>",
                    triple(axis)
                );
            }
            None if self.footprints.is_empty() => *text += "<freejoint/>",
            None => {}
        }
        let _ = write!(
            text,
            "<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{} {} {} {} {} {}\"/>",
            triple(&body.com.coords),
            body.mass,
            i.m11,
            i.m22,
            i.m33,
            i.m12,
            i.m13,
            i.m23
        );
        for (solid, pose) in &body.solids {
            let geom = match solid {
                Solid::Mesh(_) => format!("type=\"mesh\" mesh=\"{}\"", body.name),
                Solid::Shape(Shape::Box(half)) => format!("type=\"box\" size=\"{}\"", triple(half)),
                Solid::Shape(Shape::Sphere(radius)) => format!("type=\"sphere\" size=\"{radius}\""),
                Solid::Shape(Shape::Capsule(half, radius)) => {
                    format!("type=\"capsule\" size=\"{radius} {half}\"")
                }
                Solid::Shape(Shape::Cylinder(half, radius)) => {
                    format!("type=\"cylinder\" size=\"{radius} {half}\"")
                }
            };
            let _ = write!(text, "<geom {geom} {}/>", placed(pose));
        }
        text.push('\n');
        for child in (1..self.bodies.len()).filter(|child| self.bodies[*child].parent == index) {
            self.body(child, text);
        }
        *text += "</body>\n";
    }
}

fn triple(vector: &Vector3<f64>) -> String {
    format!("{} {} {}", vector.x, vector.y, vector.z)
}

fn origin(pose: &Isometry3<f64>) -> String {
    let [roll, pitch, yaw] = fixed_angles(&pose.rotation);
    format!("<origin xyz=\"{}\" rpy=\"{roll} {pitch} {yaw}\"/>", triple(&pose.translation.vector))
}

/// Roll, pitch and yaw about fixed axes, exact near a pitch of 90 degrees too.
fn fixed_angles(turn: &UnitQuaternion<f64>) -> [f64; 3] {
    let m = turn.to_rotation_matrix().into_inner();
    let level = libm::hypot(m.m11, m.m21);
    let pitch = libm::atan2(-m.m31, level);
    if level > 1e-9 {
        [libm::atan2(m.m32, m.m33), pitch, libm::atan2(m.m21, m.m11)]
    } else {
        [libm::atan2(-m.m23, m.m22), pitch, 0.0]
    }
}

fn placed(pose: &Isometry3<f64>) -> String {
    let turn = pose.rotation;
    format!(
        "pos=\"{}\" quat=\"{} {} {} {}\"",
        triple(&pose.translation.vector),
        turn.w,
        turn.i,
        turn.j,
        turn.k
    )
}

/// A mesh whose corners are these points; which triangles there are does not matter.
fn stl(points: &[Vector3<f64>]) -> String {
    let mut text = "solid foot\n".to_owned();
    for index in 0..points.len() {
        text += "facet normal 0 0 1\nouter loop\n";
        for corner in 0..3 {
            let _ = writeln!(text, "vertex {}", triple(&points[(index + corner) % points.len()]));
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid foot\n"
}
