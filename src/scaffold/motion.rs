//! Smaller reference motions for robots whose legs cannot make those of the program: shorter and lower steps,
//! less sway, shallower squats.

use toml_edit::{DocumentMut, Item};

use crate::kinds::motion;

/// The sizes of a task's motion in the order in which they are tried, as shares of the original. At less than
/// half of its angles a squat is the default pose.
const SHARES: [(&str, &[f64]); 2] = [("squat", &[0.75, 0.6, 0.5]), ("walk", &[0.75, 0.5, 0.35, 0.25, 0.15])];

/// The keys that size scales: lengths of a walk, angles of a squat. A run is a recording in one part and a gait
/// in another part of its training, so it has none.
const SIZED: [(&str, &[&str]); 2] = [
    ("squat", &["hip_pitch", "knee", "ankle_pitch"]),
    ("walk", &["step_length", "foot_lift", "forward_offset", "sway", "sway_third", "speed_ripple"]),
];

/// A motion for one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Smaller {
    /// The text of its file.
    pub text: String,
    /// Its size in percent of the original.
    pub percent: f64,
}

/// Smaller and smaller motions for a task; none for a task without a motion that can be scaled. `spacing` is
/// the distance of a foot from the centre line in m for a walk, at a leg of the motion's reference length;
/// without it the original's.
pub fn smaller(task: &str, spacing: Option<f64>) -> Vec<Smaller> {
    let Some((_, sizes)) = SHARES.iter().find(|(known, _)| *known == task) else { return Vec::new() };
    let Some((_, keys)) = SIZED.iter().find(|(known, _)| *known == task) else { return Vec::new() };
    let Some(text) = motion::embedded(&format!("{task}.toml")) else { return Vec::new() };
    let own = spacing.filter(|_| task == "walk");
    let of = |(share, spacing): (f64, Option<f64>)| scaled(text, keys, share, spacing);
    let first = own.map(|own| (1.0, Some(own)));
    let shares = sizes.iter().flat_map(|share| [Some((*share, None)), own.map(|own| (*share, Some(own)))]);
    first.into_iter().chain(shares.flatten()).filter_map(of).collect()
}

/// A motion's text with these keys at a share of their values.
fn scaled(text: &str, keys: &[&str], share: f64, spacing: Option<f64>) -> Option<Smaller> {
    let mut document: DocumentMut = text.parse().ok()?;
    for key in keys {
        let written = document.get(key)?.as_str()?.to_owned();
        let (number, unit) = written.split_once(' ')?;
        let value = share * number.parse::<f64>().ok()?;
        replace(document.get_mut(key)?, &format!("{} {unit}", rounded(value)));
    }
    if let Some(spacing) = spacing {
        replace(document.get_mut("half_foot_spacing")?, &format!("{} m", rounded(spacing)));
    }
    let percent = 100.0 * share;
    let body = document.to_string();
    // The comments at the top are about the original.
    let body: Vec<&str> = body.lines().skip_while(|line| line.is_empty() || line.starts_with('#')).collect();
    let text = format!("# The shipped motion at {percent:.0} % of its size.\n{}\n", body.join("\n"));
    Some(Smaller { text, percent })
}

/// Replaces a value and keeps its comment.
fn replace(item: &mut Item, text: &str) {
    let decor = item.as_value().map(|value| value.decor().clone());
    *item = toml_edit::value(text);
    if let (Some(value), Some(decor)) = (item.as_value_mut(), decor) {
        *value.decor_mut() = decor;
    }
}

/// To a hundredth of a millimetre or of a milliradian.
fn rounded(value: f64) -> f64 {
    (value * 1e5).round() / 1e5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smaller_motions_are_the_shipped_ones_with_scaled_sizes() {
        let walks = smaller("walk", Some(0.08));
        assert_eq!(walks.len(), 11);
        assert!(walks[0].text.contains("step_length          = \"0.11227 m\""), "{}", walks[0].text);
        assert!(walks[0].text.contains("half_foot_spacing    = \"0.08 m\""), "{}", walks[0].text);
        let half: Vec<&Smaller> = walks.iter().filter(|walk| walk.percent == 50.0).collect();
        assert!(half[0].text.contains("step_length          = \"0.05614 m\""), "{}", half[0].text);
        assert!(half[0].text.contains("half_foot_spacing    = \"0.12445 m\""), "{}", half[0].text);
        assert!(half[0].text.contains("period               = \"1.8 s\""), "{}", half[0].text);
        let squats = smaller("squat", Some(0.08));
        assert_eq!(squats.len(), 3);
        assert!(squats[2].text.contains("knee        = \"0.6 rad\""), "{}", squats[1].text);
        assert_eq!(smaller("run", None).len() + smaller("stand", None).len(), 0);
    }
}
