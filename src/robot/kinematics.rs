//! Forward kinematics, centre of mass, Jacobians, mass matrix and gravity of a robot, in f64.
//!
//! [`Kinematics`] has its own copy of the parameters and all buffers: [`Kinematics::place`] sets a pose
//! without allocating, everything else uses that pose. Does not cover velocities, forces or simulation.
//!
//! Generalised coordinates, where a vector or matrix has `6 + joints` entries: velocity of the base origin
//! (world frame), angular velocity of the base (world frame), joint velocities in joint order.

use nalgebra::{
    DMatrix, DVector, Isometry3, Matrix3, Matrix6xX, Point3, Quaternion, Translation3, UnitQuaternion,
    Vector3,
};

use super::model::{Body, Robot};

/// Acceleration of gravity in m/s^2, along -z.
pub const GRAVITY: f64 = 9.81;

/// The rotation by `angle` (rad) about a unit axis; like nalgebra's but with a portable sine.
pub fn rotation_about(axis: &Vector3<f64>, angle: f64) -> UnitQuaternion<f64> {
    let (sine, cosine) = libm::sincos(0.5 * angle);
    UnitQuaternion::new_unchecked(Quaternion::from_parts(cosine, axis * sine))
}

/// The body parameters that kinematics needs.
#[derive(Clone, Debug)]
struct Inertial {
    mass: f64,
    com: Point3<f64>,
    inertia: Matrix3<f64>,
}

impl From<&Body> for Inertial {
    fn from(body: &Body) -> Self {
        Self { mass: body.mass, com: body.com, inertia: body.inertia }
    }
}

/// The parameters of a link and its joint.
#[derive(Clone, Debug)]
struct Bone {
    parent: Option<usize>,
    origin: Isometry3<f64>,
    axis: Vector3<f64>,
    armature: f64,
    inertial: Inertial,
}

/// The lower face of a foot's box.
#[derive(Clone, Debug)]
struct Sole {
    link: usize,
    centre: Translation3<f64>,
    half: [f64; 2],
}

/// The poses of a robot's links, and derived quantities.
#[derive(Clone, Debug)]
pub struct Kinematics {
    trunk: Inertial,
    bones: Vec<Bone>,
    soles: [Sole; 2],
    base: Isometry3<f64>,
    poses: Vec<Isometry3<f64>>,
    axes: Vec<Vector3<f64>>,
    coms: Vec<Point3<f64>>,
    subtree_mass: Vec<f64>,
    subtree_moment: Vec<Vector3<f64>>,
}

impl Kinematics {
    /// The kinematics of a robot, in its default pose with the base at the origin.
    pub fn new(robot: &Robot) -> Self {
        let bones: Vec<Bone> = robot
            .links
            .iter()
            .map(|link| Bone {
                parent: link.parent,
                origin: link.joint.origin,
                axis: link.joint.axis.into_inner(),
                armature: link.joint.armature,
                inertial: Inertial::from(&link.body),
            })
            .collect();
        let soles = [0, 1].map(|side| {
            let foot = &robot.feet[side];
            let centre = Translation3::new(foot.centre.x, foot.centre.y, foot.sole());
            Sole { link: foot.link, centre, half: [foot.half_extents.x, foot.half_extents.y] }
        });
        let joints = bones.len();
        let mut kinematics = Self {
            trunk: Inertial::from(&robot.base),
            bones,
            soles,
            base: Isometry3::identity(),
            poses: vec![Isometry3::identity(); joints],
            axes: vec![Vector3::zeros(); joints],
            coms: vec![Point3::origin(); joints],
            subtree_mass: vec![0.0; joints],
            subtree_moment: vec![Vector3::zeros(); joints],
        };
        kinematics.place(&Isometry3::identity(), &robot.default_pose());
        kinematics
    }

    /// Sets the pose: world from base, and joint positions in rad.
    pub fn place(&mut self, base: &Isometry3<f64>, position: &[f64]) {
        self.place_links(base, position);
        for (index, bone) in self.bones.iter().enumerate() {
            let pose = &self.poses[index];
            // A joint's axis is the same in the frames of both bodies up to rounding; this uses the parent's.
            let parent = bone.parent.map_or(base, |parent| &self.poses[parent]);
            self.axes[index] = (parent.rotation * bone.origin.rotation) * bone.axis;
            let com = pose * bone.inertial.com;
            self.coms[index] = com;
            self.subtree_mass[index] = bone.inertial.mass;
            self.subtree_moment[index] = com.coords * bone.inertial.mass;
        }
        for index in (0..self.bones.len()).rev() {
            if let Some(parent) = self.bones[index].parent {
                self.subtree_mass[parent] += self.subtree_mass[index];
                let moment = self.subtree_moment[index];
                self.subtree_moment[parent] += moment;
            }
        }
    }

    /// Sets only the base and the poses of the links; everything else remains from the last
    /// [`Kinematics::place`].
    pub fn place_links(&mut self, base: &Isometry3<f64>, position: &[f64]) {
        self.base = *base;
        for (index, bone) in self.bones.iter().enumerate() {
            let parent = bone.parent.map_or(base, |parent| &self.poses[parent]);
            let frame = parent * bone.origin;
            self.poses[index] = Isometry3::from_parts(
                frame.translation,
                frame.rotation * rotation_about(&bone.axis, position[index]),
            );
        }
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.bones.len()
    }

    /// World from base.
    pub fn base(&self) -> &Isometry3<f64> {
        &self.base
    }

    /// World from link frame.
    pub fn pose(&self, link: usize) -> &Isometry3<f64> {
        &self.poses[link]
    }

