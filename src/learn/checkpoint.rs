//! Checkpoints: everything that a training needs to go on as if it had never stopped.
//!
//! Random streams are named, so none is stored. The state of a simulator is not stored either: an episode in flight is
//! begun again and its actions are replayed, which works with every engine and comes out bit for bit the same.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::adam::Adam;
use super::error::LearnError;
use super::file::{self, Tensors};
use super::lane::Episode;
use super::network::Network;
use super::settings::Settings;

/// The file's name in the scratch folder.
const NAME: &str = "checkpoint.safetensors";
/// Raised when the same bytes mean something else, or are not all that there is. The first files do not say it.
const VERSION: u32 = 1;

/// A training between two updates.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// Both networks with their moments: actor, critic.
    pub trainees: [(Network, Adam); 2],
    /// The environments' running episodes.
    pub episodes: Vec<Episode>,
    /// Counters.
    pub progress: Progress,
}

/// Counters of a training.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// The next update.
    pub update: u64,
    /// The steered step size.
    pub rate: f64,
    /// Wall time so far in s.
    pub wall: f64,
    /// CPU time so far in s.
    pub cpu: f64,
    /// Lines of `metrics.jsonl`.
    pub lines: u64,
}

/// What every version's header says.
#[derive(Deserialize)]
struct Stamp {
    #[serde(default = "Stamp::first")]
    version: u32,
}

impl Stamp {
    fn first() -> u32 {
        1
    }
}

/// What does not fit into tensors of f32.
#[derive(Serialize, Deserialize)]
struct Header {
    #[serde(default = "Stamp::first")]
    version: u32,
    settings: Settings,
    progress: Progress,
    /// Steps of Adam: actor, critic.
    steps: [u64; 2],
    /// Number, reward and steps of each running episode.
    episodes: Vec<(u64, f64, u64)>,
}

const TRAINEES: [&str; 2] = ["actor", "critic"];

impl Checkpoint {
    /// Where a training with this scratch folder keeps it.
    pub fn path(scratch: &Path) -> PathBuf {
        scratch.join(NAME)
    }

    /// Writes the checkpoint in place of the previous one, which stays when anything fails.
    pub fn save(&self, scratch: &Path, settings: &Settings) -> Result<(), LearnError> {
        let mut tensors = Tensors::new();
        for (name, (network, adam)) in TRAINEES.iter().zip(&self.trainees) {
            network.insert_into(name, &mut tensors);
            for (moment, values) in [("first", &adam.first), ("second", &adam.second)] {
                tensors.insert(format!("{name}.{moment}"), (vec![values.len()], values.clone()));
            }
        }
        for (index, episode) in self.episodes.iter().enumerate() {
            tensors.insert(format!("actions.{index}"), (vec![episode.actions.len()], episode.actions.clone()));
        }
        let header = Header {
            version: VERSION,
            settings: settings.clone(),
            progress: self.progress,
            steps: [self.trainees[0].1.steps, self.trainees[1].1.steps],
            episodes: self.episodes.iter().map(|episode| (episode.number, episode.reward, episode.steps)).collect(),
        };
        let header = serde_json::to_string(&header).expect("a header is plain numbers");
        replace(&Self::path(scratch), &file::write(&tensors, &[("training", &header)]))
    }

    /// Reads the checkpoint of a training, if there is one.
    pub fn load(scratch: &Path, settings: &Settings) -> Result<Option<Self>, LearnError> {
        let path = Self::path(scratch);
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(LearnError::at(&path)(error)),
        };
        Self::decode(&bytes, settings).map(Some).map_err(|reason| LearnError::Checkpoint { path, reason })
    }

    fn decode(bytes: &[u8], settings: &Settings) -> Result<Self, String> {
        let (mut tensors, texts) = file::read(bytes).map_err(|error| error.to_string())?;
        let header = texts.get("training").ok_or("its header is missing")?;
        let foreign = |what: String| format!("it was written by another version of specforge ({what})");
        let Stamp { version } = serde_json::from_str(header).map_err(|error| foreign(error.to_string()))?;
        if version != VERSION {
            return Err(foreign(format!("its format is {version}, this version reads {VERSION}")));
        }
        let header: Header = serde_json::from_str(header).map_err(|error| foreign(error.to_string()))?;
        // How often checkpoints are written changes nothing that is in them.
        if (Settings { checkpoint_every: settings.checkpoint_every, ..header.settings }) != *settings {
            return Err("it was written with other settings".to_owned());
        }
        let shapes = [settings.policy.activation, settings.value.activation];
        let mut trainees = Vec::new();
        for ((name, steps), activation) in TRAINEES.iter().zip(header.steps).zip(shapes) {
            let network = Network::take_from(name, &tensors, activation).map_err(|error| error.to_string())?;
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
        Ok(Self { trainees, episodes: episodes?, progress: header.progress })
    }
}

/// The numbers of a tensor.
fn take(tensors: &mut BTreeMap<String, (Vec<usize>, Vec<f32>)>, name: &str) -> Result<Vec<f32>, String> {
    tensors.remove(name).map(|(_, numbers)| numbers).ok_or_else(|| format!("tensor `{name}` is missing"))
}

/// Writes a file in one step: either the new bytes are there, on the disk, or the old ones are.
pub(super) fn replace(path: &Path, bytes: &[u8]) -> Result<(), LearnError> {
    let draft = path.with_extension("draft");
    let written = File::create(&draft)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&draft, path));
    if written.is_err() {
        // The draft may fill the disk; that it could not be removed would hide why it could not be written.
        let _ = fs::remove_file(&draft);
    }
    written.map_err(LearnError::at(path))?;
    // The folder's entry, too, should survive a power cut; not all systems can sync a folder.
    if let Some(folder) = path.parent().and_then(|folder| File::open(folder).ok()) {
        let _ = folder.sync_all();
    }
    Ok(())
}
