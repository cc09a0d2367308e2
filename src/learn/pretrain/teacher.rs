//! The teacher: draws states of the robot and gives the actions that a good policy would take in them.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use crate::control::law::Law;
use crate::control::low_pass::LowPass;
use crate::env::Observation;
use crate::kinds::motion::{Frame, Motion};
use crate::kinds::observe::Readings;
use crate::robot::{GravityCompensation, Robot, Weighting};
use crate::spec::{Sampler, Section, Table};
use crate::stream::Stream;

use super::tracking::{Drawn, Tracking};

/// Draws labelled states. Each thread has its own.
#[derive(Clone, Debug)]
pub struct Teacher {
    observation: Observation,
    law: Law,
    gravity: GravityCompensation,
    reference: Option<Reference>,
    rule: Rule,
    noise: Noise,
    joints: Vec<Drive>,
    speed: Sampler,
    phase_action: bool,
    /// Whether the label of the phase action is drawn, as the paper prints it.
    random_phase: bool,
    state: State,
}

/// What the labels are.
#[derive(Clone, Debug)]
enum Rule {
    /// Hold still against gravity.
    Gravity {
        /// Share of the samples about the default pose.
        standing_share: f64,
        /// A sole this far above the lower one still carries, in m.
        contact_height: f64,
    },
    /// Follow the reference motion softly.
    Tracking(Box<Tracking>),
}

/// The reference motion with the velocities that the actor would see of it.
#[derive(Clone, Debug)]
struct Reference {
    motion: Motion,
    /// The same frames with velocities as the observation's filter shows them.
    seen: Motion,
}

/// Widths of the distributions of states.
#[derive(Clone, Debug)]
struct Noise {
    position: Sampler,
    velocity: Vec<f64>,
    tilt: Vec<f64>,
}

/// Figures of one joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drive {
    effort: f64,
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    pub(super) armature: f64,
    default_position: f64,
}

/// Buffers of one sample.
#[derive(Clone, Debug, Default)]
struct State {
    frame: Frame,
    seen: Frame,
    position: Vec<f64>,
    /// Deviation of the joint velocities from the reference.
    swing: Vec<f64>,
    velocity: Vec<f64>,
    seen_velocity: Vec<f64>,
    torque: Vec<f64>,
    action: Vec<f64>,
}

impl Teacher {
    /// The teacher of a decoded spec: reads `pretrain`, `observe`, `action`, `physics.rate`, `task.command` and
    /// `learn.symmetry`.
    pub fn new(fields: &Table, robot: &Robot, motion: Option<&Motion>) -> Self {
        let sections = Section::new(fields);
        let section = |name: &str| sections.section(name).expect("the spec has the sections of a learner");
        let (lesson, action) = (section("pretrain"), section("action"));
        let observation = Observation::new(fields, robot);
        let filter = filter(sections);
        let drive = |index: usize| {
            let joint = &robot.links[index].joint;
            Drive {
                effort: joint.effort_limit,
                stiffness: joint.stiffness_gain,
                damping: joint.damping_gain,
                armature: joint.armature,
                default_position: joint.default_position,
            }
        };
        let lag = lesson.has("filter_lag") && lesson.flag("filter_lag");
        let reference = motion.map(|motion| Reference {
            seen: match filter {
                Some((filter, step)) if lag => filtered(motion, filter, step),
                _ => motion.clone(),
            },
            motion: motion.clone(),
        });
        let command = section("task").section("command");
        Self {
            noise: Noise::new(lesson, &observation, robot),
            observation,
            law: Law::new(action, robot),
            gravity: GravityCompensation::new(robot, Weighting::EffortLimits),
            reference,
            rule: Rule::new(lesson, robot),
            joints: (0..robot.joints()).map(drive).collect(),
            speed: command.map_or(Sampler::Constant(0.0), |command| command.sampler("speed")),
            phase_action: action.flag("phase_modulation"),
            random_phase: lesson.text("phase_label") == "random",
            state: State::default(),
        }
    }

    /// Length of the actor's input.
    pub fn inputs(&self) -> usize {
        self.observation.len()
    }

