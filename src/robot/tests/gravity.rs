use nalgebra::{DVector, Isometry3, Matrix6xX, Vector3, Vector6};

use super::robot;
use crate::robot::kinematics::rotation_about;
use crate::robot::{Balance, GravityCompensation, Kinematics, Robot, Weighting, felt_gravity};
use crate::stream::Stream;

/// Entries of `g - S^T tau - sum J^T f`, from the Jacobians: six of the base, then the joints.
fn rest(robot: &Robot, pose: (&Isometry3<f64>, &[f64]), balance: &Balance) -> DVector<f64> {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(pose.0, pose.1);
    let size = 6 + robot.joints();
    let mut rest = DVector::zeros(size);
    kinematics.gravity(&mut rest);
    let mut jacobian = Matrix6xX::zeros(size);
    for (side, wrench) in balance.wrench.iter().enumerate() {
        let point = kinematics.sole(side).translation.vector.into();
        kinematics.jacobian(Some(kinematics.foot_link(side)), &point, &mut jacobian);
        rest -= jacobian.transpose() * wrench;
    }
    for joint in 0..robot.joints() {
        rest[6 + joint] -= balance.torque[joint];
    }
    rest
}

/// A pose near the default one, with an inclined base.
fn leaning(robot: &Robot, stream: &mut Stream) -> (Isometry3<f64>, Vec<f64>) {
    let pose = robot.default_pose().iter().map(|q| q + 0.3 * stream.normal()).collect();
    let lean = rotation_about(&Vector3::x(), 0.1 * stream.normal())
        * rotation_about(&Vector3::y(), 0.1 * stream.normal());
    (Isometry3::from_parts(nalgebra::Translation3::new(3.0, -1.0, 0.9), lean), pose)
}

#[test]
fn the_torques_and_wrenches_balance_the_weight_in_every_contact_state() {
    let mut stream = Stream::new("test/gravity");
    for name in ["tocabi", "atlas", "g1"] {
        let robot = robot(name);
        for _ in 0..20 {
            let (base, pose) = leaning(&robot, &mut stream);
            for contact in [[true, false], [false, true], [true, true]] {
                for weighting in [Weighting::Uniform, Weighting::EffortLimits] {
                    let balance =
                        GravityCompensation::new(&robot, weighting).hold(&base, &pose, contact).clone();
                    let untouched = |side: usize| contact[side] || balance.wrench[side].norm() == 0.0;
                    assert!(untouched(0) && untouched(1));
                    let residual = rest(&robot, (&base, &pose), &balance).amax();
                    assert!(residual < 1e-9, "{name} {contact:?} {weighting:?}: {residual:e}");
                }
            }
        }
    }
}

#[test]
fn pressure_kept_within_the_soles_leaves_the_joints_in_balance_and_lets_the_base_tip() {
    let mut stream = Stream::new("test/gravity/pressure");
    for name in ["tocabi", "atlas", "g1"] {
        let robot = robot(name);
        let mut tipping = 0;
        for _ in 0..20 {
            let (base, pose) = leaning(&robot, &mut stream);
            for contact in [[true, false], [false, true], [true, true]] {
                let mut compensation = GravityCompensation::new(&robot, Weighting::EffortLimits);
                let held = compensation.hold(&base, &pose, contact).clone();
                let kept = compensation.keep_pressure_within(0.8).clone();
                for side in 0..2 {
                    let sole = compensation.kinematics().sole(side).rotation;
                    let [force, moment] = [0, 3]
                        .map(|row| sole.inverse() * Vector3::from(kept.wrench[side].fixed_rows::<3>(row)));
                    let reach =
                        robot.feet[side].half_extents * 0.8 * force.z.max(0.0) + Vector3::repeat(1e-9);
                    assert!(
                        force.z < 0.0 || (moment.y.abs() <= reach.x && moment.x.abs() <= reach.y),
                        "{name}: {moment}"
                    );
                    let force_of = |wrench: &Vector6<f64>| Vector3::from(wrench.fixed_rows::<3>(0));
                    assert_eq!(force_of(&kept.wrench[side]), force_of(&held.wrench[side]));
                }
                let rest = rest(&robot, (&base, &pose), &kept);
                assert!(rest.rows(6, 12).amax() < 1e-9, "{name} {contact:?}");
                assert!(rest.rows(0, 3).amax() < 1e-9);
                tipping += usize::from(rest.rows(3, 3).amax() > 1.0);
                if kept == held {
                    assert!(rest.amax() < 1e-9);
                }
            }
        }
        assert!(tipping > 10, "{name}: the base tips in {tipping} poses");
    }
}

