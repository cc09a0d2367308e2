//! The tables of a page.

use serde::{Deserialize, Serialize};

use super::Table;

/// The tables; those without data have no rows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tables {
    /// The answer in numbers: one row per policy and engine, or one per claim of a suite.
    pub at_a_glance: Table,
    /// The setup; of a suite what all arms have in common.
    pub setup: Table,
    /// Differences between the arms, each table with a note that introduces it.
    pub differences: Vec<Table>,
    /// Learning in numbers.
    pub learning: Table,
    /// The same for the fine-tuning.
    pub fine_tuning: Table,
    /// Findings of the run-time checks during training.
    pub health: Table,
    /// Why training episodes ended.
    pub endings: Table,
    /// Whether the criteria of the task are met; not of a suite.
    pub criteria: Table,
    /// All metrics. Of single specs in every engine, then the first arm compared with each of the others, and
    /// the reward per second by term. Of a suite one table for each evaluation, with one row per arm, then
    /// the interquartile means.
    pub evaluations: Vec<Table>,
    /// Evaluations of a suite over parameter sets: survival, arms compared on the same sets, and why sets
    /// fail.
    pub failures: Vec<Table>,
    /// Wall and CPU time.
    pub cost: Table,
    /// Figures and tables with the stages they are made from; not of a suite.
    pub provenance: Table,
    /// The stages; not of a suite.
    pub stages: Table,
}

impl Tables {
    /// All of them in the order of the page.
    pub fn all(&self) -> Vec<&Table> {
        let mut tables = vec![&self.at_a_glance, &self.criteria, &self.setup];
        tables.extend(&self.differences);
        tables.extend(self.measured());
        tables.extend([&self.cost, &self.provenance, &self.stages]);
        tables
    }

    /// Those of training and evaluation that have rows.
    pub fn measured(&self) -> Vec<&Table> {
        let mut tables = vec![&self.learning, &self.health, &self.endings, &self.fine_tuning];
        tables.extend(&self.evaluations);
        tables.extend(&self.failures);
        tables.retain(|table| !table.rows.is_empty());
        tables
    }
}

/// The tables that have rows.
pub fn with_rows(mut tables: Vec<Table>) -> Vec<Table> {
    tables.retain(|table| !table.rows.is_empty());
    tables
}
