//! Low-level control laws: torques from actions, directly or through a position servo.

use crate::kinds::action::Action;
use crate::kinds::action::position::{Position, SharesOf, Span, Targets};
use crate::robot::{Joint, Robot};

use super::motor;

/// A compiled low-level law. Vectors are in joint order; an action of the law has one number per joint (the
/// phase action is handled elsewhere).
#[derive(Clone, Debug, PartialEq)]
pub struct Law {
    joints: Vec<Drive>,
    position: bool,
    servo_rate: Option<f64>,
    measured: bool,
    deviation: f64,
    speed_limited: bool,
}

/// Parameters of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Drive {
    effort: f64,
    speed: f64,
    /// Bounds of the command.
    limits: [f64; 2],
    centre: f64,
    /// Command for an action of 1, in rad.
    span: f64,
    stiffness: f64,
    damping: f64,
}

impl Law {
    /// The law of `[action]` for this robot.
    pub fn new(action: &Action, robot: &Robot) -> Self {
        let servo = action.servo();
        let joints = robot.links.iter().map(|link| match servo {
            Some(servo) => Drive::servo(servo, &link.joint),
            None => Drive::torque(&link.joint),
        });
        Self {
            joints: joints.collect(),
            position: servo.is_some(),
            servo_rate: servo.map(|servo| servo.servo_rate),
            measured: servo.is_some_and(Position::reads_encoders),
            deviation: action.std() / servo.map_or(1.0, |servo| servo.scale),
            speed_limited: action.motor_speed_limit(),
        }
    }

    /// Rate of the position servo in Hz; `None` under torque control.
    pub fn servo_rate(&self) -> Option<f64> {
        self.servo_rate
    }

    /// Whether the position servo reads its encoders; otherwise it reads the true positions and velocities.
    pub fn reads_encoders(&self) -> bool {
        self.measured
    }

    /// Standard deviation of the exploration noise in units of the action.
    pub fn deviation(&self) -> f64 {
        self.deviation
    }

    /// Proportional gains in N m/rad and derivative gains in N m s/rad; zero under torque control.
    pub fn gains(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.joints.iter().map(|drive| (drive.stiffness, drive.damping))
    }

    /// Command for an action of 1 at each joint: in N m under torque control, in rad from the default
    /// position under position control.
    pub fn units(&self) -> impl Iterator<Item = f64> + '_ {
        self.joints.iter().map(|drive| if self.position { drive.span } else { drive.effort })
    }

    /// The bounds of each joint's command, in N m under torque control, in rad under position control.
    pub fn limits(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.joints.iter().map(|drive| drive.limits)
    }

    /// The effective range of each joint's action: [`Law::command`] clips values beyond it.
    pub fn ranges(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.joints.iter().map(|drive| match self.position {
            true => drive.limits.map(|end| (end - drive.centre) / drive.span),
            false => [-1.0, 1.0],
        })
    }

    /// The command of an action: torques in N m, or joint positions in rad. Called once per control step.
    pub fn command(&self, action: &[f64], command: &mut [f64]) {
        for ((drive, action), command) in self.joints.iter().zip(action).zip(command) {
            *command = if self.position {
                (drive.centre + action * drive.span).clamp(drive.limits[0], drive.limits[1])
            } else {
                action.clamp(-1.0, 1.0) * drive.effort
            };
        }
    }

    /// The torques in N m for a command, at these joint positions in rad and velocities in rad/s, within the
    /// effort limits. Called once per servo step.
    pub fn torque(&self, command: &[f64], position: &[f64], velocity: &[f64], torque: &mut [f64]) {
        if !self.position {
            torque.copy_from_slice(command);
            return;
        }
        for (index, drive) in self.joints.iter().enumerate() {
            let wanted =
                drive.stiffness * (command[index] - position[index]) - drive.damping * velocity[index];
            torque[index] = wanted.clamp(-drive.effort, drive.effort);
        }
    }

    /// The action whose command gives these torques in N m in this state (for labels of pre-training); not
    /// clipped, so it may exceed the effective range.
    pub fn action(&self, torque: &[f64], position: &[f64], velocity: &[f64], action: &mut [f64]) {
        for (index, drive) in self.joints.iter().enumerate() {
            action[index] = if self.position {
                let target =
                    position[index] + (torque[index] + drive.damping * velocity[index]) / drive.stiffness;
                (target - drive.centre) / drive.span
            } else {
                torque[index] / drive.effort
            };
        }
    }

    /// Applies the motors' speed limit if the spec sets it. Called once per physics step.
    pub fn restrict(&self, velocity: &[f64], torque: &mut [f64]) {
        if self.speed_limited {
            for (index, drive) in self.joints.iter().enumerate() {
                torque[index] = motor::limited(torque[index], velocity[index], drive.speed);
            }
        }
    }
}

