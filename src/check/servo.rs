//! W0512: a position servo that its torque delay makes unstable.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::Subject;
use super::delay::longest;
use super::subject::{duration, short};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::action::Action;
use crate::kinds::action::position::Position;
use crate::robot::{Joint, Kinematics, Robot};

/// Phase margin in rad of the suggested damping: 30 degrees.
const MARGIN: f64 = PI / 6.0;

/// Share of the control rate up to which a policy can stabilize an oscillation.
const SEEN: f64 = 0.1;

/// In the air, at the longest delay drawn, no joint's servo oscillates faster than the policy can stabilize.
pub fn servos_bear_their_delay(subject: &Subject, sink: &mut Sink) {
    let (Some(robot), Some(Action::Position(servo))) = (subject.robot, subject.part::<Action>()) else {
        return;
    };
    let Some(lag) = lag(subject, &servo) else { return };
    let (stiffness, damping) = servo.gains();
    let shares = Shares { stiffness, damping };
    let loops = loops(robot);
    let seen = SEEN * servo.rate;
    let unstable =
        || loops.iter().filter(|servo| servo.margin(shares, lag) < 0.0 && servo.frequency(shares) > seen);
    let Some(worst) = unstable().min_by(|a, b| a.margin(shares, lag).total_cmp(&b.margin(shares, lag)))
    else {
        return;
    };
    let also = match unstable().count() - 1 {
        0 => String::new(),
        1 => " (and of one more joint)".to_owned(),
        others => format!(" (and of {others} more joints)"),
    };
    let undamped = shares.damping * worst.joint.damping_gain == 0.0;
    let why = if undamped { "has no damping and is unstable" } else { "is unstable" };
    let message = format!("the servo of `{}`{also} {why} at the longest delay", worst.joint.name);
    let reason = format!(
        "K_d = {} N m s/rad, {} late, on {} kg m^2 with the leg in the air: {:.0} Hz",
        short(shares.damping * worst.joint.damping_gain),
        duration(lag),
        short(worst.inertia),
        worst.frequency(shares)
    );
    let mut diagnostic = Diagnostic::warning("W0512", message);
    if let Some(place) = subject.place(&Position::damping.path()) {
        diagnostic = diagnostic.at(place, reason);
    }
    if let Some(place) = subject.place(&Position::delay.path()) {
        diagnostic = diagnostic.note(place, "delays the servo's torque");
    }
    sink.emit(match stable(&loops, shares, lag) {
        Some((share, degrees)) => {
            let share = format!("\"{} %\"", short((1000.0 * share).round() / 10.0));
            let diagnostic = diagnostic.help(format!(
                "with `damping = {share}` every joint has a phase margin of at least {degrees} deg"
            ));
            subject.edited(&Position::damping.path(), share, diagnostic)
        }
        None => diagnostic.help("lower the stiffness or the delay: no damping makes the servo stable"),
    });
}

/// The largest damping below that of the spec, in shares of the robot's own, that gives every joint
/// [`MARGIN`], or else the one with the largest margin; and the phase margin in degrees. If none below it makes
/// the servo stable, those above it are tried, up to twice the robot's own. `None` if no damping does.
fn stable(loops: &[Loop], shares: Shares, lag: f64) -> Option<(f64, f64)> {
    let Shares { stiffness, damping } = shares;
    let least = |damping: f64| {
        loops
            .iter()
            .map(|servo| servo.margin(Shares { stiffness, damping }, lag))
            .fold(f64::INFINITY, f64::min)
    };
    let best = |shares: &mut dyn Iterator<Item = f64>| {
        let margins = shares.map(|share| (share, least(share).min(MARGIN)));
        margins.reduce(|a, b| if b.1 > a.1 { b } else { a }).filter(|(_, margin)| *margin > 0.0)
    };
    let smaller = || best(&mut (1..100).rev().map(|percent| damping * f64::from(percent) / 100.0));
    let larger =
        || best(&mut (1..=200).map(|percent| f64::from(percent) / 100.0).filter(|share| *share > damping));
    let found = if damping > 0.0 { smaller().or_else(larger) } else { larger() };
    found.map(|(share, margin)| (share, margin.to_degrees().round()))
}

/// The longest time in s between the servo's reading and its torque: the delay, half of the servo's hold
/// time, and half of the time over which it measures velocity.
fn lag(subject: &Subject, servo: &Position) -> Option<f64> {
    let (delay, _) = longest(subject)?;
    let measuring = servo.reads_encoders().then(|| subject.physics_step());
    Some(delay + 0.5 / servo.servo_rate + 0.5 * measuring.flatten().unwrap_or(0.0))
}

/// The servos' gains in shares of the robot's own.
#[derive(Clone, Copy)]
struct Shares {
    stiffness: f64,
    damping: f64,
}

/// One joint's servo, with the robot in the air and its other joints free.
struct Loop<'a> {
    joint: &'a Joint,
    /// Effective inertia at the joint in kg m^2.
    inertia: f64,
}

