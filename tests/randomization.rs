//! Every row of the randomization table, measured: what the engine does under the row at a constant value,
//! against what physics says of the robot that the test has changed by hand.

#![cfg(all(feature = "batch", feature = "rapier", feature = "mujoco"))]

mod worlds;

use nalgebra::DVector;
use specforge::kinds::action::Position;
use specforge::kinds::randomize::link_mass::LinkMass;
use specforge::robot::{Kinematics, Robot};
use specforge::sim::State;
use specforge::spec::{Sampler, Value};
use worlds::{
    GRAVITY, LOOSE, NAMES, Rig, acceleration, aloft, as_it_is, blueprint, carried, engines, kinematics,
    on_an_incline, sliding_grip, spec, tell, velocity,
};

/// Joints of TOCABI's left leg.
const HIP_ROLL: usize = 1;
const HIP_PITCH: usize = 2;
const KNEE: usize = 3;
/// Ankle pitch of both legs.
const ANKLES: [usize; 2] = [4, 10];

/// A row at a constant scale.
fn scaled(kind: &str, scale: f64) -> String {
    format!("[randomize.row]\nkind = \"{kind}\"\nscale = {scale:?}\n")
}

/// The nominal robot with the joints of `LOOSE`.
fn loose(mut robot: Robot) -> Robot {
    for link in &mut robot.links {
        link.joint.friction *= 0.001;
        link.joint.damping *= 0.001;
    }
    robot
}

/// Generalised acceleration of the robot in the air under a torque pulse of one control step (4 ms), as it is
/// measured and as the mass matrix of `expected` has it.
fn pulse(row: &str, expected: &Robot, engine: usize) -> [DVector<f64>; 2] {
    let blueprint = blueprint("stand", "torque", &format!("{LOOSE}{row}"));
    let shares = [(HIP_PITCH, 0.4), (KNEE, -0.3), (7, 0.2)];
    let mut torque = vec![0.0; 12];
    for (joint, share) in shares {
        torque[joint] = f64::from(share) * blueprint.robot.links[joint].joint.effort_limit;
    }
    let record = Rig::new(&blueprint, &engines()[engine], aloft).act(&shares, 1).record();
    let (first, last) = (&record.states[0], &record.states[record.states.len() - 1]);
    let time = 0.0005 * (record.states.len() - 1) as f64;
    [(velocity(last) - velocity(first)) / time, acceleration(expected, first, &torque)]
}

/// Measures a row that changes the robot's inertia: the change of the accelerations must be that of the mass
/// matrix, within a hundredth of it.
fn the_change_is_that_of_the_mass_matrix(row: &str, change: fn(&mut Robot)) {
    let nominal = loose(blueprint("stand", "torque", "").robot);
    let mut expected = nominal.clone();
    change(&mut expected);
    for engine in 0..NAMES.len() {
        let [before, by_matrix_before] = pulse("", &nominal, engine);
        let [after, by_matrix_after] = pulse(row, &expected, engine);
        let (measured, due) = (after - before, by_matrix_after - by_matrix_before);
        assert!(due.norm() > 1.0, "the row must matter: {due}");
        let off = (&measured - &due).norm() / due.norm();
        tell(&format!("{row:?}: change of the acceleration"), engine, measured.norm(), due.norm());
        tell(&format!("{row:?}: off"), engine, off, 0.0);
        assert!(off < 0.01, "engine {engine}: {off} off; measured {measured} due {due}");
    }
}

#[test]
fn link_inertia_changes_the_angular_acceleration_under_a_torque_pulse() {
    the_change_is_that_of_the_mass_matrix(&scaled("link_inertia", 1.4), |robot| {
        robot.base.inertia *= 1.4;
        robot.links.iter_mut().for_each(|link| link.body.inertia *= 1.4);
    });
}

#[test]
fn link_mass_changes_the_acceleration_under_a_torque_pulse() {
    the_change_is_that_of_the_mass_matrix(&scaled("link_mass", 0.6), |robot| {
        robot.base.mass *= 0.6;
        robot.links.iter_mut().for_each(|link| link.body.mass *= 0.6);
    });
}

#[test]
fn link_com_changes_the_acceleration_under_a_torque_pulse() {
    the_change_is_that_of_the_mass_matrix(&scaled("link_com", 1.4), |robot| {
        robot.base.com.coords *= 1.4;
        robot.links.iter_mut().for_each(|link| link.body.com.coords *= 1.4);
    });
}