impl Drive {
    /// A joint whose torque is commanded.
    fn torque(joint: &Joint) -> Self {
        Self {
            effort: joint.effort_limit,
            speed: joint.velocity_limit,
            limits: [-joint.effort_limit, joint.effort_limit],
            centre: joint.default_position,
            span: 0.5 * (joint.upper - joint.lower),
            stiffness: 0.0,
            damping: 0.0,
        }
    }

    /// A joint with a position servo.
    fn servo(servo: &Position, joint: &Joint) -> Self {
        let (proportional, derivative) = servo.gains();
        let (stiffness, damping) = (proportional * joint.stiffness_gain, derivative * joint.damping_gain);
        let limits = match servo.targets {
            Some(Targets::EffortLimits) if stiffness > 0.0 => {
                let beyond = joint.effort_limit / stiffness;
                [joint.lower - beyond, joint.upper + beyond]
            }
            _ => [joint.lower, joint.upper],
        };
        Self {
            limits,
            span: servo.scale * share(servo, joint, stiffness),
            stiffness,
            damping,
            ..Self::torque(joint)
        }
    }
}

/// The angle in rad that `scale` and `std` of a position action are relative to: half of the joint's range,
/// the error at which the servo with this gain in N m/rad reaches the joint's effort limit, or a fixed angle.
/// A joint without a servo has no such error.
fn share(servo: &Position, joint: &Joint, stiffness: f64) -> f64 {
    match servo.shares_of {
        Some(SharesOf::Span(Span::EffortLimits)) if stiffness > 0.0 => joint.effort_limit / stiffness,
        Some(SharesOf::Angle(angle)) => angle,
        _ => 0.5 * (joint.upper - joint.lower),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

    use super::*;
    use crate::robot::model::{Body, Foot, Joint, Link};
    use crate::spec::typed::sample::part;

    fn robot() -> Robot {
        let body = || Body {
            name: "body".into(),
            mass: 1.0,
            com: Point3::origin(),
            inertia: Matrix3::identity(),
            collisions: Vec::new(),
        };
        let joint = Joint {
            name: "knee".into(),
            origin: Isometry3::identity(),
            axis: Vector3::y_axis(),
            lower: -0.2,
            upper: 1.8,
            effort_limit: 200.0,
            velocity_limit: 4.0,
            damping: 0.0,
            friction: 0.0,
            armature: 0.0,
            stiffness_gain: 1600.0,
            damping_gain: 20.0,
            default_position: 0.6,
        };
        let foot =
            Foot { link: 0, half_extents: Vector3::repeat(0.1), centre: Point3::origin(), friction: 1.0 };
        Robot {
            name: "leg".into(),
            base: body(),
            links: vec![Link { body: body(), parent: None, joint }],
            feet: [foot.clone(), foot],
            mirror: vec![(0, 1.0)],
            standing_height: 1.0,
        }
    }

    /// The law of an action with these keys, with default rate and exploration.
    fn law(keys: &str) -> Law {
        Law::new(&part::<Action>(&format!("rate = \"250 Hz\"\nstd = \"2 %\"\n{keys}")), &robot())
    }

    fn torque() -> Law {
        law("kind = \"torque\"")
    }

    fn position(stiffness: &str, keys: &str) -> Law {
        law(&format!("kind = \"position\"\nservo_rate = \"500 Hz\"\nstiffness = \"{stiffness}\"\n{keys}"))
    }

    fn servo(damping: &str, scale: &str) -> Law {
        position("25 %", &format!("damping = \"{damping}\"\nscale = \"{scale}\""))
    }

    #[test]
    fn a_torque_action_is_a_share_of_the_effort_limit_and_clipped() {
        let law = torque();
        let mut command = [0.0];
        for (action, expected) in [(0.25, 50.0), (-3.0, -200.0), (1.5, 200.0)] {
            law.command(&[action], &mut command);
            assert_eq!(command, [expected]);
        }
        let mut torque = [0.0];
        law.torque(&[50.0], &[0.0], &[9.0], &mut torque);
        assert_eq!((torque, law.deviation()), ([50.0], 0.02));
        assert_eq!(law.ranges().collect::<Vec<_>>(), [[-1.0, 1.0]]);
    }

    #[test]
    fn a_position_action_moves_the_target_by_half_ranges_within_the_limits() {
        let mut command = [0.0];
        for (action, expected) in [(0.0, 0.6), (-0.5, 0.1), (9.0, 1.8)] {
            servo("sqrt", "100 %").command(&[action], &mut command);
            assert!((command[0] - expected).abs() < 1e-12);
        }
        servo("sqrt", "10 %").command(&[1.0], &mut command);
        assert!((command[0] - 0.7).abs() < 1e-12);
        let [low, high] = servo("sqrt", "10 %").ranges().next().unwrap();
        assert!((low + 8.0).abs() < 1e-12 && (high - 12.0).abs() < 1e-12, "{low}, {high}");
        assert!((servo("sqrt", "10 %").deviation() - 0.2).abs() < 1e-12);
    }

    #[test]
    fn targets_within_the_effort_limits_let_a_soft_servo_give_all_its_torque() {
        // 16 N m/rad: the limit is at most 2 rad away, and 200 N m would take 12.5 rad.
        for (targets, most) in [("joint_limits", 16.0 * 1.2), ("effort_limits", 200.0)] {
            let law = position("1 %", &format!("targets = \"{targets}\""));
            let (mut command, mut torque) = ([0.0], [0.0]);
            law.command(&[1e3], &mut command);
            law.torque(&command, &[0.6], &[0.0], &mut torque);
            assert!((torque[0] - most).abs() < 1e-9, "{targets}: {torque:?}");
            assert_eq!(law.limits().next().map(|limits| limits[1]), Some(command[0]));
            let range = law.ranges().next().unwrap();
            assert!((0.6 + range[1] - command[0]).abs() < 1e-12, "{range:?}");
        }
    }

    #[test]
    fn shares_of_the_effort_limits_explore_with_the_same_torque_at_every_gain() {
        for stiffness in [0.01, 0.25, 1.0] {
            let keys = "scale = \"50 %\"\nshares_of = \"effort_limits\"\ntargets = \"effort_limits\"";
            let law = position(&format!("{} %", 100.0 * stiffness), keys);
            let (mut command, mut torque) = ([0.0], [0.0]);
            law.command(&[law.deviation()], &mut command);
            law.torque(&command, &[0.6], &[0.0], &mut torque);
            // The exploration has a standard deviation of 2 %, here of 200 N m.
            assert!((torque[0] - 0.02 * 200.0).abs() < 1e-9, "{stiffness}: {torque:?}");
            assert!((law.units().next().unwrap() * stiffness * 1600.0 - 100.0).abs() < 1e-9);
        }
    }

    #[test]
    fn shares_of_an_angle_are_the_same_at_every_joint_and_targets_stay_within_its_limits() {
        let law = position("25 %", "scale = \"10 %\"\nshares_of = \"1.5 rad\"");
        let mut command = [0.0];
        for (action, expected) in [(law.deviation(), 0.6 + 0.02 * 1.5), (1.0, 0.6 + 0.15), (10.0, 1.8)] {
            law.command(&[action], &mut command);
            assert!((command[0] - expected).abs() < 1e-12, "{action}: {command:?}");
        }
    }

    #[test]
    fn derivative_gains_follow_the_stiffness_as_the_spec_says() {
        let damping = |word| servo(word, "100 %").gains().next();
        assert_eq!(damping("sqrt"), Some((400.0, 10.0)));
        assert_eq!(damping("linear"), Some((400.0, 5.0)));
        assert_eq!(damping("fixed"), Some((400.0, 20.0)));
    }

    #[test]
    fn the_servo_is_a_pd_within_the_effort_limit() {
        let mut torque = [0.0];
        servo("sqrt", "100 %").torque(&[0.7], &[0.6], &[1.0], &mut torque);
        assert!((torque[0] - (400.0 * 0.1 - 10.0)).abs() < 1e-9);
        servo("sqrt", "100 %").torque(&[0.7], &[-0.2], &[0.0], &mut torque);
        assert_eq!(torque, [200.0]);
    }

    #[test]
    fn the_action_of_a_torque_gives_that_torque_back() {
        let (position, velocity) = ([0.4], [-0.3]);
        for law in [servo("linear", "20 %"), torque()] {
            let (mut action, mut command, mut torque) = ([0.0], [0.0], [0.0]);
            law.action(&[-37.0], &position, &velocity, &mut action);
            law.command(&action, &mut command);
            law.torque(&command, &position, &velocity, &mut torque);
            assert!((torque[0] + 37.0).abs() < 1e-9);
        }
    }

    #[test]
    fn the_motor_limit_holds_only_where_it_is_asked_for() {
        let limited = law("kind = \"torque\"\nmotor_speed_limit = true");
        for (law, expected) in [(torque(), 50.0), (limited, 0.0)] {
            let mut torque = [50.0];
            law.restrict(&[5.0], &mut torque);
            assert_eq!(torque, [expected]);
        }
    }
}
