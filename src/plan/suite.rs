//! The runs of a suite: one arm and learning seed each, with an id that is the hash of the run's content.

use serde::{Deserialize, Serialize};

use super::arm::{Arm, Runs};
use super::fingerprint::canonical_json;
use crate::kinds::learn::{Learner, Ppo};
use crate::spec::claim::Claim;
use crate::spec::section::{Header, Report};
use crate::spec::typed::{InSection, section_mut};
use crate::spec::value::canonical_table;
use crate::spec::{Section, Table, Value};

/// A suite in its plan and its report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SuiteRecord {
    /// Its name.
    pub name: String,
    /// The axes in the order of the file.
    pub axes: Vec<AxisRecord>,
    /// How many arms there are.
    pub arms: usize,
    /// The learning seeds, in order; empty when each arm has its spec's own.
    pub seeds: Vec<u64>,
    /// Its claims.
    pub claims: Vec<Claim>,
    /// Whether a failed claim ends the run with exit code 5.
    pub claims_count: bool,
}

/// An axis and the names of its points.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AxisRecord {
    /// Its name.
    pub name: String,
    /// Its points in the order of the file.
    pub points: Vec<String>,
}

/// Position of a run in its suite.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunRecord {
    /// The run's id: twelve digits of the hash of its resolved content, independent of the names of the suite
    /// and its arms.
    pub id: String,
    /// The arm: `control=torque,stiffness=100 %`.
    pub arm: String,
    /// The arm's points by axis, in the order of the axes.
    pub points: Vec<(String, String)>,
    /// The learning seed.
    pub seed: u64,
}

/// The records of an arm's runs, in the order of its seeds.
pub fn records(arm: &Arm, runs: &Runs) -> Vec<RunRecord> {
    let content = content(arm);
    let record = |seed: &u64| RunRecord {
        id: blake3::hash(format!("{content} seed {seed}").as_bytes()).to_hex()[..12].to_owned(),
        arm: arm.name.clone(),
        points: runs.points.clone(),
        seed: *seed,
    };
    runs.seeds.iter().map(record).collect()
}

/// Hash of what the runs of an arm have in common: its values without the learning seed, and the files that
/// it names. Names and report settings are left out.
fn content(arm: &Arm) -> String {
    let mut fields: Table = arm.fields.clone();
    let unread = [Header::name.name, Header::summary.name, Report::SECTION];
    unread.iter().for_each(|key| drop(fields.remove(*key)));
    if let Some(learn) = section_mut::<Learner>(&mut fields) {
        learn.remove(Ppo::seed.name);
    }
    let motion = arm.motion.as_ref().map(|motion| canonical_table(motion));
    let mut hasher = blake3::Hasher::new();
    for part in [&canonical_table(&fields), &*arm.robot, &motion.into()] {
        hasher.update(canonical_json(part).as_bytes());
        hasher.update(b"\n");
    }
    hasher.finalize().to_hex().to_string()
}

/// The values of an arm with a learning seed.
pub fn seeded(fields: &Table, seed: u64) -> Table {
    let mut fields = fields.clone();
    if let Some(learn) = section_mut::<Learner>(&mut fields) {
        learn.insert(Ppo::seed.name.to_owned(), Value::Count(seed));
    }
    fields
}

/// Whether a stage reads the learning seed.
pub fn reads_the_seed(fields: &Table) -> bool {
    Section::new(fields).within::<Learner>().is_some_and(|learn| learn.holds(Ppo::seed))
}
