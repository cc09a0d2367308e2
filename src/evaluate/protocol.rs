//! Protocols of evaluations: a list of conditions, one per episode, and common settings. The kinds of
//! protocol differ only in the list.

use std::borrow::Cow;
use std::sync::Arc;

use super::conditions::{Condition, conditions};
use crate::env::{Blueprint, BlueprintError, Randomized};
use crate::kinds::deploy::Transfer;
use crate::kinds::evaluate::{Drawn, EPISODES, Evaluation, SEED};
use crate::spec::typed::{Keys, Part};
use crate::spec::{Section, Table};

/// A protocol.
#[derive(Clone, Debug, PartialEq)]
pub struct Protocol {
    /// Conditions of each episode.
    pub conditions: Vec<Condition>,
    /// Longest duration of an episode in s; `None` is the task's.
    pub time_limit: Option<f64>,
    /// The decoded `[terrain]` that replaces the training's.
    pub terrain: Option<Table>,
    /// Standard deviation of the joint positions about the default pose at the start, in rad.
    pub perturbation: f64,
    /// Whether the observation is noisy.
    pub noise: bool,
    /// Whether the policy acts with the exploration of its training.
    pub explore: bool,
    /// Part of the names of the episodes' random streams.
    pub seed: u64,
}

impl Default for Protocol {
    fn default() -> Self {
        Self {
            conditions: vec![Condition::default(); EPISODES as usize],
            time_limit: None,
            terrain: None,
            perturbation: 0.01,
            noise: false,
            explore: false,
            seed: SEED,
        }
    }
}

impl Protocol {
    /// The protocol of a decoded `[evaluate.NAME]` table, or of a `[deploy.NAME]` table of kind `transfer`,
    /// in which keys may be missing.
    pub fn new(section: Section) -> Self {
        Self::known(section).expect("decoding promised the keys of a protocol")
    }

    /// The same of a table that another version may have decoded; `None` if this one cannot read it.
    pub fn known(section: Section) -> Option<Self> {
        match Evaluation::of_section(section) {
            Some(evaluation) => Some(Self::of_evaluation(&evaluation)),
            None => Transfer::of_table(section.table()).map(|transfer| Self::of_transfer(&transfer)),
        }
    }

    /// The protocol of an evaluation.
    fn of_evaluation(evaluation: &Evaluation) -> Self {
        let (setting, spread, command) = match evaluation {
            Evaluation::Episodes(episodes) => {
                (&episodes.setting, Some(&episodes.spread), episodes.command.as_ref())
            }
            Evaluation::ParameterSets(sets) => (&sets.setting, None, sets.command.as_ref()),
            Evaluation::Speeds(speeds) => (&speeds.setting, Some(&speeds.spread), None),
        };
        let condition = Condition {
            command: command.map(|command| command.speed),
            randomized: randomized(spread.map(|spread| &spread.randomize)),
            ..Condition::default()
        };
        let perturbation = match evaluation {
            Evaluation::ParameterSets(sets) => Some(sets.perturbation),
            _ => spread.map(|spread| spread.perturbation),
        };
        let usual = Self::default();
        Self {
            conditions: conditions(evaluation, condition, setting.seed),
            time_limit: setting.time_limit,
            terrain: setting.terrain.clone(),
            perturbation: perturbation.unwrap_or(usual.perturbation),
            noise: spread.map_or(usual.noise, |spread| spread.noise),
            explore: spread.and_then(|spread| spread.explore).unwrap_or(usual.explore),
            seed: setting.seed,
        }
    }

