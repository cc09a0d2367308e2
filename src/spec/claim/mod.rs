//! Claims: what a suite is expected to show, decoded from one `[[claim]]` table.
//!
//! Covers the keys of a claim and the grammar of `expect` and of arm patterns. Metrics and tests are in the
//! registries; whether the arms exist is checked in `check`.

mod blank;
pub mod cases;
mod expect;
mod pattern;
#[cfg(test)]
pub mod tests;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use cases::{Alternative, Case, Points, alternatives, cases, unpaired};
pub use expect::{Expectation, Operand, Relation};
pub use pattern::{ArmPattern, Term, is_meant};

use super::decode::{self, Decoded, part};
use super::marks::{Mark, Marks};
use super::{Param, Quantity, Section, Table, Ty, Value};
use crate::diag::{Diagnostic, Sink, SourceId, Span};
use crate::syntax::Node;

/// The test of a claim that does not name one.
pub const DEFAULT_TEST: &str = "welch";

/// The keys of a `[[claim]]`.
pub const PARAMS: &[Param] = &[
    Param::required("id", Ty::Text).doc("Its name in reports and events: letters, digits, `_`, `-` and `.`."),
    Param::required("text", Ty::Text).doc("What is claimed, as a sentence."),
    Param::required("metric", Ty::Text)
        .doc("A stage of the arms and a metric of it: `evaluate.nominal.survival`, `learn.final_return`."),
    Param::optional("baseline", Ty::Text).doc(
        "Another stage of the same runs: the value of a run is the metric in the stage of `metric` minus the \
         metric in this stage.",
    ),
    Param::optional("twin", Ty::Text).doc(
        "Another arm, as `axis=point` joined by commas: what a run is compared with is the run of the same \
         seed in the arm that has \
         these points and else its own, in the stage of `metric` or of `baseline`.",
    ),
    Param::optional("relative", Ty::Flag)
        .doc("Whether the metric is divided by that of the `baseline` or of the `twin` instead."),
    Param::optional(
        "compare",
        Ty::Table(&[
            Param::required("a", Ty::Text).doc("An arm, as `axis=point` joined by commas."),
            Param::required("b", Ty::Text).doc("The arm that it is compared with."),
        ]),
    )
    .doc("The arms `a` and `b` of the expectation. An axis that is not named may take any point."),
    Param::optional("arm", Ty::Text).doc("The arm `a` of a claim that compares one arm with a number."),
    Param::optional("over", Ty::OneOf(&[Ty::Choice(OVER), Ty::Table(QUANTIFIER)])).doc(
        "What is claimed when a pattern matches several arms: that it holds for `each` of them, for the \
         `mean` over \
         them, for `{ some = AXIS }` point of an axis, for `{ none = AXIS }`, for `{ at_least = N }` or \
         `{ at_most = N }` of \
         the comparisons, or for the `{ trend = AXIS }` of their means. Without it a pattern must match one \
         arm.",
    ),
    Param::required("expect", Ty::Text).doc(
        "`a > b`, `a >= b + 20 %`, `a < 0.5 * b`, `a > 0.9`, `a < 0.2 m/s` or `a == b within 5 %`; see \
             the page of claims.",
    ),
    Param::default("test", Ty::Text, "\"welch\"").doc("The test: `specforge list statistic`."),
    Param::default("summary", Ty::Choice(SUMMARIES), "\"mean\"")
        .doc("What an arm's runs are summarised by: the mean, or the interquartile mean."),
    Param::default("alpha", Ty::Number, "0.05")
        .range(1e-6, 0.5)
        .doc("Two-sided level of the test; the interval has the confidence 1 - alpha."),
    Param::optional("margin", Ty::OneOf(&[Ty::Number, Ty::Text])).doc(
        "In the metric's unit: `>` and `<` must exceed it, `>=` and `<=` may fall short by it \
            (non-inferiority).",
    ),
    Param::optional("effect", Ty::OneOf(&[Ty::Number, Ty::Text])).doc(
        "The true value that is assumed for the power of the test: of one arm, or the difference of two, in \
         the metric's unit.",
    ),
    Param::optional("spread", Ty::OneOf(&[Ty::Number, Ty::Text])).doc(
        "The standard deviation between runs that is assumed for the power of the test before there are \
         runs, in the metric's unit.",
    ),
    Param::optional("threshold", Ty::Number).doc("The return that `samples_to_threshold` waits for."),
    Param::optional("until", Ty::Count).range(1.0, 1e12).doc(
        "The samples from the beginning of a training that a metric of its curve looks at; without it, and \
         in a shorter training, all.",
    ),
    Param::optional("parameter", Ty::Text).doc(
        "The parameter that `failure_loading` and `failure_dominance` are about, by the name of its \
            randomization.",
    ),
    Param::optional(
        "paper",
        Ty::Table(&[
            Param::required("where", Ty::Text).doc("Where the paper says it."),
            Param::required("value", Ty::Text).doc("What it says, in few words."),
            Param::optional("number", Ty::OneOf(&[Ty::Number, Ty::Text])).doc(
                "The same as a number, in the metric's unit, to be drawn beside the measurement; of a claim \
                    that compares two arms, their difference.",
            ),
            Param::optional("weaker", Ty::Flag).doc(
                "Whether this claim expects less than that, so that its PASS does not establish what \
                    the paper says.",
            ),
        ]),
    )
    .doc("What the reproduced paper reports."),
];