#[test]
fn leg_length_changes_the_acceleration_under_a_torque_pulse() {
    // Of TOCABI's links thigh and shank have bones, both straight down.
    the_change_is_that_of_the_mass_matrix(&scaled("leg_length", 1.3), |robot| {
        for index in [2, 3, 8, 9] {
            let body = &mut robot.links[index].body;
            body.com.z *= 1.3;
            // Moments of the mass: those with a z are longer by the factor, those with two by its square.
            let i = body.inertia;
            let half = 0.5 * i.trace();
            let [xx, yy, zz] = [half - i.m11, half - i.m22, 1.69 * (half - i.m33)];
            (body.inertia.m11, body.inertia.m22, body.inertia.m33) = (yy + zz, xx + zz, xx + yy);
            for (row, column) in [(0, 2), (1, 2), (2, 0), (2, 1)] {
                body.inertia[(row, column)] *= 1.3;
            }
            let child = &mut robot.links[index + 1].joint.origin.translation.vector;
            child.z *= 1.3;
        }
    });
}

/// The robot's position control holds the default pose for 2.5 s. Its joints are free of friction, and in oil
/// thick enough for it to be at rest by then.
fn held(row: &str, engine: usize) -> Rig {
    let oil = LOOSE
        .replace("thin", "thick")
        .replace("\"joint_damping\"\nscale = 0.001", "\"joint_damping\"\nscale = 400.0");
    let text = format!("[action]\nstiffness = \"100 %\"\ndelay = \"0 ms\"\n{oil}{row}");
    let blueprint = blueprint("stand", "position", &text);
    let mut rig = Rig::new(&blueprint, &engines()[engine], as_it_is);
    rig.act(&[], 625);
    rig
}

/// Force in N on the feet of the held robot, and the torque in N m of both ankles.
fn load(rig: &Rig) -> [f64; 2] {
    let signals = rig.environment.signals();
    [carried(&rig.record(), 1000), ANKLES.iter().map(|joint| signals.torque[*joint]).sum()]
}

/// What statics says of the same: weight, and the moment about the ankles of everything above them.
fn statics(robot: &Robot, state: &State) -> [f64; 2] {
    let kinematics = kinematics(robot, state);
    let weight = robot.total_mass() * GRAVITY;
    let moment = |x: f64| {
        let mut moment = weight * (kinematics.com().x - x);
        for foot in &robot.feet {
            let body = &robot.links[foot.link].body;
            moment -= body.mass * GRAVITY * ((kinematics.pose(foot.link) * body.com).x - x);
        }
        moment
    };
    // Ankle pitch and ankle roll are in one place; both feet stand side by side.
    let ankle = kinematics.pose(ANKLES[0]).translation.x;
    [weight, moment(ankle)]
}

/// Holds the nominal robot and the one under a row, and compares both and their difference with statics of
/// robots that the test has made: within 0.5 N and 0.5 N m; `least` is what the row must change at least.
fn the_load_is_that_of_statics(row: &str, change: fn(&mut Robot), least: [f64; 2]) {
    let nominal = blueprint("stand", "position", "").robot;
    let mut changed = nominal.clone();
    change(&mut changed);
    for engine in 0..NAMES.len() {
        let (before, after) = (held("", engine), held(row, engine));
        let [is, was] = [(&after, &changed), (&before, &nominal)].map(|(rig, robot)| {
            let (measured, due) = (load(rig), statics(robot, rig.environment.state()));
            tell(&format!("{row:?}: N on the feet"), engine, measured[0], due[0]);
            tell(&format!("{row:?}: N m at the ankles"), engine, measured[1], due[1]);
            let [force, torque] = [0, 1].map(|index| (measured[index] - due[index]).abs());
            assert!(force < 0.5, "engine {engine}: {measured:?} is not {due:?} N");
            assert!(torque < 0.5 + 0.01 * due[1].abs(), "engine {engine}: {measured:?} is not {due:?} N m");
            measured
        });
        for index in 0..2 {
            let change = is[index] - was[index];
            assert!(change.abs() >= least[index], "engine {engine}: the load changes by {change}");
        }
    }
}

