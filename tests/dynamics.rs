//! The robot's own kinematics and statics against MuJoCo's, which reads the same robot from the MJCF text.
//!
//! Every figure on random poses of every shipped robot to 1e-9, relative where it is large. MuJoCo counts
//! joints depth first and gives the base's angular velocity in the base frame; [`Oracle`] turns its figures
//! into the generalised coordinates of `robot::Kinematics`.

#![cfg(feature = "mujoco")]

use std::sync::Arc;

use mujoco_rs::prelude::{MjData, MjModel, MjtObjBase};
use nalgebra::{
    DMatrix, DVector, Isometry3, Matrix3, Matrix6xX, Point3, Quaternion, Rotation3, Translation3,
    UnitQuaternion, Vector3, Vector6,
};
use specforge::robot::{self, GravityCompensation, Kinematics, Robot, Weighting};
use specforge::sim::{EngineSettings, Terrain, mjcf};
use specforge::stream::Stream;

/// Random poses of every robot.
const POSES: usize = 50;
/// Largest difference, relative where the figure is above one.
const EXACT: f64 = 1e-9;

fn robots() -> Vec<Robot> {
    robot::names().map(|name| robot::shipped(name).expect("it is shipped")).collect()
}

/// A pose: world from base and joint positions within the limits; the base turned anyhow, 5 m above the
/// ground.
fn pose(robot: &Robot, stream: &mut Stream) -> (Isometry3<f64>, Vec<f64>) {
    let [w, x, y, z] = [(); 4].map(|()| stream.normal());
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let place = Translation3::new(stream.normal(), stream.normal(), 5.0 + stream.uniform());
    let joints = robot.links.iter().map(|link| {
        let joint = &link.joint;
        joint.lower + (joint.upper - joint.lower) * stream.uniform()
    });
    (Isometry3::from_parts(place, turn), joints.collect())
}

/// A robot in MuJoCo.
struct Oracle {
    data: MjData<Arc<MjModel>>,
    /// MuJoCo's body of the base and of each link.
    base: usize,
    bodies: Vec<usize>,
    /// Entry of each joint in the velocities.
    dofs: Vec<usize>,
    soles: [usize; 2],
}

impl Oracle {
    fn new(robot: &Robot) -> Self {
        let settings = EngineSettings { step: 0.001, friction: 1.0, contact_time: None };
        let model = MjModel::from_xml_string(&mjcf::document(robot, &Terrain::Flat, &settings)).unwrap();
        let body = |name: &str| model.name_to_id(MjtObjBase::mjOBJ_BODY, name).unwrap();
        let joint = |name: &str| model.name_to_id(MjtObjBase::mjOBJ_JOINT, name).unwrap();
        let sole = |name: &str| model.name_to_id(MjtObjBase::mjOBJ_GEOM, name).unwrap();
        let (base, soles) = (body(&robot.base.name), mjcf::SOLES.map(sole));
        let bodies = robot.links.iter().map(|link| body(&link.body.name)).collect();
        let dofs =
            robot.links.iter().map(|link| model.jnt_dofadr()[joint(&link.joint.name)] as usize).collect();
        Self { data: MjData::try_new(Arc::new(model)).unwrap(), base, bodies, dofs, soles }
    }

    /// Puts the robot into a pose at rest.
    fn place(&mut self, base: &Isometry3<f64>, position: &[f64]) {
        let turn = base.rotation;
        let numbers = self.data.qpos_mut();
        numbers[..3].copy_from_slice(base.translation.vector.as_slice());
        numbers[3..7].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
        // A hinge has one position and one velocity, the free joint seven and six.
        self.dofs.iter().zip(position).for_each(|(dof, angle)| numbers[dof + 1] = *angle);
        self.data.qvel_mut().fill(0.0);
        self.data.forward();
    }

    /// MuJoCo's velocities from ours, a matrix.
    fn theirs_of_ours(&self) -> DMatrix<f64> {
        let size = 6 + self.dofs.len();
        let mut matrix = DMatrix::zeros(size, size);
        matrix.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        let base = self.turn(self.base).transpose();
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(base.matrix());
        self.dofs.iter().enumerate().for_each(|(joint, dof)| matrix[(*dof, 6 + joint)] = 1.0);
        matrix
    }

