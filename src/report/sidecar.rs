//! The record next to a report with the origin of everything in it: `reports/NAME.json`.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::claim::Judged;
use super::digests::Digests;
use super::fields;
use super::figure::Figure;
use super::model::{Arm, ReportInput, StageRecord};
use super::page::{Page, figure_file};
use super::policies;
use super::request::Request;
use super::runs::{self, RunRecord};
use super::source::Source;
use super::table::setup::budget_samples;
use super::table::{Cell, Table};
use super::tasks::{self, TaskRecord};
use super::wording;
use crate::bounded;
use crate::plan::TUNED_ENV;
use crate::seal::{self, Seal};

/// Stages that only prepare; they are not results.
const PREPARES: [&str; 6] = ["robot", "motion", "env", "controller", "pretrain", TUNED_ENV];

/// Version of the rules for judging claims (docs/explanation/statistics.md). Increased whenever the same
/// values give another verdict, p value or estimate.
pub const RULES: u32 = 2;

/// Whether a stage's artefact is a result: learned, measured, or made for use.
pub fn is_result(stage: &str) -> bool {
    !PREPARES.contains(&stage)
}

/// The provenance of a report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sidecar {
    /// Name of the report.
    pub report: String,
    /// Its subject, in one sentence.
    pub summary: String,
    /// How much was run.
    pub facts: Facts,
    /// Version of specforge that rendered the report.
    pub tool_version: String,
    /// Its commit.
    pub commit: String,
    /// What its command asks for.
    pub request: Request,
    /// Figures, tables and copies of policies.
    pub items: Vec<Item>,
    /// The version of the rules that the claims were judged by.
    pub rules: u32,
    /// The value of every metric in every run of a suite.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<RunRecord>,
    /// The claims with their verdicts and numbers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub claims: Vec<Judged>,
    /// How well each arm's policies do their task.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tasks: Vec<TaskRecord>,
    /// The arms with their stages and values.
    pub arms: Vec<ArmRecord>,
    /// BLAKE3 digests of the page, its figures and its copies of policies.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub digests: Digests,
    /// BLAKE3 digest of the canonical JSON of the rest of the record; empty until it is sealed.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub seal: String,
}

/// How much was run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// The profile; empty without one.
    pub profile: String,
    /// The learning seeds of a suite; empty for single specs.
    pub seeds: Vec<u64>,
    /// Number of runs.
    pub runs: usize,
    /// Number of runs with all their results.
    pub complete: usize,
    /// The budget of a run as a share of its baseline's: `5 %`, `5 to 10 %`; empty without training or
    /// baseline.
    pub scale: String,
    /// The distinct budgets of the runs in samples, ascending.
    pub budgets: Vec<u64>,
}

/// A figure, a table or a copy of a policy.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Item {
    /// Its name.
    pub id: String,
    /// `figure`, `table` or `policy`.
    pub kind: String,
    /// Its title.
    pub title: String,
    /// The file of a figure or policy, relative to the report.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub file: String,
    /// The stages it is made from.
    pub sources: Vec<Source>,
    /// The cells of a table that can be traced individually.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cells: Vec<TracedCell>,
    /// The stages of each row, for cells without their own.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub rows: BTreeMap<String, Vec<Source>>,
}

/// A cell of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TracedCell {
    /// Name of the row.
    pub row: String,
    /// Heading of the column.
    pub column: String,
    /// The value.
    pub value: Cell,
    /// The stage that it comes from; if absent, those of its row.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<Source>,
}

impl Item {
    /// The stages that a cell comes from.
    pub fn sources_of<'a>(&'a self, cell: &'a TracedCell) -> Vec<&'a Source> {
        match &cell.source {
            Some(source) => vec![source],
            None => self.rows.get(&cell.row).into_iter().flatten().collect(),
        }
    }
}

/// An arm.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ArmRecord {
    /// Name of its spec.
    pub name: String,
    /// Its file.
    pub spec: String,
    /// Its stages.
    pub stages: Vec<StageRecord>,
    /// Every value of the spec with its origin, by path. The runs of a suite omit values that equal the first
    /// run's.
    pub fields: BTreeMap<String, FieldRecord>,
    /// Whether omitted values are those of the first arm.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub like_the_first: bool,
    /// Values of the first arm that are missing in this one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
}

/// A value of a spec.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FieldRecord {
    /// The value as written.
    pub value: String,
    /// Where it is written.
    pub origin: String,
}

/// Why a report's record cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// It is not a record.
    #[error("{} is not a report's record: {source}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The syntax or format error.
        source: serde_json::Error,
    },
    /// It was changed after it was written.
    #[error("{} was changed after it was written: it does not have its own digest", path.display())]
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// Its own digest is missing.
    #[error("{}: {}", path.display(), seal::REMOVED)]
    Unsealed {
        /// The file.
        path: PathBuf,
    },
}