#[test]
fn link_mass_is_the_weight_on_the_feet() {
    let double = |robot: &mut Robot| {
        robot.base.mass *= 1.4;
        robot.links.iter_mut().for_each(|link| link.body.mass *= 1.4);
    };
    the_load_is_that_of_statics(&scaled("link_mass", 1.4), double, [400.0, 0.0]);
}

#[test]
fn link_com_moves_the_load_over_the_ankles() {
    let move_ = |robot: &mut Robot| {
        robot.base.com.coords *= 1.4;
        robot.links.iter_mut().for_each(|link| link.body.com.coords *= 1.4);
    };
    the_load_is_that_of_statics(&scaled("link_com", 1.4), move_, [0.0, 5.0]);
}

#[test]
fn a_payload_is_weight_on_the_feet_and_moves_the_load_over_the_ankles() {
    let row = "[randomize.row]\nkind = \"payload\"\nmass = \"20 kg\"\n";
    the_load_is_that_of_statics(row, |robot| robot.base.mass += 20.0, [196.0, 2.0]);
}

#[test]
fn leg_length_is_the_height_at_which_the_robot_stands_and_of_its_reference() {
    let nominal = blueprint("stand", "position", "").robot;
    for engine in 0..NAMES.len() {
        let stand = |scale: f64| {
            let rig = held(&scaled("leg_length", scale), engine);
            let (signals, force) = (rig.environment.signals(), carried(&rig.record(), 1000));
            let weight = nominal.total_mass() * GRAVITY;
            assert!((force - weight).abs() < 0.5, "engine {engine}: {force} N");
            let soles = kinematics(&rig.robot(), rig.environment.state());
            let lowest = soles.lowest_corner(0).min(soles.lowest_corner(1));
            assert!((-0.004..0.001).contains(&lowest), "engine {engine}: the soles are at {lowest} m");
            [signals.base_height, signals.reference.base_height, signals.stature]
        };
        let one = stand(1.0);
        assert_eq!(one[1..], [nominal.standing_height, 1.0]);
        for scale in [0.8, 1.2] {
            let [height, reference, stature] = stand(scale);
            // Thigh and shank of 0.35 m each at 0.24 rad and 0.36 rad to the vertical.
            let due = (scale - 1.0) * 0.35 * (libm::cos(0.24) + libm::cos(0.36));
            tell(&format!("leg_length {scale}: stands higher by, in m"), engine, height - one[0], due);
            assert!(
                (height - one[0] - due).abs() < 5e-3,
                "engine {engine}: stands {} m higher",
                height - one[0]
            );
            assert!((reference - nominal.standing_height - due).abs() < 1e-9);
            assert!((stature - (nominal.standing_height + due) / nominal.standing_height).abs() < 1e-9);
        }
    }
}

#[test]
fn the_least_height_and_the_critic_s_view_of_the_height_follow_the_legs() {
    // TOCABI stands at 0.93 m, on legs of 0.8 at 0.80 m: below 0.85 m, but not below its share of that.
    let more = "[terminate.base_height]\nbelow = \"0.85 m\"\n[learn.value]\nprivileged = true\n";
    for scale in [0.8, 1.2] {
        let blueprint = blueprint("stand", "torque", &format!("{more}{}", scaled("leg_length", scale)));
        let mut rig = Rig::new(&blueprint, &engines()[0], as_it_is);
        let sizes = rig.environment.view().sizes();
        let mut seen = vec![0.0; sizes.privileged];
        rig.environment.view().observe_privileged(&mut seen);
        // After three velocities and three rates.
        let height = seen[sizes.observation + 6];
        assert!(height.abs() < 1e-3, "legs of {scale}: a standing start shows {height} as its height");
        let step = rig.environment.step(&vec![0.0; sizes.action]);
        assert_eq!(step.end, None, "legs of {scale}");
    }
}

