//! Measurements for the run-time checks in addition to a rollout's sums: statistics of the policy's means, of
//! the targets and of the actor's hidden units. Reads the records without changing them.

use std::collections::BTreeMap;

use crate::env::Output;
use crate::learn::inference::Inference;
use crate::learn::lane::Records;
use crate::learn::metrics::UpdateMetrics;

/// Number of states, spread evenly over a rollout, at which hidden units are evaluated: a unit that is zero
/// in all of them is useless, and the cost is small compared with the passes of an update.
const PROBED: usize = 256;

/// Adds the numbers of a rollout to its metrics: `std` is the exploration's standard deviation of each
/// action, `actor` the policy that acted.
pub fn measure(
    metrics: &mut UpdateMetrics,
    records: &[&Records],
    outputs: &[Output],
    std: &[f64],
    actor: &Inference,
) {
    let actions = actions(records, outputs);
    let named = |of: &dyn Fn(usize) -> f64| -> BTreeMap<String, f64> {
        outputs.iter().enumerate().map(|(index, output)| (output.name.clone(), of(index))).collect()
    };
    metrics.action_saturation = named(&|index| actions[index].beyond / actions[index].count.max(1.0));
    metrics.action_spread = named(&|index| actions[index].deviation() / std[index]);
    let targets = extremes(records, |records| &records.targets);
    // The last value belongs to the state after the rollout, which has no target.
    let values = extremes(records, |records| &records.values[..records.targets.len()]);
    [metrics.target_min, metrics.target_max] = targets.map(Some);
    [metrics.value_min, metrics.value_max] = values.map(Some);
    metrics.dead_units = Some(dead_units(records, actor));
}

/// Sums over the means of one action.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    sum: f64,
    squares: f64,
    beyond: f64,
}

impl Sums {
    fn deviation(&self) -> f64 {
        let mean = self.sum / self.count.max(1.0);
        (self.squares / self.count.max(1.0) - mean * mean).max(0.0).sqrt()
    }
}

fn actions(records: &[&Records], outputs: &[Output]) -> Vec<Sums> {
    let mut sums = vec![Sums::default(); outputs.len()];
    for row in records.iter().flat_map(|records| records.means.chunks_exact(outputs.len())) {
        for ((sums, output), mean) in sums.iter_mut().zip(outputs).zip(row) {
            let mean = f64::from(*mean);
            sums.count += 1.0;
            sums.sum += mean;
            sums.squares += mean * mean;
            sums.beyond += f64::from(u8::from(mean < output.range[0] || mean > output.range[1]));
        }
    }
    sums
}

/// The least and the greatest number.
fn extremes(records: &[&Records], of: impl Fn(&Records) -> &[f32]) -> [f64; 2] {
    let numbers = records.iter().flat_map(|records| of(records)).map(|number| f64::from(*number));
    numbers
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], number| [low.min(number), high.max(number)])
}

/// The share of the actor's hidden units that are zero in every sampled state.
fn dead_units(records: &[&Records], actor: &Inference) -> f64 {
    let width = actor.inputs();
    let rows: usize = records.iter().map(|records| records.observations.len() / width).sum();
    let all = records.iter().flat_map(|records| records.observations.chunks_exact(width));
    let probed: Vec<f32> = all.step_by(rows.div_ceil(PROBED).max(1)).flatten().copied().collect();
    let [idle, units] = actor.idle_units(&probed);
    idle as f64 / units.max(1) as f64
}
