//! New specs for `specforge new`: children of the parents in `specs/base/`, standalone specs with everything
//! in them, and suites over a spec. The parents are included in the program.

mod alone;
pub mod motion;
mod own;
mod parents;

pub use parents::{actions, parent, tasks};

use crate::format::{Order, Sort, format};
use crate::robot::{self, Proportions};

/// Settings of a new spec.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish {
    /// Its name, which is also the file's name.
    pub name: String,
    /// The robot.
    pub robot: String,
    /// The task: a parent with this name.
    pub task: String,
    /// The action: a parent with this name.
    pub action: String,
    /// The proportions of a robot that is not shipped with the program.
    pub build: Option<Proportions>,
    /// The name of a motion of its own; by default the task's.
    pub motion: Option<String>,
}

/// Height at which TOCABI's episodes end, as a share of its pelvis height.
const LOWEST: f64 = 0.65;
/// Deviation of the base's origin from the pelvis, as a share of the pelvis height, from which the parents'
/// bounds do not fit.
const BESIDE: f64 = 0.1;
/// Height in m below which the parents' height bounds do not fit: those of TOCABI and Atlas, which are 0.9 m
/// high or more.
const SMALL: f64 = 0.85;

/// The comment of a quantity that a user's robot turns into a share.
const RELATIVE: &str = " # mgh: the robot's weight times the height of its pelvis";

impl Wish {
    /// The lines that depend on the robot.
    fn own(&self) -> String {
        let bound = |build: Proportions| {
            let (sinks, share) = ((1.0 - LOWEST) * build.stands, 100.0 * (1.0 - LOWEST));
            let bound = build.base - sinks;
            let table = |above: &str| {
                format!(
                    "[{above}terminate.base_height]\nbelow = \"{bound:.2} m\" # standing height {:.2} m, minus \
                     {share:.0} % of the pelvis height\n\n",
                    build.base
                )
            };
            // A profile of a parent would override the robot's own bound.
            let profiles = parents::profiles_with(&self.family(), &["terminate", "base_height", "below"]);
            let own = profiles.iter().map(|profile| table(&format!("profile.{profile}.")));
            std::iter::once(table("")).chain(own).collect::<String>()
        };
        let shipped = || robot::shipped(&self.robot).map(|robot| Proportions::of(&robot));
        let is_other = |build: &Proportions| {
            build.stands < SMALL || (build.base - build.stands).abs() > BESIDE * build.stands
        };
        let small = self.build.or_else(shipped).filter(is_other);
        let bound = small.map(bound).unwrap_or_default();
        let desk =
            format!("{}{}{}{}", self.desk_action(), self.quick_action(), self.labels(), self.last_part());
        let motion = self.motion.as_ref().map(|name| format!("[task]\nmotion = \"{name}\"\n\n"));
        format!("{}{}{}{bound}{desk}", motion.unwrap_or_default(), self.own_action(), self.filter())
    }

    /// A one-sentence summary.
    fn summary(&self) -> String {
        let action = match self.action.as_str() {
            "position" => "joint position targets and a PD servo",
            _ => "direct joint torque commands",
        };
        format!("{} {}s under {action}", self.robot, self.task)
    }

    /// The names of the parents; later ones win.
    pub fn family(&self) -> Vec<&str> {
        parents::family(&self.task, &self.action, &self.robot)
    }

    /// The robot-dependent lines of `[action]`: only TOCABI's file has gains that the paper divides by 8, and
    /// G1's motors are a third stronger relative to weight and height.
    fn own_action(&self) -> String {
        match (self.action.as_str(), self.robot.as_str()) {
            ("torque", "g1") if self.task != "squat" => {
                "[action]\nstd = \"5 %\" # of each joint's effort limit\n\n".to_owned()
            }
            ("torque", _) => {
                let own = self.build.and_then(|build| own::exploration(&build, &self.task));
                own.map(|std| format!("[action]\nstd = \"{std}\"{RELATIVE}\n\n")).unwrap_or_default()
            }
            ("position", robot) if robot != "tocabi" && !self.has_a_servo() => {
                let damping = match robot {
                    "atlas" | "g1" => {
                        "damping = \"50 %\" # stable for its light ankles at a delay of 6 ms (W0512)\n"
                    }
                    _ => "",
                };
                format!("[action]\nstiffness = \"100 %\" # of the gains in the robot's file\n{damping}\n")
            }
            _ => String::new(),
        }
    }