impl RecordError {
    /// Whether the record does not exist.
    pub fn is_absence(&self) -> bool {
        let absent =
            |source: &std::io::Error| matches!(source.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory);
        matches!(self, Self::Unreadable { source, .. } if absent(source))
    }
}

impl Sidecar {
    /// The path of a report's record in a folder.
    pub fn path(folder: &Path, name: &str) -> PathBuf {
        folder.join(format!("{name}.json"))
    }

    /// Reads a record without verifying its digest.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        Self::open(path).map(|(record, _)| record)
    }

    /// Reads a record, which must be unchanged.
    pub fn read_whole(path: &Path) -> Result<Self, RecordError> {
        match Self::open(path)? {
            (_, Seal::Broken) => Err(RecordError::Changed { path: path.to_owned() }),
            (_, Seal::Absent) => Err(RecordError::Unsealed { path: path.to_owned() }),
            (record, Seal::Whole) => Ok(record),
        }
    }

    /// Reads a record and verifies its own digest.
    pub fn open(path: &Path) -> Result<(Self, Seal), RecordError> {
        let path = path.to_owned();
        let text = match bounded::text(&path, bounded::RECORD) {
            Ok(text) => text,
            Err(error) => return Err(RecordError::Unreadable { path, source: error.into() }),
        };
        let record = serde_json::from_str(&text).map_err(|source| RecordError::Malformed { path, source })?;
        Ok((record, seal::state(&text)))
    }

    /// The record, completed with the digest of its content.
    pub fn sealed(mut self) -> Self {
        self.seal = seal::of(&self.to_json()).unwrap_or_default();
        self
    }

    /// The record of a report.
    pub fn new(input: &ReportInput, page: &Page, figures: &[Figure]) -> Self {
        let pictures = figures.iter().map(|figure| Item {
            id: figure.id.clone(),
            kind: "figure".to_string(),
            title: figure.title.clone(),
            file: figure_file(input, figure),
            sources: figure.sources.clone(),
            cells: Vec::new(),
            rows: BTreeMap::new(),
        });
        let policies = policies::copies(input).into_iter().map(|copy| Item {
            id: copy.id,
            kind: "policy".to_string(),
            title: "Exported policy".to_string(),
            file: copy.file,
            sources: vec![copy.source],
            ..Item::default()
        });
        let tables =
            page.all_tables().into_iter().filter(|table| !table.sources.is_empty()).map(|table| Item {
                id: table.id.clone(),
                kind: "table".to_string(),
                title: table.title.clone(),
                file: String::new(),
                sources: table.sources.clone(),
                cells: cells(table),
                rows: rows(table),
            });
        Self {
            report: input.name.clone(),
            summary: input.summary.clone(),
            facts: Facts::of(input),
            tool_version: input.tool_version.clone(),
            commit: input.commit.clone(),
            request: input.request.clone(),
            items: pictures.chain(tables).chain(policies).collect(),
            rules: RULES,
            runs: runs::records(input),
            claims: page.judged.clone(),
            tasks: tasks::records(input),
            arms: arms(input),
            digests: Digests::new(),
            seal: String::new(),
        }
    }

    /// The command that reproduces it.
    pub fn command(&self) -> String {
        self.request.command("run")
    }

    /// Whether its claims were judged by another version of the rules, so that this one may judge otherwise.
    pub fn is_by_other_rules(&self) -> bool {
        self.rules != RULES && !self.claims.is_empty()
    }

    /// Number of results in the report.
    pub fn results(&self) -> usize {
        self.arms.iter().flat_map(|arm| &arm.stages).filter(|record| is_result(&record.stage)).count()
    }

    /// Every value of an arm's spec with its origin, by path.
    pub fn fields<'a>(&'a self, arm: &'a ArmRecord) -> BTreeMap<&'a String, &'a FieldRecord> {
        let first = self.arms.first().filter(|_| arm.like_the_first);
        let shared =
            first.into_iter().flat_map(|first| &first.fields).filter(|(path, _)| !arm.without.contains(path));
        shared.chain(&arm.fields).collect()
    }

    /// The provenance embedded in a figure: a line of JSON.
    pub fn metadata(&self, id: &str) -> String {
        let sources = self.items.iter().filter(|item| item.id == id).flat_map(|item| &item.sources);
        let runs = sources.map(|source| {
            let record = self.record(source);
            serde_json::json!({
                "arm": source.arm,
                "stage": source.stage,
                "fingerprint": record.map_or("", |record| &record.fingerprint),
                "commit": record.map_or("", |record| &record.commit),
                "fields": record.map_or(&[][..], |record| &record.fields),
            })
        });
        serde_json::json!({
            "report": self.report,
            "figure": id,
            "specforge": self.tool_version,
            "command": self.command(),
            "runs": runs.collect::<Vec<_>>(),
        })
        .to_string()
    }

    /// The record of a stage.
    pub fn record(&self, source: &Source) -> Option<&StageRecord> {
        let arm = self.arms.iter().find(|arm| arm.name == source.arm)?;
        arm.stages.iter().find(|record| record.stage == source.stage)
    }

    /// The file's text.
    pub fn to_json(&self) -> String {
        let mut text =
            serde_json::to_string_pretty(self).expect("names, numbers and lists can be written as JSON");
        text.push('\n');
        text
    }
}

