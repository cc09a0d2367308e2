//! W1001: claims that only an impossible value could refute: that a fall takes time, that feet press on the
//! ground, that a walking robot does not move backward.

use super::{ArmScope, Scope, arms_in, at};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::evaluate::Setting;
use crate::kinds::metric::MetricKind;
use crate::kinds::task::{Task, Walk};
use crate::robot::{GRAVITY, Robot, hip_height};
use crate::spec::Section;
use crate::spec::claim::{Case, Claim, Operand, Over, Relation, keys};
use crate::spec::typed::units;
use crate::spec::typed::{Quantified, Typed};

use super::range::in_unit;

/// Time in s that every fall takes.
const FALL: f64 = 0.2;
/// Froude number that no legged robot exceeds.
const FASTEST: f64 = 9.0;
/// Foot force relative to the robot's weight that no landing reaches.
const IMPACT: f64 = 100.0;

/// Values that every result of a metric exceeds, and stays below.
#[derive(Clone, Copy, Debug, Default)]
struct Sure {
    above: Option<f64>,
    below: Option<f64>,
}

impl Sure {
    fn between(above: Option<f64>, below: Option<f64>) -> Self {
        Self { above, below }
    }
}

/// A number that no result of a simulated robot comes near refutes no claim.
pub fn something_can_refute_it(
    claim: &Claim,
    metric: &MetricKind,
    scope: &Scope,
    cases: &[Case],
    sink: &mut Sink,
) {
    let Operand::Number(number) = &claim.expect.right else { return };
    let is_plain = claim.baseline.is_none() && claim.sides.len() == 1;
    let is_direct = !matches!(claim.over, Some(Over::None(_) | Over::AtMost(_) | Over::Trend(_)));
    let known = sink.diagnostics.iter().any(|found| matches!(found.code, "W1001" | "W0511"));
    if !is_plain || !is_direct || known || sink.has_errors() {
        return;
    }
    let arms = arms_in(cases, scope);
    let sure = |arm: &&ArmScope| sure(metric.kind.name, arm, &claim.metric.stage);
    let is_sure = |sure: Sure| match claim.expect.relation {
        Relation::Greater | Relation::AtLeast => sure.above.is_some_and(|bound| number.si <= bound),
        Relation::Less | Relation::AtMost => sure.below.is_some_and(|bound| number.si >= bound),
        Relation::Equal => false,
    };
    if arms.is_empty() || !arms.iter().map(sure).all(is_sure) {
        return;
    }
    let name = metric.kind.name;
    let (side, bound) = match claim.expect.relation {
        Relation::Greater | Relation::AtLeast => {
            ("above", arms.iter().filter_map(|arm| sure(arm).above).reduce(f64::min))
        }
        _ => ("below", arms.iter().filter_map(|arm| sure(arm).below).reduce(f64::max)),
    };
    let bound = in_unit(bound.unwrap_or(number.si), claim, metric);
    let message = format!("no robot can refute `{}`: `{name}` is always {side} {bound}", claim.id);
    let warning = at(
        claim,
        keys::Claim::expect.name,
        Diagnostic::warning("W1001", message),
        "a fallen robot does this",
    );
    sink.emit(warning.help("expect more: state the smallest value that the claim is about"));
}

/// The values of an arm's metric that are certain.
fn sure(metric: &str, arm: &ArmScope, stage: &str) -> Sure {
    let fields = Section::new(arm.fields);
    let limit = limit(fields, stage);
    let most_effort = |robot: &Robot| robot.effort_limits().into_iter().fold(0.0, f64::max);
    let effort = arm.robot.map(most_effort).filter(|most| *most > 0.0);
    let fastest = arm.robot.map(|robot| (FASTEST * GRAVITY * hip_height(robot).max(1e-3)).sqrt());
    let forward = Task::commanded(fields).is_some_and(|command| command.speed.bounds()[1] > 0.0);
    let still = forward.then_some(0.0);
    match metric {
        "time_to_fall" => Sure::between(Some(FALL), limit.map(|limit| limit * (1.0 + 1e-9))),
        "peak_foot_force" => {
            let weight = arm.robot.map(|robot| robot.total_mass() * GRAVITY);
            Sure::between(Some(0.2 * weight.unwrap_or(0.0)), weight.map(|weight| IMPACT * weight))
        }
        "peak_ankle_torque" | "torque_rms" => Sure::between(Some(0.0), effort),
        "speed" | "steady_speed" => Sure::between(still, fastest),
        "distance" => Sure::between(still, fastest.zip(limit).map(|(speed, time)| speed * time)),
        "speed_error" => Sure::between(Some(0.0), fastest.map(|speed| 2.0 * speed)),
        "joint_error" => Sure::between(Some(0.0), Some(std::f64::consts::TAU)),
        "height_error" => Sure::between(Some(0.0), arm.robot.map(|robot| 2.0 * robot.standing_height)),
        "drift" => Sure::between(Some(0.0), None),
        _ => Sure::default(),
    }
}

/// The time limit in s of a stage's episodes.
fn limit(fields: Section, stage: &str) -> Option<f64> {
    let (section, name) = stage.split_once('.')?;
    let number = |section: Section, key: &str| Quantified::<units::Second>::read(section.get(key)?);
    let own = fields.section(section).and_then(|section| section.section(name));
    let own = own.and_then(|own| number(own, Setting::time_limit.name));
    own.or_else(|| number(fields.section("task")?, Walk::episode.name))
}
