//! Gravity compensation with contacts: the joint torques that hold a robot still in a pose.
//!
//! Pure statics (no mass matrix). With `f` the ground's wrenches on the feet, rest means
//! `J_base^T f = g_base` and `tau = g_joints - J_joints^T f`. With one foot on the ground the wrench is the
//! weight; with two, its distribution is free and minimises the weighted sum of squared torques. In flight
//! nothing can be compensated and the torques are zero. The result equals the operational-space form of Park
//! and Khatib, "Contact consistent control framework for humanoid robots" (ICRA 2006), for the same
//! weighting.
//!
//! A leg with fewer than six joints carries some wrenches without any torque, for example a lateral force
//! through its hip. Between two such legs these directions are free, and tiny torque savings would cost
//! forces of many times the weight. There the wrenches are minimised too, each relative to what its sole can
//! transmit.

use nalgebra::{Isometry3, Matrix6, SMatrix, UnitQuaternion, Vector3, Vector6};

use super::kinematics::{GRAVITY, Kinematics};
use super::model::Robot;

/// Cost of a sole's wrench at its limit, relative to a squared joint torque at its limit: that of a tenth of
/// that torque. Only for legs with fewer than six joints.
const WRENCH_WEIGHT: f64 = 0.01;

/// Minimum friction coefficient that wrenches are normalised by: a frictionless sole has no lateral force,
/// but its cost must be finite.
const MIN_POSITIVE_GRIP: f64 = 0.05;

/// What the distribution of weight between two feet minimises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    /// The sum of squared torques relative to the joints' effort limits: spares weak joints.
    EffortLimits,
    /// The sum of squared torques: the pseudo-inverse of the operational-space form.
    Uniform,
}

/// The statics of a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Balance {
    /// Joint torques in N m, in joint order.
    pub torque: Vec<f64>,
    /// Wrench of the ground on the left and the right foot: force in N and moment in N m about the
    /// centre of the sole, world frame. Zero for a foot that is not in contact.
    pub wrench: [Vector6<f64>; 2],
}

/// Effective gravity in a body with a horizontal acceleration (m/s^2, x and y): the rotation of the effective
/// vertical to `z`, and the factor on the weight. Holding the rotated pose, with torques and wrenches times
/// the factor, accelerates all links equally (d'Alembert).
#[must_use]
pub fn felt_gravity(horizontal: [f64; 2]) -> (UnitQuaternion<f64>, f64) {
    let felt = Vector3::new(horizontal[0], horizontal[1], GRAVITY);
    let upright = UnitQuaternion::rotation_between(&felt, &Vector3::z());
    (upright.expect("gravity has a vertical part"), felt.norm() / GRAVITY)
}

/// Computes gravity compensation for one robot; holds all buffers.
#[derive(Clone, Debug)]
pub struct GravityCompensation {
    kinematics: Kinematics,
    weights: Vec<f64>,
    chains: [Vec<usize>; 2],
    soles: [[f64; 2]; 2],
    /// Friction coefficients of the soles.
    friction: [f64; 2],
    /// Whether a leg cannot apply every wrench to its foot.
    few_joints: bool,
    balance: Balance,
}

impl GravityCompensation {
    /// For a robot.
    pub fn new(robot: &Robot, weighting: Weighting) -> Self {
        let kinematics = Kinematics::new(robot);
        let weight = |limit: &f64| match weighting {
            Weighting::EffortLimits => 1.0 / limit,
            Weighting::Uniform => 1.0,
        };
        let weights = robot.effort_limits().iter().map(weight).collect();
        let chains: [Vec<usize>; 2] =
            [0, 1].map(|side| kinematics.chain(kinematics.foot_link(side)).collect());
        let own = |side: usize| chains[side].iter().filter(|joint| !chains[1 - side].contains(joint)).count();
        let few_joints = own(0) < 6 || own(1) < 6;
        let friction = robot.feet.each_ref().map(|foot| foot.friction);
        let balance = Balance { torque: vec![0.0; robot.joints()], wrench: [Vector6::zeros(); 2] };
        let soles = robot.feet.each_ref().map(|foot| [foot.half_extents[0], foot.half_extents[1]]);
        Self { kinematics, weights, chains, soles, friction, few_joints, balance }
    }