impl Facts {
    fn of(input: &ReportInput) -> Self {
        Self {
            profile: input.request.profile.clone().unwrap_or_default(),
            seeds: input.suite.as_ref().map(|suite| suite.seeds.clone()).unwrap_or_default(),
            runs: input.arms.len(),
            complete: input.arms.iter().filter(|arm| arm.failures.is_empty()).count(),
            scale: scale(input),
            budgets: input
                .arms
                .iter()
                .filter_map(budget_samples)
                .collect::<BTreeSet<_>>()
                .into_iter()
                .collect(),
        }
    }
}

/// The smallest and largest budget as shares of the baselines'.
fn scale(input: &ReportInput) -> String {
    let percent = |share: f64| wording::number(100.0 * share);
    let shares = || input.arms.iter().filter_map(|arm| arm.budget_share);
    match (shares().min_by(f64::total_cmp), shares().max_by(f64::total_cmp)) {
        (Some(least), Some(most)) if least == most => format!("{} %", percent(least)),
        (Some(least), Some(most)) => format!("{} to {} %", percent(least), percent(most)),
        _ => String::new(),
    }
}

/// The cells of named rows whose column or row has a source.
fn cells(table: &Table) -> Vec<TracedCell> {
    let mut cells = Vec::new();
    for row in table.rows.iter().filter(|row| !row.name.is_empty()) {
        for (column, value) in row.cells.iter().enumerate() {
            let of_column = table.column_sources.get(column).copied().flatten();
            let source = of_column.and_then(|index| table.sources.get(index)).cloned();
            let Some(head) = table.columns.get(column + 1) else { continue };
            if source.is_some() || !row.sources.is_empty() {
                cells.push(TracedCell {
                    row: row.name.clone(),
                    column: head.clone(),
                    value: value.clone(),
                    source,
                });
            }
        }
    }
    cells
}

/// The sources of the rows with sources.
fn rows(table: &Table) -> BTreeMap<String, Vec<Source>> {
    let with_sources = table.rows.iter().filter(|row| !row.name.is_empty() && !row.sources.is_empty());
    with_sources.map(|row| (row.name.clone(), row.sources.clone())).collect()
}

/// The records of the arms. A suite has many similar runs, so only the first has all its values.
fn arms(input: &ReportInput) -> Vec<ArmRecord> {
    let mut arms: Vec<ArmRecord> = input.arms.iter().map(arm).collect();
    if let (Some(_), [first, rest @ ..]) = (&input.suite, arms.as_mut_slice()) {
        for arm in rest {
            let lacks = |path: &&String| !arm.fields.contains_key(*path);
            arm.without = first.fields.keys().filter(lacks).cloned().collect();
            arm.fields.retain(|path, field| first.fields.get(path) != Some(field));
            arm.like_the_first = true;
        }
    }
    arms
}

fn arm(arm: &Arm) -> ArmRecord {
    let record = |(path, value): fields::Field| {
        let origin = fields::origin(arm, &path).to_string();
        (path, FieldRecord { value: wording::value(value), origin })
    };
    ArmRecord {
        name: arm.name.clone(),
        spec: arm.spec.clone(),
        stages: arm.stages.clone(),
        fields: fields::flat(&arm.fields).into_iter().map(record).collect(),
        like_the_first: false,
        without: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_that_is_not_there_is_told_from_one_that_cannot_be_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = Sidecar::path(folder.path(), "page");
        let error = Sidecar::read(&path).expect_err("nothing is there");
        assert!(error.is_absence() && error.to_string().contains("page.json"), "{error}");
        for broken in [&b"{"[..], b"{}", b"\xff"] {
            std::fs::write(&path, broken).expect("it can be written");
            let error = Sidecar::read(&path).expect_err("it is not a record");
            assert!(!error.is_absence() && error.to_string().contains("page.json"), "{error}");
        }
        std::fs::write(&path, Sidecar::default().to_json()).expect("it can be written");
        assert_eq!(Sidecar::read(&path).expect("a record"), Sidecar::default());
    }
}