#[test]
fn joint_damping_slows_a_turning_joint() {
    // In the air, the knee turns at 3 rad/s; what damping adds to its deceleration in the first millisecond.
    let nominal = blueprint("stand", "torque", "").robot;
    for engine in 0..NAMES.len() {
        let after = |scale: f64| {
            let bearings = "[randomize.loose_bearings]\nkind = \"joint_friction\"\nscale = 0.001\n";
            let row = format!("{bearings}{}", scaled("joint_damping", scale));
            let blueprint = blueprint("stand", "torque", &row);
            let turning = |state: &mut State| {
                aloft(state);
                state.velocity[KNEE] = 3.0;
            };
            let record = Rig::new(&blueprint, &engines()[engine], turning).act(&[], 1).record();
            (record.states[0].clone(), velocity(&record.states[2]))
        };
        let (start, slow) = after(1.4);
        let (_, fast) = after(0.6);
        let measured = (slow - fast) / 0.001;
        let mut torque = vec![0.0; 12];
        torque[KNEE] = -0.8 * nominal.links[KNEE].joint.damping * 3.0;
        let due = acceleration(&nominal, &start, &torque) - acceleration(&nominal, &start, &[0.0; 12]);
        let off = (&measured - &due).norm() / due.norm();
        tell("joint_damping: change of the knee's acceleration", engine, measured[6 + KNEE], due[6 + KNEE]);
        assert!(
            due[6 + KNEE] < -2.0 && off < 0.05,
            "engine {engine}: {off} off; measured {measured} due {due}"
        );
    }
}

#[test]
fn joint_friction_is_the_torque_at_which_a_joint_begins_to_turn() {
    // In the air nothing else loads the knee. Its friction is 4.18 N m.
    for engine in 0..NAMES.len() {
        for scale in [0.6, 1.4] {
            let blueprint = blueprint("stand", "torque", &scaled("joint_friction", scale));
            let joint = &blueprint.robot.links[KNEE].joint;
            let turned = |share: f64| {
                let share = share * scale * joint.friction / joint.effort_limit;
                let rig =
                    Rig::new(&blueprint, &engines()[engine], aloft).act(&[(KNEE, share as f32)], 25).record();
                let (first, last) = (&rig.states[0], &rig.states[rig.states.len() - 1]);
                (last.position[KNEE] - first.position[KNEE]).abs()
            };
            let (below, above) = (turned(0.9), turned(1.5));
            tell(&format!("joint_friction {scale}: turn at 0.9 of it"), engine, below, 0.0);
            tell(&format!("joint_friction {scale}: turn at 1.5 of it"), engine, above, f64::NAN);
            assert!(
                below < 1e-3,
                "engine {engine}, {scale}: below its friction the knee turns by {below} rad"
            );
            assert!(
                above > 1.5e-3 && above > 4.0 * below,
                "engine {engine}, {scale}: above it by {above} rad"
            );
        }
    }
}

#[test]
fn motor_constant_is_a_factor_on_the_acceleration_and_on_the_effort_limit() {
    for engine in 0..NAMES.len() {
        let jump = |scale: f64, share: f32| {
            let blueprint =
                blueprint("stand", "torque", &format!("{LOOSE}{}", scaled("motor_constant", scale)));
            let record = Rig::new(&blueprint, &engines()[engine], aloft).act(&[(KNEE, share)], 1).record();
            record.states[1].velocity[KNEE] / 0.0005
        };
        // 0.3 is within the effort limit, 1 at it.
        for share in [0.3, 1.0] {
            for scale in [0.8, 1.1] {
                let ratio = jump(scale, share) / jump(1.0, share);
                tell(&format!("motor_constant at {share} of the limit"), engine, ratio, scale);
                assert!((ratio - scale).abs() < 2e-3, "engine {engine}, {share}: {ratio} instead of {scale}");
            }
        }
    }
}

#[test]
fn action_delay_is_the_time_until_a_command_moves_the_robot() {
    let delay = "[action]\ndelay = \"4 ms\"\n";
    for engine in 0..NAMES.len() {
        for (scale, steps) in [(0.5, 4), (1.0, 8), (1.5, 12)] {
            let row = format!("{delay}{LOOSE}{}", scaled("action_delay", scale));
            let blueprint = blueprint("stand", "torque", &row);
            let mut rig = Rig::new(&blueprint, &engines()[engine], aloft);
            // The first command fills the line; the second is given after eight physics steps.
            let record = rig.act(&[], 1).act(&[(KNEE, 0.3)], 3).record();
            let still = record.states.iter().take_while(|state| state.velocity[KNEE].abs() < 1e-3).count();
            // The state after the step that has the torque is the first that moves; state 0 is the start.
            tell("action_delay: steps of 0.5 ms", engine, (still - 9) as f64, f64::from(steps));
            assert_eq!(still - 9, steps as usize, "engine {engine}, scale {scale}");
        }
    }
}