    fn turn(&self, body: usize) -> Rotation3<f64> {
        Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&self.data.xmat()[body]))
    }

    fn sole(&self, side: usize, half_height: f64) -> Point3<f64> {
        let geom = self.soles[side];
        let turn = Matrix3::from_row_slice(&self.data.geom_xmat()[geom]);
        Point3::from(self.data.geom_xpos()[geom]) - turn * Vector3::z() * half_height
    }

    fn mass_matrix(&self) -> DMatrix<f64> {
        let size = 6 + self.dofs.len();
        let mut entries = vec![0.0; size * size];
        self.data.full_m(&mut entries).unwrap();
        let turn = self.theirs_of_ours();
        turn.transpose() * DMatrix::from_row_slice(size, size, &entries) * turn
    }

    fn gravity(&self) -> DVector<f64> {
        self.theirs_of_ours().transpose() * DVector::from_column_slice(self.data.qfrc_bias())
    }

    /// Jacobian of a point that moves with a body, linear rows first.
    fn jacobian(&self, body: usize, point: &Point3<f64>) -> DMatrix<f64> {
        let (linear, angular) = self.data.jac(true, true, &[point.x, point.y, point.z], body);
        let size = 6 + self.dofs.len();
        DMatrix::from_row_slice(6, size, &[linear, angular].concat()) * self.theirs_of_ours()
    }
}

/// Whether two figures are the same.
fn assert_same(ours: &[f64], theirs: &[f64], what: &str) {
    assert_eq!(ours.len(), theirs.len(), "{what}");
    for (index, (ours, theirs)) in ours.iter().zip(theirs).enumerate() {
        let error = (ours - theirs).abs() / theirs.abs().max(1.0);
        assert!(
            error < EXACT,
            "{what}, entry {index}: {ours} here and {theirs} in MuJoCo, {error:.1e} apart"
        );
    }
}

/// Calls a check for random poses of every robot.
fn on_random_poses(stream: &str, mut check: impl FnMut(&Robot, &mut Oracle, &Kinematics, &str)) {
    for robot in robots() {
        let mut stream = Stream::new(&format!("test/dynamics/{stream}/{}", robot.name));
        let (mut oracle, mut kinematics) = (Oracle::new(&robot), Kinematics::new(&robot));
        for number in 0..POSES {
            let (base, position) = pose(&robot, &mut stream);
            oracle.place(&base, &position);
            kinematics.place(&base, &position);
            check(&robot, &mut oracle, &kinematics, &format!("{} in pose {number}", robot.name));
        }
    }
}

#[test]
fn every_body_joint_and_sole_is_where_mujoco_has_it() {
    on_random_poses("places", |robot, oracle, kinematics, what| {
        let data = &oracle.data;
        for (link, body) in oracle.bodies.iter().enumerate() {
            let pose = kinematics.pose(link);
            assert_same(
                pose.translation.vector.as_slice(),
                &data.xpos()[*body],
                &format!("{what}: link {link}"),
            );
            let turn = pose.rotation.to_rotation_matrix();
            assert_same(
                turn.matrix().transpose().as_slice(),
                &data.xmat()[*body],
                &format!("{what}: link {link}"),
            );
            let com = pose * robot.links[link].body.com;
            assert_same(
                com.coords.as_slice(),
                &data.xipos()[*body],
                &format!("{what}: centre of mass of link {link}"),
            );
            let joint =
                data.model().jnt_dofadr().iter().position(|dof| *dof as usize == oracle.dofs[link]).unwrap();
            assert_same(
                kinematics.axis(link).as_slice(),
                &data.xaxis()[joint],
                &format!("{what}: axis {link}"),
            );
        }
        for side in 0..2 {
            let sole = oracle.sole(side, robot.feet[side].half_extents.z);
            assert_same(
                kinematics.sole(side).translation.vector.as_slice(),
                sole.coords.as_slice(),
                &format!("{what}: sole {side}"),
            );
        }
    });
}

#[test]
fn the_total_mass_and_the_centre_of_mass_are_those_of_mujoco() {
    on_random_poses("mass", |_, oracle, kinematics, what| {
        assert_same(kinematics.com().coords.as_slice(), &oracle.data.subtree_com()[oracle.base], what);
        let mass: f64 = oracle.data.model().body_mass().iter().sum();
        assert_same(&[kinematics.total_mass()], &[mass], what);
    });
}

#[test]
fn jacobians_of_the_soles_and_of_every_centre_of_mass_are_those_of_mujoco() {
    on_random_poses("jacobians", |robot, oracle, kinematics, what| {
        let mut jacobian = Matrix6xX::zeros(6 + robot.joints());
        let mut compare = |link: Option<usize>, point: Point3<f64>| {
            let body = link.map_or(oracle.base, |link| oracle.bodies[link]);
            kinematics.jacobian(link, &point, &mut jacobian);
            assert_same(
                jacobian.as_slice(),
                oracle.jacobian(body, &point).as_slice(),
                &format!("{what}: {link:?} at {point}"),
            );
        };
        compare(None, kinematics.base() * robot.base.com);
        for link in 0..robot.joints() {
            compare(Some(link), kinematics.pose(link) * robot.links[link].body.com);
        }
        for side in 0..2 {
            compare(Some(kinematics.foot_link(side)), Point3::from(kinematics.sole(side).translation.vector));
        }
    });
}

