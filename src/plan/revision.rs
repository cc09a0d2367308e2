//! Revisions of single kinds: a change of a kind's numbers invalidates only the stages that use it, whereas a
//! stage's epoch would invalidate all of them.

use super::stage::StageKind;
use crate::kinds::deploy::{Deployment, Transfer};
use crate::kinds::evaluate::{Drawn, Evaluation, ParameterSets};
use crate::kinds::physics::Physics;
use crate::kinds::task::Task;
use crate::kinds::task::stand::Stand;
use crate::sim::EngineName;
use crate::spec::{Section, Table};

/// Kinds that have changed since their first release: section, kind, revision. Raised when the kind's numbers
/// change for the same keys.
const KINDS: &[(&str, &str, u32)] = &[
    // Six scales belong to the joints' functions, whatever the robot's joint order.
    ("observe", "joint_velocity", 2),
    // Anything that protrudes below the middle of a sole lifts it.
    ("terrain", "box_obstacle", 2),
    // As above, and heights on the engines' triangles.
    ("terrain", "height_field", 2),
    // Links are stretched along their length, not scaled in all directions; inertia, shapes and the
    // reference's heights follow.
    ("randomize", "leg_length", 2),
    // A push has its exact impulse, whatever the physics step.
    ("randomize", "push", 2),
    // A delay is exactly the drawn time, not rounded to physics steps.
    ("randomize", "action_delay", 2),
];

/// MuJoCo's motors have the scaled effort limit since this revision of `motor_constant`.
const MOTOR_IN_MUJOCO: &str = "randomize.motor_constant in mujoco, revision 2";

/// The revisions that a stage's numbers depend on.
pub fn of(kind: StageKind, fields: &Table) -> Vec<String> {
    let fields = Section::new(fields);
    match kind {
        StageKind::Env => {
            let mut found = revised(fields, |_| true);
            let mujoco = fields.at(Physics::engine) == Some(EngineName::Mujoco);
            found.extend(
                (mujoco && uses(fields, "randomize", "motor_constant")).then(|| MOTOR_IN_MUJOCO.into()),
            );
            found
        }
        StageKind::Transfer => {
            let drawn = fields.at(Transfer::engine) == Some(EngineName::Mujoco)
                && fields.at(Transfer::randomize) == Some(Drawn::AsTrained(true));
            let mut found = fields.within::<Deployment>().map_or_else(Vec::new, own);
            found.extend(drawn.then(|| MOTOR_IN_MUJOCO.into()));
            found
        }
        StageKind::Evaluate => fields
            .within::<Evaluation>()
            .map_or_else(Vec::new, |evaluate| [own(evaluate), sets(evaluate)].concat()),
        StageKind::Pretrain => revised(fields, |section| section == "observe"),
        _ => Vec::new(),
    }
}

/// The revisions for the task of the arm, which the stage itself does not read.
pub fn of_task(kind: StageKind, arm: &Table) -> Vec<String> {
    let task = Section::new(arm).within::<Task>();
    let stands = task.is_some_and(|task| task.is::<Stand>());
    let still = task.is_some_and(|task| !task.holds(Stand::motion));
    match kind {
        // They measure how far the base drifts.
        StageKind::Evaluate | StageKind::Transfer if stands => vec!["task.stand, revision 2".into()],
        // The contract contains the duration of the phase's cycle.
        StageKind::Export if still => vec!["task without a motion, revision 2".into()],
        _ => Vec::new(),
    }
}

/// The revised kinds in an evaluation's own ground and randomization.
fn own(table: Section) -> Vec<String> {
    revised(table, |section| matches!(section, "terrain" | "randomize"))
}

/// The revision of randomized delays, if an evaluation scales the delay in its parameter sets.
fn sets(evaluate: Section) -> Vec<String> {
    let parameters = evaluate.value(ParameterSets::parameters).unwrap_or_default();
    let scaled = |name: &str| parameters.iter().any(|parameter| parameter.word() == name);
    let delays =
        KINDS.iter().filter(|(at, name, _)| (*at, *name) == ("randomize", "action_delay") && scaled(name));
    delays.map(|(at, name, now)| format!("{at}.{name}, revision {now}")).collect()
}

/// The revised kinds that are used in these sections.
fn revised(fields: Section, of: impl Fn(&str) -> bool) -> Vec<String> {
    let used = KINDS.iter().filter(|(section, name, _)| of(section) && uses(fields, section, name));
    used.map(|(at, name, now)| format!("{at}.{name}, revision {now}")).collect()
}