#[test]
fn a_moment_on_top_is_all_that_is_missing_from_rest() {
    let mut stream = Stream::new("test/gravity/moment");
    for name in ["tocabi", "atlas", "g1"] {
        let robot = robot(name);
        for _ in 0..20 {
            let (base, pose) = leaning(&robot, &mut stream);
            let moment = Vector3::from_fn(|_, _| 50.0 * stream.normal());
            for contact in [[true, false], [false, true], [true, true]] {
                let mut compensation = GravityCompensation::new(&robot, Weighting::EffortLimits);
                let balance = compensation.hold_turning(&base, &pose, contact, &moment).clone();
                let mut missing = rest(&robot, (&base, &pose), &balance);
                (0..3).for_each(|axis| missing[3 + axis] += moment[axis]);
                assert!(missing.amax() < 1e-9, "{name} {contact:?}: {:e}", missing.amax());
            }
        }
    }
}

#[test]
fn in_felt_gravity_the_torques_and_wrenches_accelerate_every_link_alike() {
    let mut stream = Stream::new("test/gravity/felt");
    for name in ["tocabi", "atlas", "g1"] {
        let robot = robot(name);
        for _ in 0..20 {
            let (base, pose) = leaning(&robot, &mut stream);
            let horizontal = [2.0 * stream.normal(), 2.0 * stream.normal()];
            let (upright, load) = felt_gravity(horizontal);
            for contact in [[true, false], [false, true], [true, true]] {
                let mut compensation = GravityCompensation::new(&robot, Weighting::EffortLimits);
                let mut balance = compensation.hold(&(upright * base), &pose, contact).clone();
                balance.torque.iter_mut().for_each(|torque| *torque *= load);
                for wrench in &mut balance.wrench {
                    let [force, moment] =
                        [0, 3].map(|row| upright.inverse() * Vector3::from(wrench.fixed_rows::<3>(row)));
                    *wrench = load * Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
                }
                let mut kinematics = Kinematics::new(&robot);
                kinematics.place(&base, &pose);
                let mut acceleration = DVector::zeros(18);
                acceleration.rows_mut(0, 2).copy_from_slice(&horizontal);
                let left = rest(&robot, (&base, &pose), &balance) + kinematics.mass_matrix() * acceleration;
                assert!(left.amax() < 1e-9, "{name} {contact:?}: {:e}", left.amax());
            }
        }
    }
}

#[test]
fn in_flight_nothing_is_compensated() {
    let robot = robot("tocabi");
    let mut compensation = GravityCompensation::new(&robot, Weighting::EffortLimits);
    let balance = compensation.hold(&Isometry3::identity(), &robot.default_pose(), [false, false]);
    assert_eq!(balance.torque, [0.0; 12]);
}

/// Torques of TOCABI in its default pose.
fn default_torque(contact: [bool; 2], weighting: Weighting) -> Vec<f64> {
    let robot = robot("tocabi");
    GravityCompensation::new(&robot, weighting)
        .hold(&Isometry3::identity(), &robot.default_pose(), contact)
        .torque
        .clone()
}

#[test]
fn standing_on_both_feet_takes_the_torques_of_the_prototype() {
    // Hip pitch -15.1, knee -46.6, ankle pitch 6.5 N m. In the symmetric pose the sagittal torques do not
    // depend on the weighting: an asymmetric distribution would change them, but is never better.
    for weighting in [Weighting::Uniform, Weighting::EffortLimits] {
        let torque = default_torque([true, true], weighting);
        for leg in 0..2 {
            for (joint, expected) in (2..5).zip([-15.1, -46.6, 6.5]) {
                let value = torque[6 * leg + joint];
                assert!((value - expected).abs() < 0.4, "{weighting:?} joint {joint} of leg {leg}: {value}");
            }
        }
    }
}

#[test]
fn single_support_in_the_symmetric_pose_carries_the_weight_at_half_the_hip_width() {
    // Ankle roll torque: the weight above the ankle times its lever arm, about 0.1025 m.
    let robot = robot("tocabi");
    let kinematics = Kinematics::new(&robot);
    let foot = &robot.links[5].body;
    let above = robot.total_mass() - foot.mass;
    let ankle = kinematics.pose(5).translation.vector;
    let total =
        kinematics.com().coords * robot.total_mass() - (kinematics.pose(5) * foot.com).coords * foot.mass;
    let lever = total / above - ankle;
    let torque = default_torque([true, false], Weighting::EffortLimits);
    assert!((torque[5] + above * 9.81 * lever.y).abs() < 1e-9, "{torque:?}");
    assert!((lever.y + 0.1025).abs() < 0.01 && torque[5] > 90.0);
    assert!((torque[3] + 104.4).abs() < 0.1, "{torque:?}");
}