#[test]
fn the_gravity_vector_is_that_of_mujoco() {
    on_random_poses("gravity", |robot, oracle, kinematics, what| {
        let mut gravity = DVector::zeros(6 + robot.joints());
        kinematics.gravity(&mut gravity);
        assert_same(gravity.as_slice(), oracle.gravity().as_slice(), what);
    });
}

#[test]
fn the_mass_matrix_with_its_rotors_is_that_of_mujoco() {
    on_random_poses("mass_matrix", |_, oracle, kinematics, what| {
        assert_same(kinematics.mass_matrix().as_slice(), oracle.mass_matrix().as_slice(), what);
    });
}

#[test]
fn a_rotor_stands_on_the_diagonal_of_both_mass_matrices_and_nowhere_else() {
    for mut robot in robots() {
        let (base, position) = pose(&robot, &mut Stream::new("test/dynamics/rotors"));
        let mut with_rotors = |extra: f64| {
            robot.links.iter_mut().for_each(|link| link.joint.armature += extra);
            let (mut oracle, mut kinematics) = (Oracle::new(&robot), Kinematics::new(&robot));
            oracle.place(&base, &position);
            kinematics.place(&base, &position);
            [kinematics.mass_matrix(), oracle.mass_matrix()]
        };
        let (before, after) = (with_rotors(0.0), with_rotors(0.75));
        for (before, after) in before.into_iter().zip(after) {
            let mut expected = before;
            (6..expected.nrows()).for_each(|joint| expected[(joint, joint)] += 0.75);
            assert_same(expected.as_slice(), after.as_slice(), &robot.name);
        }
    }
}

/// A robot whose motors deliver any torque, without what would hold it still by itself.
fn free(robot: &Robot) -> Robot {
    let mut free = robot.clone();
    for link in &mut free.links {
        (link.joint.effort_limit, link.joint.friction, link.joint.damping) = (1e6, 0.0, 0.0);
    }
    free
}

/// A wrench about the centre of a sole as MuJoCo takes it: force and moment about the body's centre of mass.
fn about_the_com(wrench: &Vector6<f64>, sole: &Vector3<f64>, com: &[f64; 3]) -> [f64; 6] {
    let (force, moment) = (wrench.fixed_rows::<3>(0), wrench.fixed_rows::<3>(3));
    let moment = moment + (sole - Vector3::from(*com)).cross(&force);
    [force.x, force.y, force.z, moment.x, moment.y, moment.z]
}

#[test]
fn with_the_torques_and_wrenches_of_gravity_compensation_no_force_is_left_in_mujoco() {
    for robot in robots() {
        let robot = free(&robot);
        let mut stream = Stream::new(&format!("test/dynamics/balance/{}", robot.name));
        let mut oracle = Oracle::new(&robot);
        for (number, weighting) in
            (0..POSES).flat_map(|n| [(n, Weighting::Uniform), (n, Weighting::EffortLimits)])
        {
            let (base, position) = pose(&robot, &mut stream);
            for contact in [[true, false], [false, true], [true, true]] {
                let mut compensation = GravityCompensation::new(&robot, weighting);
                let balance = compensation.hold(&base, &position, contact).clone();
                oracle.place(&base, &position);
                let weight = oracle.gravity().amax();
                for side in 0..2 {
                    let kinematics = compensation.kinematics();
                    let sole = kinematics.sole(side).translation.vector;
                    let body = oracle.bodies[kinematics.foot_link(side)];
                    let applied = about_the_com(&balance.wrench[side], &sole, &oracle.data.xipos()[body]);
                    oracle.data.xfrc_applied_mut()[body] = applied;
                }
                oracle.data.ctrl_mut().copy_from_slice(&balance.torque);
                oracle.data.forward();
                let scale =
                    weight.max(balance.torque.iter().fold(0.0, |most: f64, torque| most.max(torque.abs())));
                let left =
                    oracle.data.qfrc_smooth().iter().fold(0.0, |most: f64, force| most.max(force.abs()));
                assert!(
                    left < EXACT * scale,
                    "{} in pose {number}, contacts {contact:?}, {weighting:?}: {left:e} N of {scale} N are \
                     left",
                    robot.name
                );
            }
        }
    }
}

#[test]
fn in_flight_the_whole_weight_is_left() {
    let robot = free(&robots()[0]);
    let (base, position) = pose(&robot, &mut Stream::new("test/dynamics/flight"));
    let mut oracle = Oracle::new(&robot);
    oracle.place(&base, &position);
    let mut compensation = GravityCompensation::new(&robot, Weighting::Uniform);
    oracle.data.ctrl_mut().copy_from_slice(&compensation.hold(&base, &position, [false, false]).torque);
    oracle.data.forward();
    let left = oracle.data.qfrc_smooth()[2];
    assert_same(&[left], &[-robot.total_mass() * robot::GRAVITY], "vertical force on the base");
}
