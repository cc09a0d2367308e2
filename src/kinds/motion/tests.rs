//! Tests of the shipped motions on the shipped robots.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::{Motion, MotionError, embedded, kinds, load, names, shipped};
use crate::diag::{Sink, Sources};
use crate::robot::tests::robot;
use crate::robot::{Kinematics, Robot, leg_length, symmetry};
use crate::spec::Section;

const ROBOTS: [&str; 3] = ["tocabi", "atlas", "g1"];

fn motion(name: &str, robot: &Robot) -> Motion {
    let motion = shipped(name, robot).expect("a motion of this name, without mistakes");
    motion.unwrap_or_else(|error| panic!("{name} on {}: {error}", robot.name))
}

/// World from base at a sample, with the base at x = y = 0.
fn base(motion: &Motion, index: usize) -> Isometry3<f64> {
    let frame = &motion.samples[index];
    let [w, x, y, z] = frame.base_orientation;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::new(0.0, 0.0, frame.base_height), turn)
}

#[test]
fn every_motion_suits_every_robot_and_stays_within_its_limits() {
    for name in ROBOTS {
        let robot = robot(name);
        for motion_name in names() {
            let motion = motion(motion_name, &robot);
            assert_eq!(motion.name, motion_name);
            for frame in &motion.samples {
                for (link, &position) in robot.links.iter().zip(&frame.position) {
                    assert!(
                        (link.joint.lower..=link.joint.upper).contains(&position),
                        "{name} {motion_name}"
                    );
                }
                let numbers = frame.position.iter().chain(&frame.velocity).chain(&frame.acceleration);
                assert!(
                    numbers
                        .chain(&frame.base_velocity)
                        .chain(&frame.base_acceleration)
                        .all(|x| x.is_finite())
                );
            }
        }
    }
}