    /// The protocol of a transfer.
    fn of_transfer(transfer: &Transfer) -> Self {
        let usual = Self::default();
        let condition = Condition {
            command: transfer.command.as_ref().map(|command| command.speed),
            randomized: randomized(transfer.randomize.as_ref()),
            ..Condition::default()
        };
        Self {
            conditions: vec![condition; transfer.episodes.unwrap_or(EPISODES) as usize],
            time_limit: transfer.time_limit,
            terrain: transfer.terrain.clone(),
            perturbation: transfer.perturbation.unwrap_or(usual.perturbation),
            noise: transfer.noise.unwrap_or(usual.noise),
            explore: transfer.explore.unwrap_or(usual.explore),
            seed: transfer.seed.unwrap_or(usual.seed),
        }
    }

    /// The given number of episodes under the usual conditions.
    pub fn of(episodes: usize) -> Self {
        Self { conditions: vec![Condition::default(); episodes], ..Self::default() }
    }

    /// Name of the random stream of an episode. It is independent of the policy: arms with the same seed get
    /// the same starts and disturbances.
    pub fn stream(&self, episode: usize) -> String {
        format!("{}/evaluate/episode/{episode}", self.seed)
    }

    /// The environment on the protocol's ground.
    pub fn ground<'a>(&self, blueprint: &'a Blueprint) -> Result<Cow<'a, Blueprint>, BlueprintError> {
        match &self.terrain {
            None => Ok(Cow::Borrowed(blueprint)),
            Some(terrain) => blueprint.with_terrain(terrain.clone()).map(Cow::Owned),
        }
    }

    /// The command in m/s of all episodes, where `usual` is the task's default; `None` if they differ.
    pub fn command(&self, usual: Option<f64>) -> Option<f64> {
        let mut commands = self.conditions.iter().map(|condition| condition.command.or(usual));
        let first = commands.next()?;
        first.filter(|_| commands.all(|command| command == first))
    }
}

/// The value of the key `randomize`: nothing, the training's table or its own table.
fn randomized(drawn: Option<&Drawn>) -> Randomized {
    match drawn {
        Some(Drawn::AsTrained(true)) => Randomized::AsTrained,
        Some(Drawn::Rows(table)) => Randomized::By(Arc::new(table.clone())),
        Some(Drawn::AsTrained(false)) | None => Randomized::Nothing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::{Quantity, Value};

    fn of_speed(speed: f64) -> Condition {
        Condition { command: Some(speed), ..Condition::default() }
    }

    #[test]
    fn a_table_overrides_what_it_names_and_nothing_else() {
        let number = |si| Value::Quantity(Quantity { si, text: String::new() });
        let table = Table::from([
            ("kind".into(), Value::Text("transfer".into())),
            ("engine".into(), Value::Text("mujoco".into())),
            ("rate".into(), number(500.0)),
            ("episodes".into(), Value::Count(4)),
            ("command".into(), Value::Table(Table::from([("speed".into(), number(0.8))]))),
            ("noise".into(), Value::Flag(true)),
        ]);
        let protocol = Protocol::new(Section::new(&table));
        let expected = Protocol { conditions: vec![of_speed(0.8); 4], noise: true, ..Protocol::default() };
        assert_eq!(protocol, expected);
        assert_eq!([protocol.command(Some(0.2)), Protocol::of(2).command(Some(0.2))], [Some(0.8), Some(0.2)]);
        let differing = Protocol { conditions: [0.1, 0.2].map(of_speed).to_vec(), ..Protocol::default() };
        assert_eq!(differing.command(Some(0.2)), None);
        assert_eq!(protocol.stream(3), "1000/evaluate/episode/3");
    }

    #[test]
    fn randomization_is_none_the_training_s_or_a_table_of_its_own() {
        let rows = Table::from([("push".to_owned(), Value::Table(Table::new()))]);
        let of = |drawn: Drawn| randomized(Some(&drawn));
        assert_eq!(of(Drawn::AsTrained(false)), Randomized::Nothing);
        assert_eq!(of(Drawn::AsTrained(true)), Randomized::AsTrained);
        assert_eq!(of(Drawn::Rows(rows.clone())), Randomized::By(Arc::new(rows)));
    }
}
