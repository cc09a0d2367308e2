//! Evaluations over parameter sets: how many each arm survives, why sets fail, and comparisons of arms on the
//! sets that they share.

use std::collections::BTreeMap;

use crate::kinds::evaluate::{Evaluation as Protocols, ParameterSets};
use crate::outcome::{Episode, Evaluation};
use crate::report::comparison::are_paired;
use crate::report::estimate::Estimate;
use crate::report::group::{self, Group};
use crate::report::model::Arm;
use crate::report::source::Source;
use crate::report::table::{Cell, Table};
use crate::report::wording::{arm_in_words, significance};
use crate::spec::typed::InSection;
use crate::statistics::CONFIDENCE;
use crate::statistics::difference::Pairs;
use crate::statistics::failure::{Analysis, FEWEST, Ranged, Sets, loadings};
use crate::statistics::proportion::mcnemar_exact;
use crate::statistics::summary::{deviation, mean};
use crate::stream::Stream;

/// With more arms than this, all are compared with the first one only.
const ALL_PAIRS: usize = 4;

/// The stages of evaluations over parameter sets, in the order of the runs.
pub fn stages(groups: &[Group<'_>]) -> Vec<String> {
    let mut stages: Vec<String> = Vec::new();
    for measured in groups.iter().flat_map(|group| &group.runs).flat_map(|run| &run.evaluations) {
        if is_of_sets(&measured.evaluation) && !stages.contains(&measured.stage) {
            stages.push(measured.stage.clone());
        }
    }
    stages
}

/// Whether an evaluation is one over parameter sets.
pub fn is_of_sets(evaluation: &Evaluation) -> bool {
    evaluation.episodes.iter().any(|episode| !episode.parameters.is_empty())
}

/// An arm's evaluations of a stage, with their runs.
fn evaluations<'a>(group: &Group<'a>, stage: &str) -> Vec<(&'a Arm, &'a Evaluation)> {
    let of_run = |run: &&'a Arm| {
        let measured = run.evaluations.iter().find(|measured| measured.stage == stage)?;
        is_of_sets(&measured.evaluation).then_some((*run, &measured.evaluation))
    };
    group.runs.iter().filter_map(of_run).collect()
}

/// A set with its deviations from the nominal one.
struct Tried {
    row: Vec<f64>,
    failures: f64,
    trials: f64,
}

/// The sets that an arm's policies tried in a stage, and how often each failed.
pub fn sets(group: &Group<'_>, stage: &str) -> Sets {
    let tried = evaluations(group, stage);
    let episodes = || tried.iter().flat_map(|(_, evaluation)| &evaluation.episodes);
    let mut names: Vec<String> = episodes().flat_map(|episode| episode.parameters.keys().cloned()).collect();
    names.sort();
    names.dedup();
    let scales = |name: &str| {
        episodes().filter_map(|episode| episode.parameters.get(name).copied()).collect::<Vec<_>>()
    };
    names.retain(|name| scales(name).windows(2).any(|pair| pair[0] != pair[1]));
    let half = tried.first().and_then(|(run, _)| half_range(run, stage));
    let halves: Vec<f64> = names
        .iter()
        .map(|name| {
            half.unwrap_or_else(|| scales(name).iter().map(|scale| (scale - 1.0).abs()).fold(0.0, f64::max))
        })
        .collect();
    // Random stream and scales identify a set: policies that share sets are counted in one row.
    let mut rows: BTreeMap<(&str, Vec<u64>), Tried> = BTreeMap::new();
    for episode in episodes().filter(|episode| names.iter().all(|name| episode.parameters.contains_key(name)))
    {
        let row: Vec<f64> =
            names.iter().zip(&halves).map(|(name, half)| (episode.parameters[name] - 1.0) / half).collect();
        let key = (episode.stream.as_str(), row.iter().map(|value| value.to_bits()).collect());
        let tried = rows.entry(key).or_insert(Tried { row, failures: 0.0, trials: 0.0 });
        tried.failures += f64::from(u8::from(!episode.survived));
        tried.trials += 1.0;
    }
    let mut found = Sets { names, ..Sets::default() };
    for tried in rows.into_values() {
        found.rows.push(tried.row);
        found.failures.push(tried.failures);
        found.trials.push(tried.trials);
    }
    found
}