    /// The velocity filter of a user's robot: the paper's 4 Hz suits a robot with slowly swinging legs.
    fn filter(&self) -> &'static str {
        match self.task.as_str() {
            "walk" | "squat" | "run" if self.build.is_some() => {
                "[observe.joint_velocity]\nlow_pass = \"20 Hz\" # the paper's 4 Hz is too slow for light \
                 legs\n\n"
            }
            _ => "",
        }
    }

    /// The stiffness of the labels: the parents give a share of the gains in the robot's file, and files
    /// differ.
    fn labels(&self) -> String {
        let Some([stiffness, damping]) = self.build.and_then(|build| own::labels(&build, &self.task)) else {
            return String::new();
        };
        let table = |profile: &str| {
            format!(
                "[profile.{profile}.pretrain]\nstiffness = \"{stiffness}\"{RELATIVE}\ndamping = \"{damping}\" # \
                 with the passive damping of the joints\n\n"
            )
        };
        ["desk", "quick"].map(table).concat()
    }

    /// Whether a parent sets the robot's servo.
    fn has_a_servo(&self) -> bool {
        self.family().iter().any(|name| *name == format!("{}_servo", self.robot))
    }

    /// The lines of `[profile.desk.action]`: the profile trains a run with more exploration than the paper,
    /// and position control with a soft servo.
    fn desk_action(&self) -> String {
        let std = match self.task.as_str() {
            "run" => {
                let own = self.build.as_ref().and_then(own::running_exploration);
                let share = own.unwrap_or(if self.robot == "g1" { "14 %" } else { "20 %" });
                format!("std = \"{share}\" # less exploration: runs later, less robust to other bodies\n")
            }
            _ => self.own_noise(),
        };
        table("profile.desk.action", &[self.own_servo(), std])
    }

    /// The lines of `[profile.quick.action]`.
    fn quick_action(&self) -> String {
        table("profile.quick.action", &[self.own_servo(), self.own_noise()])
    }

    /// The servo with which a user's robot trains.
    fn own_servo(&self) -> String {
        let build = self.build.filter(|_| self.moves_with_a_servo());
        let stiffness = build.as_ref().and_then(own::servo);
        let line = |stiffness| format!("stiffness = \"{stiffness}\"{RELATIVE}\n");
        stiffness.map(line).unwrap_or_default()
    }

    /// The exploration with which a user's robot trains under position control.
    fn own_noise(&self) -> String {
        let build = self.build.filter(|_| self.moves_with_a_servo());
        let std = build.and_then(|build| own::exploration(&build, &self.task));
        std.map(|std| format!("std = \"{std}\"{RELATIVE}\n")).unwrap_or_default()
    }

    fn moves_with_a_servo(&self) -> bool {
        self.action == "position" && self.task != "stand"
    }

    /// Walks and runs end with reduced exploration.
    fn last_part(&self) -> String {
        let (part, shipped) = match (self.task.as_str(), self.robot.as_str()) {
            ("walk", _) => ("quarter", "2.5 %"),
            ("run", "g1") => ("fifth", "3.5 %"),
            ("run", _) => ("fifth", "5 %"),
            _ => return String::new(),
        };
        let own = self.build.and_then(|build| own::last_exploration(&build, &self.task));
        let share = own.unwrap_or(shipped);
        format!(
            "[profile.desk.fine_tune]\nstd = \"{share}\" # little exploration in the last {part} of the \
             samples\n\n"
        )
    }
}