#[test]
fn the_share_between_the_feet_is_the_cheapest_one() {
    // Moving any internal wrench from one foot to the other must not lower the cost.
    let robot = robot("tocabi");
    let pose: Vec<f64> = robot.default_pose().iter().enumerate().map(|(i, q)| q + 0.02 * i as f64).collect();
    let mut compensation = GravityCompensation::new(&robot, Weighting::Uniform);
    let torque = compensation.hold(&Isometry3::identity(), &pose, [true, true]).torque.clone();
    let mut kinematics = Kinematics::new(&robot);
    kinematics.place(&Isometry3::identity(), &pose);
    let origin = nalgebra::Point3::origin();
    let mut jacobians = [Matrix6xX::zeros(18), Matrix6xX::zeros(18)];
    for (side, jacobian) in jacobians.iter_mut().enumerate() {
        kinematics.jacobian(Some(kinematics.foot_link(side)), &origin, jacobian);
    }
    let internal = jacobians[0].transpose() - jacobians[1].transpose();
    for axis in 0..6 {
        let direction = internal.column(axis).rows(6, 12).clone_owned();
        let slope: f64 = torque.iter().zip(direction.iter()).map(|(torque, change)| torque * change).sum();
        assert!(slope.abs() < 1e-6, "axis {axis}: {slope}");
    }
}

#[test]
fn soles_at_one_height_are_both_taken_as_contacts() {
    let robot = robot("tocabi");
    let mut compensation = GravityCompensation::new(&robot, Weighting::EffortLimits);
    let both = compensation.hold_by_height(&Isometry3::identity(), &robot.default_pose(), 0.02).clone();
    assert!(both.wrench.iter().all(|wrench| (wrench[2] - 512.5).abs() < 15.0), "{both:?}");
    let mut lifted = robot.default_pose();
    (lifted[2], lifted[3], lifted[4]) = (-0.54, 1.2, -0.66);
    let right = compensation.hold_by_height(&Isometry3::identity(), &lifted, 0.02);
    assert_eq!(right.wrench[0].norm(), 0.0);
}

/// The robot with these joints fixed at zero; the bodies that they moved become massless.
fn without(robot: &Robot, words: &[&str]) -> Robot {
    let mut robot = robot.clone();
    while let Some(gone) = robot
        .links
        .iter()
        .position(|link| words.iter().any(|word| link.joint.name.to_lowercase().contains(word)))
    {
        let link = robot.links.remove(gone);
        let renumbered = |index: usize| index - usize::from(index > gone);
        for child in &mut robot.links {
            if child.parent == Some(gone) {
                child.parent = link.parent;
                child.joint.origin = link.joint.origin * child.joint.origin;
            }
            child.parent = child.parent.map(renumbered);
        }
        for foot in &mut robot.feet {
            if foot.link == gone {
                foot.link = link.parent.expect("a foot hangs from a leg");
                foot.centre = link.joint.origin * foot.centre;
            }
            foot.link = renumbered(foot.link);
        }
        robot.mirror.remove(gone);
        robot.mirror.iter_mut().for_each(|(index, _)| *index -= usize::from(*index > gone));
    }
    robot
}

/// Legs without ankle roll (Unitree's H1) and legs with only pitch joints: tiny torque savings must not
/// decide how hard the feet push against each other.
#[test]
fn feet_of_legs_with_few_joints_do_not_push_against_each_other_and_small_changes_have_small_effects() {
    let mut stream = Stream::new("test/gravity/few");
    for (name, words) in [("tocabi", &["ankleroll"][..]), ("tocabi", &["ankleroll", "hipyaw", "hiproll"])] {
        let full = robot(name);
        let robot = without(&full, words);
        assert_eq!(full.joints() - robot.joints(), 2 * words.len(), "{words:?}");
        let weight = Kinematics::new(&robot).total_mass() * crate::robot::GRAVITY;
        let mut gravity = GravityCompensation::new(&robot, Weighting::EffortLimits);
        for sample in 0..50 {
            let width = [0.0, 1e-6, 0.03, 0.1, 0.2][sample % 5];
            let pose: Vec<f64> = robot.default_pose().iter().map(|q| q + width * stream.normal()).collect();
            let base = Isometry3::identity();
            let held = gravity.hold(&base, &pose, [true, true]).clone();
            let residual = rest(&robot, (&base, &pose), &held).amax();
            assert!(residual < 1e-9, "{words:?} {width}: {residual:e}");
            for wrench in held.wrench {
                let lateral = wrench[0].hypot(wrench[1]);
                assert!(lateral < weight && wrench[2].abs() < 1.5 * weight, "{words:?} {width}: {wrench}");
            }
            let moved: Vec<f64> = pose.iter().map(|q| q + 1e-7 * stream.normal()).collect();
            let other = gravity.hold(&base, &moved, [true, true]);
            let change =
                held.torque.iter().zip(&other.torque).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(change < 1e-2, "{words:?} {width}: {change} N m for 1e-7 rad");
        }
    }
}
