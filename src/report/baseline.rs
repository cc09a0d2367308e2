//! The baseline of an arm: the spec that a page compares it with.

use super::table::setup::budget_of;
use crate::kinds::action::Action;
use crate::kinds::task::Task;
use crate::spec::typed::InSection;
use crate::spec::{Section, Table};

/// Picks the baseline of an arm: the first one with the same task and kind of action, else the first one with
/// the same task.
pub fn choice(baselines: &[Table], fields: &Table) -> Option<usize> {
    let of_task = || {
        baselines.iter().enumerate().filter(|(_, baseline)| kind::<Task>(baseline) == kind::<Task>(fields))
    };
    of_task()
        .find(|(_, baseline)| kind::<Action>(baseline) == kind::<Action>(fields))
        .or_else(|| of_task().next())
        .map(|(place, _)| place)
}

/// The samples of an arm's training as a share of its baseline's.
pub fn budget_share(baseline: &Table, fields: &Table) -> Option<f64> {
    let whole = budget_of(baseline).filter(|samples| *samples > 0)?;
    Some(budget_of(fields)? as f64 / whole as f64)
}

fn kind<Part: InSection>(fields: &Table) -> Option<&str> {
    Section::new(fields).within::<Part>()?.kind()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::Value;

    fn spec(task: &str, action: &str, samples: u64) -> Table {
        let section = |key: &str, value: Value| Value::Table(Table::from([(key.to_owned(), value)]));
        Table::from([
            ("task".to_owned(), section("kind", Value::Text(task.into()))),
            ("action".to_owned(), section("kind", Value::Text(action.into()))),
            ("learn".to_owned(), section("samples", Value::Count(samples))),
        ])
    }

    #[test]
    fn an_arm_has_the_baseline_of_its_task_and_if_there_is_one_of_its_action() {
        let baselines = [spec("walk", "torque", 80), spec("walk", "position", 80), spec("run", "torque", 80)];
        let chosen = |task: &str, action: &str| choice(&baselines, &spec(task, action, 1));
        assert_eq!(chosen("walk", "torque"), Some(0));
        assert_eq!(chosen("walk", "position"), Some(1));
        assert_eq!(chosen("run", "position"), Some(2), "of the task alone");
        assert_eq!(chosen("squat", "torque"), None);
    }

    #[test]
    fn a_budget_is_a_share_of_the_baselines() {
        let baseline = spec("walk", "torque", 80);
        assert_eq!(budget_share(&baseline, &spec("walk", "torque", 4)), Some(0.05));
        assert_eq!(budget_share(&baseline, &Table::new()), None);
        assert_eq!(budget_share(&Table::new(), &baseline), None);
    }
}