    /// Length of the actor's output.
    pub fn outputs(&self) -> usize {
        self.joints.len() + usize::from(self.phase_action)
    }

    /// Number of outputs that have a torque behind them; one more is the phase action.
    pub fn joints(&self) -> usize {
        self.joints.len()
    }

    /// Torque in N m (for small errors) per unit of each joint's action.
    pub fn torque_per_action(&self) -> Vec<f64> {
        let units = self.law.units().zip(self.law.gains());
        units.map(|(unit, (stiffness, _))| if stiffness > 0.0 { stiffness * unit } else { unit }).collect()
    }

    /// Draws a state; writes the actor's input and the action it should take. The phase action's label is zero
    /// unless a random one is asked for.
    pub fn draw(&mut self, stream: &mut Stream, input: &mut [f32], label: &mut [f32]) {
        let shown_phase = stream.uniform();
        let attitude = self.pose(shown_phase, stream);
        self.torques(&attitude);
        let State { position, velocity, seen_velocity, torque, action, .. } = &mut self.state;
        for (torque, drive) in torque.iter_mut().zip(&self.joints) {
            *torque = torque.clamp(-drive.effort, drive.effort);
        }
        action.resize(self.joints.len(), 0.0);
        self.law.action(torque, position, velocity, action);
        if self.observation.reflects(shown_phase) {
            self.observation.reflect(action);
        }
        label.fill(0.0);
        label.iter_mut().zip(action).for_each(|(label, action)| *label = *action as f32);
        let command_speed = stream.draw(&self.speed);
        let readings =
            Readings { attitude, position, velocity: seen_velocity, phase: shown_phase, command_speed, mirror: None };
        self.observation.write(&readings, input);
        if self.random_phase && self.phase_action {
            label[self.joints.len()] = stream.uniform() as f32;
        }
    }

    /// Draws joints and base; returns the base's fixed-XYZ angles.
    fn pose(&mut self, shown_phase: f64, stream: &mut Stream) -> [f64; 3] {
        let State { frame, seen, position, swing, velocity, seen_velocity, .. } = &mut self.state;
        // Gravity compensation does not know the phase, so its pose is that of another one.
        let (standing, phase) = match &self.rule {
            Rule::Gravity { standing_share, .. } => (stream.uniform() < *standing_share, stream.uniform()),
            Rule::Tracking(_) => (false, shown_phase),
        };
        match &self.reference {
            Some(reference) if !standing => {
                reference.motion.at(phase, frame);
                reference.seen.at(phase, seen);
            }
            _ => {
                *frame = standing_frame(&self.joints);
                seen.clone_from(frame);
            }
        }
        let width = stream.draw(&self.noise.position);
        position.clear();
        position.extend(frame.position.iter().map(|centre| centre + width * stream.normal()));
        swing.clear();
        swing.extend(self.noise.velocity.iter().map(|width| width * stream.normal()));
        let add = |frame: &Frame, velocity: &mut Vec<f64>| {
            velocity.clear();
            velocity.extend(frame.velocity.iter().zip(&*swing).map(|(centre, swing)| centre + swing));
        };
        add(frame, velocity);
        add(seen, seen_velocity);
        let upright = crate::env::attitude::angles(frame.base_orientation);
        std::array::from_fn(|axis| upright[axis] + self.noise.tilt[axis] * stream.normal())
    }

    /// Computes the torques of the drawn state.
    fn torques(&mut self, attitude: &[f64; 3]) {
        let base = Isometry3::from_parts(Translation3::identity(), rotation(attitude));
        let State { frame, position, swing, torque, .. } = &mut self.state;
        torque.clear();
        match &mut self.rule {
            Rule::Gravity { contact_height, .. } => {
                torque.extend(&self.gravity.hold_by_height(&base, position, *contact_height).torque);
            }
            Rule::Tracking(tracking) => {
                let drawn = Drawn { base, yaw: attitude[2], position, swing };
                tracking.torques(&mut self.gravity, &self.joints, &drawn, frame, torque);
            }
        }
    }
}