/// A table with these lines, or nothing without lines.
fn table(name: &str, lines: &[String]) -> String {
    let lines = lines.concat();
    if lines.is_empty() { lines } else { format!("[{name}]\n{lines}\n") }
}

/// A spec that extends the parents in the folder `base`, relative to the new file; `schema` is the path of
/// the schema.
pub fn child(wish: &Wish, base: &str, schema: Option<&str>) -> String {
    let Wish { name, robot, .. } = wish;
    let schema = schema.map(|place| format!("#:schema {place}\n")).unwrap_or_default();
    // The first parent, common to all specs, is extended by the task's parent.
    let parents: Vec<String> =
        wish.family()[1..].iter().map(|name| format!("\"{base}/{name}.toml\"")).collect();
    canonical(&format!(
        "{schema}spec = 1\nname = \"{name}\"\nsummary = \"{}\"\nextends = [{}]\n\n\
         [robot]\nmodel = \"{robot}\"\n\n{}\
         # `specforge show --origins {name}.toml` prints every value with the line that it comes from. Values \
         here\n\
         # override the parents. `specforge run {name}.toml --profile quick` trains for minutes, without a \
         profile for hours.\n\
         # [learn]\n# samples = \"8 M\"\n# [reward.torque]\n# weight = 0.1\n",
        wish.summary(),
        parents.join(", "),
        wish.own()
    ))
}

/// A spec that needs no other files.
pub fn alone(wish: &Wish) -> String {
    let Wish { name, robot, .. } = wish;
    let own = format!("[robot]\nmodel = \"{robot}\"\n\n{}", wish.own());
    let parents: Vec<&str> = wish.family().into_iter().filter_map(parent).collect();
    let body = alone::merged(&parents, &own);
    canonical(&format!(
        "# The complete experiment. `specforge explain KEY` and `specforge explain KIND` document its lines,\n\
         # `specforge list` the alternatives; `specforge run FILE --profile quick` trains for minutes.\n\
         spec = 1\nname = \"{name}\"\nsummary = \"{}\"\n\n{body}",
        wish.summary()
    ))
}

/// A suite over a spec, whose path is relative to the new file: an axis with two weights, seeds and two
/// claims.
pub fn suite(name: &str, spec: &str, schema: Option<&str>) -> String {
    let schema = schema.map(|place| format!("#:schema {place}\n")).unwrap_or_default();
    let text = format!(
        "{schema}spec = 1\nsuite = \"{name}\"\nsummary = \"What the weight of the torque term \
         decides\"\nextends = \"{spec}\"\n\n\
         # Every arm is trained once per seed; a claim about arms takes three seeds or more. `specforge \
         explain sweep`.\n\
         [sweep]\nseeds = 3\n\n\
         # An axis: a value of the spec, and what it takes. Axes multiply.\n\
         [sweep.weight]\npath = \"reward.torque.weight\"\nvalues = [0.05, 0.2]\n\n\
         # What the suite is expected to show: PASS, FAIL or NOT ESTABLISHED in its report. `specforge \
         explain claim`.\n\
         [[claim]]\nid = \"heavier_saves_torque\"\ntext = \"With the heavier term the robot needs less \
         torque\"\n\
         metric = \"evaluate.nominal.torque_rms\" # a table of the spec and one of `specforge list metric`\n\
         compare = {{ a = \"weight=0.2\", b = \"weight=0.05\" }}\nexpect = \"a < b\"\n\n\
         [[claim]]\nid = \"heavier_survives\"\ntext = \"With the heavier term it survives more than half of \
         its episodes\"\n\
         metric = \"evaluate.nominal.survival\"\narm = \"weight=0.2\"\nexpect = \"a > 50 %\"\n"
    );
    format(&text, Sort::Suite, &Order::of_this_edition())
}

/// A new spec in the form of `specforge fmt`.
fn canonical(text: &str) -> String {
    format(text, Sort::Spec, &Order::of_this_edition())
}

/// The robots included in the program.
pub fn robots() -> Vec<&'static str> {
    robot::names().collect()
}

#[cfg(test)]
mod tests;
