//! Training results and costs as tables.

use super::{Cell, Table};
use crate::plan::Training;
use crate::report::estimate::Estimate;
use crate::report::model::{Arm, Pretrain, ReportInput, Update};
use crate::report::returns::Returns;
use crate::report::source::Source;
use crate::report::wording::{count, duration, labels};
use crate::statistics::summary::mean;

/// The training table, one column per arm.
pub fn learning(input: &ReportInput) -> Table {
    let mut table = of_training(input, Training::First);
    let mut row = |name: &str, label: &str, of: &dyn Fn(&Arm) -> Cell| {
        table.row(name, label, input.arms.iter().map(of));
    };
    row("pretrain", "pre-training error on held-out states, root mean square (N m)", &|arm| {
        pretraining(arm, "N m", |pretrain| pretrain.rmse_nm)
    });
    row("pretrain_labels", "root mean square of its labels (N m)", &|arm| {
        pretraining(arm, "N m", |pretrain| pretrain.label_rms_nm)
    });
    row("pretrain_cpu", "CPU time of pre-training (s)", &|arm| {
        pretraining(arm, "s", |pretrain| pretrain.cpu_s)
    });
    table
}

/// The fine-tuning table, one column per arm; no rows if no arm has one.
pub fn fine_tuning(input: &ReportInput) -> Table {
    match input.arms.iter().all(|arm| arm.fine_tuning.is_empty()) {
        true => Table::default(),
        false => of_training(input, Training::FineTuning),
    }
}

/// The results of a training.
fn of_training(input: &ReportInput, training: Training) -> Table {
    let (id, title) = match training {
        Training::First => ("learning", "Learning"),
        Training::FineTuning => ("fine_tuning", "Fine-tuning"),
    };
    let mut table = Table::new(id, title, [String::new()].into_iter().chain(labels(&input.arms)));
    let stage = training.stage().to_owned();
    table.sources =
        input.arms.iter().map(|arm| Source { arm: arm.name.clone(), stage: stage.clone() }).collect();
    table.column_sources = (0..input.arms.len()).map(Some).collect();
    let returns = Returns::of(&input.arms);
    let (unit, digits) = returns.format();
    let mut row = |name: &str, label: &str, of: &dyn Fn(&Arm) -> Cell| {
        table.row(name, label, input.arms.iter().map(of));
    };
    row("samples", "samples", &|arm| last(arm.updates_of(training), |update| count(update.samples)));
    row("simulated", "simulated time", &|arm| {
        last(arm.updates_of(training), |update| duration(update.simulated_s))
    });
    row("wall", "wall time", &|arm| last(arm.updates_of(training), |update| duration(update.wall_s)));
    row("cpu", "CPU time", &|arm| last(arm.updates_of(training), |update| duration(update.cpu_s)));
    row("cpu_per_sample", "CPU time per sample (us)", &|arm| cpu_per_sample(arm.updates_of(training)).into());
    row("return", &format!("{}, last tenth", returns.label()), &|arm| {
        let mean = late_episodes(arm.updates_of(training), |update| returns.value(arm, update));
        Estimate::maybe(mean, unit, digits).into()
    });
    row("length", "episode length, last tenth (s)", &|arm| {
        Estimate::maybe(late_episodes(arm.updates_of(training), |update| update.length_mean_s), "s", 2).into()
    });
    row("kl", "KL per update, last tenth", &|arm| late(arm.updates_of(training), "", 4, |update| update.kl));
    row("explained", "explained variance, last tenth", &|arm| {
        late(arm.updates_of(training), "", 2, |update| update.explained_variance)
    });
    table
}

fn last(updates: &[Update], of: impl Fn(&Update) -> String) -> Cell {
    updates.last().map_or_else(|| "\u{2013}".into(), |update| Cell::Text(of(update)))
}

/// A number from the pre-training.
fn pretraining(arm: &Arm, unit: &str, of: impl Fn(&Pretrain) -> f64) -> Cell {
    Estimate::maybe(arm.pretrain.as_ref().map(of), unit, 1).into()
}

fn cpu_per_sample(updates: &[Update]) -> Estimate {
    let last = updates.last().filter(|update| update.samples > 0);
    Estimate::maybe(last.map(|update| 1e6 * update.cpu_s / update.samples as f64), "us", 0)
}

/// Mean over the last tenth of the updates.
fn late(updates: &[Update], unit: &str, digits: usize, of: impl Fn(&Update) -> Option<f64>) -> Cell {
    Estimate::maybe(late_mean(updates, of), unit, digits).into()
}

/// The mean of a quantity over the last tenth of the updates, but at least one update.
fn late_mean(updates: &[Update], of: impl Fn(&Update) -> Option<f64>) -> Option<f64> {
    mean(&updates[last_tenth(updates)..].iter().filter_map(of).collect::<Vec<_>>())
}

/// Where the last tenth of the updates begins.
fn last_tenth(updates: &[Update]) -> usize {
    updates.len() - updates.len().div_ceil(10)
}

/// Fewest episodes that describe the end of a training. Surviving episodes all end at once, and the last
/// tenth of a short training may lie between two such moments and contain a single early fall.
const ENOUGH: u64 = 32;

/// The mean of a per-episode quantity over the episodes that ended in the last tenth of the updates; if they
/// are fewer than [`ENOUGH`], earlier updates are added.
pub fn late_episodes(updates: &[Update], of: impl Fn(&Update) -> Option<f64>) -> Option<f64> {
    let ended = |update: &Update| update.ends.values().sum::<u64>();
    let (mut sum, mut episodes) = (0.0, 0);
    for (index, update) in updates.iter().enumerate().rev() {
        if index < last_tenth(updates) && episodes >= ENOUGH {
            break;
        }
        if let Some(value) = of(update).filter(|_| ended(update) > 0) {
            episodes += ended(update);
            sum += ended(update) as f64 * value;
        }
    }
    (episodes > 0).then(|| sum / episodes as f64)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn update(episodes: u64, length: f64) -> Update {
        let ends = BTreeMap::from([("time_out".to_owned(), episodes)]);
        Update { ends, length_mean_s: (episodes > 0).then_some(length), ..Update::default() }
    }

    #[test]
    fn the_end_of_a_training_is_told_over_enough_episodes() {
        let length = |updates: &[Update]| late_episodes(updates, |update| update.length_mean_s);
        let mut updates = vec![update(64, 10.0); 20];
        updates[18] = update(48, 16.0);
        updates[19] = update(16, 12.0);
        assert_eq!(length(&updates), Some(15.0), "the last tenth, by episodes");
        // Surviving episodes all end at once; in the last tenth only a fall ended one.
        updates[16..].fill(update(0, 0.0));
        updates[19] = update(1, 1.0);
        updates[15] = update(7, 1.0);
        updates[14] = update(56, 9.0);
        assert_eq!(length(&updates), Some(8.0), "(1 + 7 + 56 * 9) / 64");
        assert_eq!(length(&updates[19..]), Some(1.0));
        assert_eq!(length(&[update(0, 0.0)]), None);
        assert_eq!(length(&[]), None);
    }
}
