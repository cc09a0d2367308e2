use nalgebra::{Matrix6xX, Translation3, Vector6};

use super::*;
use crate::kinds::motion::{self, Motion};
use crate::learn::pretrain::specs;
use crate::robot::kinematics::rotation_about;
use crate::spec::{Section, Value};
use crate::stream::Stream;

const ROBOTS: [(&str, &str); 3] = [("tocabi", "walk"), ("atlas", "walk"), ("g1", "walk_g1")];

/// A robot, its walk and its balance with some keys changed.
fn setting((robot, walk): (&str, &str), soles: f64, changed: &[(&str, f64)]) -> (Robot, Motion, Balance) {
    let robot = crate::robot::shipped(robot).unwrap();
    let walk = motion::shipped(walk, &robot).unwrap().unwrap();
    let Value::Table(mut keys) = specs::balance() else { unreachable!("the keys are a table") };
    keys.extend(changed.iter().map(|(key, number)| ((*key).to_owned(), specs::number(*number))));
    let balance = Balance::new(&Section::new(&keys).read(), &robot, soles);
    (robot, walk, balance)
}

fn at(walk: &Motion, phase: f64) -> Frame {
    let mut frame = Frame::default();
    walk.at(phase, &mut frame);
    frame
}

fn leaning(roll: f64, pitch: f64, yaw: f64) -> Isometry3<f64> {
    let turn = rotation_about(&Vector3::z(), yaw)
        * rotation_about(&Vector3::y(), pitch)
        * rotation_about(&Vector3::x(), roll);
    Isometry3::from_parts(Translation3::identity(), turn)
}

/// A state near the reference.
fn about(frame: &Frame, stream: &mut Stream) -> (Isometry3<f64>, f64, Vec<f64>, Vec<f64>) {
    let yaw = 0.5 * stream.normal();
    let base = leaning(0.06 * stream.normal(), 0.06 * stream.normal(), yaw);
    let position = frame.position.iter().map(|centre| centre + 0.1 * stream.normal()).collect();
    let swing = frame.position.iter().map(|_| 0.5 * stream.normal()).collect();
    (base, yaw, position, swing)
}

#[test]
fn on_the_reference_the_push_is_the_references_in_every_heading() {
    for robot in ROBOTS {
        let (_, walk, mut balance) = setting(robot, 100.0, &[]);
        for (phase, yaw) in [(0.0, 0.0), (0.1, 0.4), (0.25, -1.0), (0.5, 3.0), (0.8, 0.4), (0.95, 2.0)] {
            let frame = at(&walk, phase);
            let still = vec![0.0; frame.position.len()];
            let drawn = Drawn { base: leaning(0.0, 0.0, yaw), yaw, position: &frame.position, swing: &still };
            let push = balance.push(&drawn, &frame);
            let [x, y, _] = frame.base_acceleration;
            let [ahead, aside] = push.acceleration;
            let (sin, cos) = libm::sincos(yaw);
            assert!((ahead - (cos * x - sin * y)).abs() < 1e-6, "{robot:?} at {phase}: {ahead}");
            assert!((aside - (sin * x + cos * y)).abs() < 1e-6, "{robot:?} at {phase}: {aside}");
            assert!(push.moment.norm() < 1e-4);
        }
    }
}

