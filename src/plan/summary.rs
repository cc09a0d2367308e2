//! A short summary of a suite's plan, however many runs it has: stages by name, runs by point, and the same
//! as a graph.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use super::budgets;
use super::expected::Expected;
use super::graph::{Plan, Stage};
use super::render::{Statuses, summary};
use super::suite::SuiteRecord;
use super::why::State;
use crate::escape::graph;
use crate::escape::terminal::one_line;

/// Numbers of stages by state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Tally {
    cached: usize,
    changed: usize,
    missing: usize,
}

impl Tally {
    fn add(&mut self, state: State) {
        match state {
            State::Cached => self.cached += 1,
            State::Changed => self.changed += 1,
            State::Missing => self.missing += 1,
        }
    }

    fn all(self) -> usize {
        self.cached + self.changed + self.missing
    }

    fn row(self) -> String {
        format!("{:>6}  {:>6}  {:>7}  {:>7}", self.all(), self.cached, self.changed, self.missing)
    }

    /// The state of all, if it is the same.
    fn common(self) -> Option<State> {
        match self {
            Self { changed: 0, missing: 0, .. } => Some(State::Cached),
            Self { cached: 0, missing: 0, .. } => Some(State::Changed),
            Self { cached: 0, changed: 0, .. } => Some(State::Missing),
            _ => None,
        }
    }
}

/// Stages of one name, in the order of the pipeline.
struct Group<'a> {
    name: &'a str,
    stages: Vec<&'a Stage>,
    tally: Tally,
}

fn groups<'a>(plan: &'a Plan, statuses: &Statuses) -> Vec<Group<'a>> {
    let mut groups: Vec<Group<'a>> = Vec::new();
    for stage in plan.stages() {
        let place = groups.iter().position(|group| group.name == stage.name());
        let place = place.unwrap_or_else(|| {
            groups.push(Group { name: stage.name(), stages: Vec::new(), tally: Tally::default() });
            groups.len() - 1
        });
        groups[place].stages.push(stage);
        groups[place].tally.add(statuses[&stage.fingerprint].state);
    }
    groups.sort_by_key(|group| group.stages[0].kind);
    groups
}

/// The text of `plan` for a suite.
pub fn text(plan: &Plan, suite: &SuiteRecord, statuses: &Statuses, expected: &Expected) -> String {
    let mut out = head(plan, suite);
    let groups = groups(plan, statuses);
    let width = groups.iter().map(|group| group.name.len()).max().unwrap_or(0).max("stage".len());
    out += &one_line(&format!(
        "\n{:<width$}  {:>6}  {:>6}  {:>7}  {:>7}  each for",
        "stage", "stages", "cached", "changed", "missing"
    ));
    for group in &groups {
        let row = format!("{:<width$}  {}  {}", group.name, group.tally.row(), used(group));
        out += &one_line(row.trim_end());
    }
    out += &by_point(plan, suite, statuses);
    out.push('\n');
    out += &budgets::text(plan);
    out += &expected.text();
    out += &one_line(&format!("{}; `--all` lists them", summary(plan, statuses)));
    out
}

/// `gains: 4 arms x 3 seeds = 12 runs`, and the axes.
fn head(plan: &Plan, suite: &SuiteRecord) -> String {
    let (arms, seeds, runs) = (suite.arms, suite.seeds.len().max(1), plan.arms.len());
    let plural =
        |count: usize, word: &str| if count == 1 { format!("1 {word}") } else { format!("{count} {word}s") };
    // If arms leave out seeds, this is the largest number.
    let most = if runs == arms * seeds { "x" } else { "x up to" };
    let product =
        format!("{} {most} {} = {}", plural(arms, "arm"), plural(seeds, "seed"), plural(runs, "run"));
    let mut out = one_line(&format!("{}: {product}", suite.name));
    let width = suite.axes.iter().map(|axis| axis.name.len()).max().unwrap_or(0).max("seeds".len());
    for axis in &suite.axes {
        out += &one_line(&format!("  {:<width$}  {}", axis.name, some(&axis.points)));
    }
    let seeds: Vec<String> = suite.seeds.iter().map(u64::to_string).collect();
    let seeds = if seeds.is_empty() { "each spec's own".to_owned() } else { some(&seeds) };
    out += &one_line(&format!("  {:<width$}  {seeds}", "seeds"));
    out
}

/// A list, shortened in its middle.
fn some(names: &[String]) -> String {
    const SHOWN: usize = 12;
    match names {
        [first @ .., last] if names.len() > SHOWN => {
            format!("{}, ..., {last} ({} in all)", first[..SHOWN - 2].join(", "), names.len())
        }
        _ => names.join(", "),
    }
}