/// The direction of failure of a policy in a stage over parameter sets, one entry per parameter; `None` with
/// too few failures or survivals.
pub fn direction(run: &Arm, stage: &str) -> Option<Vec<(String, f64)>> {
    let sets = sets(&Group { name: &run.name, points: &[], runs: vec![run] }, stage);
    let [failed, tried] = sets.counts();
    if failed < FEWEST || tried - failed < FEWEST {
        return None;
    }
    let found = loadings::of(&sets, &vec![1.0; sets.rows.len()])?;
    Some(sets.names.into_iter().zip(found.direction).collect())
}

/// Half the range of the scales in the spec.
fn half_range(run: &Arm, stage: &str) -> Option<f64> {
    let (_, name) = stage.split_once('.').filter(|(section, _)| *section == Protocols::SECTION)?;
    let protocol = run.section().within::<Protocols>()?.section(name)?;
    match protocol.value(ParameterSets::scale)?.as_slice() {
        [low, high] if high > low => Some(0.5 * (high - low)),
        _ => None,
    }
}

/// The sets of an arm and why they fail; `None` with too few failures or survivals.
type Found = Option<(Sets, Analysis)>;

/// Why an arm's sets fail.
pub fn analysis(group: &Group<'_>, stage: &str) -> Option<(Sets, Analysis)> {
    let sets = sets(group, stage);
    let mut stream = Stream::new(&format!("report/failures/{}/{stage}", group.name));
    let analysis = sets.analyse(CONFIDENCE, &mut stream)?;
    Some((sets, analysis))
}

