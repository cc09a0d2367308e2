//! Formats the names, numbers and values of a spec for a report.

use super::estimate::Estimate;
use super::model::Arm;
use super::plot::axis::written;
use crate::quantity;
use crate::spec::{Sampler, Value};

/// Short names of the arms: their spec names without a common prefix of words (`atlas_run_torque`,
/// `atlas_run_position` become `torque`, `position`).
pub fn labels(arms: &[Arm]) -> Vec<String> {
    let words: Vec<Vec<&str>> = arms.iter().map(|arm| arm.name.split('_').collect()).collect();
    let shortest = words.iter().map(Vec::len).min().unwrap_or(0);
    let shared =
        (0..shortest.saturating_sub(1)).take_while(|at| words.iter().all(|name| name[*at] == words[0][*at]));
    let cut = if arms.len() > 1 { shared.count() } else { 0 };
    let short: Vec<String> = words.iter().map(|name| name[cut..].join("_")).collect();
    let unique = short.iter().enumerate().all(|(at, name)| !short[..at].contains(name));
    if unique { short } else { arms.iter().map(|arm| arm.name.clone()).collect() }
}

/// Most characters of a name in a drawing.
const DIRECT: usize = 30;

/// The short names of the arms for labels next to lines; long ones are shortened in the middle.
pub fn direct_labels(arms: &[Arm]) -> Vec<String> {
    labels(arms).iter().map(|name| shortened(name, DIRECT)).collect()
}

/// A text of at most `most` characters; longer ones are shortened in the middle.
pub fn shortened(text: &str, most: usize) -> String {
    let characters: Vec<char> = text.chars().collect();
    if characters.len() <= most {
        return text.to_owned();
    }
    let kept = most.saturating_sub(1);
    let (head, tail) = (kept.div_ceil(2), kept / 2);
    let words = characters[..head].iter().chain(&['\u{2026}']).chain(&characters[characters.len() - tail..]);
    words.collect()
}

/// The text with a capital first letter.
pub fn capitalised(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or(String::new(), |first| first.to_uppercase().chain(characters).collect())
}

/// `a`, `a and b`, `a, b and c`.
pub fn listed<T: AsRef<str>>(items: &[T]) -> String {
    let items: Vec<&str> = items.iter().map(AsRef::as_ref).collect();
    match items.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => items.concat(),
    }
}

/// Axes whose points are clear without the name of the axis: `torque`, not `control torque`.
const PLAIN_AXES: &[&str] = &["robot", "task", "control", "case", "setting"];

/// The name of an arm or a run of a suite in words: `robot=tocabi,std=10 %,seed=2` is `tocabi, std 10 %,
/// seed 2`.
/// A name of another form is returned unchanged.
pub fn arm_in_words(name: &str) -> String {
    let part = |text: &str| {
        let (axis, point) = text.split_once('=')?;
        let [axis, point] = [axis, point].map(|text| text.replace('_', " "));
        Some(if PLAIN_AXES.contains(&axis.as_str()) { point } else { format!("{axis} {point}") })
    };
    let parts: Option<Vec<String>> = name.split(',').map(part).collect();
    parts.map_or_else(|| name.to_owned(), |parts| parts.join(", "))
}

/// A p value in few digits: `< 0.001`, `0.012`.
pub fn significance(p: f64) -> String {
    if p < 0.001 { "< 0.001".to_owned() } else { format!("{p:.3}") }
}

/// A count in a few characters: `128`, `16 384`, `200 k`, `3.0 M`.
pub fn count(value: u64) -> String {
    match value {
        0..100_000 => grouped(value),
        100_000..1_000_000 => format!("{} k", value / 1000),
        _ => format!("{:.1} M", value as f64 / 1e6),
    }
}

fn grouped(value: u64) -> String {
    if value < 10_000 { value.to_string() } else { format!("{} {:03}", value / 1000, value % 1000) }
}