/// The number of runs that use a stage of a group.
fn used(group: &Group<'_>) -> String {
    let counts: BTreeSet<usize> = group.stages.iter().map(|stage| stage.users.len()).collect();
    let runs = |count: usize| if count == 1 { "1 run".to_owned() } else { format!("{count} runs") };
    match (counts.first(), counts.last()) {
        _ if group.stages[0].kind == super::StageKind::Report => "all".to_owned(),
        (Some(least), Some(most)) if least == most => runs(*most),
        (Some(least), Some(most)) => format!("{least} to {most} runs"),
        _ => String::new(),
    }
}

/// The stages that the runs of each point need, including those that other points share.
fn by_point(plan: &Plan, suite: &SuiteRecord, statuses: &Statuses) -> String {
    let mut out = String::new();
    let point_width = |axis: &super::AxisRecord| {
        axis.points.iter().map(|point| axis.name.len() + 1 + point.chars().count()).max()
    };
    let width = suite.axes.iter().filter_map(point_width).max().unwrap_or(0).max("point".len());
    for axis in &suite.axes {
        let mut points: BTreeMap<&str, (usize, BTreeSet<_>)> = BTreeMap::new();
        for record in &plan.arms {
            let own =
                record.run.as_ref().and_then(|run| run.points.iter().find(|(name, _)| *name == axis.name));
            let Some((_, point)) = own else { continue };
            let (runs, stages) = points.entry(point).or_default();
            *runs += 1;
            stages.extend(record.stages.values());
        }
        out += &one_line(&format!(
            "\n{:<width$}  {:>5}  {:>6}  {:>6}  {:>7}  {:>7}",
            "point", "runs", "stages", "cached", "changed", "missing"
        ));
        for point in axis.points.iter().filter(|point| points.contains_key(point.as_str())) {
            let (runs, stages) = &points[point.as_str()];
            let mut tally = Tally::default();
            stages.iter().for_each(|key| tally.add(statuses[*key].state));
            out += &one_line(&format!(
                "{:<width$}  {runs:>5}  {}",
                format!("{}={point}", axis.name),
                tally.row()
            ));
        }
    }
    out
}

/// The artefacts between the groups: producer, consumer and artefact, each once.
fn edges(plan: &Plan) -> BTreeSet<(String, String, String)> {
    let of_stage = |consumer: &Stage| {
        let consumer_name = consumer.name().to_owned();
        let inputs = plan.inputs(consumer).into_iter();
        inputs
            .map(move |(from, edge)| (from.name().to_owned(), consumer_name.clone(), edge.artefact.clone()))
            .collect::<Vec<_>>()
    };
    plan.stages().flat_map(of_stage).collect()
}

fn label(group: &Group<'_>) -> (String, String) {
    let Tally { cached, changed, missing } = group.tally;
    let count = group.tally.all();
    let name = if count == 1 { group.name.to_owned() } else { format!("{count} x {}", group.name) };
    let states = match group.tally.common() {
        Some(state) => state.name().to_owned(),
        None => [(cached, "cached"), (changed, "changed"), (missing, "missing")]
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, word)| format!("{count} {word}"))
            .collect::<Vec<_>>()
            .join(", "),
    };
    (name, states)
}

/// The graph of a suite in Graphviz' dot language, with stages of the same name as one node.
pub fn dot(plan: &Plan, statuses: &Statuses) -> String {
    let mut out = String::from(
        "digraph suite {\n  rankdir=LR;\n  node [shape=box, style=rounded, fontname=\"sans-serif\"];\n",
    );
    for group in groups(plan, statuses) {
        let (name, states) = label(&group);
        let _ =
            writeln!(out, "  \"{}\" [label=\"{}\\n{states}\"];", graph::dot(group.name), graph::dot(&name));
    }
    for (from, to, artefact) in edges(plan) {
        let _ =
            writeln!(out, "  \"{}\" -> \"{}\" [label=\"{artefact}\"];", graph::dot(&from), graph::dot(&to));
    }
    out + "}\n"
}

/// The graph of a suite in Mermaid's language, with stages of the same name as one node.
pub fn mermaid(plan: &Plan, statuses: &Statuses) -> String {
    let id = |name: &str| name.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
    let mut out = String::from("flowchart LR\n");
    for group in groups(plan, statuses) {
        let (name, states) = label(&group);
        let _ = writeln!(out, "  {}[\"{}<br/>{states}\"]", id(group.name), graph::mermaid(&name));
    }
    for (from, to, artefact) in edges(plan) {
        let _ = writeln!(out, "  {} -->|{artefact}| {}", id(&from), id(&to));
    }
    out
}
