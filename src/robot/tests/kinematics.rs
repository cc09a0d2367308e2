use nalgebra::{DVector, Isometry3, Matrix6xX, Translation3, Vector3};

use super::robot;
use crate::robot::kinematics::{GRAVITY, Kinematics, rotation_about};
use crate::stream::Stream;

/// A tilted, displaced base and a random pose within the limits.
fn random_pose(robot: &crate::robot::Robot, stream: &mut Stream) -> (Isometry3<f64>, Vec<f64>) {
    let turn =
        rotation_about(&Vector3::x(), 0.3 * stream.normal()) * rotation_about(&Vector3::z(), stream.normal());
    let base = Isometry3::from_parts(Translation3::new(0.4, -0.2, 0.9), turn);
    let joints = robot.links.iter().map(|link| {
        let joint = &link.joint;
        joint.lower + (joint.upper - joint.lower) * stream.uniform()
    });
    (base, joints.collect())
}

/// The pose after an infinitesimal generalised displacement.
fn displaced(base: &Isometry3<f64>, position: &[f64], axis: usize, by: f64) -> (Isometry3<f64>, Vec<f64>) {
    let (mut base, mut position) = (*base, position.to_vec());
    match axis {
        0..3 => base.translation.vector[axis] += by,
        3..6 => base.rotation = rotation_about(&Vector3::ith(axis - 3, 1.0), by) * base.rotation,
        _ => position[axis - 6] += by,
    }
    (base, position)
}

#[test]
fn jacobians_agree_with_finite_differences() {
    let mut stream = Stream::new("test/jacobian");
    for name in ["tocabi", "atlas", "g1"] {
        let robot = robot(name);
        let mut kinematics = Kinematics::new(&robot);
        let (base, position) = random_pose(&robot, &mut stream);
        for side in 0..2 {
            kinematics.place(&base, &position);
            let link = kinematics.foot_link(side);
            let mut jacobian = Matrix6xX::zeros(18);
            let sole = kinematics.sole(side);
            kinematics.jacobian(Some(link), &sole.translation.vector.into(), &mut jacobian);
            for column in 0..18 {
                let step = 1e-6;
                let soles = [step, -step].map(|by| {
                    let (base, position) = displaced(&base, &position, column, by);
                    kinematics.place(&base, &position);
                    kinematics.sole(side)
                });
                let linear = (soles[0].translation.vector - soles[1].translation.vector) / (2.0 * step);
                let turn = (soles[0].rotation * soles[1].rotation.inverse()).imag() * 2.0 / (2.0 * step);
                for row in 0..3 {
                    assert!(
                        (jacobian[(row, column)] - linear[row]).abs() < 1e-8,
                        "{name} {side} {row} {column}"
                    );
                    assert!(
                        (jacobian[(3 + row, column)] - turn[row]).abs() < 1e-8,
                        "{name} {side} {row} {column}"
                    );
                }
            }
        }
    }
}

#[test]
fn gravity_is_the_slope_of_the_potential_energy() {
    let robot = robot("atlas");
    let mut kinematics = Kinematics::new(&robot);
    let (base, position) = random_pose(&robot, &mut Stream::new("test/potential"));
    kinematics.place(&base, &position);
    let mut gravity = DVector::zeros(18);
    kinematics.gravity(&mut gravity);
    for axis in 0..18 {
        let energies = [1e-6, -1e-6].map(|by| {
            let (base, position) = displaced(&base, &position, axis, by);
            kinematics.place(&base, &position);
            kinematics.com().z * robot.total_mass() * GRAVITY
        });
        assert!((gravity[axis] - (energies[0] - energies[1]) / 2e-6).abs() < 1e-6, "axis {axis}");
    }
}

#[test]
fn the_generalised_weight_is_the_robots_weight() {
    let robot = robot("tocabi");
    let mut gravity = DVector::zeros(18);
    Kinematics::new(&robot).gravity(&mut gravity);
    assert!((gravity[2] - 104.48712 * 9.81).abs() < 1e-9);
    assert!((gravity[2] - 1025.0).abs() < 0.05, "the authors' reference vertical force");
}

#[test]
fn the_mass_matrix_is_symmetric_and_positive_and_holds_the_total_mass() {
    let mut stream = Stream::new("test/mass");
    for name in ["tocabi", "atlas", "g1"] {
        let robot = robot(name);
        let mut kinematics = Kinematics::new(&robot);
        let (base, position) = random_pose(&robot, &mut stream);
        kinematics.place(&base, &position);
        let mass = kinematics.mass_matrix();
        assert!((&mass - mass.transpose()).abs().max() < 1e-10);
        assert!(mass.clone().cholesky().is_some());
        for axis in 0..3 {
            assert!((mass[(axis, axis)] - robot.total_mass()).abs() < 1e-9);
        }
        assert!(mass.diagonal().iter().zip(6..).take(12).all(|(value, _)| *value > 0.0));
    }
}

#[test]
fn the_kinetic_energy_of_a_turning_joint_is_that_of_its_inertia_about_the_axis() {
    // The right foot of Atlas about its roll axis x: ixx + m (y^2 + z^2) = 0.002 + 0.867 * 0.067^2.
    let robot = robot("atlas");
    let mass = Kinematics::new(&robot).mass_matrix();
    assert!((mass[(17, 17)] - (0.002 + 0.867 * 0.067 * 0.067)).abs() < 1e-12);
}
