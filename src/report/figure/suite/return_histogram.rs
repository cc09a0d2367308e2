//! Reward per second of the episodes that survive: one histogram per arm, over all its policies.

use super::{View, policies};
use crate::outcome::Evaluation;
use crate::report::failures::is_of_sets;
use crate::report::figure::Figure;
use crate::report::metric::Metric;
use crate::report::model::Measured;
use crate::report::plot::axis::{bounds, written};
use crate::report::plot::drawing::text_width;
use crate::report::plot::{Anchor, Area, Axis, Drawing, Ink, Panel};
use crate::report::wording::shortened;
use crate::statistics::summary::{deviation, mean};

/// Number of bars.
const BARS: usize = 40;
/// Height of a histogram and of the gap below it, in pixels.
const ROW: [f64; 2] = [74.0, 34.0];

/// The surviving episodes of an arm.
struct Survivors {
    name: String,
    policies: usize,
    episodes: usize,
    rewards: Vec<f64>,
}

/// The figure, if an episode survived: of the named evaluation, or of the first one over parameter sets.
pub fn figure(view: &View) -> Option<Figure> {
    let over_sets = |measured: &Measured| is_of_sets(&measured.evaluation);
    let named = view.input.figures.contains(&view.wanted.name);
    let stage = view.stage(over_sets).or_else(|| view.stage(|_| named))?;
    let arms = arms(view, &stage);
    let all = || arms.iter().flat_map(|arm| arm.rewards.iter().copied());
    let [low, high] = bounds(all())?;
    let margin = 0.02 * (high - low).max(1e-3 * high.abs().max(1e-6));
    let x =
        Axis::over("reward per second of an episode that survives (1/s)", [low - margin, high + margin], 8);
    let counts: Vec<Vec<f64>> = arms.iter().map(|arm| shares(&arm.rewards, x.range)).collect();
    let highest = counts.iter().flatten().copied().fold(0.0, f64::max);
    let left = 58.0;
    let right = 24.0
        + arms.iter().flat_map(|arm| arm.words()).map(|text| text_width(&text, 12.0)).fold(0.0, f64::max);
    let height = arms.len() as f64 * (ROW[0] + ROW[1]) - ROW[1];
    let grid = Area { left, top: 34.0, width: 470.0, height };
    let mut drawing =
        Drawing::new(grid.right() + right, grid.bottom() + 44.0, "Reward of the episodes that survive");
    for (row, (arm, shares)) in arms.iter().zip(&counts).enumerate() {
        let area = grid.cell([1, arms.len()], [0, row], [0.0, ROW[1]]);
        let lowest = row + 1 == arms.len();
        let x = if lowest { x.clone() } else { x.without_words() };
        let panel =
            Panel { area, x, y: Axis::from_zero(if row == 0 { "share (%)" } else { "" }, [highest], 2) };
        panel.frame(&mut drawing, &arm.name);
        bars(&mut drawing, &panel, shares, row);
        for (line, text) in arm.words().into_iter().enumerate() {
            let at = [area.right() + 12.0, area.top + 16.0 + 17.0 * line as f64];
            drawing.text(at, text, if line == 0 { Ink::Text } else { Ink::Muted }, Anchor::Start);
        }
    }
    let n: Vec<String> = arms.iter().map(|arm| format!("{}: n = {}", arm.name, arm.rewards.len())).collect();
    Some(Figure {
        id: view.id(),
        title: "Reward of the episodes that survive".to_owned(),
        caption: format!(
            "Reward per second of the episodes of `{stage}` that reach their time limit, as a share of an \
             arm's own survivors ({}). An arm that survives harder \
             conditions has them in its mean: on what both arms survive they are compared in the table.",
            n.join("; ")
        ),
        drawing,
        sources: view.sources(&stage),
    })
}

fn arms(view: &View, stage: &str) -> Vec<Survivors> {
    let Some(reward) = Metric::named("reward_per_s") else { return Vec::new() };
    let measured = view.measured(stage);
    let survivors = |(place, group): (usize, &crate::report::group::Group<'_>)| {
        let own: Vec<&Evaluation> = measured
            .iter()
            .filter(|(at, ..)| *at == place)
            .map(|(.., measured)| &measured.evaluation)
            .collect();
        let rewards = own.iter().flat_map(|evaluation| {
            let values = reward.values(evaluation).into_iter().zip(&evaluation.episodes);
            values.filter(|(_, episode)| episode.survived).map(|(value, _)| value).collect::<Vec<_>>()
        });
        Survivors {
            name: shortened(group.name, 60),
            policies: own.len(),
            episodes: own.iter().map(|evaluation| evaluation.episodes.len()).sum(),
            rewards: rewards.collect(),
        }
    };
    view.groups.iter().enumerate().map(survivors).filter(|arm| arm.policies > 0).collect()
}

impl Survivors {
    /// The text next to its histogram.
    fn words(&self) -> Vec<String> {
        let mut words = vec![format!("{} of {} survive", self.rewards.len(), self.episodes)];
        if let Some(mean) = mean(&self.rewards) {
            let spread =
                deviation(&self.rewards).map_or(String::new(), |s| format!(", deviation {}", written(s, 1)));
            words.push(format!("mean {}{spread}", written(mean, 1)));
        }
        words.push(policies(self.policies));
        words
    }
}

/// Percentage of the values in each bar over a range.
fn shares(values: &[f64], [low, high]: [f64; 2]) -> Vec<f64> {
    let mut counts = vec![0.0; BARS];
    for value in values {
        let place = ((value - low) / (high - low) * BARS as f64) as usize;
        counts[place.min(BARS - 1)] += 100.0 / values.len() as f64;
    }
    counts
}

fn bars(drawing: &mut Drawing, panel: &Panel, shares: &[f64], arm: usize) {
    let [low, high] = panel.x.range;
    let edge = |at: usize| low + (high - low) * at as f64 / shares.len() as f64;
    for (at, share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
        let (a, b) = (panel.place(edge(at), 0.0), panel.place(edge(at + 1), *share));
        drawing.rectangle([a[0] + 0.5, a[1]], [b[0] - 0.5, b[1]], Ink::Arm(arm), 0.8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_one_bar() {
        let shares = shares(&[0.0, 0.1, 9.99, 10.0], [0.0, 10.0]);
        assert_eq!((shares[0], shares[BARS - 1], shares.len()), (50.0, 50.0, BARS));
        assert!((shares.iter().sum::<f64>() - 100.0).abs() < 1e-12);
    }
}
