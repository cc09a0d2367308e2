//! Contents of a world in plain numbers: bodies, joints, shapes, ground. SI units, rotation matrices by rows,
//! world frame z up.

/// A rotation matrix by rows.
pub type Rows = [[f64; 3]; 3];

/// No rotation.
pub const IDENTITY: Rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A tree of bodies on revolute joints under a floating base.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// The base first, then the body of each joint.
    pub bodies: Vec<Body>,
    /// Joint `i` carries body `i + 1`; parents come before their children.
    pub joints: Vec<Joint>,
}

/// Mass properties and shapes of a body in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Mass in kg.
    pub mass: f64,
    /// Centre of mass in m.
    pub com: [f64; 3],
    /// Inertia about the centre of mass, axes of the body frame: xx, yy, zz, xy, xz, yz in kg m^2.
    pub inertia: [f64; 6],
    /// Shapes that collide with the ground.
    pub shapes: Vec<Shape>,
}

/// A revolute joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Index of the parent body.
    pub parent: usize,
    /// Position of the joint in the parent's frame in m.
    pub place: [f64; 3],
    /// Orientation of the joint in the parent's frame.
    pub turn: Rows,
    /// Unit axis in the joint's frame.
    pub axis: [f64; 3],
    /// Position limits in rad.
    pub limits: [f64; 2],
    /// Effort limit in N m: torques are clipped to it.
    pub effort: f64,
    /// Viscous damping in N m s/rad.
    pub damping: f64,
    /// Coulomb friction in N m.
    pub friction: f64,
    /// Rotor inertia in kg m^2.
    pub armature: f64,
}

/// A collision shape in its body's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Kind and size.
    pub kind: Kind,
    /// Its centre in m.
    pub place: [f64; 3],
    /// Its orientation.
    pub turn: Rows,
    /// Friction coefficient against the ground.
    pub friction: f64,
    /// The foot whose contact force it adds to; `None` counts as contact of the body.
    pub foot: Option<usize>,
}

/// Kinds of shapes, centred on their frame's origin; sizes in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Half extents.
    Box([f64; 3]),
    /// Along z: half length without the caps, radius.
    Capsule(f64, f64),
    /// Along z: half length, radius.
    Cylinder(f64, f64),
    /// Radius.
    Sphere(f64),
}

impl Kind {
    /// Three numbers that describe its size.
    pub(crate) fn size(&self) -> [f64; 3] {
        match *self {
            Self::Box(half) => half,
            Self::Capsule(half, radius) | Self::Cylinder(half, radius) => [radius, half, 0.0],
            Self::Sphere(radius) => [radius, 0.0, 0.0],
        }
    }

    /// Radius of its bounding sphere in m.
    pub(crate) fn radius(&self) -> f64 {
        match *self {
            Self::Box([x, y, z]) => (x * x + y * y + z * z).sqrt(),
            Self::Capsule(half, radius) => half + radius,
            Self::Cylinder(half, radius) => (half * half + radius * radius).sqrt(),
            Self::Sphere(radius) => radius,
        }
    }
}

/// The ground, all of it solid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ground {
    /// Planes.
    pub planes: Vec<Plane>,
    /// Upright boxes.
    pub boxes: Vec<Block>,
    /// A height field.
    pub field: Option<Field>,
}

/// A half space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point on its surface in m.
    pub point: [f64; 3],
    /// Its unit normal, pointing out of the ground.
    pub normal: [f64; 3],
}

/// A box with sides along the world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Its centre in m.
    pub centre: [f64; 3],
    /// Its half extents in m.
    pub half: [f64; 3],
}

/// Heights over a grid centred on the origin. Each cell is two triangles, split along the diagonal from its
/// low to its high corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    pub(crate) cell: f64,
    pub(crate) counts: [usize; 2],
    pub(crate) heights: Vec<f64>,
    pub(crate) bottom: f64,
    top: f64,
}

impl Field {
    /// A field with cells of this side in m, these numbers of samples along x and y (at least two), heights
    /// in m (x outer, y inner), solid down to a height in m.
    pub fn new(cell: f64, counts: [usize; 2], heights: Vec<f64>, bottom: f64) -> Self {
        assert!(
            counts.iter().all(|count| *count > 1) && heights.len() == counts[0] * counts[1],
            "a grid has cells"
        );
        let top = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Self { cell, counts, heights, bottom, top }
    }

    /// Its highest point in m.
    pub(crate) fn top(&self) -> f64 {
        self.top
    }

    /// Half its extent along x and y in m.
    pub(crate) fn half(&self) -> [f64; 2] {
        self.counts.map(|count| 0.5 * self.cell * (count - 1) as f64)
    }
}

/// Settings of a world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Physics step in s.
    pub step: f64,
    /// Gravity in m/s^2, downwards.
    pub gravity: f64,
    /// Time constant of contacts in s; raised to two steps if smaller, as in MuJoCo (`refsafe`).
    pub contact_time: f64,
}
