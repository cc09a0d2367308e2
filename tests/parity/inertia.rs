//! Masses, inertias, axes and gravity as the engines have them, from the velocities that one small step
//! gives.
//!
//! Three doctored copies make the engines' own figures visible: a statue (no joint can move) shows mass and
//! centre of mass, a robot with an anchored base shows the joints' block of the mass matrix and the gravity
//! torques.

use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector3};
use specforge::robot::{Kinematics, Robot};
use specforge::sim::{Engine, State};
use specforge::stream::Stream;

use super::lab::{
    Load, acceleration, anchored, bare, each, kinematics, largest, modelled, random_pose, response, standing,
    statue, weight,
};
use super::table::{Row, within};

/// Share of a joint's effort limit that a pulse has.
const PULSE: f64 = 0.3;

/// All quantities of a robot.
pub fn rows(robot: &Robot) -> Vec<Row> {
    vec![
        total_mass(robot),
        centre_of_mass(robot),
        mass_matrix_diagonal(robot),
        armature(robot),
        gravity_torques(robot),
        forward_dynamics(robot),
        joint_axes(robot),
    ]
}

/// Mass in kg and centre of mass in m of a statue in the default pose, from three pushes at the base.
fn rigid(engine: &dyn Engine, robot: &Robot) -> (f64, Vector3<f64>) {
    let (statue, pose, push) = (statue(robot), standing(robot, 2.0), weight(robot));
    // The base origin accelerates with F / m + alpha x (origin - com): nine equations for F / m and the
    // lever.
    let mut system = SMatrix::<f64, 9, 4>::zeros();
    let mut motion = SVector::<f64, 9>::zeros();
    for axis in 0..3 {
        let mut load = Load::none(robot);
        load.push[axis] = push;
        let response = response(engine, &statue, &pose, &load);
        let turn = Vector3::new(response[3], response[4], response[5]);
        system[(3 * axis + axis, 0)] = 1.0;
        system.fixed_view_mut::<3, 3>(3 * axis, 1).copy_from(&turn.cross_matrix());
        motion.fixed_rows_mut::<3>(3 * axis).copy_from(&response.fixed_rows::<3>(0));
    }
    let normal = system.transpose() * system;
    let found =
        normal.cholesky().expect("three pushes tell everything").solve(&(system.transpose() * motion));
    let lever = Vector3::new(found[1], found[2], found[3]);
    (push / found[0], Vector3::from(pose.base_position) - lever)
}

/// Total mass from the pushes.
fn total_mass(robot: &Robot) -> Row {
    let mass = robot.total_mass();
    let figures = each(|engine| rigid(engine, robot).0 / mass - 1.0);
    Row::deviation("total mass", format!("{mass:.3} kg"), "relative", within(3e-6, figures))
}

/// Centre of mass in the default pose from the pushes.
fn centre_of_mass(robot: &Robot) -> Row {
    let expected = kinematics(robot, &standing(robot, 2.0)).com().coords;
    let figures = each(|engine| 1e3 * (rigid(engine, robot).1 - expected).norm());
    let base = expected - Vector3::new(0.0, 0.0, robot.standing_height + 2.0);
    let shown = format!("({:.4}, {:.4}, {:.4}) m from the base", base.x, base.y, base.z);
    Row::deviation("centre of mass", shown, "mm", within(1e-3, figures))
}

/// The joints' block of the mass matrix, measured: the inverse of the accelerations to unit torques at an
/// anchored base.
fn joint_inertia(engine: &dyn Engine, anchored: &Robot, pose: &State) -> DMatrix<f64> {
    let joints = anchored.joints();
    let mut mobility = DMatrix::zeros(joints, joints);
    for joint in 0..joints {
        let torque = PULSE * anchored.links[joint].joint.effort_limit;
        let response = response(engine, anchored, pose, &Load::at(anchored, joint, torque));
        mobility.set_column(joint, &(response.rows(6, joints) / torque));
    }
    mobility.try_inverse().expect("every torque moves its joint")
}

/// The diagonal of the mass matrix in the default pose.
fn mass_matrix_diagonal(robot: &Robot) -> Row {
    let expected = Kinematics::new(robot).mass_matrix().diagonal().rows(6, robot.joints()).clone_owned();
    let (anchored, pose) = (anchored(robot), standing(robot, 2.0));
    let figures = each(|engine| {
        let measured = joint_inertia(engine, &anchored, &pose).diagonal();
        largest(measured.component_div(&expected).add_scalar(-1.0).iter())
    });
    let shown = format!("{:.4} to {:.3} kg m^2", expected.min(), expected.max());
    Row::deviation("diagonal of the mass matrix, joints", shown, "relative", within(1e-5, figures))
}