impl Rule {
    fn new(lesson: Section, robot: &Robot) -> Self {
        match lesson.text("kind") {
            "tracking" => Self::Tracking(Box::new(Tracking::new(lesson, robot))),
            _ => Self::Gravity {
                standing_share: lesson.si("standing_share"),
                contact_height: lesson.si("contact_height"),
            },
        }
    }
}

impl Noise {
    fn new(lesson: Section, observation: &Observation, robot: &Robot) -> Self {
        let share = lesson.si("velocity_noise");
        let scales =
            observation.inputs().iter().filter(|input| input.name == "joint_velocity").map(|input| input.scale);
        let mut velocity: Vec<f64> = scales.map(|scale| share * scale).collect();
        // An actor that does not see velocities is taught about resting joints.
        velocity.resize(robot.joints(), 0.0);
        let tilt = lesson.numbers("tilt_noise");
        let tilt = tilt.iter().copied().cycle().take(if tilt.is_empty() { 0 } else { 3 }).collect();
        Self { position: lesson.sampler("position_noise"), velocity, tilt }
    }
}

/// The observation's velocity filter with its step in s, where there is one.
fn filter(sections: Section) -> Option<(LowPass, f64)> {
    let step = 1.0 / sections.section("physics")?.si_if("rate")?;
    let mut terms = sections.section("observe")?.sections();
    let (_, term) = terms.find(|(name, term)| term.text_if("kind").unwrap_or(name) == "joint_velocity")?;
    term.si_if("low_pass").map(|cutoff| (LowPass::new(cutoff, step), step))
}

/// The motion with velocities as a low-pass filter shows them in steady state, at every frame.
fn filtered(motion: &Motion, filter: LowPass, step: f64) -> Motion {
    let mut seen = motion.clone();
    let mut frame = Frame::default();
    let mut output = vec![0.0; motion.samples[0].velocity.len()];
    let share = step / motion.period;
    let mut phase = 0.0;
    // One cycle to settle (ten time constants of 40 ms at the slowest), one to record.
    let settle = (1.0 / share).ceil().max(20.0 / (filter.share() + 1e-9)) as usize;
    for _ in 0..settle {
        phase = (phase + share) % 1.0;
        motion.at(phase, &mut frame);
        output.iter_mut().zip(&frame.velocity).for_each(|(y, x)| *y = filter.next(*y, *x));
    }
    let count = motion.samples.len();
    let mut travelled = 0.0;
    while travelled < 1.0 + share {
        let before = phase;
        let previous = output.clone();
        phase += share;
        travelled += share;
        motion.at(phase, &mut frame);
        output.iter_mut().zip(&frame.velocity).for_each(|(y, x)| *y = filter.next(*y, *x));
        // Frames between the two filter steps are interpolated.
        let mut index = (before * count as f64).ceil();
        while index / count as f64 <= phase {
            let mix = (index / count as f64 - before) / share;
            let target = &mut seen.samples[index as usize % count].velocity;
            for (joint, velocity) in target.iter_mut().enumerate() {
                *velocity = previous[joint] + mix * (output[joint] - previous[joint]);
            }
            index += 1.0;
        }
        phase %= 1.0;
    }
    seen
}

/// The default pose as a frame of a motion: at rest on both feet.
fn standing_frame(joints: &[Drive]) -> Frame {
    Frame {
        position: joints.iter().map(|drive| drive.default_position).collect(),
        velocity: vec![0.0; joints.len()],
        acceleration: vec![0.0; joints.len()],
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        contact: [true, true],
        ..Frame::default()
    }
}