/// A duration: `0.8 s`, `4 min 12 s`, `3 h 20 min`.
pub fn duration(seconds: f64) -> String {
    let whole = (seconds + 0.5).max(0.0) as u64;
    match whole {
        0..10 => format!("{seconds:.1} s"),
        10..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}

/// A number with three significant digits, more for large whole numbers, without trailing zeros.
pub fn number(value: f64) -> String {
    let size = value.abs();
    let decimals = match size {
        _ if size == 0.0 || size >= 100.0 => 0,
        _ if size >= 10.0 => 1,
        _ if size >= 1.0 => 2,
        _ => (2.0 - libm::floor(libm::log10(size))).clamp(2.0, 6.0) as usize,
    };
    let text = written(value, decimals);
    let trimmed = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    trimmed.to_string()
}

/// A value of a spec, in its author's units if known.
pub fn value(value: &Value) -> String {
    match value {
        Value::Flag(flag) => flag.to_string(),
        Value::Count(number) => count(*number),
        Value::Quantity(quantity) => quantity::written(&quantity.text),
        Value::Text(text) => text.clone(),
        Value::List(items) => format!("[{}]", items.iter().map(self::value).collect::<Vec<_>>().join(", ")),
        Value::Sampler(sampler) => distribution(sampler),
        Value::Table(table) => {
            let entries: Vec<String> =
                table.iter().map(|(key, item)| format!("{key} = {}", self::value(item))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
    }
}

fn distribution(sampler: &Sampler) -> String {
    let list = |values: &[f64]| values.iter().map(|value| number(*value)).collect::<Vec<_>>().join(", ");
    match sampler {
        Sampler::Constant(value) => number(*value),
        Sampler::Uniform(range) => format!("uniform [{}]", list(range)),
        Sampler::Normal(shape) => format!("normal [{}]", list(shape)),
        Sampler::LogUniform(range) => format!("log-uniform [{}]", list(range)),
        Sampler::Choice(values) => format!("one of [{}]", list(values)),
    }
}

/// A number with its 95 % interval, `94 % [80, 98]`; without its unit if the table's row has it.
pub fn with_interval(estimate: &Estimate, unit: bool) -> String {
    let scale = if estimate.unit == "%" { 100.0 } else { 1.0 };
    let digits = |value: f64| written(scale * value, estimate.digits);
    let Some(value) = estimate.value.filter(|value| value.is_finite()) else { return "\u{2013}".to_string() };
    let unit = if unit && !estimate.unit.is_empty() { format!(" {}", estimate.unit) } else { String::new() };
    let interval = estimate
        .interval()
        .map_or(String::new(), |ends| format!(" [{}, {}]", digits(ends.low), digits(ends.high)));
    format!("{}{unit}{interval}", digits(value))
}

/// The first characters of a fingerprint or a commit.
pub fn short(digest: &str) -> &str {
    digest.get(..12).unwrap_or(digest)
}

/// The first twelve digits of a commit, with the suffix of a modified working tree.
pub fn commit(commit: &str) -> String {
    let digits = commit.strip_suffix(MODIFIED);
    digits.map_or_else(|| short(commit).to_owned(), |digits| format!("{}{MODIFIED}", short(digits)))
}

/// The suffix that the build appends to the commit of a modified working tree.
const MODIFIED: &str = "-modified";

#[cfg(test)]
mod tests {
    use super::*;

    fn arms(names: &[&str]) -> Vec<Arm> {
        names.iter().map(|name| Arm { name: name.to_string(), ..Arm::default() }).collect()
    }

    #[test]
    fn arms_are_called_by_what_tells_them_apart() {
        assert_eq!(labels(&arms(&["atlas_run_torque", "atlas_run_position"])), ["torque", "position"]);
        assert_eq!(labels(&arms(&["atlas_run_torque"])), ["atlas_run_torque"]);
        assert_eq!(labels(&arms(&["run", "run_fast"])), ["run", "run_fast"]);
        assert_eq!(labels(&arms(&["a_x", "a_x"])), ["a_x", "a_x"]);
    }

    #[test]
    fn numbers_are_written_in_few_characters() {
        assert_eq!([128, 16_384, 200_000, 3_014_656].map(count), ["128", "16 384", "200 k", "3.0 M"]);
        assert_eq!(
            [0.84, 42.0, 252.0, 12_000.0].map(duration),
            ["0.8 s", "42 s", "4 min 12 s", "3 h 20 min"]
        );
        assert_eq!([0.0, 0.01234, 1.234, 12.34, 1234.5].map(number), ["0", "0.0123", "1.23", "12.3", "1234"]);
    }

    #[test]
    fn a_long_name_loses_its_middle_and_a_short_one_nothing() {
        assert_eq!(shortened("atlas_walk_torque", 17), "atlas_walk_torque");
        assert_eq!(shortened("atlas_walk_torque", 9), "atla\u{2026}rque");
        assert_eq!(shortened("\u{e4}\u{f6}\u{fc}\u{df}", 3), "\u{e4}\u{2026}\u{df}");
    }

    #[test]
    fn a_number_is_written_with_its_interval() {
        let share = Estimate::share(&[true, true, true, false]);
        assert_eq!(with_interval(&share, true), "75 % [30, 95]");
        assert_eq!(with_interval(&share, false), "75 [30, 95]");
        assert_eq!(with_interval(&Estimate::exact(-0.25, "m", 1), true), "\u{2212}0.2 m");
        assert_eq!(with_interval(&Estimate::default(), true), "\u{2013}");
    }
}