const OVER: &[&str] = &["each", "mean"];
/// The keys of `over` as a table; exactly one is written.
const QUANTIFIER: &[Param] = &[
    Param::optional("some", Ty::Text)
        .doc("An axis: at one of its points at least, the expectation holds in every comparison."),
    Param::optional("none", Ty::Text)
        .doc("An axis: at none of its points does the expectation hold in every comparison."),
    Param::optional("at_least", Ty::Count)
        .range(1.0, 1e4)
        .doc("In so many of the comparisons, or more, the expectation holds."),
    Param::optional("at_most", Ty::Count)
        .range(0.0, 1e4)
        .doc("In so many of the comparisons, or fewer, the expectation holds."),
    Param::optional("trend", Ty::Text).doc(
        "An axis: the expectation is about the slope of the means over its points, in their order and \
            per point.",
    ),
];
const SUMMARIES: &[&str] = &["mean", "iqm"];

/// A claim. Serialized as its decoded table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "Table", try_from = "Table")]
pub struct Claim {
    /// Its name.
    pub id: String,
    /// What is claimed, as a sentence.
    pub text: String,
    /// What is measured.
    pub metric: MetricPath,
    /// The arms by their name in `expect`: `a` alone, or `a` and `b`.
    pub sides: BTreeMap<String, ArmPattern>,
    /// How a claim combines the arms that one pattern matches; if absent, each pattern matches one arm.
    pub over: Option<Over>,
    /// What is expected of the sides.
    pub expect: Expectation,
    /// Name of the test.
    pub test: String,
    /// How the runs of an arm are summarized.
    pub summary: Summary,
    /// Two-sided level.
    pub alpha: f64,
    /// The margin of superiority or non-inferiority, in the metric's unit.
    pub margin: Option<Quantity>,
    /// What each run's value is compared with, by difference or ratio.
    pub baseline: Option<Baseline>,
    /// Assumed standard deviation between runs before there are any, in the metric's unit.
    pub spread: Option<Quantity>,
    /// The value, or the difference of two arms, for which the power is computed, in the metric's unit.
    pub effect: Option<Quantity>,
    /// The return at which a metric of learning counts as reached.
    pub threshold: Option<f64>,
    /// Number of training samples that a metric of learning covers; all if absent.
    pub until: Option<f64>,
    /// The parameter of a failure metric.
    pub parameter: Option<String>,
    /// What the paper reports.
    pub paper: Option<Paper>,
    /// The decoded table; [`Claim::of_table`] rebuilds the claim from it.
    pub fields: Table,
    /// The places of all parts, by key; the terms of a pattern as `compare.a.0`, `arm.1`, with the axis as
    /// key and the point as value; the parts of the expectation as `expect.left`, `expect.right`,
    /// `expect.within`; those of the metric as `metric.stage` and `metric.name`.
    pub marks: Marks,
}

/// What the metric of a run is compared with: another stage, another arm's run with the same seed, or both.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Baseline {
    /// The stage: `evaluate.flat`.
    pub stage: String,
    /// The points in which the other arm differs; absent if the run is compared with itself.
    pub twin: Option<ArmPattern>,
    /// Whether the value is the ratio of the two instead of their difference.
    pub relative: bool,
}

/// A metric of a stage.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MetricPath {
    /// The stage: `evaluate.nominal`, `deploy.mujoco`, `learn`.
    pub stage: String,
    /// The metric: `survival`.
    pub name: String,
}

