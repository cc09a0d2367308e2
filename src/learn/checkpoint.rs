//! Checkpoints: everything that a training needs to resume with the same results as without an interruption.
//!
//! Random streams are named, so none is stored. The state of a simulator is not stored either: a running
//! episode is restarted and its actions are replayed, which works with every engine and gives the same state
//! bit for bit.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::adam::Adam;
use super::beside::{Beside, EVENTS};
use super::error::LearnError;
use super::file::{self, Doubles, Tensors};
use super::lane::Episode;
use super::network::Network;
use super::settings::Settings;
use crate::bounded;
use crate::env::Sizes;
use crate::{finite, safe_fs};

/// The file's name in the scratch folder.
const NAME: &str = "checkpoint.safetensors";
/// Raised when the meaning of the bytes changes or something is added. The first files have no version.
const VERSION: u32 = 3;
/// Version of the program that writes the file; another version may interpret the same settings differently.
const TOOL: &str = env!("CARGO_PKG_VERSION");

/// The state of a training between two updates.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// Both networks with their moments: actor, critic.
    pub trainees: [(Network, Adam); 2],
    /// The environments' running episodes.
    pub episodes: Vec<Episode>,
    /// Counters.
    pub progress: Progress,
    /// Digests of the files next to the checkpoint.
    pub beside: Beside,
}

/// Counters of a training.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    /// The next update.
    pub update: u64,
    /// The current step size of the actor if it is steered.
    pub rate: f64,
    /// Wall time so far in s.
    pub wall: f64,
    /// CPU time so far in s.
    pub cpu: f64,
    /// Lines of `metrics.jsonl`.
    pub lines: u64,
}

/// The part of the header that all versions share.
#[derive(Deserialize)]
struct Stamp {
    #[serde(default = "Stamp::first")]
    version: u32,
    #[serde(default)]
    tool: String,
}

impl Stamp {
    fn first() -> u32 {
        1
    }

    /// Refuses files of other programs and versions, whatever their layout.
    fn check(&self) -> Result<(), String> {
        if self.version != VERSION {
            Err(foreign(format!("its format is {}, this version reads {VERSION}", self.version)))
        } else if self.tool != TOOL {
            Err(foreign(format!("{}, this is {TOOL}", self.tool)))
        } else {
            Ok(())
        }
    }
}

fn foreign(what: impl std::fmt::Display) -> String {
    format!("it was written by another version of specforge ({what})")
}

/// The part of a checkpoint that does not fit into tensors of f32.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    version: u32,
    tool: String,
    settings: Settings,
    progress: Progress,
    beside: Beside,
    /// Steps of Adam: actor, critic.
    steps: [u64; 2],
    /// Number, reward and steps of each running episode.
    episodes: Vec<(u64, f64, u64)>,
}

const TRAINEES: [&str; 2] = ["actor", "critic"];

impl Checkpoint {
    /// The checkpoint's path in a training's scratch folder.
    pub fn path(scratch: &Path) -> PathBuf {
        scratch.join(NAME)
    }

    /// Writes the checkpoint in place of the previous one, which remains if anything fails.
    pub fn save(&self, scratch: &Path, settings: &Settings) -> Result<(), LearnError> {
        let mut tensors = Tensors::new();
        for (name, (network, adam)) in TRAINEES.iter().zip(&self.trainees) {
            network.insert_into(name, &mut tensors);
            for (moment, values) in [("first", &adam.first), ("second", &adam.second)] {
                tensors.insert(format!("{name}.{moment}"), (vec![values.len()], values.clone()));
            }
        }
        for (index, episode) in self.episodes.iter().enumerate() {
            tensors
                .insert(format!("actions.{index}"), (vec![episode.actions.len()], episode.actions.clone()));
        }
        let header = Header {
            version: VERSION,
            tool: TOOL.to_owned(),
            settings: settings.clone(),
            progress: self.progress,
            beside: self.beside.clone(),
            steps: [self.trainees[0].1.steps, self.trainees[1].1.steps],
            episodes: self
                .episodes
                .iter()
                .map(|episode| (episode.number, episode.reward, episode.steps))
                .collect(),
        };
        let header = finite::to_string(&header).map_err(|found| LearnError::not_finite(NAME, found))?;
        replace(&Self::path(scratch), &sealed(&tensors, &header))
    }

    /// Reads the checkpoint, if there is one, of a training in environments of these sizes.
    pub fn load(scratch: &Path, settings: &Settings, sizes: Sizes) -> Result<Option<Self>, LearnError> {
        let path = Self::path(scratch);
        let bytes = match bounded::bytes(&path, bounded::ARTEFACT) {
            Ok(bytes) => bytes,
            Err(error) if error.is_absence() => return Ok(None),
            Err(error) => return Err(LearnError::at(&path)(error.into())),
        };
        let fitting =
            Self::decode(&bytes, settings).and_then(|found| found.check(settings, sizes).map(|()| found));
        fitting.map(Some).map_err(|reason| LearnError::Checkpoint { path, reason })
    }