#[test]
fn action_delay_within_a_physics_step_leaves_the_rest_of_that_step_to_the_new_torque() {
    for engine in 0..NAMES.len() {
        // 4.2 ms are 8.4 steps of 0.5 ms: six tenths of the ninth step have the torque.
        let row = format!("[action]\ndelay = \"4.2 ms\"\n{LOOSE}");
        let mut rig = Rig::new(&blueprint("stand", "torque", &row), &engines()[engine], aloft);
        let record = rig.act(&[], 1).act(&[(KNEE, 0.3)], 3).record();
        let speed = |step: usize| record.states[step].velocity[KNEE];
        let share = (speed(17) - speed(16)) / (speed(18) - speed(17));
        tell("action_delay: share of the step in which the torque changes", engine, share, 0.6);
        assert!(speed(16).abs() < 1e-3 && (share - 0.6).abs() < 1e-2, "engine {engine}: {share}");
    }
}

#[test]
fn joint_offset_is_what_encoders_show_and_where_the_servo_holds_the_joints() {
    let row =
        "[randomize.row]\nkind = \"joint_offset\"\noffset = \"0.03 rad\"\njoints = [\"L_Knee_Joint\"]\n";
    for engine in 0..NAMES.len() {
        let text = format!("[action]\nstiffness = \"100 %\"\ndelay = \"0 ms\"\n{LOOSE}{row}");
        let blueprint = blueprint("stand", "position", &text);
        let mut rig = Rig::new(&blueprint, &engines()[engine], aloft);
        let layout = blueprint.observation();
        for (steps, held) in [(0, 0.0), (250, -0.03)] {
            rig.act(&[], steps);
            let mut seen = vec![0.0; layout.len()];
            rig.environment.view().observe(&mut seen);
            let state = rig.environment.state();
            for (joint, link) in blueprint.robot.links.iter().enumerate() {
                let place = layout.inputs().iter().position(|input| {
                    input.name == "joint_position" && input.joint.as_deref() == Some(link.joint.name.as_str())
                });
                let place = place.expect("every joint is shown");
                let input = &layout.inputs()[place];
                let shown = f64::from(seen[place]) * input.scale + input.offset;
                let (shift, due) = if joint == KNEE { (0.03, held) } else { (0.0, 0.0) };
                let truth = state.position[joint];
                assert!((shown - truth - shift).abs() < 1e-6, "engine {engine}: joint {joint} shows {shown}");
                let off = truth - link.joint.default_position - due;
                if joint == KNEE {
                    tell(
                        "joint_offset: the knee is held at",
                        engine,
                        truth,
                        link.joint.default_position + due,
                    );
                }
                assert!(off.abs() < 2e-3, "engine {engine}: joint {joint} is held {off} rad off");
            }
        }
    }
}

/// TOCABI stands for 2 s under a servo at 2 kHz with this share of its own stiffness, 4 ms of delay and the
/// encoders' noise: the joints' positions, and the torques that are asked for, mean over each control step.
fn standing(engine: usize, stiffness: &str, feedback: &str) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let text =
        format!("[action]\nstiffness = \"{stiffness}\"\nfeedback = \"{feedback}\"\ndelay = \"4 ms\"\n");
    let trial = specforge::env::Trial { noise: true, ..Default::default() };
    let mode = specforge::env::Mode::Evaluation(trial);
    let mut rig = Rig::of_mode(&blueprint("stand", "position", &text), &engines()[engine], as_it_is, &mode);
    let mut torques = Vec::new();
    for _ in 0..500 {
        rig.act(&[], 1);
        torques.push(rig.environment.torque().to_vec());
    }
    (rig.record().states.into_iter().map(|state| state.position).collect(), torques)
}

/// Root mean square of the differences between pairs of numbers.
fn spread(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (count, sum) = pairs.fold((0.0, 0.0), |(count, sum), (a, b)| (count + 1.0, sum + (a - b).powi(2)));
    f64::sqrt(sum / count)
}