    /// The kinematics in the pose of the last call.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Torques and wrenches of the last call.
    pub fn balance(&self) -> &Balance {
        &self.balance
    }

    /// Torques and wrenches that hold this pose with these feet (left, right) on the ground. Only the
    /// base's orientation matters, not its position.
    pub fn hold(&mut self, base: &Isometry3<f64>, position: &[f64], contact: [bool; 2]) -> &Balance {
        self.hold_turning(base, position, contact, &Vector3::zeros())
    }

    /// Like [`Self::hold`], with an additional moment in N m (world frame) from the feet, which turns the
    /// robot.
    pub fn hold_turning(
        &mut self,
        base: &Isometry3<f64>,
        position: &[f64],
        contact: [bool; 2],
        moment: &Vector3<f64>,
    ) -> &Balance {
        self.kinematics.place(base, position);
        self.hold_placed(contact, moment)
    }

    /// Like [`Self::hold`], with the contacts inferred from the pose: soles within `tolerance` (m) of the
    /// lower one's height are in contact.
    pub fn hold_by_height(&mut self, base: &Isometry3<f64>, position: &[f64], tolerance: f64) -> &Balance {
        self.kinematics.place(base, position);
        self.hold_placed(self.kinematics.contacts_by_height(tolerance), &Vector3::zeros())
    }

    /// Removes from the last balance what the ground cannot apply: moves each foot's centre of pressure into
    /// this share of its sole's half extents, and subtracts the corresponding moment from the joints. The
    /// base is then no longer in balance: the robot tips over the edge of its sole, as in a step.
    pub fn keep_pressure_within(&mut self, share: f64) -> &Balance {
        for side in 0..2 {
            let wrench = self.balance.wrench[side];
            let sole = self.kinematics.sole(side).rotation;
            let [force, moment] =
                [0, 3].map(|row| sole.inverse() * Vector3::from(wrench.fixed_rows::<3>(row)));
            if force.z <= 0.0 {
                continue;
            }
            let [length, width] = self.soles[side].map(|half| share * half * force.z);
            // A centre of pressure ahead (x) gives a negative moment about y.
            let kept = Vector3::new(moment.x.clamp(-width, width), moment.y.clamp(-length, length), moment.z);
            let excess = sole * (moment - kept);
            for index in 0..self.chains[side].len() {
                let joint = self.chains[side][index];
                self.balance.torque[joint] += self.kinematics.axis(joint).dot(&excess);
            }
            (0..3).for_each(|axis| self.balance.wrench[side][3 + axis] -= excess[axis]);
        }
        &self.balance
    }

    fn hold_placed(&mut self, contact: [bool; 2], moment: &Vector3<f64>) -> &Balance {
        if contact == [false, false] {
            self.balance.torque.fill(0.0);
            self.balance.wrench = [Vector6::zeros(); 2];
            return &self.balance;
        }
        let mut weight = self.weight();
        (0..3).for_each(|axis| weight[3 + axis] += moment[axis]);
        let left = match contact {
            [true, false] => weight,
            [false, _] => Vector6::zeros(),
            [true, true] => self.left_share(&weight),
        };
        self.apply([left, weight - left]);
        &self.balance
    }

    /// The wrench about the base origin that supports the robot's weight.
    fn weight(&self) -> Vector6<f64> {
        let force = self.kinematics.total_mass() * GRAVITY;
        let lever = self.kinematics.com().coords - self.kinematics.base().translation.vector;
        Vector6::new(0.0, 0.0, force, lever.y * force, -lever.x * force, 0.0)
    }