#[test]
fn the_spring_and_the_damper_act_on_the_centre_of_mass_over_feet_that_rest() {
    let mut stream = Stream::new("test/balance/spring");
    for robot in ROBOTS {
        let (model, walk, mut balance) =
            setting(robot, 1e3, &[("stiffness", 0.7), ("damping", 1.3), ("upright", 0.0)]);
        let mut kinematics = Kinematics::new(&model);
        for phase in [0.2, 0.3, 0.7, 0.85] {
            let frame = at(&walk, phase);
            let foot = usize::from(frame.contact == [false, true]);
            assert_ne!(frame.contact, [true, true]);
            let (base, yaw, position, swing) = about(&frame, &mut stream);
            let push = balance.push(&Drawn { base, yaw, position: &position, swing: &swing }, &frame);
            // The motion of the base that follows from a resting foot by the foot's Jacobian, and the centre
            // of mass a moment later.
            let from_foot =
                |kinematics: &Kinematics| kinematics.com() - kinematics.sole(foot).translation.vector;
            kinematics.place(&leaning(0.0, 0.0, yaw), &frame.position);
            let wanted = from_foot(&kinematics).coords;
            kinematics.place(&base, &position);
            let [offset, com] = [from_foot(&kinematics).coords, kinematics.com().coords];
            let mut jacobian = Matrix6xX::zeros(18);
            let sole = kinematics.sole(foot).translation.vector.into();
            kinematics.jacobian(Some(kinematics.foot_link(foot)), &sole, &mut jacobian);
            let joints: Vector6<f64> = (0..12).map(|joint| jacobian.column(6 + joint) * swing[joint]).sum();
            let twist = jacobian.fixed_columns::<6>(0).into_owned().lu().solve(&-joints).unwrap();
            let [linear, angular] = [0, 3].map(|row| Vector3::from(twist.fixed_rows::<3>(row)) * 1e-6);
            let later = Isometry3::from_parts(
                Translation3::from(base.translation.vector + linear),
                UnitQuaternion::from_scaled_axis(angular) * base.rotation,
            );
            let moved: Vec<f64> = position.iter().zip(&swing).map(|(q, swing)| q + 1e-6 * swing).collect();
            kinematics.place(&later, &moved);
            let velocity = (kinematics.com().coords - com) / 1e-6;
            let square = GRAVITY / wanted.z;
            let [x, y, _] = frame.base_acceleration;
            let reference = rotation_about(&Vector3::z(), yaw) * Vector3::new(x, y, 0.0);
            let expected =
                reference - (offset - wanted) * (0.7 * square) - velocity * (1.3 * libm::sqrt(square));
            let error = Vector2::from(push.acceleration) - expected.xy();
            assert!(error.norm() < 1e-3 * expected.norm(), "{robot:?} at {phase}: {error} of {expected}");
        }
    }
}

#[test]
fn a_tilted_base_is_turned_back() {
    let (robot, walk, mut balance) = setting(ROBOTS[1], 1e3, &[("upright", 0.4)]);
    let frame = at(&walk, 0.25);
    let still = vec![0.0; 12];
    let mut moment = |roll, pitch| {
        let drawn =
            Drawn { base: leaning(roll, pitch, 0.0), yaw: 0.0, position: &frame.position, swing: &still };
        balance.push(&drawn, &frame).moment
    };
    let mut kinematics = Kinematics::new(&robot);
    kinematics.place(&Isometry3::identity(), &frame.position);
    let foot = usize::from(frame.contact == [false, true]);
    let height = kinematics.com().z - kinematics.sole(foot).translation.z;
    let stiffness = 0.4 * kinematics.total_mass() * GRAVITY * height;
    assert!((moment(0.05, 0.0) - Vector3::new(-0.05 * stiffness, 0.0, 0.0)).norm() < 1e-6 * stiffness);
    assert!((moment(0.0, -0.03) - Vector3::new(0.0, 0.03 * stiffness, 0.0)).norm() < 1e-6 * stiffness);
}

#[test]
fn the_centre_of_pressure_stays_on_the_soles_in_contact() {
    let mut stream = Stream::new("test/balance/pressure");
    for name in ROBOTS {
        let (robot, walk, mut balance) = setting(name, 0.8, &[]);
        let mut kinematics = Kinematics::new(&robot);
        let (mut inside, mut at_the_edge) = (0, 0);
        for sample in 0..300 {
            let frame = at(&walk, f64::from(sample) / 300.0);
            let (base, yaw, position, swing) = about(&frame, &mut stream);
            let push = balance.push(&Drawn { base, yaw, position: &position, swing: &swing }, &frame);
            kinematics.place(&leaning(0.0, 0.0, yaw), &frame.position);
            let height = |kinematics: &Kinematics| offset(kinematics, frame.contact).z;
            let square = GRAVITY / height(&kinematics);
            kinematics.place(&base, &position);
            let lean = Vector2::new(push.moment.y, -push.moment.x) / (kinematics.total_mass() * GRAVITY);
            let pressure = kinematics.com().coords.xy() - lean - Vector2::from(push.acceleration) / square;
            let along = |point: Vector2<f64>| (rotation_about(&Vector3::z(), -yaw) * point.push(0.0)).xy();
            let off = (0..2).filter(|side| frame.contact[*side]).map(|side| {
                let reach = 0.8 * robot.feet[side].half_extents.xy();
                let centre = along(kinematics.sole(side).translation.vector.xy());
                [centre - reach, centre + reach]
            });
            let [low, high] =
                off.reduce(|one, other| [one[0].inf(&other[0]), one[1].sup(&other[1])]).unwrap();
            let along = along(pressure);
            let within = (along - low).min().min((high - along).min());
            assert!(within > -1e-9, "{name:?}, sample {sample}: {within} m beyond the soles");
            if within < 1e-9 { at_the_edge += 1 } else { inside += 1 }
        }
        assert!(inside > 20 && at_the_edge > 20, "{name:?}: {inside} inside, {at_the_edge} at the edge");
    }
}