    /// Returns what is wrong with the checkpoint in a scratch folder or with the files next to it. `None`
    /// without a checkpoint, and for one of another version, which only that version can judge.
    pub fn fault(scratch: &Path) -> Option<String> {
        let bytes = match bounded::bytes(&Self::path(scratch), bounded::ARTEFACT) {
            Ok(bytes) => bytes,
            Err(error) if error.is_absence() => return None,
            Err(error) => return Some(error.to_string()),
        };
        let stamp = file::header(&bytes)
            .ok()
            .and_then(|texts| serde_json::from_str::<Stamp>(texts.get("training")?).ok());
        if stamp.is_some_and(|stamp| stamp.check().is_err()) {
            return None;
        }
        let beside = open(&bytes).map(|(_, header)| header.beside);
        let whole = beside.and_then(|beside| {
            let lost = || format!("{EVENTS} has changed since the checkpoint was written");
            beside.check(scratch).and_then(|()| beside.events(scratch).map(drop).ok_or_else(lost))
        });
        whole.err()
    }

    fn decode(bytes: &[u8], settings: &Settings) -> Result<Self, String> {
        let (mut tensors, header) = open(bytes)?;
        if !header.settings.agrees_with(settings) {
            return Err("it was written with other settings".to_owned());
        }
        let shapes = [settings.policy.activation, settings.value.activation];
        let mut trainees = Vec::new();
        for ((name, steps), activation) in TRAINEES.iter().zip(header.steps).zip(shapes) {
            let network =
                Network::take_from(name, &tensors, activation).map_err(|error| error.to_string())?;
            let mut moment = |which: &str| take(&mut tensors, &format!("{name}.{which}"));
            let adam = Adam { first: moment("first")?, second: moment("second")?, steps };
            trainees.push((network, adam));
        }
        let episodes: Result<Vec<Episode>, String> = header
            .episodes
            .iter()
            .enumerate()
            .map(|(index, (number, reward, steps))| {
                let actions = take(&mut tensors, &format!("actions.{index}"))?;
                Ok(Episode { number: *number, actions, reward: *reward, steps: *steps })
            })
            .collect();
        let trainees = trainees.try_into().map_err(|_| "a network is missing".to_owned())?;
        Ok(Self { trainees, episodes: episodes?, progress: header.progress, beside: header.beside })
    }

    /// Checks that it belongs to a training with these settings. The lengths of the moments are checked when
    /// the learner restores them.
    fn check(&self, settings: &Settings, sizes: Sizes) -> Result<(), String> {
        let states = if settings.privileged { sizes.privileged } else { sizes.observation };
        let asked =
            [settings.policy.widths(sizes.observation, sizes.action), settings.value.widths(states, 1)];
        for ((name, (network, _)), asked) in TRAINEES.iter().zip(&self.trainees).zip(asked) {
            if network.widths() != asked {
                return Err(format!(
                    "its {name} has layers {:?}, the spec asks for {asked:?}",
                    network.widths()
                ));
            }
        }
        let (found, asked) = (self.episodes.len(), settings.environments);
        if found != asked {
            return Err(format!("it has {found} running episodes, the spec has {asked} environments"));
        }
        let whole = |episode: &Episode| episode.actions.len() as u64 == episode.steps * sizes.action as u64;
        if let Some(index) = self.episodes.iter().position(|episode| !whole(episode)) {
            return Err(format!("running episode {index} has different numbers of actions and steps"));
        }
        let (update, updates) = (self.progress.update, settings.end());
        if update > updates {
            return Err(format!("it follows update {update} of {updates}"));
        }
        Ok(())
    }
}

/// The tensors and the header of a file that is complete and of this version.
fn open(bytes: &[u8]) -> Result<(Tensors, Header), String> {
    let (tensors, texts) = file::read(bytes).map_err(|error| error.to_string())?;
    let header = texts.get("training").ok_or("its header is missing")?;
    serde_json::from_str::<Stamp>(header).map_err(foreign)?.check()?;
    if texts.get("digest") != Some(&digest(&tensors, header)) {
        return Err("it is damaged: its content does not match its digest".to_owned());
    }
    let header = serde_json::from_str(header).map_err(foreign)?;
    Ok((tensors, header))
}

/// Serializes these tensors and this header with their digest.
fn sealed(tensors: &Tensors, header: &str) -> Vec<u8> {
    file::write(tensors, &[("training", header), ("digest", &digest(tensors, header))])
}

fn digest(tensors: &Tensors, header: &str) -> String {
    file::digest(tensors, &Doubles::new(), &[("training", header)])
}

/// The numbers of a tensor.
fn take(tensors: &mut BTreeMap<String, (Vec<usize>, Vec<f32>)>, name: &str) -> Result<Vec<f32>, String> {
    tensors.remove(name).map(|(_, numbers)| numbers).ok_or_else(|| format!("tensor `{name}` is missing"))
}

