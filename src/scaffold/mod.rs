//! New specs for `specforge new`: children of the parents in `specs/base/`, or specs that stand alone with
//! everything in them, and suites over a spec. The parents come with the program.

mod alone;
mod build;
mod parents;

pub use build::Build;
pub use parents::{actions, parent, tasks};

use crate::format::{Order, Sort, format};
use crate::robot;

/// What a new spec shall be about.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish {
    /// Its name, that of its file.
    pub name: String,
    /// The robot.
    pub robot: String,
    /// The task: a parent of this name.
    pub task: String,
    /// The action: a parent of this name.
    pub action: String,
    /// How a robot is built that does not come with the program.
    pub build: Option<Build>,
}

/// The share of the height of its pelvis at which TOCABI's episodes end.
const LOWEST: f64 = 0.65;
/// Distance of the base's origin from where a pelvis is, as a share of that height, from which on the
/// parents' bounds do not fit.
const BESIDE: f64 = 0.1;
/// The parents' bounds on the height are those of TOCABI and Atlas, which stand 0.9 m high and more; in m.
const SMALL: f64 = 0.85;

impl Wish {
    /// The lines that depend on the robot.
    fn own(&self) -> String {
        let bound = |build: Build| {
            let (sinks, share) = ((1.0 - LOWEST) * build.stands, 100.0 * (1.0 - LOWEST));
            let bound = build.base - sinks;
            format!(
                "[terminate.base_height]\nbelow = \"{bound:.2} m\" # it stands at {:.2} m and may sink by \
                 {share:.0} % of the height of its pelvis\n\n",
                build.base
            )
        };
        let shipped = || robot::shipped(&self.robot).map(|robot| Build::of(&robot));
        let is_other =
            |build: &Build| build.stands < SMALL || (build.base - build.stands).abs() > BESIDE * build.stands;
        let small = self.build.or_else(shipped).filter(is_other);
        let bound = small.map(bound).unwrap_or_default();
        let desk =
            format!("{}{}{}{}", self.desk_action(), self.quick_action(), self.labels(), self.last_part());
        format!("{}{}{bound}{desk}", self.own_action(), self.filter())
    }

    /// What the spec is about, in one sentence.
    fn summary(&self) -> String {
        let action = match self.action.as_str() {
            "position" => "joint position targets and a PD servo",
            _ => "direct joint torque commands",
        };
        format!("{} {}s under {action}", self.robot, self.task)
    }

    /// The names of the parents, each before those that win over it.
    pub fn family(&self) -> Vec<&str> {
        parents::family(&self.task, &self.action, &self.robot)
    }

    /// The lines of `[action]` that depend on the robot: only TOCABI's file holds gains that the paper
    /// divides by 8, and G1's motors are a third stronger for its weight and height.
    fn own_action(&self) -> String {
        let explores = |std: &str, why: &str| {
            format!("[action]\nstd = \"{std}\" # of each joint's effort limit{why}\n\n")
        };
        match (self.action.as_str(), self.robot.as_str()) {
            ("torque", "g1") if self.task != "squat" => explores("5 %", ""),
            ("torque", _) => {
                let own = self.build.and_then(|build| build.exploration(&self.task));
                own.map(|std| explores(&std, "; the same for every robot's weight")).unwrap_or_default()
            }
            ("position", robot) if robot != "tocabi" && !self.has_a_servo() => {
                let damping = match robot {
                    "atlas" | "g1" => {
                        "damping = \"50 %\" # what its light ankles bear at a delay of 6 ms (W0512)\n"
                    }
                    _ => "",
                };
                format!("[action]\nstiffness = \"100 %\" # of the gains in the robot's file\n{damping}\n")
            }
            _ => String::new(),
        }
    }

