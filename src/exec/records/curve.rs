//! The learning curve of a training: for every update the values that figures and claims use, and the last
//! update in full.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The values kept from a line of `metrics.jsonl`.
#[derive(Deserialize)]
struct Update {
    samples: u64,
    episodes: u64,
    return_mean: Option<f64>,
    length_mean_s: Option<f64>,
    #[serde(default)]
    single_support: Option<f64>,
    cpu_s: f64,
    wall_s: f64,
    #[serde(flatten)]
    late: Option<Late>,
}

/// The values of an update that tables of the end of a training use. Trainings that were restored from records
/// of earlier versions do not have them.
#[derive(Deserialize)]
struct Late {
    ends: BTreeMap<String, u64>,
    kl: f64,
    explained_variance: f64,
}

/// Columns with one value per update.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Curve {
    /// Samples so far.
    samples: Vec<u64>,
    /// Episodes that ended in the update.
    episodes: Vec<u64>,
    /// Their mean return, rounded to single precision like all columns below.
    return_mean: Vec<Option<f64>>,
    /// Their mean length in s.
    length_mean_s: Vec<Option<f64>>,
    /// Share of the control steps in single support.
    single_support: Vec<Option<f64>>,
    /// CPU time so far in s, over all threads.
    cpu_s: Vec<f64>,
    /// Wall time so far in s.
    wall_s: Vec<f64>,
    /// Numbers of episodes that ended, KL divergences and explained variances; absent in records of earlier
    /// versions, whose pages leave them out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    late: Option<Columns>,
    /// The whole line of the last update.
    last: serde_json::Value,
}

/// Columns that tables of the end of a training use.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Columns {
    /// Episodes that ended by each cause.
    ends: BTreeMap<String, Vec<u64>>,
    /// KL divergence of the update.
    kl: Vec<f64>,
    /// Share of the variance of the critic's targets that its values explain.
    explained_variance: Vec<f64>,
}

impl Columns {
    /// Adds an update; `None` if it has other causes than those before.
    fn push(mut self, late: &Late) -> Option<Self> {
        if self.kl.is_empty() {
            self.ends = late.ends.keys().map(|cause| (cause.clone(), Vec::new())).collect();
        }
        if !self.ends.keys().eq(late.ends.keys()) {
            return None;
        }
        self.ends.iter_mut().for_each(|(cause, counts)| counts.push(late.ends[cause]));
        self.kl.push(single(late.kl));
        self.explained_variance.push(single(late.explained_variance));
        Some(self)
    }

    /// Whether every column has this length.
    fn have_length(&self, count: usize) -> bool {
        let ends = self.ends.values().map(Vec::len);
        ends.chain([self.kl.len(), self.explained_variance.len()]).all(|length| length == count)
    }

    /// Adds the values of an update to its line.
    fn put(&self, index: usize, line: &mut serde_json::Value) {
        let ends = self.ends.iter().map(|(cause, counts)| (cause.clone(), counts[index].into()));
        line["ends"] = serde_json::Value::Object(ends.collect());
        line["kl"] = self.kl[index].into();
        line["explained_variance"] = self.explained_variance[index].into();
    }
}

impl Curve {
    /// Extracts the curve from `metrics.jsonl`.
    pub fn of(metrics: &str) -> Result<Self, serde_json::Error> {
        let mut curve = Self { late: Some(Columns::default()), ..Self::default() };
        for line in metrics.lines() {
            let update: Update = serde_json::from_str(line)?;
            curve.samples.push(update.samples);
            curve.episodes.push(update.episodes);
            curve.return_mean.push(update.return_mean.map(single));
            curve.length_mean_s.push(update.length_mean_s.map(single));
            curve.single_support.push(update.single_support.map(single));
            curve.cpu_s.push(single(update.cpu_s));
            curve.wall_s.push(single(update.wall_s));
            curve.late = curve.late.zip(update.late).and_then(|(columns, late)| columns.push(&late));
            curve.last = serde_json::from_str(line)?;
        }
        Ok(curve)
    }

