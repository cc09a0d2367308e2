//! TensorBoard's event file next to `metrics.jsonl`: the same numbers over samples, for `tensorboard
//! --logdir`.
//!
//! A file of records (length, masked CRC-32C of the length, an `Event` in protocol buffers, masked CRC-32C of
//! the event), the format of TensorFlow's `tfrecord` and `event.proto`. When a training resumes, the file is
//! truncated to the checkpoint or rebuilt from the metrics, so it never has more than they have.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use prost::Message;
use serde_json::Value;

pub use super::beside::EVENTS as NAME;
use super::error::LearnError;
use super::metrics::UpdateMetrics;
use crate::safe_fs;

/// Content of a file's first event.
const VERSION: &str = "brain.Event:2";
/// Fields that are counters, not measurements.
const COUNTERS: [&str; 3] = ["update", "samples", "samples_total"];

/// `Event` of TensorFlow's event.proto, with the fields that are used.
#[derive(Clone, PartialEq, Message)]
struct Event {
    #[prost(double, tag = "1")]
    wall_time: f64,
    #[prost(int64, tag = "2")]
    step: i64,
    #[prost(string, optional, tag = "3")]
    file_version: Option<String>,
    #[prost(message, optional, tag = "5")]
    summary: Option<Scalars>,
}

/// `Summary`.
#[derive(Clone, PartialEq, Message)]
struct Scalars {
    #[prost(message, repeated, tag = "1")]
    value: Vec<Scalar>,
}

/// `Summary.Value`.
#[derive(Clone, PartialEq, Message)]
struct Scalar {
    #[prost(string, tag = "1")]
    tag: String,
    #[prost(float, optional, tag = "2")]
    simple_value: Option<f32>,
}

/// The open file.
pub(super) struct EventFile {
    path: PathBuf,
    file: File,
    /// The time at which the training's wall clock would have begun, in s since 1970.
    begin: f64,
}

impl EventFile {
    /// Opens the file in a folder; `wall` is the training's wall clock now. For an interrupted training the
    /// first `kept` bytes, which hold the metrics so far, remain; without them the file is rebuilt.
    pub fn open(
        folder: &Path,
        known: &[UpdateMetrics],
        wall: f64,
        kept: Option<u64>,
    ) -> Result<Self, LearnError> {
        let path = folder.join(NAME);
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64());
        if let Some(kept) = kept {
            let file = safe_fs::no_follow().append(true).open(&path).map_err(LearnError::at(&path))?;
            file.set_len(kept).map_err(LearnError::at(&path))?;
            return Ok(Self { path, file, begin: now - wall });
        }
        let file = safe_fs::no_follow().write(true).create(true).truncate(true).open(&path);
        let file = file.map_err(LearnError::at(&path))?;
        let mut events = Self { path, file, begin: now - wall };
        let first =
            Event { wall_time: events.begin, file_version: Some(VERSION.to_owned()), ..Event::default() };
        events.write(&first)?;
        known.iter().try_for_each(|metrics| events.add(metrics))?;
        Ok(events)
    }

    /// Adds the metrics of an update.
    pub fn add(&mut self, metrics: &UpdateMetrics) -> Result<(), LearnError> {
        let event = Event {
            wall_time: self.begin + metrics.wall_s,
            step: metrics.samples as i64,
            file_version: None,
            summary: Some(Scalars { value: scalars(metrics) }),
        };
        self.write(&event)
    }

    /// Makes sure that all events are on the disk.
    pub fn sync(&self) -> Result<(), LearnError> {
        self.file.sync_data().map_err(LearnError::at(&self.path))
    }

    fn write(&mut self, event: &Event) -> Result<(), LearnError> {
        self.file.write_all(&record(&event.encode_to_vec())).map_err(LearnError::at(&self.path))
    }
}

/// Every number of the metrics, nested ones as `terms/NAME` and `ends/NAME`; missing measurements are left
/// out.
fn scalars(metrics: &UpdateMetrics) -> Vec<Scalar> {
    let Ok(Value::Object(fields)) = serde_json::to_value(metrics) else { return Vec::new() };
    let mut scalars = Vec::new();
    let mut add = |tag: String, value: &Value| {
        let number = value.as_f64();
        scalars.extend(number.map(|number| Scalar { tag, simple_value: Some(number as f32) }));
    };
    for (name, value) in fields.iter().filter(|(name, _)| !COUNTERS.contains(&name.as_str())) {
        match value {
            Value::Object(parts) => {
                parts.iter().for_each(|(part, value)| add(format!("{name}/{part}"), value))
            }
            value => add(name.clone(), value),
        }
    }
    scalars
}