/// Tables and sentences for every stage over parameter sets.
pub fn told(groups: &[Group<'_>]) -> (Vec<Table>, Vec<String>) {
    let (mut tables, mut sentences) = (Vec::new(), Vec::new());
    for stage in stages(groups) {
        // Resampling is slow, so tables and sentences share it.
        let found: Vec<Found> = groups.iter().map(|group| analysis(group, &stage)).collect();
        tables.extend([survivors(groups, &stage), pairs(groups, &stage), causes(groups, &stage, &found)]);
        let tried = groups.iter().zip(&found).filter(|(group, _)| !evaluations(group, &stage).is_empty());
        sentences.extend(tried.map(|(group, found)| sentence(group, &stage, found)));
    }
    tables.retain(|table| !table.rows.is_empty());
    (tables, sentences)
}

fn id(what: &str, stage: &str) -> String {
    format!("{what}_{}", stage.replace('.', "_"))
}

fn sources(runs: &[(&Arm, &Evaluation)], stage: &str) -> Vec<Source> {
    runs.iter().map(|(run, _)| Source { arm: run.name.clone(), stage: stage.to_owned() }).collect()
}

/// Survival, one row per arm.
fn survivors(groups: &[Group<'_>], stage: &str) -> Table {
    let heads = [
        "arm",
        "policies",
        "sets",
        "episodes that survive (%)",
        "their reward (1/s)",
        "deviation of their reward",
    ];
    let title = format!("Parameter sets of `{stage}`");
    let mut table = Table::new(&id("sets", stage), &title, heads.map(String::from));
    for group in groups {
        let tried = evaluations(group, stage);
        if tried.is_empty() {
            continue;
        }
        let episodes = || tried.iter().flat_map(|(_, evaluation)| &evaluation.episodes);
        let alive = alive_rewards(episodes());
        let name = format!("{}/{stage}/alive", group.name);
        let cells = [
            Cell::Text(tried.len().to_string()),
            Cell::Text(sets(group, stage).rows.len().to_string()),
            Estimate::share(&episodes().map(|episode| episode.survived).collect::<Vec<_>>()).into(),
            Estimate::mean(&alive, "", 1, &name).into(),
            Estimate::maybe(deviation(&alive), "", 1).into(),
        ];
        table.row_from(group.name, &arm_in_words(group.name), cells, sources(&tried, stage));
    }
    table.sources = group::sources(groups, stage);
    table
}

fn alive_rewards<'a>(episodes: impl Iterator<Item = &'a Episode>) -> Vec<f64> {
    episodes.filter(|episode| episode.survived).map(reward).collect()
}

/// The reward per second of an episode.
fn reward(episode: &Episode) -> f64 {
    episode.reward_per_second.values().sum()
}

/// Comparisons of the arms on shared sets, between policies with the same seed.
fn pairs(groups: &[Group<'_>], stage: &str) -> Table {
    let heads = [
        "arms",
        "sets",
        "survived by the first alone",
        "by the second alone",
        "difference (points)",
        "exact McNemar test, p",
        "difference of the survivors' reward (1/s)",
        "the same on sets that both survive (1/s)",
    ];
    let title = format!("The arms on the same sets of `{stage}`");
    let mut table = Table::new(&id("pairs", stage), &title, heads.map(String::from));
    for (first, a) in groups.iter().enumerate() {
        let others = if groups.len() > ALL_PAIRS && first > 0 { &[][..] } else { &groups[first + 1..] };
        for b in others {
            for (one, other) in evaluations(a, stage).into_iter().zip(evaluations(b, stage)) {
                if are_paired(one.1, other.1) {
                    pair(&mut table, stage, [a, b], [one, other]);
                }
            }
        }
    }
    table.sources = group::sources(groups, stage);
    table
}

fn pair(table: &mut Table, stage: &str, arms: [&Group<'_>; 2], runs: [(&Arm, &Evaluation); 2]) {
    let [one, other] = runs.map(|(_, evaluation)| &evaluation.episodes);
    let survived = |episodes: &[Episode]| episodes.iter().map(|episode| episode.survived).collect::<Vec<_>>();
    let pairs = Pairs::count(&survived(one), &survived(other));
    let (value, interval) = pairs.difference(CONFIDENCE);
    let difference =
        Estimate { value: Some(value), n: Some(one.len()), unit: "%".into(), ..Estimate::default() };
    let seed = |run: &Arm| run.run.as_ref().map_or(String::new(), |run| format!("seed {}", run.seed));
    let (seeds, name) = (runs.map(|(run, _)| seed(run)), runs.map(|(run, _)| run.name.as_str()).join("/"));
    let seeds = if seeds[0] == seeds[1] { seeds[0].clone() } else { seeds.join(" and ") };
    let of_survivors = mean(&alive_rewards(one.iter())).zip(mean(&alive_rewards(other.iter())));
    let both = one.iter().zip(other).filter(|(a, b)| a.survived && b.survived);
    let common: Vec<f64> = both.map(|(a, b)| reward(a) - reward(b)).collect();
    let cells = [
        Cell::Text(one.len().to_string()),
        Cell::Text(pairs.only_first.to_string()),
        Cell::Text(pairs.only_second.to_string()),
        difference.within(Some(interval)).into(),
        Cell::Text(significance(mcnemar_exact(pairs.only_first, pairs.only_second))),
        Estimate::maybe(of_survivors.map(|(a, b)| a - b), "", 1).into(),
        Estimate::mean(&common, "", 1, &format!("{name}/{stage}/common")).into(),
    ];
    let label = format!("{} minus {}, {seeds}", arm_in_words(arms[0].name), arm_in_words(arms[1].name));
    table.row_from(&name, &label, cells, sources(&runs, stage));
}

/// Why sets fail: one row per arm and parameter.
fn causes(groups: &[Group<'_>], stage: &str, found: &[Found]) -> Table {
    let heads = [
        "arm and parameter",
        "direction of failure",
        "log odds by one deviation",
        "by one deviation of the square",
        "standardised mean difference",
    ];
    let title = format!("Why sets of `{stage}` fail");
    let mut table = Table::new(&id("failures", stage), &title, heads.map(String::from));
    for (group, found) in groups.iter().zip(found) {
        let tried = evaluations(group, stage);
        let Some((sets, found)) = found else { continue };
        for (at, parameter) in sets.names.iter().enumerate() {
            let cells = [&found.loadings, &found.linear, &found.quadratic, &found.differences]
                .map(|numbers| Cell::from(estimate(&numbers[at])));
            let name = format!("{}/{parameter}", group.name);
            table.row_from(
                &name,
                &format!("{}: {parameter}", arm_in_words(group.name)),
                cells,
                sources(&tried, stage),
            );
        }
    }
    table.sources = group::sources(groups, stage);
    table
}

fn estimate(ranged: &Ranged) -> Estimate {
    Estimate::exact(ranged.value, "", 2).within(ranged.interval)
}

/// Caveats on an arm's failures.
fn sentence(group: &Group<'_>, stage: &str, found: &Found) -> String {
    let [failed, tried] = sets(group, stage).counts();
    let start = format!("{} in `{stage}`: {failed} of {tried} tries failed;", arm_in_words(group.name));
    let Some((sets, found)) = found else {
        return format!("{start} ten of either kind are needed to say why.");
    };
    let (share, none) = (100.0 * found.share, 100.0 / sets.names.len() as f64);
    let ridge = found.ridge.map_or(String::new(), |penalty| {
        format!(
            " Failures can be told from survivals without a mistake, so the regression was held by a ridge \
             penalty of {penalty}: read its signs and order, not its sizes."
        )
    });
    format!(
        "{start} {share:.0} % of the squared distances of the failed sets lie along the direction of failure \
         ({none:.0} % where there is none).{ridge}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::model::Measured;
    use crate::spec::{Quantity, Table, Value};

    fn table<const N: usize>(entries: [(&str, Value); N]) -> Value {
        Value::Table(Table::from(entries.map(|(key, value)| (key.to_owned(), value))))
    }

    /// A run that tried three delays and fell at the longest.
    fn run(fields: Table) -> Arm {
        let episode = |(index, scale): (usize, f64)| Episode {
            stream: format!("1/{index}"),
            survived: scale < 1.1,
            parameters: BTreeMap::from([("action_delay".to_owned(), scale), ("link_mass".to_owned(), 1.0)]),
            ..Episode::default()
        };
        let episodes = [0.9, 1.0, 1.1].into_iter().enumerate().map(episode).collect();
        let evaluation = Evaluation { episodes, ..Evaluation::default() };
        let evaluations = vec![Measured { stage: "evaluate.sets".into(), evaluation }];
        Arm { fields, evaluations, ..Arm::default() }
    }

    #[test]
    fn scales_are_counted_in_half_ranges_of_the_spec_and_policies_on_one_set_together() {
        let number = |si: f64| Value::Quantity(Quantity { si, text: si.to_string() });
        let scale = Value::List(vec![number(0.8), number(1.2)]);
        let evaluate = table([("sets", table([("scale", scale)]))]);
        let known = run(Table::from([("evaluate".to_owned(), evaluate)]));
        let group = Group { name: "a", points: &[], runs: vec![&known, &known] };
        let found = sets(&group, "evaluate.sets");
        assert_eq!(found.names, ["action_delay"], "what is the same in every set says nothing");
        let row: Vec<f64> = found.rows.iter().map(|row| (row[0] * 1e6).round() / 1e6).collect();
        assert_eq!(
            (row, found.failures, found.trials),
            (vec![-0.5, 0.0, 0.5], vec![0.0, 0.0, 2.0], vec![2.0; 3])
        );
        let unknown = run(Table::new());
        let found = sets(&Group { name: "a", points: &[], runs: vec![&unknown] }, "evaluate.sets");
        assert!(
            (found.rows[0][0] + 1.0).abs() < 1e-9,
            "without a range the farthest set is its end: {found:?}"
        );
    }
}