#[test]
fn a_servo_that_reads_its_encoders_holds_the_robot_as_one_that_reads_the_truth() {
    for engine in 0..NAMES.len() {
        for (share, stiffness) in [(1.0_f64, "100 %"), (0.125, "12.5 %")] {
            let [truth, measured] =
                ["true", "measured"].map(|feedback| standing(engine, stiffness, feedback));
            // The last second: by then the start has died away.
            let late = |run: &[Vec<f64>], joint: usize| -> Vec<f64> {
                run[run.len() / 2..].iter().map(|row| row[joint]).collect()
            };
            let joints = 0..truth.0[0].len();
            let shift =
                joints.map(|joint| spread(late(&truth.0, joint).into_iter().zip(late(&measured.0, joint))));
            let shift = shift.fold(0.0, f64::max);
            let change = |run: &[Vec<f64>]| {
                let roll = late(run, HIP_ROLL);
                spread(roll.iter().copied().zip(roll[1..].iter().copied()))
            };
            // The mean over eight physics steps has K_d (n_0 - n_8) / 4 ms of noise, its change the root of
            // three times as much: 3.1 N m with the 50 N m s/rad of 100 %.
            let due = share.sqrt() * 50.0 * 6.0_f64.sqrt() * 1e-4 / 0.004;
            let [without, with] = [&truth.1, &measured.1].map(|run| change(run));
            tell(
                &format!("feedback: N m from step to step at the hip roll, the truth, {stiffness}"),
                engine,
                without,
                0.0,
            );
            tell(
                &format!("feedback: N m from step to step at the hip roll, measured, {stiffness}"),
                engine,
                with,
                due,
            );
            tell(&format!("feedback: rad at the joints, {stiffness}"), engine, shift, 0.0);
            assert!(shift < 1e-2, "engine {engine}, {stiffness}: the joints are {shift} rad off");
            assert!(
                with > 0.5 * due && with < 2.0 * due + without,
                "engine {engine}, {stiffness}: {with} N m of {due}"
            );
        }
    }
}

#[test]
fn a_push_gives_the_whole_robot_its_impulse() {
    let row = "[randomize.row]\nkind = \"push\"\nimpulse = \"60 N*s\"\nduration = \"0.1003 s\"\nevery = \
        \"0.6 s\"\n";
    let blueprint = blueprint("stand", "torque", &format!("[task]\nepisode = \"0.6 s\"\n{row}"));
    for engine in 0..NAMES.len() {
        let trial =
            specforge::env::Trial { randomized: specforge::env::Randomized::AsTrained, ..Default::default() };
        let mode = specforge::env::Mode::Evaluation(trial);
        let mut rig = Rig::of_mode(&blueprint, &engines()[engine], aloft, &mode);
        let record = rig.act(&[], 200).record();
        let robot = rig.robot();
        let centre = |index: usize| {
            let state = &record.states[index];
            kinematics(&robot, state).com()
        };
        let last = record.states.len() - 1;
        let speed = (centre(last) - centre(last - 100)) / 0.05;
        let momentum = robot.total_mass() * speed.x.hypot(speed.y);
        tell("push: N s", engine, momentum, 60.0);
        assert!((momentum - 60.0).abs() < 0.03, "engine {engine}: {momentum} N s");
        let before = (centre(1) - centre(0)).xy().norm();
        assert!(before < 1e-6, "engine {engine}: it moves by {before} m before the push");
    }
}

/// Share of its load with which the ground under each foot resists while the robot slides down an incline.
fn grip(row: &str, engine: usize) -> [f64; 2] {
    sliding_grip(&on_an_incline(0.05, row), &engines()[engine])
}

#[test]
fn ground_friction_is_the_resistance_under_both_sliding_feet() {
    for engine in 0..NAMES.len() {
        for scale in [0.5, 1.5] {
            let grips = grip(&scaled("ground_friction", scale), engine);
            for coefficient in grips {
                let due = 0.05 * scale;
                tell("ground_friction", engine, coefficient, due);
                assert!(
                    (coefficient / due - 1.0).abs() < 0.02,
                    "engine {engine}: {grips:?} instead of {due}"
                );
            }
        }
    }
}

#[test]
fn foot_friction_is_the_resistance_under_each_sliding_foot() {
    let row = "[randomize.row]\nkind = \"foot_friction\"\nscale = { uniform = [0.4, 1.6] }\n";
    for engine in 0..NAMES.len() {
        let rig = Rig::new(&on_an_incline(0.05, row), &engines()[engine], aloft);
        let drawn = rig.robot().feet.map(|foot| 0.05 * foot.friction);
        assert!(
            (drawn[0] - drawn[1]).abs() > 5e-3,
            "the draws must differ to tell the feet apart: {drawn:?}"
        );
        let measured = grip(row, engine);
        for side in 0..2 {
            let ratio = measured[side] / drawn[side];
            tell("foot_friction", engine, measured[side], drawn[side]);
            assert!((ratio - 1.0).abs() < 0.02, "engine {engine}: {measured:?} instead of {drawn:?}");
        }
    }
}