    /// The row of `J^T` of a joint above a foot: its torque per wrench about the base origin.
    fn row(&self, joint: usize) -> Vector6<f64> {
        let axis = self.kinematics.axis(joint);
        let lever =
            self.kinematics.pose(joint).translation.vector - self.kinematics.base().translation.vector;
        let linear = axis.cross(&(-lever));
        Vector6::new(linear.x, linear.y, linear.z, axis.x, axis.y, axis.z)
    }

    /// The left foot's wrench that minimises the weighted torques when both feet support `weight`: one 6 x 6
    /// normal equation. A joint above both feet depends only on their sum.
    fn left_share(&self, weight: &Vector6<f64>) -> Vector6<f64> {
        let mut normal = Matrix6::zeros();
        let mut target = Vector6::zeros();
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let own = self.chains[side].iter().filter(|joint| !self.chains[1 - side].contains(joint));
            for &joint in own {
                let row = self.row(joint);
                let fixed = if side == 0 { 0.0 } else { row.dot(weight) };
                let weighting = self.weights[joint] * self.weights[joint];
                normal.syger(weighting, &row, &row, 1.0);
                target.axpy(sign * weighting * (self.kinematics.gravity_torque(joint) - fixed), &row, 1.0);
            }
        }
        if self.few_joints {
            for side in 0..2 {
                let relative = self.relative_wrench(side);
                let cost = WRENCH_WEIGHT * relative.transpose() * relative;
                normal += cost;
                if side == 1 {
                    target += cost * weight;
                }
            }
        }
        solve_positive(&normal, &target)
    }

    /// Maps a wrench about the base origin to one on a sole, in its frame, with each entry relative to the
    /// limit of a sole that carries the whole weight: friction, weight, and the moments of a force at its
    /// edge.
    fn relative_wrench(&self, side: usize) -> Matrix6<f64> {
        let (sole, force) = (self.kinematics.sole(side), self.kinematics.total_mass() * GRAVITY);
        let lever = sole.translation.vector - self.kinematics.base().translation.vector;
        let turn = sole.rotation.inverse().to_rotation_matrix().into_inner();
        let ([length, width], grip) = (self.soles[side], self.friction[side].max(MIN_POSITIVE_GRIP) * force);
        let limits = [grip, grip, force, width * force, length * force, 0.5 * (length + width) * grip];
        let mut relative = Matrix6::zeros();
        relative.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
        relative.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
        relative.fixed_view_mut::<3, 3>(3, 0).copy_from(&(-turn * lever.cross_matrix()));
        for (row, limit) in limits.into_iter().enumerate() {
            relative.row_mut(row).scale_mut(1.0 / limit);
        }
        relative
    }

    /// Joint torques and sole wrenches from the wrenches about the base origin.
    fn apply(&mut self, wrench: [Vector6<f64>; 2]) {
        for joint in 0..self.kinematics.joints() {
            self.balance.torque[joint] = self.kinematics.gravity_torque(joint);
        }
        for (side, wrench) in wrench.iter().enumerate() {
            for index in 0..self.chains[side].len() {
                let joint = self.chains[side][index];
                self.balance.torque[joint] -= self.row(joint).dot(wrench);
            }
            let lever =
                self.kinematics.sole(side).translation.vector - self.kinematics.base().translation.vector;
            let force: Vector3<f64> = wrench.fixed_rows::<3>(0).into();
            let moment: Vector3<f64> = wrench.fixed_rows::<3>(3).into();
            let moment = moment - lever.cross(&force);
            self.balance.wrench[side] = Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
        }
    }
}

/// Solves a symmetric positive semidefinite system; a singular one (two straight legs in line) is regularised
/// by 1e-9 of its mean diagonal.
fn solve_positive(lower: &Matrix6<f64>, target: &Vector6<f64>) -> Vector6<f64> {
    if let Some(factor) = SMatrix::cholesky(*lower) {
        return factor.solve(target);
    }
    let shift = 1e-9 * lower.trace() / 6.0;
    let shifted = lower + Matrix6::from_diagonal_element(shift);
    SMatrix::cholesky(shifted).map_or_else(Vector6::zeros, |factor| factor.solve(target))
}
