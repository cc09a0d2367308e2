//! What an evaluation is asked to do: the decoded table of kind `episodes`.

use serde::{Deserialize, Serialize};

use crate::spec::Section;

/// The protocol `episodes`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Protocol {
    /// Number of episodes.
    pub episodes: usize,
    /// Forward speed in m/s commanded in every episode; `None` is the task's own command.
    pub command: Option<f64>,
    /// Longest duration of an episode in s; `None` is the task's.
    pub time_limit: Option<f64>,
    /// Standard deviation of the joint positions about the default pose at the start, in rad.
    pub perturbation: f64,
    /// Whether the training's randomization is drawn.
    pub randomize: bool,
    /// Whether the observation carries its noise.
    pub noise: bool,
    /// Names the streams of the episodes.
    pub seed: u64,
}

impl Default for Protocol {
    fn default() -> Self {
        Self {
            episodes: 32,
            command: None,
            time_limit: None,
            perturbation: 0.01,
            randomize: false,
            noise: false,
            seed: 1000,
        }
    }
}

impl Protocol {
    /// The protocol of a decoded `[evaluate.NAME]` table, or of a `[deploy.NAME]` table of kind `transfer`,
    /// which may leave keys out.
    pub fn new(section: Section) -> Self {
        let usual = Self::default();
        let flag = |key: &str, usual: bool| if section.has(key) { section.flag(key) } else { usual };
        let count = |key: &str, usual: u64| if section.has(key) { section.count(key) } else { usual };
        Self {
            episodes: count("episodes", usual.episodes as u64) as usize,
            command: section.section("command").map(|command| command.si("speed")),
            time_limit: section.si_if("time_limit"),
            perturbation: section.si_if("perturbation").unwrap_or(usual.perturbation),
            randomize: flag("randomize", usual.randomize),
            noise: flag("noise", usual.noise),
            seed: count("seed", usual.seed),
        }
    }

    /// Name of the random stream of an episode. It does not name the policy: arms that share a seed meet
    /// the same starts and disturbances.
    pub fn stream(&self, episode: usize) -> String {
        format!("{}/evaluate/episode/{episode}", self.seed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::{Quantity, Table, Value};

    #[test]
    fn a_table_overrides_what_it_names_and_nothing_else() {
        let number = |si| Value::Quantity(Quantity { si, text: String::new() });
        let table = Table::from([
            ("episodes".into(), Value::Count(4)),
            ("command".into(), Value::Table(Table::from([("speed".into(), number(0.8))]))),
            ("noise".into(), Value::Flag(true)),
        ]);
        let protocol = Protocol::new(Section::new(&table));
        let expected = Protocol { episodes: 4, command: Some(0.8), noise: true, ..Protocol::default() };
        assert_eq!(protocol, expected);
        assert_eq!(protocol.stream(3), "1000/evaluate/episode/3");
    }
}