#[test]
fn closed_forms_are_their_own_mirror_image_half_a_cycle_later() {
    for name in ROBOTS {
        let robot = robot(name);
        for motion_name in ["walk", "run_gait", "run_gait_short_flight", "squat"] {
            let motion = motion(motion_name, &robot);
            let half = if motion_name == "squat" { 0 } else { motion.samples.len() / 2 };
            for (index, frame) in motion.samples.iter().enumerate() {
                let other = &motion.samples[(index + half) % motion.samples.len()];
                assert_eq!(
                    symmetry::mirrored(&robot.mirror, &frame.position),
                    other.position,
                    "{name} {motion_name}"
                );
                assert_eq!(symmetry::mirrored(&robot.mirror, &frame.velocity), other.velocity);
                assert_eq!(
                    [frame.contact[1], frame.contact[0]],
                    other.contact,
                    "{name} {motion_name} {index}"
                );
                assert!((frame.base_height - other.base_height).abs() < 1e-9);
                assert!((frame.base_velocity[1] + other.base_velocity[1]).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn rates_and_accelerations_are_the_derivatives_of_the_angles() {
    let robot = robot("tocabi");
    for name in names() {
        let motion = motion(name, &robot);
        let (count, step) = (motion.samples.len(), motion.period / motion.samples.len() as f64);
        for index in 0..count {
            let [before, here, after] =
                [count - 1, 0, 1].map(|offset| &motion.samples[(index + offset) % count]);
            for joint in 0..12 {
                let rate = (after.position[joint] - before.position[joint]) / (2.0 * step);
                assert!((here.velocity[joint] - rate).abs() < 0.04, "{name} {index} {joint}");
                let acceleration = (after.velocity[joint] - before.velocity[joint]) / (2.0 * step);
                // A clip's spline has kinks in its acceleration, a squat's cubic has jumps.
                let smooth = !matches!(name, "run_clip" | "squat");
                assert!(
                    !smooth || (here.acceleration[joint] - acceleration).abs() < 0.5,
                    "{name} {index} {joint}"
                );
            }
            let climb = (after.base_height - before.base_height) / (2.0 * step);
            assert!((here.base_velocity[2] - climb).abs() < 0.05, "{name} {index}");
        }
    }
}

/// Largest drift (m) of a sole's position from its mean over the stance phases, and largest height.
fn stance_drift(motion: &Motion, robot: &Robot) -> (f64, f64) {
    let mut kinematics = Kinematics::new(robot);
    let (count, step) = (motion.samples.len(), motion.period / motion.samples.len() as f64);
    let (mut drift, mut height) = (0.0f64, 0.0f64);
    let (mut way, mut planted) = (Vector3::<f64>::zeros(), [None::<Vector3<f64>>; 2]);
    for index in 0..2 * count {
        let frame = &motion.samples[index % count];
        let mut pose = base(motion, index % count);
        pose.translation.vector += Vector3::new(way.x, way.y, 0.0);
        kinematics.place(&pose, &frame.position);
        for (side, planted) in planted.iter_mut().enumerate() {
            let sole = kinematics.sole(side).translation.vector;
            if frame.contact[side] {
                let first = planted.get_or_insert(sole);
                drift = drift.max((sole.xy() - first.xy()).norm());
                height = height.max(sole.z.abs());
            } else {
                *planted = None;
            }
        }
        let after = &motion.samples[(index + 1) % count];
        for axis in 0..2 {
            way[axis] += 0.5 * step * (frame.base_velocity[axis] + after.base_velocity[axis]);
        }
    }
    (drift, height)
}

#[test]
fn planted_feet_stay_where_they_are() {
    for name in ROBOTS {
        let robot = robot(name);
        for (motion_name, limits) in
            [("walk", (1e-3, 1e-3)), ("squat", (1e-5, 1e-9)), ("run_gait", (4e-3, 1e-2))]
        {
            let (drift, height) = stance_drift(&motion(motion_name, &robot), &robot);
            println!("{name} {motion_name}: drift {drift:.5} height {height:.5}");
            assert!(drift < limits.0 && height < limits.1, "{name} {motion_name}: {drift} {height}");
        }
    }
}

#[test]
fn the_walk_has_its_published_steps() {
    let robot = robot("tocabi");
    let motion = motion("walk", &robot);
    assert!((motion.speed - 2.0 * 0.11227 / 1.8).abs() < 1e-12);
    let share = |contact: [bool; 2]| {
        motion.samples.iter().filter(|frame| frame.contact == contact).count() as f64
            / motion.samples.len() as f64
    };
    assert_eq!(share([false, true]), 1.0 / 3.0);
    assert_eq!(share([true, false]), 1.0 / 3.0);
    assert!(!motion.samples[180].contact[0] && motion.samples[180].contact[1], "the right foot stands first");
    // Mid-swing the left ankle is 0.052 m above the right one.
    let mut kinematics = Kinematics::new(&robot);
    kinematics.place(&Isometry3::identity(), &motion.samples[180].position);
    let lift = kinematics.pose(5).translation.z - kinematics.pose(11).translation.z;
    assert!((lift - 0.05197).abs() < 0.002, "{lift}");
}

#[test]
fn the_walk_agrees_with_the_figures_of_the_authors_cycle() {
    // Ranges of the authors' walking cycle over its samples, from the documents' summary: hip roll -0.081 to
    // 0.167, hip pitch -0.466 to -0.103, knee 0.508 to 0.938, ankle pitch -0.521 to -0.206 rad.
    let motion = motion("walk", &robot("tocabi"));
    for (joint, low, high) in
        [(1, -0.081, 0.167), (2, -0.466, -0.103), (3, 0.508, 0.938), (4, -0.521, -0.206)]
    {
        let angles = motion.samples.iter().map(|frame| frame.position[joint]);
        let (least, most) = (angles.clone().fold(f64::MAX, f64::min), angles.fold(f64::MIN, f64::max));
        println!("joint {joint}: {least:.3} {most:.3}");
        assert!((least - low).abs() < 0.035 && (most - high).abs() < 0.035, "joint {joint}: {least} {most}");
    }
}

#[test]
fn the_run_flies_as_long_as_its_file_says() {
    for (name, motion_name, flight) in
        [("tocabi", "run_gait", 0.3), ("atlas", "run_gait", 0.3), ("atlas", "run_gait_short_flight", 0.28)]
    {
        let motion = motion(motion_name, &robot(name));
        let airborne = motion.samples.iter().filter(|frame| frame.contact == [false, false]).count();
        assert!((airborne as f64 / 720.0 - flight).abs() <= 2.0 / 720.0, "{name} {airborne}");
        assert!(motion.samples.iter().all(|frame| frame.contact != [true, true]));
        assert_eq!(motion.samples[0].contact, [true, false]);
    }
}

#[test]
fn the_run_is_ballistic_in_flight_and_carries_the_weight_on_average() {
    let motion = motion("run_gait", &robot("tocabi"));
    let count = motion.samples.len() as f64;
    let mean: f64 = motion.samples.iter().map(|frame| frame.base_acceleration[2]).sum::<f64>() / count;
    assert!(mean.abs() < 0.02, "{mean}");
    let flight = motion.samples.iter().filter(|frame| frame.contact == [false, false]);
    assert!(flight.clone().all(|frame| frame.base_acceleration[2] == -9.81));
    // Between take-off and touch-down the vertical velocity goes from g t / 2 to -g t / 2, t = 0.099 s.
    let fastest = flight.map(|frame| frame.base_velocity[2]).fold(f64::MIN, f64::max);
    assert!((fastest - 0.5 * 9.81 * 0.099).abs() < 0.02, "{fastest}");
}

#[test]
fn the_run_keeps_clear_of_the_straight_knee_and_asks_for_documented_rates() {
    for (name, rates) in [("tocabi", 6.5..8.5), ("atlas", 6.0..9.0)] {
        let robot = robot(name);
        let motion = motion("run_gait", &robot);
        let knee = motion.samples.iter().map(|frame| frame.position[3]).fold(f64::MAX, f64::min);
        let rate = motion.samples.iter().map(|frame| frame.velocity[3].abs()).fold(0.0, f64::max);
        let torque = motion.samples.iter().map(|frame| frame.acceleration[3].abs()).fold(0.0, f64::max)
            * robot.links[3].joint.armature
            / robot.links[3].joint.effort_limit;
        println!(
            "{name}: least knee {knee:.3} rad, knee rate {rate:.2} rad/s, armature torque {torque:.2} of the \
             limit"
        );
        assert!(knee > 0.2 && rates.contains(&rate), "{name} {knee} {rate}");
    }
}

#[test]
fn the_legs_of_a_run_reach_no_further_than_stated() {
    // Before smoothing the largest distance is exactly 96.5 %; smoothing changes it slightly.
    for name in ROBOTS {
        let robot = robot(name);
        let motion = motion("run_gait", &robot);
        let hip = crate::robot::Leg::of(&robot, 0).unwrap().hip_pitch.0;
        let mut kinematics = Kinematics::new(&robot);
        let distances = motion.samples.iter().filter(|frame| frame.contact[0]).map(|frame| {
            kinematics.place(&Isometry3::identity(), &frame.position);
            let ankle = kinematics.pose(robot.feet[0].link).translation.vector;
            (kinematics.pose(hip).translation.vector - ankle).norm()
        });
        let share = distances.fold(0.0, f64::max) / leg_length(&robot).unwrap();
        println!("{name}: {share:.3}");
        assert!((0.94..0.99).contains(&share), "{name}: {share}");
    }
}

#[test]
fn the_squat_is_the_cubic_of_the_paper() {
    let robot = robot("tocabi");
    let motion = motion("squat", &robot);
    assert_eq!(motion.period, 8.0);
    let at = |time: f64| &motion.samples[(time / 8.0 * 720.0) as usize];
    assert_eq!(at(0.5).position, robot.default_pose());
    assert!((at(4.0).position[3] - 1.2).abs() < 1e-12 && (at(4.0).position[8] + 0.54).abs() < 1e-12);
    // Half way down: the mean of both poses, at 3/2 of the mean rate.
    assert!((at(2.0).position[3] - 0.9).abs() < 1e-12);
    assert!((at(2.0).velocity[3] - 1.5 * 0.6 / 2.0).abs() < 1e-12);
    assert!((at(0.5).base_height - at(4.0).base_height - (0.92814 - 0.83731)).abs() < 1e-4);
}

#[test]
fn the_clip_plays_the_recorded_frames_with_the_authors_contacts() {
    let motion = motion("run_clip", &robot("tocabi"));
    // Frame 2 of 24: left knee 0.920114 and right knee 1.835379 rad.
    assert!((motion.samples[60].position[3] - 0.920114).abs() < 1e-9);
    assert!((motion.samples[60].position[9] - 1.835379).abs() < 1e-9);
    let contacts =
        |side: usize| (0..24).map(|frame| motion.samples[30 * frame].contact[side]).collect::<Vec<_>>();
    assert_eq!(contacts(0), (0..24).map(|frame| !(9..22).contains(&frame)).collect::<Vec<_>>());
    assert_eq!(contacts(1), (0..24).map(|frame| (11..20).contains(&frame)).collect::<Vec<_>>());
    let peak =
        |joint: usize| motion.samples.iter().map(|frame| frame.velocity[joint].abs()).fold(0.0, f64::max);
    assert!((9.0..16.0).contains(&peak(3)), "{}", peak(3));
}

#[test]
fn the_registry_is_sorted_and_every_page_has_a_summary() {
    let names: Vec<&str> = kinds().iter().map(|kind| kind.name).collect();
    assert_eq!(names, ["clip", "run_gait", "squat", "walk"]);
    for kind in kinds() {
        assert!(kind.doc.lines().next().is_some_and(|line| line.ends_with('.')), "{}", kind.name);
        assert!(kind.params.iter().all(|param| !param.doc.is_empty()), "{}", kind.name);
    }
}

/// The TOCABI motion of a shipped file with a changed text.
fn changed(name: &str, from: &str, to: &str) -> Result<Motion, MotionError> {
    let text = embedded(&format!("{name}.toml")).unwrap();
    assert!(text.contains(from), "{from}");
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("motion.toml", text.replacen(from, to, 1));
    let file = load(&sources, source, &mut sink).expect("a sound file");
    super::build(name, Section::new(&file.table), &robot("tocabi"), None)
}

#[test]
fn a_motion_that_the_robot_cannot_do_is_refused() {
    let far = changed("walk", "half_foot_spacing    = \"0.12445 m\"", "half_foot_spacing = \"1.5 m\"");
    assert!(matches!(far, Err(MotionError::OutOfReach { .. })), "{far:?}");
    let bent = changed("squat", "ankle_pitch = \"-0.66 rad\"", "ankle_pitch = \"-1.66 rad\"");
    assert!(
        matches!(&bent, Err(MotionError::OutsideLimits { joint, .. }) if joint == "L_AnklePitch_Joint"),
        "{bent:?}"
    );
    let lost = changed("run_clip", "\n", "\n");
    assert!(matches!(lost, Err(MotionError::Clip(_))), "a clip without its file");
}

/// TOCABI with hip pitch axes rotated by this angle about x, outwards on both sides, as in many humanoids.
fn slanted(angle: f64) -> Robot {
    let mut robot = robot("tocabi");
    for (joint, side) in [(2, 1.0), (8, -1.0)] {
        let turn = crate::robot::kinematics::rotation_about(&Vector3::x(), side * angle);
        let own = &mut robot.links[joint].joint;
        own.axis = turn * own.axis;
    }
    robot.mirror = symmetry::mirror_map(&robot).expect("both sides are turned alike");
    robot
}

#[test]
fn a_squat_of_legs_with_slanted_hips_keeps_both_soles_planted() {
    for degrees in [0.0_f64, 10.0, 25.0, 35.0] {
        let mut robot = slanted(degrees.to_radians());
        // Straight legs are level whatever the hip axes.
        robot
            .links
            .iter_mut()
            .for_each(|link| link.joint.default_position = 0.0_f64.clamp(link.joint.lower, link.joint.upper));
        robot.standing_height = symmetry::standing_height(&robot);
        let squat = motion("squat", &robot);
        let mut kinematics = Kinematics::new(&robot);
        let mut lowest = f64::INFINITY;
        for (index, frame) in squat.samples.iter().enumerate() {
            kinematics.place(&base(&squat, index), &frame.position);
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                let sole = kinematics.sole(side);
                let normal = sole.rotation * Vector3::z();
                assert!(libm::hypot(normal.x, normal.y) < 0.01, "{degrees} deg, sample {index}: {normal}");
                assert!(
                    sole.translation.z.abs() < 1e-3,
                    "{degrees} deg, sample {index}: {}",
                    sole.translation.z
                );
                let start = 0.1025 * sign;
                assert!((sole.translation.y - start).abs() < 5e-3, "{degrees} deg: {}", sole.translation.y);
            }
            lowest = lowest.min(frame.base_height);
            let next = &squat.samples[(index + 1) % squat.samples.len()];
            let step = squat.period / squat.samples.len() as f64;
            // A straight knee begins to bend at once, so its speed jumps at both ends of the motion.
            let moves = |height: f64| height < robot.standing_height - 0.01;
            for joint in (0..robot.joints()).filter(|_| moves(frame.base_height) && moves(next.base_height)) {
                let mean = 0.5 * (frame.velocity[joint] + next.velocity[joint]);
                assert!(((next.position[joint] - frame.position[joint]) / step - mean).abs() < 0.02);
            }
        }
        assert!(
            lowest < robot.standing_height - 0.05,
            "{degrees} deg: {lowest} of {}",
            robot.standing_height
        );
    }
}

#[test]
fn legs_without_three_pitch_joints_name_the_joint_that_stands_aslant() {
    let aslant = slanted(45.0_f64.to_radians());
    let said = shipped("squat", &aslant)
        .expect("it is shipped")
        .expect_err("its hip has an oblique axis")
        .to_string();
    assert!(said.contains("joint `L_HipPitch_Joint` is 45 deg off every axis of the base"), "{said}");
}