#[test]
fn a_row_without_a_spread_of_one_is_the_nominal_physics_bit_for_bit() {
    let text = [
        "link_mass",
        "link_inertia",
        "link_com",
        "joint_damping",
        "joint_friction",
        "motor_constant",
        "action_delay",
    ]
    .map(|kind| format!("[randomize.one_{kind}]\nkind = \"{kind}\"\nscale = 1.0\n"))
    .concat();
    let text = text
        + &["leg_length", "ground_friction", "foot_friction"]
            .map(|kind| format!("[randomize.one_{kind}]\nkind = \"{kind}\"\nscale = 1.0\n"))
            .concat();
    for engine in 0..NAMES.len() {
        let run = |row: &str| {
            let blueprint = blueprint("stand", "torque", row);
            let record = Rig::new(&blueprint, &engines()[engine], as_it_is).act(&[(KNEE, 0.1)], 40).record();
            record.states
        };
        assert_eq!(run(""), run(&text), "engine {engine}");
    }
}

#[test]
fn the_heights_of_the_reference_follow_the_legs_through_a_squat() {
    let text = "[initial]\nkind = \"reference\"\nstanding_share = \"0 %\"\n";
    let row = scaled("leg_length", 1.25);
    let [nominal, tall] = ["", row.as_str()].map(|row| {
        let blueprint = blueprint("squat", "torque", &format!("{text}{row}"));
        let mode = specforge::env::Mode::Training;
        let mut rig = Rig::of_mode(&blueprint, &engines()[0], as_it_is, &mode);
        let mut heights = Vec::new();
        for episode in 0..20 {
            rig.environment.begin(&format!("measured/{episode}"));
            let (signals, robot) = (rig.environment.signals(), rig.robot());
            let mut kinematics = Kinematics::new(&robot);
            kinematics.place(&nalgebra::Isometry3::identity(), &signals.reference.position);
            let depth = -kinematics.lowest_corner(0).min(kinematics.lowest_corner(1));
            assert!(
                (depth - signals.reference.base_height).abs() < 1e-3,
                "the soles of the reference are on the ground"
            );
            heights.push(signals.reference.base_height);
        }
        heights
    });
    let gains: Vec<f64> = tall.iter().zip(&nominal).map(|(tall, nominal)| tall - nominal).collect();
    let (least, most) =
        gains.iter().fold((f64::MAX, f64::MIN), |(low, high), gain| (low.min(*gain), high.max(*gain)));
    assert!(least > 0.1 && most - least > 0.01, "a deep squat gains less than standing: {gains:?}");
}

#[test]
fn the_parents_of_the_experiments_have_the_paper_s_table() {
    let paper: [(&str, Option<&str>, [f64; 2]); 7] = [
        ("link_mass", Some("link"), [0.6, 1.4]),
        ("link_inertia", Some("link"), [0.6, 1.4]),
        ("link_com", Some("link"), [0.6, 1.4]),
        ("joint_damping", Some("joint"), [0.6, 1.4]),
        ("joint_friction", Some("joint"), [0.6, 1.4]),
        ("motor_constant", Some("joint"), [1.0, 1.1]),
        ("action_delay", None, [0.5, 1.5]),
    ];
    for (task, control) in [("walk", "torque"), ("squat", "position"), ("run", "torque")] {
        let blueprint =
            spec(&format!("extends = [\"base/task/{task}.toml\", \"base/action/{control}.toml\"]\n"));
        let table = blueprint.section("randomize");
        assert_eq!(table.sections().count(), paper.len(), "{task}");
        for (row, per, range) in paper {
            let term = table.section(row).unwrap_or_else(|| panic!("{task} has no {row}"));
            assert_eq!(term.value(LinkMass::scale), Some(Sampler::Uniform(range)), "{task}: {row}");
            assert_eq!(term.get("per").and_then(Value::as_text).map(String::as_str), per, "{task}: {row}");
        }
        // 2 to 6 ms.
        assert_eq!(blueprint.section("action").value(Position::delay), Some(0.004));
    }
}
