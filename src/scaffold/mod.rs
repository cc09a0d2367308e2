//! New specs for `specforge new`: children of the parents in `specs/base/`, standalone specs with everything
//! in them, and suites over a spec. The parents are included in the program.

mod alone;
pub mod motion;
mod parents;

pub use parents::{actions, parents, tasks};

use crate::format::{Order, Sort, format};
use crate::robot::{self, Proportions};

/// Settings of a new spec.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish {
    /// Its name, which is also the file's name.
    pub name: String,
    /// The robot.
    pub robot: String,
    /// The task: a file of `specs/base/task/`.
    pub task: String,
    /// The action: a file of `specs/base/action/`.
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

/// The paper's share of TOCABI's gains, as in `specs/base/action/position.toml`.
const PAPERS_GAIN: f64 = 0.125;
/// Stiffness in units of weight and height below which a servo does not hold the robot. With the paper's share
/// TOCABI has 0.45; Atlas and G1, whose files hold soft gains, have 0.07 and 0.04.
const SOFT: f64 = 0.15;

impl Wish {
    /// How the robot is built.
    fn proportions(&self) -> Option<Proportions> {
        self.build.or_else(|| Some(Proportions::of(&robot::shipped(&self.robot)?)))
    }

    /// Whether the paper's share of the robot's own gains does not hold it.
    fn has_soft_gains(&self) -> bool {
        let stiffness = self.proportions().and_then(|build| build.stiffness);
        stiffness.is_some_and(|own| PAPERS_GAIN * own < SOFT)
    }

    /// The lines that depend on the robot.
    fn own(&self) -> String {
        let Some(build) = self.proportions() else { return String::new() };
        [self.motion(), lowest(&build), labels(&build)].concat()
    }

    /// Its own motion, or that of the task that comes with the robot: `walk_g1`.
    fn motion(&self) -> String {
        let shipped = format!("{}_{}", self.task, self.robot);
        let shipped = crate::kinds::motion::names().any(|name| name == shipped).then_some(shipped);
        match self.motion.clone().or(shipped) {
            Some(name) => format!("[task]\nmotion = \"{name}\"\n\n"),
            None => String::new(),
        }
    }

    /// A one-sentence summary.
    fn summary(&self) -> String {
        let action = match self.action.as_str() {
            "position" => "joint position targets and a PD servo",
            _ => "direct joint torque commands",
        };
        format!("{} {}s under {action}", self.robot, self.task)
    }

    /// The parents as paths in `specs/base/` without the ending; later ones win.
    pub fn family(&self) -> Vec<String> {
        let own = (self.action == "position" && self.has_soft_gains()).then_some("robot/soft_gains");
        parents::family(&self.task, &self.action, own)
    }
}

/// The pre-training of a robot whose file has no gains to which those of the parents' labels can be relative.
fn labels(build: &Proportions) -> String {
    if build.stiffness.is_some() && build.damping.is_some() {
        return String::new();
    }
    "[profile.small.pretrain] # the robot's file has no gains for labels that track the reference\nkind = \
     \"gravity_compensation\"\nsamples = \"200 k\"\n\n"
        .to_owned()
}

/// The height at which episodes end, for a robot that the parents' bounds do not fit.
fn lowest(build: &Proportions) -> String {
    if build.stands >= SMALL && (build.base - build.stands).abs() <= BESIDE * build.stands {
        return String::new();
    }
    let (sinks, share) = ((1.0 - LOWEST) * build.stands, 100.0 * (1.0 - LOWEST));
    let bound = build.base - sinks;
    format!(
        "[terminate.base_height]\nbelow = \"{bound:.2} m\" # standing height {:.2} m, minus {share:.0} % of the \
         pelvis height\n\n",
        build.base
    )
}

/// A spec that extends the parents in the folder `base`, relative to the new file; `schema` is the path of
/// the schema.
pub fn child(wish: &Wish, base: &str, schema: Option<&str>) -> String {
    let Wish { name, robot, .. } = wish;
    let schema = schema.map(|place| format!("#:schema {place}\n")).unwrap_or_default();
    let family = wish.family();
    // The common parents are extended by the task's.
    let own = &family[parents::COMMON.len()..];
    let parents: Vec<String> = own.iter().map(|name| format!("\"{base}/{name}.toml\"")).collect();
    canonical(&format!(
        "{schema}spec = 1\nname = \"{name}\"\nsummary = \"{}\"\nextends = [{}]\n\n\
         [robot]\nmodel = \"{robot}\"\n\n{}\
         # `specforge show --origins {name}.toml` prints every value with the line that it comes from. Values \
         here\n\
         # override the parents, and the parents' profiles override both: what a profile sets is changed in its \
         table.\n\
         # `specforge run {name}.toml --profile quick` trains for minutes, without a profile for hours.\n\
         # [reward.torque]\n# weight = 0.1\n# [profile.desk.learn]\n# samples = \"8 M\"\n",
        wish.summary(),
        parents.join(", "),
        wish.own()
    ))
}

/// A spec that needs no other files.
pub fn alone(wish: &Wish) -> String {
    let Wish { name, robot, .. } = wish;
    let own = format!("[robot]\nmodel = \"{robot}\"\n\n{}", wish.own());
    let family = wish.family();
    let texts = parents().filter(|(path, _)| family.iter().any(|name| name == path));
    let parents: Vec<&str> = texts.map(|(_, text)| text).collect();
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