/// The rotation of fixed-XYZ angles: Rz(yaw) Ry(pitch) Rx(roll).
fn rotation(angles: &[f64; 3]) -> UnitQuaternion<f64> {
    let [(sr, cr), (sp, cp), (sy, cy)] = angles.map(|angle| libm::sincos(0.5 * angle));
    UnitQuaternion::from_quaternion(Quaternion::new(
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::kinds::motion;
    use crate::learn::pretrain::specs;
    use crate::robot::felt_gravity;
    use crate::robot::kinematics::Kinematics;
    use crate::spec::Value;

    fn setting() -> (Robot, Motion) {
        let robot = crate::robot::shipped("tocabi").unwrap();
        let walk = motion::shipped("walk", &robot).unwrap().unwrap();
        (robot, walk)
    }

    fn draw(teacher: &mut Teacher, name: &str) -> (Vec<f32>, Vec<f32>) {
        let (mut input, mut label) = (vec![0.0; teacher.inputs()], vec![0.0; teacher.outputs()]);
        teacher.draw(&mut Stream::new(name), &mut input, &mut label);
        (input, label)
    }

    #[test]
    fn angles_and_rotation_are_inverses() {
        let angles = [0.2, -0.4, 1.1];
        let q = rotation(&angles);
        let found = crate::env::attitude::angles([q.w, q.i, q.j, q.k]);
        assert!(found.iter().zip(angles).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn without_noise_the_label_of_tracking_is_the_scheduled_gravity_compensation() {
        let (robot, walk) = setting();
        let fields = specs::still(specs::torque("tracking"));
        let mut teacher = Teacher::new(&fields, &robot, Some(&walk));
        let mut gravity = GravityCompensation::new(&robot, Weighting::EffortLimits);
        for sample in 0..20 {
            let name = format!("test/teacher/{sample}");
            let (input, label) = draw(&mut teacher, &name);
            let phase = Stream::new(&name).uniform();
            let mut frame = Frame::default();
            walk.at(phase, &mut frame);
            let held = gravity.hold(&Isometry3::identity(), &frame.position, frame.contact);
            for (joint, link) in robot.links.iter().enumerate() {
                let expected = (held.torque[joint] / link.joint.effort_limit).clamp(-1.0, 1.0);
                assert!((f64::from(label[joint]) - expected).abs() < 1e-6, "joint {joint} of sample {sample}");
                let raw = 0.15 * f64::from(input[3 + joint]) + link.joint.default_position;
                assert!((raw - frame.position[joint]).abs() < 1e-5);
            }
            assert_eq!(label[12], 0.0);
        }
    }

    #[test]
    fn without_noise_the_label_of_gravity_compensation_holds_the_pose_on_the_lower_soles() {
        let (robot, walk) = setting();
        let fields = specs::still(specs::torque("gravity_compensation"));
        let mut teacher = Teacher::new(&fields, &robot, Some(&walk));
        let mut kinematics = Kinematics::new(&robot);
        let mut gravity = GravityCompensation::new(&robot, Weighting::EffortLimits);
        let mut seen = BTreeMap::new();
        for sample in 0..300 {
            let (input, label) = draw(&mut teacher, &format!("test/teacher/{sample}"));
            // Joint positions and base from what the actor sees.
            let shown = |index: usize, scale: f64| scale * f64::from(input[index]);
            let joints = robot.links.iter().enumerate();
            let position: Vec<f64> =
                joints.clone().map(|(index, link)| shown(3 + index, 0.15) + link.joint.default_position).collect();
            let attitude = [shown(0, 0.1), shown(1, 0.1), shown(2, 0.2)];
            let base = Isometry3::from_parts(Translation3::identity(), rotation(&attitude));
            kinematics.place(&base, &position);
            let [left, right] = [0, 1].map(|side| kinematics.sole(side).translation.z);
            let apart = left - right;
            if (apart.abs() - 0.02).abs() < 1e-5 {
                // The f32 of the input does not say which side of the limit it is on.
                continue;
            }
            let contact = [apart < 0.02, apart > -0.02];
            let held = gravity.hold(&base, &position, contact);
            for (joint, link) in joints {
                let expected = (held.torque[joint] / link.joint.effort_limit).clamp(-1.0, 1.0);
                assert!((f64::from(label[joint]) - expected).abs() < 1e-5, "joint {joint} of sample {sample}");
            }
            assert_eq!(label[12], 0.0);
            *seen.entry(contact).or_insert(0) += 1;
        }
        let counts =
            [[true, true], [true, false], [false, true]].map(|contact| seen.get(&contact).copied().unwrap_or(0));
        assert!(counts.iter().all(|count| *count > 20) && seen.len() == 3, "{counts:?}");
    }

    #[test]
    fn in_tilted_gravity_the_label_carries_the_swing_of_the_reference() {
        let (robot, walk) = setting();
        let mut fields = specs::still(specs::torque("tracking"));
        if let Some(Value::Table(pretrain)) = fields.get_mut("pretrain") {
            pretrain.insert("tilted_gravity".into(), Value::Flag(true));
        }
        let mut teacher = Teacher::new(&fields, &robot, Some(&walk));
        let mut gravity = GravityCompensation::new(&robot, Weighting::EffortLimits);
        let mut furthest: f64 = 0.0;
        for sample in 0..20 {
            let name = format!("test/teacher/{sample}");
            let (_, label) = draw(&mut teacher, &name);
            let mut frame = Frame::default();
            walk.at(Stream::new(&name).uniform(), &mut frame);
            let [x, y, _] = frame.base_acceleration;
            let (upright, load) = felt_gravity([x, y]);
            let swung = gravity
                .hold(&Isometry3::from_parts(Translation3::identity(), upright), &frame.position, frame.contact)
                .clone();
            let still = gravity.hold(&Isometry3::identity(), &frame.position, frame.contact);
            for (joint, link) in robot.links.iter().enumerate() {
                let share = |torque: f64| (torque / link.joint.effort_limit).clamp(-1.0, 1.0);
                assert!((f64::from(label[joint]) - share(load * swung.torque[joint])).abs() < 1e-6, "joint {joint}");
                furthest = furthest.max((swung.torque[joint] - still.torque[joint]).abs());
            }
        }
        assert!(furthest > 20.0, "N m away from statics: {furthest}");
    }

    #[test]
    fn a_random_label_of_the_phase_action_changes_no_other_number() {
        let (robot, walk) = setting();
        let [zero, random] = ["zero", "random"].map(|word| {
            let mut fields = specs::torque("gravity_compensation");
            if let Some(Value::Table(pretrain)) = fields.get_mut("pretrain") {
                pretrain.insert("phase_label".into(), Value::Text(word.into()));
            }
            let mut teacher = Teacher::new(&fields, &robot, Some(&walk));
            (0..200).map(|sample| draw(&mut teacher, &format!("test/teacher/{sample}"))).collect::<Vec<_>>()
        });
        let (mut mean, mut square) = (0.0, 0.0);
        for ((input, label), (same_input, same_label)) in zero.iter().zip(&random) {
            assert_eq!((input, &label[..12]), (same_input, &same_label[..12]));
            let phase = f64::from(same_label[12]);
            assert!((0.0..1.0).contains(&phase));
            mean += phase / 200.0;
            square += phase * phase / 200.0;
        }
        // A uniform distribution on [0, 1): mean 1/2, mean square 1/3, with standard errors of 0.020 and 0.021.
        assert!((mean - 0.5).abs() < 0.08 && (square - 1.0 / 3.0).abs() < 0.08, "{mean} and {square}");
    }

    #[test]
    fn with_balance_the_label_of_the_reference_carries_its_swing_and_other_poses_are_brought_back() {
        let (robot, walk) = setting();
        let teacher = |keys: &[(&str, Value)], quiet: bool| {
            let mut fields = specs::torque("tracking");
            fields = if quiet { specs::still(fields) } else { fields };
            if let Some(Value::Table(pretrain)) = fields.get_mut("pretrain") {
                pretrain.insert("pressure_within".into(), specs::number(0.8));
                pretrain.extend(keys.iter().map(|(key, value)| ((*key).to_owned(), value.clone())));
            }
            Teacher::new(&fields, &robot, Some(&walk))
        };
        let furthest = |quiet: bool| -> Vec<f32> {
            let mut swung = teacher(&[("tilted_gravity", Value::Flag(true))], quiet);
            let mut balanced = teacher(&[("balance", specs::balance())], quiet);
            let differences = (0..40).map(|sample| {
                let name = format!("test/teacher/{sample}");
                let [one, other] = [&mut swung, &mut balanced].map(|teacher| draw(teacher, &name).1);
                one.iter().zip(&other).map(|(one, other)| (one - other).abs()).fold(0.0, f32::max)
            });
            differences.collect()
        };
        // Where the reference's pressure is within the soles (80 % of them), which it is for most of the cycle.
        let same = furthest(true).into_iter().filter(|difference| *difference < 1e-4).count();
        assert!(same >= 20, "{same} of 40 labels are alike");
        let brought_back = furthest(false).into_iter().filter(|difference| *difference > 0.02).count();
        assert!(brought_back > 35, "{brought_back} of 40 labels differ");
    }

    #[test]
    fn in_the_mirror_the_second_half_of_the_cycle_has_the_labels_of_the_first() {
        let (robot, walk) = setting();
        let mut fields = specs::still(specs::torque("tracking"));
        fields.insert("learn".into(), specs::table(&[("symmetry", specs::text("phase_mirror"))]));
        let mut teacher = Teacher::new(&fields, &robot, Some(&walk));
        let mut gravity = GravityCompensation::new(&robot, Weighting::EffortLimits);
        let mut mirrored = 0;
        for sample in 0..20 {
            let name = format!("test/teacher/{sample}");
            let (_, label) = draw(&mut teacher, &name);
            let phase = Stream::new(&name).uniform();
            mirrored += usize::from(phase >= 0.5);
            let mut frame = Frame::default();
            walk.at(phase % 0.5, &mut frame);
            let held = gravity.hold(&Isometry3::identity(), &frame.position, frame.contact);
            for (joint, link) in robot.links.iter().enumerate() {
                let expected = (held.torque[joint] / link.joint.effort_limit).clamp(-1.0, 1.0);
                assert!((f64::from(label[joint]) - expected).abs() < 0.02, "joint {joint} at phase {phase}");
            }
        }
        assert!(mirrored > 3);
    }

    #[test]
    fn a_position_label_makes_the_servo_give_the_torque() {
        let (robot, walk) = setting();
        let mut torque = Teacher::new(&specs::torque("tracking"), &robot, Some(&walk));
        let mut position = Teacher::new(&specs::position("tracking"), &robot, Some(&walk));
        for sample in 0..10 {
            let name = format!("test/teacher/{sample}");
            let (_, shares) = draw(&mut torque, &name);
            let (_, targets) = draw(&mut position, &name);
            let State { position: q, velocity: qd, .. } = &position.state;
            for (joint, link) in robot.links.iter().enumerate() {
                let Drive { stiffness, damping, .. } = position.joints[joint];
                let half = 0.5 * (link.joint.upper - link.joint.lower);
                let target = link.joint.default_position + half * f64::from(targets[joint]);
                // The spec asks for 12.5 % of the stiffness, so the damping is its square root.
                let servo = 0.125 * stiffness * (target - q[joint]) - 0.125f64.sqrt() * damping * qd[joint];
                let wanted = f64::from(shares[joint]) * link.joint.effort_limit;
                assert!((servo - wanted).abs() < 1e-3, "{servo} is not {wanted}");
            }
        }
    }

    #[test]
    fn the_filter_delays_a_sine_by_its_phase_and_weakens_it_by_its_gain() {
        let count = 256;
        let frame = |index: usize| Frame {
            velocity: vec![libm::sin(std::f64::consts::TAU * index as f64 / f64::from(count))],
            position: vec![0.0],
            acceleration: vec![0.0],
            ..Frame::default()
        };
        let samples = (0..count as usize).map(frame).collect();
        let motion = Motion { name: "sine".into(), period: 0.66, speed: 0.0, samples };
        let seen = filtered(&motion, LowPass::new(4.0, 1e-4), 1e-4);
        let ratio = 1.0 / 0.66 / 4.0;
        for (index, sample) in seen.samples.iter().enumerate() {
            let angle = std::f64::consts::TAU * index as f64 / f64::from(count) - libm::atan(ratio);
            let expected = libm::sin(angle) / libm::sqrt(1.0 + ratio * ratio);
            assert!((sample.velocity[0] - expected).abs() < 2e-3, "{index}: {} is not {expected}", sample.velocity[0]);
        }
    }
}