    /// The lines of `metrics.jsonl`, without the values that the curve does not store.
    pub fn lines(&self) -> Result<String, String> {
        let count = self.samples.len();
        let lengths = [self.return_mean.len(), self.length_mean_s.len(), self.single_support.len()];
        let others = [self.episodes.len(), self.cpu_s.len(), self.wall_s.len()];
        let is_torn = self.late.as_ref().is_some_and(|late| !late.have_length(count));
        if is_torn || lengths.into_iter().chain(others).any(|length| length != count) {
            return Err("the columns of the learning curve have different lengths".to_owned());
        }
        let mut text = String::new();
        for index in 0..count.saturating_sub(1) {
            let mut line = serde_json::json!({
                "update": index, "samples": self.samples[index], "episodes": self.episodes[index],
                "return_mean": self.return_mean[index], "length_mean_s": self.length_mean_s[index],
                "single_support": self.single_support[index], "cpu_s": self.cpu_s[index],
                "wall_s": self.wall_s[index],
            });
            if let Some(late) = &self.late {
                late.put(index, &mut line);
            }
            text += &format!("{line}\n");
        }
        if count > 0 {
            let mut last = self.last.clone();
            // Without those of the other updates these of the last one would pass for the end of the training.
            if let (None, Some(values)) = (&self.late, last.as_object_mut()) {
                LATE.iter().for_each(|key| drop(values.remove(*key)));
            }
            text += &format!("{last}\n");
        }
        Ok(text)
    }
}

/// The keys of [`Late`].
const LATE: [&str; 3] = ["ends", "kl", "explained_variance"];

/// Rounds to single precision and back, by the shortest decimal form.
fn single(number: f64) -> f64 {
    (number as f32).to_string().parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use serde_json::{Value as Json, json};

    use super::*;

    #[test]
    fn a_curve_gives_back_its_numbers_to_single_precision_and_the_last_line_whole() {
        let update = |update: u64, return_mean: Option<f64>| {
            json!({
                "update": update, "samples": 256 * (update + 1), "episodes": update,
                "return_mean": return_mean,
                "length_mean_s": null, "single_support": 1.0 / 3.0, "cpu_s": 0.5, "wall_s": 1.5, "kl": 0.125,
                "explained_variance": 0.5, "ends": { "time_out": update, "base_tilt": 1 }, "epochs": 4,
            })
        };
        let updates = [update(0, None), update(1, Some(0.123_456_789_012_3)), update(2, Some(17.5))];
        let text: String = updates.iter().map(|update| format!("{update}\n")).collect();
        let curve = Curve::of(&text).expect("lines of metrics");
        let again = curve.lines().expect("columns of one length");
        let read: Vec<Json> = again.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(read.len(), 3);
        assert_eq!((&read[0]["return_mean"], &read[1]["return_mean"]), (&Json::Null, &json!(0.123_456_79)));
        assert_eq!(
            (&read[1]["update"], &read[1]["samples"], &read[1]["episodes"]),
            (&json!(1), &json!(512), &json!(1))
        );
        assert_eq!((read[1].get("epochs"), &read[2]), (None, &updates[2]));
        assert_eq!(
            (&read[1]["kl"], &read[1]["ends"]),
            (&json!(0.125), &json!({ "time_out": 1, "base_tilt": 1 }))
        );
        // A record of an earlier version: no update has what only the last one would have.
        let earlier = Curve { late: None, ..curve.clone() };
        let text = earlier.lines().expect("columns of one length");
        let read: Vec<Json> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert!(read.iter().all(|line| LATE.iter().all(|key| line.get(key).is_none())), "{text}");
        assert_eq!(read[2]["epochs"], 4);
        let again = Curve::of(&text).expect("lines of metrics");
        assert_eq!(again.late, None);
        let torn = Curve { episodes: vec![1], ..curve };
        assert!(torn.lines().is_err());
    }
}