/// What another 0.5 kg m^2 of armature on every joint adds to the diagonal.
fn armature(robot: &Robot) -> Row {
    let pose = standing(robot, 2.0);
    let before = anchored(robot);
    let mut after = before.clone();
    after.links.iter_mut().for_each(|link| link.joint.armature += 0.5);
    let figures = each(|engine| {
        let [before, after] = [&before, &after].map(|robot| joint_inertia(engine, robot, &pose).diagonal());
        largest((after - before).add_scalar(-0.5).iter()) / 0.5
    });
    Row::deviation("armature of 0.5 kg m^2 on every joint", "+0.5 kg m^2", "relative", within(1e-5, figures))
}

/// Gravity torques in random poses with the base held by a push of the whole weight.
fn gravity_torques(robot: &Robot) -> Row {
    let (anchored, mut stream) = (anchored(robot), Stream::new("parity/gravity"));
    let mut load = Load::none(robot);
    load.push[2] = weight(&anchored);
    let poses: Vec<State> = (0..4).map(|_| random_pose(robot, &mut stream)).collect();
    let mut most: f64 = 0.0;
    let expected: Vec<DVector<f64>> = poses
        .iter()
        .map(|pose| {
            let kinematics = kinematics(robot, pose);
            DVector::from_fn(robot.joints(), |joint, _| kinematics.gravity_torque(joint))
        })
        .inspect(|torques| most = most.max(torques.amax()))
        .collect();
    let figures = each(|engine| {
        let errors = poses.iter().zip(&expected).map(|(pose, expected)| {
            let fall = acceleration(engine, &anchored, pose, &load).rows(6, robot.joints()).clone_owned();
            (joint_inertia(engine, &anchored, pose) * fall + expected).amax() / most
        });
        errors.fold(0.0, f64::max)
    });
    Row::deviation(
        "gravity torques, 4 random poses",
        format!("up to {most:.1} N m"),
        "relative",
        within(1e-5, figures),
    )
}

/// Accelerations of the floating robot under random torques and a random push, as a share of the kinetic
/// energy's norm.
fn forward_dynamics(robot: &Robot) -> Row {
    let (bare, mut stream) = (bare(robot), Stream::new("parity/dynamics"));
    let trials: Vec<(State, Load)> = (0..10)
        .map(|_| {
            let pose = random_pose(robot, &mut stream);
            let torque =
                robot.effort_limits().iter().map(|limit| limit * (2.0 * stream.uniform() - 1.0)).collect();
            (pose, Load { torque, push: [(); 3].map(|()| 0.3 * weight(robot) * stream.normal()) })
        })
        .collect();
    let figures = each(|engine| {
        let errors = trials.iter().map(|(pose, load)| {
            let mass = kinematics(&bare, pose).mass_matrix();
            let norm = |motion: &DVector<f64>| motion.dot(&(&mass * motion)).sqrt();
            let expected = modelled(&bare, pose, load);
            norm(&(acceleration(engine, &bare, pose, load) - &expected)) / norm(&expected)
        });
        errors.fold(0.0, f64::max)
    });
    Row::deviation(
        "accelerations under random torques and a push, 10 random poses",
        "M^-1 (tau + J^T f - g)",
        "relative",
        within(2e-4, figures),
    )
}

/// Axes and signs: a torque on one joint turns that joint forward and the base about the axis that the model
/// says.
fn joint_axes(robot: &Robot) -> Row {
    let (bare, pose) = (bare(robot), standing(robot, 2.0));
    let angle = |engine: &dyn Engine, joint: usize| {
        let load = Load::at(&bare, joint, PULSE * bare.links[joint].joint.effort_limit);
        let rest = modelled(&bare, &pose, &Load::none(&bare));
        let [is, should] = [response(engine, &bare, &pose, &load), modelled(&bare, &pose, &load) - rest];
        let [one, other] = [&is, &should].map(|motion| Vector3::new(motion[3], motion[4], motion[5]));
        let forward = if is[6 + joint] > 0.0 { 0.0 } else { std::f64::consts::PI };
        forward + libm::atan2(one.cross(&other).norm(), one.dot(&other))
    };
    let figures = each(|engine| (0..robot.joints()).map(|joint| angle(engine, joint)).fold(0.0, f64::max));
    Row::deviation(
        "axes and signs of the joints, by the turn of the base",
        "the model's",
        "rad",
        within(3e-4, figures),
    )
}