    /// The velocity filter of a robot of one's own: the paper's 4 Hz is that of a robot whose legs swing
    /// slowly.
    fn filter(&self) -> &'static str {
        match self.task.as_str() {
            "walk" | "squat" | "run" if self.build.is_some() => {
                "[observe.joint_velocity]\nlow_pass = \"20 Hz\" # the paper's 4 Hz is too slow for light \
                 legs\n\n"
            }
            _ => "",
        }
    }

    /// How soft the labels of a robot's own are: the parents give a share of the gains in its file, and files
    /// differ.
    fn labels(&self) -> String {
        let Some([stiffness, damping]) = self.build.and_then(|build| build.labels(&self.task)) else {
            return String::new();
        };
        let table = |profile: &str| {
            format!(
                "[profile.{profile}.pretrain]\nstiffness = \"{stiffness}\" # of the gains in its file; as \
                 soft for every robot's weight\n\
                 damping = \"{damping}\"\n\n"
            )
        };
        ["desk", "quick"].map(table).concat()
    }

    /// Whether a parent has the robot's servo.
    fn has_a_servo(&self) -> bool {
        self.family().iter().any(|name| *name == format!("{}_servo", self.robot))
    }

    /// The lines of `[profile.desk.action]`: the desk learns a run with more exploration than the paper's,
    /// and to move under position control with a soft servo.
    fn desk_action(&self) -> String {
        let std = match self.task.as_str() {
            "run" => {
                let own = self.build.and_then(|build| build.running_exploration());
                let share =
                    own.unwrap_or_else(|| if self.robot == "g1" { "14 %" } else { "20 %" }.to_owned());
                format!("std = \"{share}\" # who explores less learns to run later, and for fewer bodies\n")
            }
            _ => self.own_noise(),
        };
        table("profile.desk.action", &[self.own_servo(), std])
    }

    /// The lines of `[profile.quick.action]`.
    fn quick_action(&self) -> String {
        table("profile.quick.action", &[self.own_servo(), self.own_noise()])
    }

    /// The servo with which a robot of one's own learns to move.
    fn own_servo(&self) -> String {
        let stiffness = self.build.filter(|_| self.moves_with_a_servo()).and_then(|build| build.servo());
        let line = |share| {
            format!("stiffness = \"{share}\" # of the gains in its file; as soft for every robot's weight\n")
        };
        stiffness.map(line).unwrap_or_default()
    }

    /// The exploration with which a robot of one's own learns to move under position control.
    fn own_noise(&self) -> String {
        let share =
            self.build.filter(|_| self.moves_with_a_servo()).and_then(|build| build.exploration(&self.task));
        share.map(|share| format!("std = \"{share}\" # of each joint's effort limit\n")).unwrap_or_default()
    }

    fn moves_with_a_servo(&self) -> bool {
        self.action == "position" && self.task != "stand"
    }

    /// Walks and runs end with little exploration.
    fn last_part(&self) -> String {
        let (part, shipped) = match (self.task.as_str(), self.robot.as_str()) {
            ("walk", _) => ("quarter", "2.5 %"),
            ("run", "g1") => ("fifth", "3.5 %"),
            ("run", _) => ("fifth", "5 %"),
            _ => return String::new(),
        };
        let own = self.build.and_then(|build| build.last_exploration(&self.task));
        let share = own.unwrap_or(shipped.to_owned());
        format!(
            "[profile.desk.fine_tune]\nstd = \"{share}\" # little exploration in the last {part} of the \
             samples\n\n"
        )
    }
}

/// A table with these lines, or nothing where there are none.
fn table(name: &str, lines: &[String]) -> String {
    let lines = lines.concat();
    if lines.is_empty() { lines } else { format!("[{name}]\n{lines}\n") }
}

/// A spec that extends the parents in a folder `base`, named relative to the new file; `schema` is the
/// schema's place.
pub fn child(wish: &Wish, base: &str, schema: Option<&str>) -> String {
    let Wish { name, robot, .. } = wish;
    let schema = schema.map(|place| format!("#:schema {place}\n")).unwrap_or_default();
    // The first, which all have in common, is the task's own parent.
    let parents: Vec<String> =
        wish.family()[1..].iter().map(|name| format!("\"{base}/{name}.toml\"")).collect();
    canonical(&format!(
        "{schema}spec = 1\nname = \"{name}\"\nsummary = \"{}\"\nextends = [{}]\n\n\
         [robot]\nmodel = \"{robot}\"\n\n{}\
         # `specforge show --origins {name}.toml` prints every value with the line that it comes from. What \
         is written here\n\
         # wins over the parents. `specforge run {name}.toml --profile quick` trains for minutes, without a \
         profile for hours.\n\
         # [learn]\n# samples = \"8 M\"\n# [reward.torque]\n# weight = 0.1\n",
        wish.summary(),
        parents.join(", "),
        wish.own()
    ))
}

/// A spec that needs no other file.
pub fn alone(wish: &Wish) -> String {
    let Wish { name, robot, .. } = wish;
    let own = format!("[robot]\nmodel = \"{robot}\"\n\n{}", wish.own());
    let parents: Vec<&str> = wish.family().into_iter().filter_map(parent).collect();
    let body = alone::merged(&parents, &own);
    canonical(&format!(
        "# Everything that this experiment is made of. `specforge explain KEY` and `specforge explain KIND` \
         say what a line\n\
         # means, `specforge list` what else there is; `specforge run FILE --profile quick` trains for \
         minutes.\n\
         spec = 1\nname = \"{name}\"\nsummary = \"{}\"\n\n{body}",
        wish.summary()
    ))
}

/// A suite over a spec, named relative to the new file: an axis of two weights, seeds and two claims.
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

/// A new spec as `specforge fmt` would write it.
fn canonical(text: &str) -> String {
    format(text, Sort::Spec, &Order::of_this_edition())
}

/// The robots that come with the program.
pub fn robots() -> Vec<&'static str> {
    robot::names().collect()
}

#[cfg(test)]
mod tests;