impl Loop<'_> {
    /// The gains in N m/rad and N m s/rad.
    fn gains(&self, shares: Shares) -> (f64, f64) {
        (shares.stiffness * self.joint.stiffness_gain, shares.damping * self.joint.damping_gain)
    }

    /// Crossover frequency in Hz, at which the loop gain is one; the gain falls with frequency. Zero if it is
    /// always below one.
    fn frequency(&self, shares: Shares) -> f64 {
        let ((stiffness, damping), viscous) = (self.gains(shares), self.joint.damping);
        let lead = damping * damping - viscous * viscous;
        let squares = (lead + libm::sqrt(lead * lead + 4.0 * (self.inertia * stiffness).powi(2))) / 2.0;
        libm::sqrt(squares.max(0.0)) / self.inertia / TAU
    }

    /// Phase margin in rad of `(K_d s + K_p) exp(-lag s) / (I s^2 + d s)` with these shares of the robot's
    /// own gains; negative if the loop is unstable.
    fn margin(&self, shares: Shares, lag: f64) -> f64 {
        let (stiffness, damping) = self.gains(shares);
        let frequency = TAU * self.frequency(shares);
        if frequency == 0.0 {
            return f64::INFINITY;
        }
        let rising = libm::atan2(damping * frequency, stiffness);
        let falling = libm::atan2(self.inertia * frequency, self.joint.damping);
        FRAC_PI_2 + rising - falling - frequency * lag
    }
}

fn loops(robot: &Robot) -> Vec<Loop<'_>> {
    let Some(mobility) = Kinematics::new(robot).mass_matrix().try_inverse() else { return Vec::new() };
    let inertia = |index: usize| 1.0 / mobility[(6 + index, 6 + index)];
    robot
        .links
        .iter()
        .enumerate()
        .map(|(index, link)| Loop { joint: &link.joint, inertia: inertia(index) })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::robots::sample::biped;
    use super::super::subject::sample::found;
    use super::*;

    /// Whether a pendulum without gravity oscillates: the servo reads and holds as in the environment.
    fn swings_up(inertia: f64, (stiffness, damping): (f64, f64), late: usize) -> bool {
        let step = 2e-5;
        let (hold, delay) = (100, late * 100);
        let mut torques = vec![0.0; delay];
        let (mut position, mut velocity, mut wanted) = (1e-3_f64, 0.0, 0.0);
        let mut late = 0.0_f64;
        for tick in 0..200_000 {
            if tick % hold == 0 {
                wanted = -stiffness * position - damping * velocity;
            }
            torques.push(wanted);
            velocity += torques[tick] / inertia * step;
            position += velocity * step;
            if tick > 150_000 {
                late = late.max(position.abs());
            }
        }
        late > 1e-3
    }

    #[test]
    fn the_margin_tells_what_swings_up() {
        let mut robot = biped();
        let joint = &mut robot.links[0].joint;
        joint.damping = 0.0;
        let (inertia, joint) = (0.02, joint.clone());
        for late in [1, 3] {
            let lag = late as f64 * 0.002 + 0.001;
            for (stiffness, damping) in
                [(40.0, 1.0), (40.0, 5.0), (40.0, 15.0), (5.0, 0.05), (200.0, 2.5), (400.0, 1.0)]
            {
                let shares = Shares {
                    stiffness: stiffness / joint.stiffness_gain,
                    damping: damping / joint.damping_gain,
                };
                let margin = Loop { joint: &joint, inertia }.margin(shares, lag);
                assert!(margin.abs() > 0.02, "too near to tell: {margin}");
                assert_eq!(
                    margin < 0.0,
                    swings_up(inertia, (stiffness, damping), late),
                    "{stiffness} {damping} {late}"
                );
            }
        }
    }

    #[test]
    fn the_longest_delay_counts_and_less_damping_is_advised() {
        let said = |stiffness: f64, delay: f64| {
            let text = format!(
                "physics = {{ rate = 500 }}\naction = \
                 {{ rate = 125, kind = \"position\", stiffness = {stiffness:?}, damping = \"fixed\", std = \
                 0.1, \
                 servo_rate = 500, delay = {delay:?} }}\n[randomize.action_delay]\nkind = \
                 \"action_delay\"\nscale = [0.5, 1.5]"
            );
            found(servos_bear_their_delay, &text, Some(&biped()))
        };
        assert_eq!(said(0.01, 0.0), []);
        // Slow enough for the policy to stabilize.
        assert_eq!(said(0.01, 0.05), []);
        let found = said(4.0, 0.02);
        assert_eq!(found.iter().map(|found| found.code).collect::<Vec<_>>(), ["W0512"]);
        assert!(found[0].message.ends_with("is unstable at the longest delay"), "{}", found[0].message);
    }

    #[test]
    fn a_servo_without_damping_is_told_so_and_some_damping_is_advised() {
        let mut robot = biped();
        robot.links.iter_mut().for_each(|link| link.joint.damping_gain = 100.0);
        let text = "physics = { rate = 500 }\naction = { rate = 125, kind = \"position\", stiffness = 4.0, \
                    damping = 0.0, std = 0.1, servo_rate = 500, delay = 0.002 }";
        let found = found(servos_bear_their_delay, text, Some(&robot));
        assert_eq!(found.iter().map(|found| found.code).collect::<Vec<_>>(), ["W0512"]);
        assert!(found[0].message.contains("has no damping and is unstable"), "{}", found[0].message);
        assert!(found[0].help[0].starts_with("with `damping = \""), "{:?}", found[0].help);
    }
}
