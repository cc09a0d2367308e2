//! What a robot of one's own asks for: labels as soft and an exploration as strong, for its weight, as those of the robots
//! that come with the program and walk.
//!
//! Specs give both as shares of what a robot's file says, and files differ: for their weight G1's gains are an eleventh of
//! TOCABI's and its motors a third stronger. The measure is the torque that holds the robot's weight at the height at which it
//! stands, `m g h` in N m, and each figure is the geometric mean over the joints of the left leg
//! (`docs/design/learner.md`, "A robot of one's own").

use crate::robot::{GRAVITY, Joint, Kinematics, Robot, legs};

/// Stiffness of the labels in m g h per rad: TOCABI's walk has 0.22, Atlas' 0.13, G1's 0.16.
const SOFTNESS: f64 = 0.17;
/// Exploration with torque, as a share of m g h. Atlas and G1 squat with 0.012 and 0.010, TOCABI and Atlas run with 0.026 and
/// 0.023.
const EXPLORATION: [(&str, f64); 2] = [("squat", 0.011), ("run", 0.025)];
/// The exploration of all other tasks: TOCABI walks with 0.026, Atlas with 0.023 and 0.012, G1 with 0.017.
const WALKS_WITH: f64 = 0.02;
/// The exploration of a walk's last part: 0.0064 (TOCABI), 0.0058 (Atlas), 0.0086 (G1).
const LAST_PART: f64 = 0.007;

/// The largest share that the keys take.
const MOST: f64 = 10.0;

/// How a robot is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Build {
    /// The height at which it stands, in m.
    pub stands: f64,
    /// `stiffness_gain` of a leg's joint in m g h per rad; `None` where a joint has none.
    pub stiffness: Option<f64>,
    /// Effort limit of a leg's joint as a share of m g h; `None` where a joint has none.
    pub effort: Option<f64>,
}

impl Build {
    /// That of a robot.
    pub fn of(robot: &Robot) -> Self {
        let stands = robot.standing_height;
        let unit = robot.total_mass() * GRAVITY * stands;
        let leg = legs::own(&Kinematics::new(robot), 0);
        let mean = |figure: fn(&Joint) -> f64| {
            let sum: f64 = leg.iter().map(|joint| libm::log(figure(&robot.links[*joint].joint))).sum();
            Some(libm::exp(sum / leg.len() as f64) / unit).filter(|mean| mean.is_normal())
        };
        Self { stands, stiffness: mean(|joint| joint.stiffness_gain), effort: mean(|joint| joint.effort_limit) }
    }

    /// Labels' stiffness as a share of the robot's own gains, and their damping, which falls with its root.
    pub fn labels(&self, task: &str) -> Option<[String; 2]> {
        let soft = if task == "run" { 2.0 * SOFTNESS } else { SOFTNESS };
        let share = soft / self.stiffness?;
        Some([percent(share), percent(share.sqrt())])
    }

    /// The exploration of a task as a share of the effort limits.
    pub fn exploration(&self, task: &str) -> Option<String> {
        let of = EXPLORATION.iter().find(|(known, _)| *known == task).map_or(WALKS_WITH, |(_, of)| *of);
        Some(percent(of / self.effort?))
    }

    /// The exploration of a walk's last part.
    pub fn last_exploration(&self) -> Option<String> {
        Some(percent(LAST_PART / self.effort?))
    }
}

/// A share with two significant digits.
fn percent(share: f64) -> String {
    let percent = 100.0 * share.min(MOST);
    let digits = (1.0 - libm::log10(percent).floor()).max(0.0) as usize;
    format!("{percent:.digits$} %")
}
