//! How learning went and what it cost, in numbers.

use super::{Cell, Table};
use crate::plan::Training;
use crate::report::estimate::Estimate;
use crate::report::model::{Arm, Pretrain, ReportInput, Update};
use crate::report::returns::Returns;
use crate::report::source::Source;
use crate::report::wording::{count, duration, labels};
use crate::statistics::summary::mean;

/// The table of learning, one column per arm.
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
    row("pretrain_cpu", "CPU time of pre-training (s)", &|arm| pretraining(arm, "s", |pretrain| pretrain.cpu_s));
    table
}

/// The table of the fine-tuning, one column per arm; without rows when no arm has one.
pub fn fine_tuning(input: &ReportInput) -> Table {
    match input.arms.iter().all(|arm| arm.fine_tuning.is_empty()) {
        true => Table::default(),
        false => of_training(input, Training::FineTuning),
    }
}

/// What a training came to.
fn of_training(input: &ReportInput, training: Training) -> Table {
    let (id, title) = match training {
        Training::First => ("learning", "Learning"),
        Training::FineTuning => ("fine_tuning", "Fine-tuning"),
    };
    let mut table = Table::new(id, title, [String::new()].into_iter().chain(labels(&input.arms)));
    let stage = training.stage().to_owned();
    table.sources = input.arms.iter().map(|arm| Source { arm: arm.name.clone(), stage: stage.clone() }).collect();
    table.column_sources = (0..input.arms.len()).map(Some).collect();
    let returns = Returns::of(&input.arms);
    let (unit, digits) = returns.format();
    let mut row = |name: &str, label: &str, of: &dyn Fn(&Arm) -> Cell| {
        table.row(name, label, input.arms.iter().map(of));
    };
    row("samples", "samples", &|arm| last(arm.updates_of(training), |update| count(update.samples)));
    row("simulated", "simulated time", &|arm| last(arm.updates_of(training), |update| duration(update.simulated_s)));
    row("wall", "wall time", &|arm| last(arm.updates_of(training), |update| duration(update.wall_s)));
    row("cpu", "CPU time", &|arm| last(arm.updates_of(training), |update| duration(update.cpu_s)));
    row("cpu_per_sample", "CPU time per sample (us)", &|arm| cpu_per_sample(arm.updates_of(training)).into());
    row("return", &format!("{}, last tenth", returns.label()), &|arm| {
        late(arm.updates_of(training), unit, digits, |update| returns.value(arm, update))
    });
    row("length", "episode length, last tenth (s)", &|arm| {
        late(arm.updates_of(training), "s", 2, |update| update.length_mean_s)
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

/// A figure of the pre-training.
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

/// The mean of a quantity over the last tenth of the updates, at least one.
pub fn late_mean(updates: &[Update], of: impl Fn(&Update) -> Option<f64>) -> Option<f64> {
    let first = updates.len() - updates.len().div_ceil(10);
    mean(&updates[first..].iter().filter_map(of).collect::<Vec<_>>())
}