/// Whether a section has a kind, or a term of it.
fn uses(fields: Section, section: &str, kind: &str) -> bool {
    let Some(section) = fields.section(section) else { return false };
    section.kind() == Some(kind) || section.sections().any(|(name, term)| term.kind().unwrap_or(name) == kind)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::Value;

    fn table(pairs: &[(&str, Value)]) -> Table {
        pairs.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect()
    }

    fn kind(name: &str) -> Value {
        Value::Table(table(&[("kind", Value::Text(name.into()))]))
    }

    #[test]
    fn a_stage_that_uses_no_revised_kind_has_no_revision() {
        let fields = table(&[
            ("terrain", kind("flat")),
            (
                "randomize",
                Value::Table(table(&[("link_mass", kind("link_mass")), ("motor", kind("motor_constant"))])),
            ),
            ("physics", Value::Table(table(&[("engine", Value::Text("rapier".into()))]))),
        ]);
        assert!(of(StageKind::Env, &fields).is_empty());
    }

    #[test]
    fn a_revised_kind_is_found_under_its_own_and_under_another_name() {
        let fields = table(&[
            ("terrain", kind("height_field")),
            (
                "randomize",
                Value::Table(table(&[("growth", kind("leg_length")), ("motor", kind("motor_constant"))])),
            ),
            ("physics", Value::Table(table(&[("engine", Value::Text("mujoco".into()))]))),
        ]);
        let found = of(StageKind::Env, &fields);
        assert_eq!(
            found,
            ["terrain.height_field, revision 2", "randomize.leg_length, revision 2", MOTOR_IN_MUJOCO],
        );
        assert!(of(StageKind::Learner, &fields).is_empty(), "it reaches the learner through its inputs");
    }

    #[test]
    fn only_standing_arms_have_the_revisions_of_standing() {
        let arm = |task: &str, motion: Option<&str>| {
            let motion = motion.map(|motion| ("motion".to_owned(), Value::Text(motion.into())));
            let keys = [("kind".to_owned(), Value::Text(task.into()))].into_iter().chain(motion);
            table(&[("task", Value::Table(keys.collect()))])
        };
        let all = [StageKind::Learner, StageKind::Evaluate, StageKind::Export, StageKind::Transfer];
        let count = |arm: &Table| all.map(|kind| of_task(kind, arm).len());
        assert_eq!(count(&arm("stand", None)), [0, 1, 1, 1]);
        assert_eq!(count(&arm("stand", Some("sway"))), [0, 1, 0, 1]);
        assert_eq!(count(&arm("squat", Some("squat"))), [0; 4]);
    }

    #[test]
    fn an_evaluation_counts_the_kinds_of_its_own_tables_alone() {
        let evaluate = |keys: &[(&str, Value)]| table(&[("evaluate", Value::Table(table(keys)))]);
        assert!(of(StageKind::Evaluate, &evaluate(&[("randomize", Value::Flag(true))])).is_empty());
        let rows = Value::Table(table(&[("shove", kind("push"))]));
        let own = evaluate(&[("terrain", kind("box_obstacle")), ("randomize", rows)]);
        let expected = ["terrain.box_obstacle, revision 2", "randomize.push, revision 2"];
        assert_eq!(of(StageKind::Evaluate, &own), expected);
        let sets = |names: &[&str]| {
            let names = names.iter().map(|name| Value::Text((*name).into())).collect();
            evaluate(&[("kind", Value::Text("parameter_sets".into())), ("parameters", Value::List(names))])
        };
        assert!(of(StageKind::Evaluate, &sets(&["link_mass"])).is_empty());
        let found = of(StageKind::Evaluate, &sets(&["link_mass", "action_delay"]));
        assert_eq!(found, ["randomize.action_delay, revision 2"]);
    }

    #[test]
    fn a_transfer_to_mujoco_counts_the_motors_only_where_they_are_drawn() {
        let deploy = |drawn: bool| {
            let keys = [("engine", Value::Text("mujoco".into())), ("randomize", Value::Flag(drawn))];
            table(&[("deploy", Value::Table(table(&keys)))])
        };
        assert!(of(StageKind::Transfer, &deploy(false)).is_empty());
        assert_eq!(of(StageKind::Transfer, &deploy(true)), [MOTOR_IN_MUJOCO]);
    }
}
