//! Detects NaN and infinity in stored results. Results stored now contain neither; earlier versions stored
//! `null` in their place, which a reader would take for "not measured".

use std::path::Path;

use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::bounded;
use crate::deploy::contract::Contract;
use crate::env::Blueprint;
use crate::kinds::motion::Motion;
use crate::learn::file::is_finite;
use crate::robot::Robot;

/// Values of a training update that may be missing.
const UNMEASURED: [&str; 3] = ["dead_units", "single_support", "reference_single_support"];
/// Means over the episodes that ended during an update.
const OF_EPISODES: [&str; 2] = ["return_mean", "length_mean_s"];
/// Values that the summary of a training may lack.
const OF_SUMMARY: [&str; 3] = ["return_mean", "length_mean_s", "warnings"];

/// Fails with the first non-finite number in these files of a folder.
pub fn check<'a>(folder: &Path, files: impl Iterator<Item = &'a str>) -> Result<(), String> {
    for name in files {
        let bytes = match name {
            name if name.ends_with(".safetensors") || name.ends_with(".json") || name == "metrics.jsonl" => {
                bounded::bytes(&folder.join(name), bounded::ARTEFACT)
                    .map_err(|error| format!("{name}: {error}"))?
            }
            _ => continue,
        };
        if let Some(place) = broken(name, &bytes) {
            return Err(format!("{name}: {place} is not a finite number"));
        }
    }
    Ok(())
}

/// The location of a non-finite number in a file.
fn broken(name: &str, bytes: &[u8]) -> Option<String> {
    if name.ends_with(".safetensors") {
        return (!is_finite(bytes)).then(|| "a weight".to_owned());
    }
    // Almost no file contains `null`; skip parsing those without.
    if !bytes.windows(4).any(|window| window == b"null") {
        return None;
    }
    match name {
        "metrics.jsonl" => bytes.split(|byte| *byte == b'\n').enumerate().find_map(|(index, line)| {
            let place = of_update(&serde_json::from_slice(line).ok()?)?;
            Some(format!("`{place}` in line {}", index + 1))
        }),
        "evaluation.json" => first_null(bytes, &["command"]),
        "summary.json" => first_null(bytes, &OF_SUMMARY),
        "pretrain.json" => first_null(bytes, &[]),
        // The types of these say what may be missing.
        "robot.json" => untyped::<Robot>(bytes),
        "motion.json" => untyped::<Motion>(bytes),
        "env.json" => untyped::<Blueprint>(bytes),
        "contract.json" => untyped::<Contract>(bytes),
        _ => None,
    }
}

/// The name of a non-finite number of an update.
fn of_update(update: &Value) -> Option<String> {
    let ended = update.get("episodes").and_then(Value::as_u64).unwrap_or_default() > 0;
    let mut allowed = UNMEASURED.to_vec();
    allowed.extend(OF_EPISODES.iter().filter(|_| !ended));
    null_in(update, &allowed)
}

fn first_null(bytes: &[u8], allowed: &[&str]) -> Option<String> {
    let value = serde_json::from_slice(bytes).ok()?;
    null_in(&value, allowed).map(|place| format!("`{place}`"))
}

/// The path of the first `null` in a value, except under the allowed keys.
fn null_in(value: &Value, allowed: &[&str]) -> Option<String> {
    match value {
        Value::Null => Some(String::new()),
        Value::Array(items) => {
            items.iter().enumerate().find_map(|(index, item)| below(&index.to_string(), item))
        }
        Value::Object(map) => {
            let mut kept =
                map.iter().filter(|(key, value)| !(value.is_null() && allowed.contains(&key.as_str())));
            kept.find_map(|(key, value)| below(key, value))
        }
        _ => None,
    }
}

fn below(step: &str, value: &Value) -> Option<String> {
    let rest = null_in(value, &[])?;
    Some(if rest.is_empty() { step.to_owned() } else { format!("{step}.{rest}") })
}

/// Where a file does not match its type.
fn untyped<T: DeserializeOwned>(bytes: &[u8]) -> Option<String> {
    serde_json::from_slice::<T>(bytes).err().map(|error| format!("a value ({error})"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::network::{Activation, Network};
    use crate::learn::pretrain::PretrainReport;
    use crate::learn::{Summary, UpdateMetrics};
    use crate::outcome::{Episode, Evaluation};
    use crate::stream::Stream;

    /// What is wrong with a file of this value, as written by earlier versions.
    fn told<T: serde::Serialize>(name: &str, value: &T) -> Option<String> {
        broken(name, serde_json::to_string(value).expect("it can be written").as_bytes())
    }

    #[test]
    fn a_null_where_a_number_was_measured_is_found_and_one_that_was_not_measured_is_none() {
        assert_eq!(told("pretrain.json", &PretrainReport::default()), None);
        let pretrain = PretrainReport { rmse_nm: f64::INFINITY, ..PretrainReport::default() };
        assert_eq!(told("pretrain.json", &pretrain).as_deref(), Some("`rmse_nm`"));
        let episode = |peak| Episode { peak_ankle_torque: peak, ..Episode::default() };
        let evaluation = |peak| Evaluation { episodes: vec![episode(peak)], ..Evaluation::default() };
        assert_eq!(told("evaluation.json", &evaluation(None)), None);
        let found = told("evaluation.json", &evaluation(Some(f64::NAN)));
        assert_eq!(found.as_deref(), Some("`episodes.0.peak_ankle_torque`"));
        let summary = Summary { cpu_us_per_sample: f64::NAN, ..Summary::default() };
        assert_eq!(told("summary.json", &Summary::default()), None);
        assert_eq!(told("summary.json", &summary).as_deref(), Some("`cpu_us_per_sample`"));
        let update = |episodes, value_loss| UpdateMetrics {
            episodes,
            value_loss,
            target_min: Some(0.0),
            target_max: Some(0.0),
            value_min: Some(0.0),
            value_max: Some(0.0),
            ..UpdateMetrics::default()
        };
        assert_eq!(told("metrics.jsonl", &update(0, 0.0)), None);
        assert_eq!(told("metrics.jsonl", &update(0, f64::NAN)).as_deref(), Some("`value_loss` in line 1"));
        // Episodes ended, so their mean return should have been measured.
        assert_eq!(told("metrics.jsonl", &update(2, 0.0)).as_deref(), Some("`return_mean` in line 1"));
    }

    #[test]
    fn a_weight_that_is_not_a_number_is_found() {
        let mut network = Network::orthogonal(&[5, 8, 3], Activation::Relu, &mut Stream::new("test/numbers"));
        assert_eq!(broken("actor.safetensors", &network.to_safetensors("actor")), None);
        network.layers[1].weight[3] = f32::NAN;
        assert_eq!(
            broken("actor.safetensors", &network.to_safetensors("actor")).as_deref(),
            Some("a weight")
        );
    }
}
