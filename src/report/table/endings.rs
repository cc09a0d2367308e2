//! Counts why training episodes ended: over the whole training, in its first and in its last tenth.

use std::collections::BTreeMap;

use super::{Cell, Table};
use crate::report::estimate::Estimate;
use crate::report::group::Group;
use crate::report::model::{Arm, ReportInput, Update};
use crate::report::source::Source;
use crate::report::wording::{arm_in_words, count, labels};

/// Episodes by cause.
type Counts<'a> = BTreeMap<&'a str, u64>;

/// The table of an experiment: one row per arm and cause that occurred.
pub fn endings(input: &ReportInput) -> Table {
    let heads = ["cause", "episodes", "share (%)", "first tenth (%)", "last tenth (%)"].map(String::from);
    let mut table = Table::new("ends", "Why training episodes ended", heads);
    for (arm, name) in input.arms.iter().zip(labels(&input.arms)) {
        let tenth = arm.updates.len().div_ceil(10);
        let whole = counts(&arm.updates);
        let tenths = [&arm.updates[..tenth], &arm.updates[arm.updates.len() - tenth..]].map(counts);
        for (cause, episodes) in whole.iter().filter(|(_, episodes)| **episodes > 0) {
            let cause_name = cause.replace('_', " ");
            let label = if input.arms.len() > 1 { format!("{name}: {cause_name}") } else { cause_name };
            let shares = [&whole, &tenths[0], &tenths[1]].map(|counts| share(counts, cause).into());
            table.row("", &label, [Cell::Text(count(*episodes))].into_iter().chain(shares));
        }
    }
    table.sources = sources(input.arms.iter());
    table
}

/// The table of a suite: one row per arm, one column per cause, shares in the last tenth of its runs.
pub fn of_groups(groups: &[Group<'_>]) -> Table {
    let late: Vec<Counts> = groups.iter().map(late).collect();
    let mut causes: Vec<&str> = late
        .iter()
        .flat_map(|counts| counts.iter().filter(|(_, n)| **n > 0).map(|(cause, _)| *cause))
        .collect();
    causes.sort_unstable();
    causes.dedup();
    let heads = ["arm".to_owned(), "episodes".to_owned()].into_iter();
    let heads = heads.chain(causes.iter().map(|cause| format!("{} (%)", cause.replace('_', " "))));
    let mut table = Table::new("ends", "Why episodes ended in the last tenth of the training", heads);
    for (group, counts) in groups.iter().zip(&late).filter(|(_, counts)| counts.values().sum::<u64>() > 0) {
        let cells = causes.iter().map(|cause| Cell::from(share(counts, cause)));
        let episodes = Cell::Text(count(counts.values().sum()));
        table.row("", &arm_in_words(group.name), [episodes].into_iter().chain(cells));
    }
    table.sources = sources(groups.iter().flat_map(|group| group.runs.iter().copied()));
    table
}

fn counts(updates: &[Update]) -> Counts<'_> {
    let mut counts = Counts::new();
    for (cause, count) in updates.iter().flat_map(|update| &update.ends) {
        *counts.entry(cause).or_default() += count;
    }
    counts
}

/// The last tenths of an arm's runs, added up.
fn late<'a>(group: &Group<'a>) -> Counts<'a> {
    let mut sum = Counts::new();
    for run in &group.runs {
        let first = run.updates.len() - run.updates.len().div_ceil(10);
        counts(&run.updates[first..])
            .into_iter()
            .for_each(|(cause, count)| *sum.entry(cause).or_default() += count);
    }
    sum
}

fn share(counts: &Counts, cause: &str) -> Estimate {
    let total: u64 = counts.values().sum();
    let share = counts.get(cause).copied().unwrap_or(0) as f64 / total as f64;
    Estimate { n: Some(total as usize), ..Estimate::maybe((total > 0).then_some(share), "%", 0) }
}

fn sources<'a>(arms: impl Iterator<Item = &'a Arm>) -> Vec<Source> {
    let learned = arms.filter(|arm| arm.stage("learner").is_some());
    learned.map(|arm| Source { arm: arm.name.clone(), stage: "learner".into() }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twenty updates: falls in the first half, time-outs in the second, one divergence in total.
    fn arm() -> Arm {
        let update = |index: u64| Update {
            ends: BTreeMap::from([
                ("base_height".to_owned(), if index < 10 { 9 } else { 0 }),
                ("exploded".to_owned(), u64::from(index == 3)),
                ("ground_contact".to_owned(), 0),
                ("time_out".to_owned(), if index < 10 { 0 } else { 3 }),
            ]),
            ..Update::default()
        };
        Arm { name: "walk".into(), updates: (0..20).map(update).collect(), ..Arm::default() }
    }

    fn numbers(cells: &[Cell]) -> Vec<Option<f64>> {
        let number = |cell: &Cell| if let Cell::Number(estimate) = cell { estimate.value } else { None };
        cells.iter().map(number).collect()
    }

    #[test]
    fn causes_are_counted_over_the_training_and_shared_out_over_its_first_and_last_tenth() {
        let table = endings(&ReportInput { arms: vec![arm()], ..ReportInput::default() });
        let rows: Vec<&str> = table.rows.iter().map(|row| row.label.as_str()).collect();
        assert_eq!(rows, ["base height", "exploded", "time out"], "what never happened has no row");
        assert_eq!(table.rows[0].cells[0], Cell::from("90"));
        assert_eq!(numbers(&table.rows[0].cells[1..]), [Some(90.0 / 121.0), Some(1.0), Some(0.0)]);
        assert_eq!(numbers(&table.rows[2].cells[1..]), [Some(30.0 / 121.0), Some(0.0), Some(1.0)]);
    }

    #[test]
    fn a_suite_shares_out_the_last_tenth_of_all_runs() {
        let (one, two) = (arm(), arm());
        let mut fallen = arm();
        fallen.updates.truncate(10);
        let group = Group { name: "std=5 %", points: &[], runs: vec![&one, &two, &fallen] };
        let table = of_groups(&[group]);
        assert_eq!(table.columns, ["arm", "episodes", "base height (%)", "time out (%)"]);
        // Two runs with two updates of three time-outs each, and one update of nine falls.
        assert_eq!(numbers(&table.rows[0].cells[1..]), [Some(9.0 / 21.0), Some(12.0 / 21.0)]);
        assert_eq!(table.rows[0].cells[0], Cell::from("21"));
    }

    #[test]
    fn without_a_training_there_is_no_row() {
        let table = endings(&ReportInput { arms: vec![Arm::default()], ..ReportInput::default() });
        assert!(table.rows.is_empty());
    }
}