    /// Axis of a joint in the world frame.
    pub fn axis(&self, joint: usize) -> &Vector3<f64> {
        &self.axes[joint]
    }

    /// World from the sole's frame of the left (0) or right (1) foot: the centre of the sole's lower
    /// face, axes of the foot's link.
    pub fn sole(&self, side: usize) -> Isometry3<f64> {
        let sole = &self.soles[side];
        self.poses[sole.link] * sole.centre
    }

    /// The corners of a sole in the world, in m: heel right, heel left, toe left, toe right as seen from
    /// above.
    pub fn corners(&self, side: usize) -> [Point3<f64>; 4] {
        let [x, y] = self.soles[side].half;
        let sole = self.sole(side);
        [(-x, -y), (-x, y), (x, y), (x, -y)].map(|(x, y)| sole * Point3::new(x, y, 0.0))
    }

    /// Height in the world of the lowest corner of a sole, in m.
    pub fn lowest_corner(&self, side: usize) -> f64 {
        self.corners(side).iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min)
    }

    /// Index of the link of the left (0) or right (1) foot.
    pub fn foot_link(&self, side: usize) -> usize {
        self.soles[side].link
    }

    /// Whether each sole's centre is within `tolerance` (m) of the lower one's height: the contacts of a
    /// standing robot, inferred from its pose.
    pub fn contacts_by_height(&self, tolerance: f64) -> [bool; 2] {
        let heights = [0, 1].map(|side| self.sole(side).translation.z);
        let lowest = heights[0].min(heights[1]);
        heights.map(|height| height - lowest < tolerance)
    }

    /// Whether a joint is between the base and a link (including the link's own joint).
    pub fn carries(&self, joint: usize, link: usize) -> bool {
        self.chain(link).any(|ancestor| ancestor == joint)
    }

    /// The joints from a link up to the base, the link's own first.
    pub fn chain(&self, link: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(link), |index| self.bones[*index].parent)
    }

    /// Total mass in kg.
    pub fn total_mass(&self) -> f64 {
        self.trunk.mass + self.bones.iter().map(|bone| bone.inertial.mass).sum::<f64>()
    }

    /// Centre of mass of the whole robot in the world, in m.
    pub fn com(&self) -> Point3<f64> {
        let trunk = (self.base * self.trunk.com).coords * self.trunk.mass;
        let links = self.coms.iter().zip(&self.bones).map(|(com, bone)| com.coords * bone.inertial.mass);
        Point3::from((trunk + links.sum::<Vector3<f64>>()) / self.total_mass())
    }

    /// Gravity torque of a joint in N m: what its drive must supply to hold the links below it.
    pub fn gravity_torque(&self, joint: usize) -> f64 {
        let anchor = self.poses[joint].translation.vector;
        let lever = self.subtree_moment[joint] - anchor * self.subtree_mass[joint];
        let axis = &self.axes[joint];
        GRAVITY * (axis.x * lever.y - axis.y * lever.x)
    }

    /// Writes the generalised gravity vector (`6 + joints`; N and N m): the force that holds the robot still
    /// without any contact.
    pub fn gravity(&self, out: &mut DVector<f64>) {
        let weight = self.total_mass() * GRAVITY;
        let lever = self.com() - Point3::from(self.base.translation.vector);
        out.rows_mut(0, 3).copy_from(&Vector3::new(0.0, 0.0, weight));
        out.rows_mut(3, 3).copy_from(&Vector3::new(lever.y * weight, -lever.x * weight, 0.0));
        for joint in 0..self.joints() {
            out[6 + joint] = self.gravity_torque(joint);
        }
    }

    /// Writes the Jacobian (6 x `6 + joints`; linear rows first, world frame) of a point in the world
    /// that moves with a link; `None` is the base.
    pub fn jacobian(&self, link: Option<usize>, point: &Point3<f64>, out: &mut Matrix6xX<f64>) {
        out.fill(0.0);
        let lever = point - Point3::from(self.base.translation.vector);
        out.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        out.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-lever.cross_matrix()));
        out.fixed_view_mut::<3, 3>(3, 3).fill_with_identity();
        for joint in link.into_iter().flat_map(|link| self.chain(link)) {
            let axis = self.axes[joint];
            let anchor = Point3::from(self.poses[joint].translation.vector);
            out.fixed_view_mut::<3, 1>(0, 6 + joint).copy_from(&axis.cross(&(point - anchor)));
            out.fixed_view_mut::<3, 1>(3, 6 + joint).copy_from(&axis);
        }
    }

    /// The mass matrix (`6 + joints` square; kg, kg m, kg m^2), reflected rotor inertias included.
    pub fn mass_matrix(&self) -> DMatrix<f64> {
        let size = 6 + self.joints();
        let mut matrix = DMatrix::zeros(size, size);
        let mut jacobian = Matrix6xX::zeros(size);
        let trunk = std::iter::once((None, &self.trunk, &self.base));
        let links = self.bones.iter().zip(&self.poses).enumerate();
        let links = links.map(|(index, (bone, pose))| (Some(index), &bone.inertial, pose));
        for (link, inertial, pose) in trunk.chain(links) {
            self.jacobian(link, &(pose * inertial.com), &mut jacobian);
            let rotation = pose.rotation.to_rotation_matrix();
            let inertia = rotation.matrix() * inertial.inertia * rotation.matrix().transpose();
            let linear = jacobian.fixed_rows::<3>(0);
            let angular = jacobian.fixed_rows::<3>(3);
            matrix += linear.transpose() * linear * inertial.mass;
            matrix += angular.transpose() * inertia * angular;
        }
        for (index, bone) in self.bones.iter().enumerate() {
            matrix[(6 + index, 6 + index)] += bone.armature;
        }
        matrix
    }
}
