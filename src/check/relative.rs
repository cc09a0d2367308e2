//! Replaces quantities relative to the robot (`"0.16 mgh/rad"`) by the shares of its own figures that they
//! amount to, so that everything after the checks sees shares.
//!
//! The text of the value then has both, `0.16 mgh/rad = 4.523 %`, which reports print.

use crate::diag::{Diagnostic, Sink};
use crate::kinds::action::position::{SharesOf, Span};
use crate::kinds::action::{Position, Torque};
use crate::kinds::fine_tune;
use crate::kinds::pretrain::Tracking;
use crate::quantity::{self, Dimension, Measure, Relative};
use crate::robot::{Proportions, Robot};
use crate::spec::typed::Keys;
use crate::spec::{Experiment, Param, Quantity, Section, Table, Value, bounds};

/// Significant digits of a share. More would differ between robots whose figures are the same.
const DIGITS: usize = 4;

/// The keys that take such quantities, by their paths.
fn keys() -> Vec<(String, &'static [Param])> {
    vec![
        (Tracking::stiffness.path(), Tracking::PARAMS),
        (Tracking::damping.path(), Tracking::PARAMS),
        (Position::stiffness.path(), Position::PARAMS),
        (Torque::std.path(), Torque::PARAMS),
        (fine_tune::Ppo::std.path(), fine_tune::Ppo::PARAMS),
    ]
}

/// A quantity relative to the robot, with its key.
struct Found {
    path: String,
    text: String,
    relative: Relative,
    param: Param,
}

/// All that a decoded spec has.
fn found(table: &Table) -> Vec<Found> {
    let read = |(path, params): (String, &[Param])| {
        let (section, key) = path.split_once('.')?;
        let text = match table.get(section)?.as_table()?.get(key)? {
            Value::Quantity(quantity) => quantity.text.clone(),
            _ => return None,
        };
        let relative = quantity::relative(&text)?.ok()?;
        let param = *params.iter().find(|param| param.name == key)?;
        Some(Found { path, text, relative, param })
    };
    keys().into_iter().filter_map(read).collect()
}

/// Whether a decoded spec has any.
pub(super) fn any(table: &Table) -> bool {
    !found(table).is_empty()
}

/// Replaces every quantity relative to the robot by a share. Errors are reported where it is written: a figure
/// that the robot lacks (E0207), a share out of the key's bounds (E0204).
pub(super) fn resolve(experiment: &mut Experiment, robot: &Robot, sink: &mut Sink) {
    let found = found(&experiment.table);
    if found.is_empty() {
        return;
    }
    let own = Proportions::of(robot);
    for quantity in found {
        match share(&quantity, &own, robot, Section::new(&experiment.table)) {
            Ok(share) => replace(&mut experiment.table, &quantity.path, share),
            Err(error) => {
                sink.emit(match experiment.marks.get(&quantity.path) {
                    Some(mark) => error.at(mark.value, "relative to the robot"),
                    None => error,
                });
                drop_section(experiment, &quantity.path);
            }
        }
    }
}

fn share(found: &Found, own: &Proportions, robot: &Robot, spec: Section) -> Result<Quantity, Diagnostic> {
    let Found { path, text, relative, param } = found;
    let key = param.name;
    if relative.measure == Measure::Torque && !explores_in_torques(spec) {
        let message = format!("`{path}` is a torque, and the policy commands positions");
        return Err(Diagnostic::error("E0207", message).help(format!(
            "set `action.shares_of = \"effort_limits\"`, or write `{key}` as a percentage, for example \"10 %\""
        )));
    }
    let Some(share) = own.share(*relative) else {
        let missing = match relative.measure {
            Measure::Torque => "effort_limit",
            Measure::Stiffness => "stiffness_gain",
            Measure::Damping => "damping_gain",
        };
        let message = format!("`{path}` is relative to `{}`, whose legs lack a `{missing}`", robot.name);
        return Err(Diagnostic::error("E0207", message)
            .help(format!("give every joint of a leg a `{missing}` in the robot's file")));
    };
    let share: f64 = format!("{share:.*e}", DIGITS - 1).parse().unwrap_or(share);
    let percent = quantity::print_ratio(share);
    if !bounds::holds(param, share) {
        let message = format!("`{key}` is out of range: \"{text}\" is {percent} for `{}`", robot.name);
        let allowed = bounds::in_words(param, Dimension::NONE);
        return Err(Diagnostic::error("E0204", message).help(format!("it must be {allowed}")));
    }
    // The number of the printed share, so that text and number agree to the last bit.
    let si = quantity::quantity_of(&percent, Dimension::NONE).unwrap_or(share);
    Ok(Quantity { si, text: format!("{text}{}{percent}", Quantity::EQUALS) })
}

/// Whether shares of the exploration are shares of torques.
fn explores_in_torques(spec: Section) -> bool {
    let Some(action) = spec.within::<Position>() else { return true };
    let is_torque = action.is::<Torque>();
    is_torque || action.value(Position::shares_of) == Some(SharesOf::Span(Span::EffortLimits))
}

/// Removes the section of an invalid value, as decoding does.
fn drop_section(experiment: &mut Experiment, path: &str) {
    let Some((section, _)) = path.split_once('.') else { return };
    experiment.table.remove(section);
    experiment.poisoned.push(section.to_owned());
}

fn replace(table: &mut Table, path: &str, share: Quantity) {
    let Some((section, key)) = path.split_once('.') else { return };
    if let Some(Value::Table(section)) = table.get_mut(section) {
        section.insert(key.to_owned(), Value::Quantity(share));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::vocabulary::vocabulary;
    use crate::spec::{Kind, Shape, Ty};

    /// Paths of keys that take quantities relative to the robot, of a list of keys.
    fn relative(section: &str, params: &[Param]) -> Vec<String> {
        let takes = |param: &&Param| matches!(param.ty, Ty::Ratio(share) if share.measure.is_some());
        params.iter().filter(takes).map(|param| format!("{section}.{}", param.name)).collect()
    }

    #[test]
    fn every_key_that_takes_them_is_resolved() {
        let mut all = Vec::new();
        for section in vocabulary().sections {
            let of = |kind: &&'static Kind| relative(section.name, kind.params);
            match &section.shape {
                Shape::Plain(params) => all.extend(relative(section.name, params)),
                Shape::Kind(kinds) => all.extend(kinds.iter().flat_map(of)),
                Shape::Terms(kinds, _) => assert!(kinds.iter().flat_map(of).next().is_none()),
            }
        }
        all.sort();
        all.dedup();
        let mut resolved: Vec<String> = keys().into_iter().map(|(path, _)| path).collect();
        resolved.sort();
        assert_eq!(all, resolved);
    }
}