impl MetricPath {
    /// The path as text: `evaluate.nominal.survival`.
    pub fn written(&self) -> String {
        format!("{}.{}", self.stage, self.name)
    }
}

/// How a claim combines several arms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Over {
    /// It holds for each.
    Each,
    /// It holds for the mean over them; runs are resampled within each arm.
    Mean,
    /// It holds for each at some point of this axis.
    Some(String),
    /// It holds for each at no point of this axis.
    None(String),
    /// It holds in at least this many comparisons.
    AtLeast(usize),
    /// It holds in at most this many comparisons.
    AtMost(usize),
    /// It holds for the slope of the means over the points of this axis, per point.
    Trend(String),
}

impl Over {
    /// The axis whose points are alternatives.
    pub fn axis(&self) -> Option<&str> {
        match self {
            Self::Some(axis) | Self::None(axis) => Some(axis),
            Self::Each | Self::Mean | Self::AtLeast(_) | Self::AtMost(_) | Self::Trend(_) => None,
        }
    }

    /// The key and the axis it names.
    pub fn named(&self) -> Option<(&'static str, &str)> {
        match self {
            Self::Some(axis) => Some(("over.some", axis)),
            Self::None(axis) => Some(("over.none", axis)),
            Self::Trend(axis) => Some(("over.trend", axis)),
            Self::Each | Self::Mean | Self::AtLeast(_) | Self::AtMost(_) => None,
        }
    }

    /// Whether all comparisons form one sample, each being a stratum.
    pub fn is_joint(&self) -> bool {
        matches!(self, Self::Mean | Self::Trend(_))
    }

    /// `each`, `some axis`, `at least 3`.
    pub fn in_words(&self) -> String {
        match self {
            Self::Each => "each".to_owned(),
            Self::Mean => "mean".to_owned(),
            Self::Some(axis) => format!("some {axis}"),
            Self::None(axis) => format!("no {axis}"),
            Self::AtLeast(count) => format!("at least {count}"),
            Self::AtMost(count) => format!("at most {count}"),
            Self::Trend(axis) => format!("trend of {axis}"),
        }
    }

    /// Parses the output of [`Over::in_words`].
    pub fn of_words(words: &str) -> Option<Self> {
        let axis = |start: &str| words.strip_prefix(start).map(str::to_owned);
        let count = |start: &str| words.strip_prefix(start)?.parse().ok();
        Some(match words {
            "each" => Self::Each,
            "mean" => Self::Mean,
            _ => {
                return (axis("some ").map(Self::Some))
                    .or_else(|| axis("no ").map(Self::None))
                    .or_else(|| axis("trend of ").map(Self::Trend))
                    .or_else(|| count("at least ").map(Self::AtLeast))
                    .or_else(|| count("at most ").map(Self::AtMost));
            }
        })
    }

    /// The minimum or maximum number of comparisons that hold.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::AtLeast(count) | Self::AtMost(count) => Some(*count),
            _ => None,
        }
    }
}

/// How the runs of an arm are summarized.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Summary {
    /// The mean.
    #[default]
    Mean,
    /// The interquartile mean (Agarwal et al. 2021).
    Iqm,
}

impl Summary {
    /// Whether it is the default.
    pub fn is_mean(&self) -> bool {
        *self == Self::Mean
    }
}

/// What the reproduced paper reports.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Paper {
    /// Where in the paper.
    #[serde(rename = "where")]
    pub place: String,
    /// The reported result.
    pub value: String,
    /// The same as a number in the metric's unit, comparable with the claim's estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<Quantity>,
    /// Whether the claim expects less than that.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub weaker: bool,
}

impl Paper {
    /// `Exp. 1: it walks (this claim expects less)`.
    pub fn in_words(&self) -> String {
        let less = if self.weaker { " (this claim expects less)" } else { "" };
        format!("{}: {}{less}", self.place, self.value.trim_end_matches('.'))
    }
}

/// Decodes one `[[claim]]` table. `None` if anything is wrong with it; all mistakes are then in the sink.
///
/// Whether the metric, the test and the arms exist is not checked here.
pub fn decode(node: &Node, sink: &mut Sink) -> Option<Claim> {
    let Decoded { table, marks } = decode::element(node, PARAMS, sink)?;
    let mut reading = Reading { fields: Section::new(&table), marks, sink, header: node.span, sound: true };
    let claim = reading.claim();
    reading.sound.then_some(claim)?
}