/// Replaces a file atomically: afterwards the disk has either the new bytes or the old ones.
pub(super) fn replace(path: &Path, bytes: &[u8]) -> Result<(), LearnError> {
    safe_fs::replace_through(&path.with_extension("draft"), path, bytes).map_err(LearnError::at(path))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use serde_json::{Value, json};

    use super::*;
    use crate::learn::toy::settings;
    use crate::stream::Stream;

    const SIZES: Sizes = Sizes { observation: 2, privileged: 3, action: 1 };

    /// A checkpoint of the toy's training after three updates.
    fn checkpoint() -> Checkpoint {
        let network = |inputs: usize| {
            let mut stream = Stream::new("test/checkpoint");
            let network =
                Network::orthogonal(&[inputs, 24, 24, 1], settings().policy.activation, &mut stream);
            (network, Adam::new(1000))
        };
        let episode = |number| Episode { number, actions: vec![0.5; 4], reward: 3.0, steps: 4 };
        Checkpoint {
            trainees: [network(2), network(3)],
            episodes: (0..5).map(episode).collect(),
            progress: Progress { update: 3, rate: 1e-3, wall: 2.0, cpu: 1.0, lines: 3 },
            beside: Beside::default(),
        }
    }

    /// The bytes of a checkpoint.
    fn written(checkpoint: &Checkpoint) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        checkpoint.save(folder.path(), &settings()).unwrap();
        fs::read(Checkpoint::path(folder.path())).unwrap()
    }

    /// What is read from these bytes.
    fn read(bytes: &[u8]) -> Result<Checkpoint, LearnError> {
        let folder = tempfile::tempdir().unwrap();
        fs::write(Checkpoint::path(folder.path()), bytes).unwrap();
        Checkpoint::load(folder.path(), &settings(), SIZES).map(|found| found.expect("it is there"))
    }

    #[track_caller]
    fn assert_refused(bytes: &[u8], why: &str) {
        let error = read(bytes).expect_err(why);
        assert!(error.code() == Some("R0002") && error.to_string().contains(why), "{error}");
    }

    /// The bytes with another header and a matching digest.
    fn with_header(bytes: &[u8], change: impl Fn(&mut Value)) -> Vec<u8> {
        let (tensors, texts) = file::read(bytes).unwrap();
        let mut header = serde_json::from_str(&texts["training"]).unwrap();
        change(&mut header);
        sealed(&tensors, &header.to_string())
    }

    #[test]
    fn it_survives_its_file() {
        assert_eq!(read(&written(&checkpoint())).unwrap(), checkpoint());
    }

    #[test]
    fn a_flipped_bit_in_tensors_or_header_is_refused() {
        let bytes = written(&checkpoint());
        let rate =
            bytes.windows(5).position(|window| window == b"0.001").expect("the header says the step size");
        for (place, bit) in [(bytes.len() - 1, 0), (bytes.len() - 20_000, 3), (rate + 4, 1)] {
            let mut flipped = bytes.clone();
            flipped[place] ^= 1 << bit;
            assert_refused(&flipped, "it is damaged");
        }
    }

    #[test]
    fn a_missing_episode_is_refused() {
        let mut short = checkpoint();
        short.episodes.pop();
        assert_refused(&written(&short), "it has 4 running episodes, the spec has 5 environments");
        let mut torn = checkpoint();
        torn.episodes[2].actions.pop();
        assert_refused(&written(&torn), "running episode 2 has different numbers of actions and steps");
    }

    #[test]
    fn a_network_of_other_widths_is_refused() {
        let mut other = checkpoint();
        other.trainees[1] = other.trainees[0].clone();
        assert_refused(
            &written(&other),
            "its critic has layers [2, 24, 24, 1], the spec asks for [3, 24, 24, 1]",
        );
    }

    #[test]
    fn more_updates_than_the_training_has_are_refused() {
        let after = |update| {
            written(&Checkpoint { progress: Progress { update, ..checkpoint().progress }, ..checkpoint() })
        };
        assert!(read(&after(8)).is_ok());
        assert_refused(&after(1_000_000), "it follows update 1000000 of 8");
    }

    #[test]
    fn an_unknown_field_is_refused() {
        for place in ["", "/progress", "/settings", "/settings/policy"] {
            let unknown =
                |header: &mut Value| header.pointer_mut(place).expect("it is there")["shade"] = json!(1);
            assert_refused(&with_header(&written(&checkpoint()), unknown), "unknown field `shade`");
        }
    }

    #[test]
    fn another_version_of_the_program_is_refused_in_the_same_format() {
        let older = |header: &mut Value| header["tool"] = json!("0.0.9");
        let why = format!("another version of specforge (0.0.9, this is {TOOL})");
        assert_refused(&with_header(&written(&checkpoint()), older), &why);
    }
}
