//! New specs for `specforge new`: children of the parents in `specs/base/`, or specs that stand alone with everything in
//! them. The parents come with the program.

mod alone;
mod parents;

pub use parents::{actions, parent, tasks};

use crate::format::{Order, Sort, format};
use crate::robot;

/// What a new spec shall be about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wish {
    /// Its name, that of its file.
    pub name: String,
    /// The robot.
    pub robot: String,
    /// The task: a parent of this name.
    pub task: String,
    /// The action: a parent of this name.
    pub action: String,
}

impl Wish {
    /// What the spec is about, in one sentence.
    fn summary(&self) -> String {
        let action = match self.action.as_str() {
            "position" => "joint position targets and a PD servo",
            _ => "direct joint torque commands",
        };
        format!("{} {}s under {action}", self.robot, self.task)
    }

    /// The lines of `[action]` that depend on the robot: only TOCABI's file holds gains that the paper divides by 8.
    fn own_action(&self) -> &'static str {
        match (self.action.as_str(), self.robot.as_str()) {
            ("position", robot) if robot != "tocabi" => {
                "[action]\nstiffness = \"100 %\" # of the gains in the robot's file\n\n"
            }
            _ => "",
        }
    }
}

/// A spec that extends the parents in a folder `base`, named relative to the new file; `schema` is the schema's place.
pub fn child(wish: &Wish, base: &str, schema: Option<&str>) -> String {
    let Wish { name, robot, task, action } = wish;
    let schema = schema.map(|place| format!("#:schema {place}\n")).unwrap_or_default();
    canonical(&format!(
        "{schema}spec = 1\nname = \"{name}\"\nsummary = \"{}\"\nextends = [\"{base}/{task}.toml\", \"{base}/{action}.toml\"]\n\n\
         [robot]\nmodel = \"{robot}\"\n\n{}\
         # `specforge show --origins {name}.toml` prints every value with the line that it comes from. What is written here\n\
         # wins over the parents:\n\
         # [learn]\n# samples = \"8 M\"\n# [reward.torque]\n# weight = 0.1\n",
        wish.summary(),
        wish.own_action()
    ))
}

/// A spec that needs no other file.
pub fn alone(wish: &Wish) -> String {
    let Wish { name, robot, task, action } = wish;
    let own = format!("[robot]\nmodel = \"{robot}\"\n\n{}", wish.own_action());
    let body = alone::merged(&parents::family(task, action), &own);
    canonical(&format!(
        "# Everything that this experiment is made of. `specforge explain KEY` and `specforge explain KIND` say what a line\n\
         # means, `specforge list` what else there is; `specforge run FILE --profile quick` trains for minutes.\n\
         spec = 1\nname = \"{name}\"\nsummary = \"{}\"\n\n{body}",
        wish.summary()
    ))
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