impl Claim {
    /// Rebuilds a claim from the valid decoded table stored in a plan; without places.
    pub fn of_table(table: &Table) -> Option<Self> {
        let nowhere = Span { source: SourceId(0), start: 0, end: 0 };
        let (fields, marks, mut sink) = (Section::new(table), Marks::default(), Sink::default());
        let claim = Reading { fields, marks, sink: &mut sink, header: nowhere, sound: true }.claim();
        claim.filter(|_| !sink.has_errors())
    }
}

impl From<Claim> for Table {
    fn from(claim: Claim) -> Self {
        claim.fields
    }
}

impl TryFrom<Table> for Claim {
    type Error = String;

    fn try_from(table: Table) -> Result<Self, String> {
        Self::of_table(&table).ok_or_else(|| "this table is not a claim".to_owned())
    }
}

/// A claim being decoded: its keys, the places found so far, and whether anything was wrong.
struct Reading<'a> {
    fields: Section<'a>,
    marks: Marks,
    sink: &'a mut Sink,
    header: Span,
    sound: bool,
}

impl Reading<'_> {
    fn claim(&mut self) -> Option<Claim> {
        self.check_id();
        self.texts_say_something();
        let metric = self.metric();
        let sides = self.sides();
        let expect = self.expectation(&sides);
        let margin = self.margin(expect.as_ref());
        let [spread, effect, number] = ["spread", "effect", "paper.number"].map(|key| self.amount(key));
        let baseline = self.baseline(metric.as_ref());
        let over = self.over();
        let word = |key| self.fields.text_if(key).unwrap_or_default();
        Some(Claim {
            id: word("id").to_owned(),
            text: word("text").to_owned(),
            metric: metric?,
            sides: sides?,
            over,
            expect: expect?,
            test: word("test").to_owned(),
            summary: if word("summary") == "iqm" { Summary::Iqm } else { Summary::Mean },
            alpha: self.fields.si("alpha"),
            margin,
            baseline,
            spread,
            effect,
            threshold: self.fields.si_if("threshold"),
            until: self.fields.has("until").then(|| self.fields.count("until") as f64),
            parameter: self.fields.text_if("parameter").map(str::to_owned),
            paper: self.fields.section("paper").map(|paper| Paper {
                place: paper.text("where").to_owned(),
                value: paper.text("value").to_owned(),
                number,
                weaker: paper.get("weaker").is_some() && paper.flag("weaker"),
            }),
            fields: self.fields.table().clone(),
            marks: std::mem::take(&mut self.marks),
        })
    }

    fn fail(&mut self, error: Diagnostic) {
        self.sink.emit(error);
        self.sound = false;
    }

    /// The place of a key's value.
    fn place(&self, key: &str) -> Span {
        self.marks.get(key).map_or(self.header, |mark| mark.value)
    }

    /// Records the place of a part of a text.
    fn mark(&mut self, path: &str, [key, value]: [Span; 2], text: &str) {
        let layer = self.marks.nearest(path).map(|mark| mark.layer).unwrap_or_default();
        self.marks.by_path.insert(path.to_owned(), Mark { key, value, layer, text: text.to_owned() });
    }

    fn check_id(&mut self) {
        let id = self.fields.text("id");
        let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.');
        if id.is_empty() || !id.chars().all(plain) {
            let error = Diagnostic::error("E0103", format!("`{id}` is not a name: claims are called by it"));
            self.fail(error.at(self.place("id"), "not a name").help("use letters, digits, `_`, `-` and `.`"));
        }
    }

    /// Decodes `over`: a word, or a table with one of its keys.
    fn over(&mut self) -> Option<Over> {
        let table = match self.fields.get("over")? {
            Value::Table(table) => Section::new(table),
            Value::Text(word) => return Some(if word == "mean" { Over::Mean } else { Over::Each }),
            _ => return None,
        };
        let axis = |key: &str| table.text_if(key).map(str::to_owned);
        let count = |key: &str| table.has(key).then(|| table.count(key) as usize);
        let given = [
            axis("some").map(Over::Some),
            axis("none").map(Over::None),
            count("at_least").map(Over::AtLeast),
            count("at_most").map(Over::AtMost),
            axis("trend").map(Over::Trend),
        ];
        let mut given = given.into_iter().flatten();
        match (given.next(), given.next()) {
            (Some(over), None) => return Some(over),
            (Some(_), Some(_)) => {
                let error = Diagnostic::error(
                    "E0105",
                    "`over` has one of `some`, `none`, `at_least`, `at_most` and `trend`",
                );
                self.fail(error.at(self.place("over"), "several").help("remove all but one"));
            }
            (None, _) => {
                let error = Diagnostic::error("E0101", "`over` does not say over what");
                let help = "write `over = { some = \"AXIS\" }`, `over = { none = \"AXIS\" }`, `over = \
                    { at_least = N }`, `over = { trend = \"AXIS\" }`, `over = \"each\"` or `over = \"mean\"`";
                self.fail(error.at(self.place("over"), "an axis or a number is missing").help(help));
            }
        }
        None
    }

    /// What the metric of each run is compared with: another stage, another arm's run, or both.
    fn baseline(&mut self, metric: Option<&MetricPath>) -> Option<Baseline> {
        let stage = self.fields.text_if("baseline").map(str::to_owned);
        let relative = self.fields.get("relative").is_some() && self.fields.flag("relative");
        if self.is_blank("baseline") || self.is_blank("twin") {
            return None;
        }
        let twin = match self.fields.text_if("twin") {
            Some(text) => Some(self.pattern("twin", text)?),
            None => None,
        };
        match stage.or_else(|| Some(metric.filter(|_| twin.is_some())?.stage.clone())) {
            Some(stage) => Some(Baseline { stage, twin, relative }),
            None => {
                if self.fields.get("relative").is_some() && twin.is_none() {
                    let error = Diagnostic::error(
                        "E0105",
                        "`relative` is a key of a claim with a `baseline` or a `twin`",
                    );
                    let error = error.at(self.place("relative"), "relative to what?");
                    self.fail(error.help("add `baseline = \"evaluate.NAME\"`, or remove `relative`"));
                }
                None
            }
        }
    }

    fn metric(&mut self) -> Option<MetricPath> {
        let (text, place) = (self.fields.text("metric"), self.place("metric"));
        let Some((stage, name)) =
            text.rsplit_once('.').filter(|(stage, name)| !stage.is_empty() && !name.is_empty())
        else {
            let error = Diagnostic::error("E0103", format!("`{text}` is not a metric of a stage"))
                .at(place, "no stage");
            let example = if text.is_empty() { "survival" } else { text.trim_matches('.') };
            self.fail(
                error.help(format!("write the stage before it, for example `evaluate.nominal.{example}`")),
            );
            return None;
        };
        let spans = [part(place, text, 0..stage.len()), part(place, text, stage.len() + 1..text.len())];
        self.mark("metric.stage", [spans[0]; 2], stage);
        self.mark("metric.name", [spans[1]; 2], name);
        Some(MetricPath { stage: stage.to_owned(), name: name.to_owned() })
    }

    /// The patterns of `compare` or `arm`.
    fn sides(&mut self) -> Option<BTreeMap<String, ArmPattern>> {
        let compare = self.fields.section("compare");
        let written = match (compare, self.fields.text_if("arm")) {
            (Some(compare), None) => {
                vec![("a", "compare.a", compare.text("a")), ("b", "compare.b", compare.text("b"))]
            }
            (None, Some(arm)) => vec![("a", "arm", arm)],
            (Some(_), Some(_)) => {
                let key = self.marks.get("arm").map_or(self.header, |mark| mark.key);
                let error = Diagnostic::error(
                    "E0105",
                    "`arm` is a key of a claim about one arm, and this compares two",
                );
                self.fail(error.at(key, "beside `compare`").help("remove `arm`, or remove `compare`"));
                return None;
            }
            (None, None) => {
                let error = Diagnostic::error("E0101", "a claim needs its arms: `compare` is missing");
                let help = "add `compare = { a = \"axis=point\", b = \"axis=point\" }`, or `arm = \
                    \"axis=point\"` for one arm";
                self.fail(error.at(self.header, "about which arms?").help(help));
                return None;
            }
        };
        let mut sides = BTreeMap::new();
        for (name, path, text) in written {
            sides.insert(name.to_owned(), self.pattern(path, text)?);
        }
        Some(sides)
    }

    fn pattern(&mut self, path: &str, text: &str) -> Option<ArmPattern> {
        if self.is_blank(path) {
            return None;
        }
        let place = self.place(path);
        match pattern::parse(text) {
            Ok(terms) => {
                for (index, term) in terms.iter().enumerate() {
                    let spans = [term.axis.clone(), term.point.clone()].map(|range| part(place, text, range));
                    self.mark(&format!("{path}.{index}"), spans, &text[term.axis.start..term.point.end]);
                }
                let word = |range: &std::ops::Range<usize>| text[range.clone()].to_owned();
                let term = |term: &pattern::Placed| Term { axis: word(&term.axis), point: word(&term.point) };
                Some(ArmPattern { terms: terms.iter().map(term).collect() })
            }
            Err(mistake) => {
                let error =
                    Diagnostic::error("E0103", mistake.message).at(part(place, text, mistake.range), "here");
                self.fail(error.help("an arm is written `axis=point`, several axes joined by commas"));
                None
            }
        }
    }

    fn expectation(&mut self, sides: &Option<BTreeMap<String, ArmPattern>>) -> Option<Expectation> {
        let (text, place) = (self.fields.text("expect"), self.place("expect"));
        let parsed = match expect::parse(text) {
            Ok(parsed) => parsed,
            Err(mistake) => {
                let error = Diagnostic::error(mistake.code, mistake.message);
                self.fail(error.at(part(place, text, mistake.range), mistake.label).help(mistake.help));
                return None;
            }
        };
        for (path, range) in &parsed.places {
            let span = part(place, text, range.clone());
            self.mark(path, [span; 2], &text[range.clone()]);
        }
        let sides = sides.as_ref()?;
        for (path, name) in parsed.expectation.names() {
            if !sides.contains_key(name) {
                let known = super::suggest::listed(sides.keys().map(String::as_str));
                let error = Diagnostic::error("E0803", format!("the claim names no arm `{name}`"));
                let error = error.at(self.place(path), "not an arm of this claim");
                self.fail(match sides.len() {
                    1 => error.help(format!(
                        "the only arm of this claim is {known}: compare it with a number, for example \
                         `expect = \"a > 90 %\"`, or write `compare` in place of `arm`"
                    )),
                    _ => error.help(format!("the arms of this claim are {known}")),
                });
                return None;
            }
        }
        let named = parsed.expectation.names().len();
        if sides.len() > named {
            let error = Diagnostic::error("E0103", "the expectation says nothing about `b`");
            self.fail(
                error
                    .at(place, "compares only `a`")
                    .help("write for example `a > b`, or `arm` in place of `compare`"),
            );
            return None;
        }
        Some(parsed.expectation)
    }

    /// A number in the metric's unit; above 0 unless it is an effect.
    fn amount(&mut self, key: &str) -> Option<Quantity> {
        let value = match key.split_once('.') {
            Some((table, key)) => self.fields.section(table)?.get(key)?,
            None => self.fields.get(key)?,
        };
        let place = self.place(key);
        let quantity = match value {
            Value::Quantity(quantity) => quantity.clone(),
            Value::Text(text) => match expect::amount(text) {
                Ok(quantity) => quantity,
                Err(mistake) => {
                    let span = part(place, text, mistake.range);
                    let error = Diagnostic::error(mistake.code, mistake.message).at(span, mistake.label);
                    self.fail(
                        error.help("write it in the metric's unit, for example `\"5 %\"` or `\"0.1 m/s\"`"),
                    );
                    return None;
                }
            },
            _ => return None,
        };
        if quantity.si <= 0.0 && matches!(key, "margin" | "spread") {
            let error = Diagnostic::error("E0204", format!("`{key}` is out of range: it must be above 0"));
            let help = match (key, quantity.si < 0.0) {
                ("margin", true) => "write the distance without a sign: the relation says the direction",
                ("margin", false) => "remove `margin`: without one nothing has to be exceeded",
                _ => "write the standard deviation between runs that you expect, or remove `spread`",
            };
            self.fail(error.at(place, "below the range").help(help));
        }
        Some(quantity)
    }

    fn margin(&mut self, expect: Option<&Expectation>) -> Option<Quantity> {
        let quantity = self.amount("margin")?;
        if expect.is_some_and(|expect| expect.relation == Relation::Equal) {
            let key = self.marks.get("margin").map_or(self.header, |mark| mark.key);
            let error =
                Diagnostic::error("E0105", "`margin` is a key of `>`, `>=`, `<` and `<=`, not of `==`");
            self.fail(
                error
                    .at(key, "beside `==`")
                    .help("say the tolerance in the expectation: `a == b within 5 %`"),
            );
        }
        Some(quantity)
    }
}