/// An event in its record.
fn record(event: &[u8]) -> Vec<u8> {
    let length = (event.len() as u64).to_le_bytes();
    [&length[..], &masked_crc(&length).to_le_bytes(), event, &masked_crc(event).to_le_bytes()].concat()
}

/// The checksum of records: rotated and shifted, so that it stays strong for data that contain checksums.
fn masked_crc(bytes: &[u8]) -> u32 {
    crc32c::crc32c(bytes).rotate_right(15).wrapping_add(0xa282_ead8)
}

#[cfg(test)]
pub(super) mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// The events of a file; their records are checked.
    fn read(path: &Path) -> Vec<Event> {
        let bytes = std::fs::read(path).unwrap();
        let mut rest = &bytes[..];
        let mut events = Vec::new();
        while !rest.is_empty() {
            let length = u64::from_le_bytes(rest[..8].try_into().unwrap()) as usize;
            let sums = [&rest[8..12], &rest[12 + length..16 + length]];
            let sums = sums.map(|sum| u32::from_le_bytes(sum.try_into().unwrap()));
            let event = &rest[12..12 + length];
            assert_eq!(sums, [masked_crc(&rest[..8]), masked_crc(event)]);
            events.push(Event::decode(event).unwrap());
            rest = &rest[16 + length..];
        }
        assert_eq!(events[0].file_version.as_deref(), Some(VERSION));
        events
    }

    /// Samples and numbers of a file's events, without the clocks' values.
    pub fn timeless(path: &Path) -> Vec<(i64, BTreeMap<String, f32>)> {
        let clocks = ["wall_s", "cpu_s", "learner_cpu_s", "samples_per_s"];
        let numbers = |event: Event| {
            let scalars = event.summary.unwrap_or_default().value.into_iter();
            let scalars = scalars.filter(|scalar| !clocks.contains(&scalar.tag.as_str()));
            (event.step, scalars.map(|scalar| (scalar.tag, scalar.simple_value.unwrap())).collect())
        };
        read(path).into_iter().map(numbers).collect()
    }

    #[test]
    fn a_record_is_that_of_tensorflow() {
        // CRC-32C of "123456789" is 0xe3069283 (RFC 3720 gives the polynomial, this is its usual check
        // value).
        assert_eq!(crc32c::crc32c(b"123456789"), 0xe306_9283);
        assert_eq!(masked_crc(b"123456789"), 0xe306_9283_u32.rotate_right(15).wrapping_add(0xa282_ead8));
        assert_eq!(record(b"ab").len(), 18);
    }

    #[test]
    fn what_was_not_measured_has_no_number() {
        let folder = tempfile::tempdir().unwrap();
        let metrics = UpdateMetrics {
            samples: 512,
            wall_s: 3.0,
            terms: BTreeMap::from([("torque".to_owned(), 0.25)]),
            ends: BTreeMap::from([("time_out".to_owned(), 2)]),
            length_mean_s: Some(1.5),
            ..UpdateMetrics::default()
        };
        let mut events = EventFile::open(folder.path(), std::slice::from_ref(&metrics), 10.0, None).unwrap();
        events.add(&UpdateMetrics { samples: 1024, wall_s: 11.0, ..metrics.clone() }).unwrap();
        let read = read(&folder.path().join(NAME));
        assert_eq!(read.iter().map(|event| event.step).collect::<Vec<_>>(), [0, 512, 1024]);
        assert!((read[2].wall_time - read[1].wall_time - 8.0).abs() < 1e-6);
        let scalars = &read[1].summary.as_ref().unwrap().value;
        let of = |tag: &str| {
            scalars.iter().find(|scalar| scalar.tag == tag).and_then(|scalar| scalar.simple_value)
        };
        assert_eq!(
            [of("terms/torque"), of("ends/time_out"), of("length_mean_s")],
            [Some(0.25), Some(2.0), Some(1.5)]
        );
        assert_eq!([of("return_mean"), of("samples")], [None, None]);
    }
}
