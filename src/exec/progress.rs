//! Progress as plain lines, for output that is not a terminal. Depends on events only, not on stages.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::curve::Curve;
use super::events::{Event, Events};
use super::pace::Pace;
use crate::escape::terminal::{self, Painted, Style};
use crate::quantity::span;

/// Minimum time between two progress lines of one stage.
const LINE_INTERVAL: Duration = Duration::from_secs(15);
/// Width of a stage's name.
pub(super) const NAME_WIDTH: usize = 32;
/// Width of a training's curve.
const CURVE_WIDTH: usize = 20;

/// Plain lines, for logs: starts and ends at once, progress at intervals.
pub struct Lines<W> {
    state: Mutex<LineState<W>>,
    interval: Duration,
}

struct LineState<W> {
    stream: W,
    /// The progress of each stage.
    seen: BTreeMap<String, Seen>,
}

struct Seen {
    pace: Pace,
    /// Time of the last line.
    told: Instant,
    /// Share that is done.
    share: f64,
    /// The return of a training so far; `None` until there is one.
    curve: Option<Curve>,
}

impl<W: Write> Lines<W> {
    /// Writes lines to this stream.
    pub fn new(stream: W) -> Self {
        Self { state: Mutex::new(LineState { stream, seen: BTreeMap::new() }), interval: LINE_INTERVAL }
    }

    /// Sets the minimum time between two lines of one stage.
    pub fn every(mut self, interval: Duration) -> Self {
        self.interval = interval;
        self
    }

    /// The stream.
    pub fn into_inner(self) -> W {
        self.state.into_inner().unwrap_or_else(PoisonError::into_inner).stream
    }
}

impl<W: Write + Send> Events for Lines<W> {
    fn emit(&self, event: Event) {
        let mut state = lock(&self.state);
        let text = match &event {
            Event::StageStarted { stage, reasons, .. } => {
                let reason = reasons.first().map(|reason| format!(" ({reason})")).unwrap_or_default();
                Some(terminal::line(&format!("{stage:<NAME_WIDTH$} started{reason}")).into_owned())
            }
            Event::Progress { stage, done, total, unit, note } => {
                state.progress(stage, [*done, *total], self.interval).map(|line| {
                    let note = if note.is_empty() { String::new() } else { format!("; {note}") };
                    let curve = state.curve(stage).map(|curve| format!("  {curve}")).unwrap_or_default();
                    let line = format!("{stage:<NAME_WIDTH$} {}{note}{curve}", line.replace("{unit}", unit));
                    terminal::line(&line).into_owned()
                })
            }
            Event::Metric { stage, values } => {
                state.measure(stage, values);
                None
            }
            _ => told(&event, false).map(|text| text.as_str().to_owned()),
        };
        if let Some(text) = text {
            let _ = writeln!(state.stream, "{}", terminal::lines(&text)).and_then(|()| state.stream.flush());
        }
    }
}

impl<W> LineState<W> {
    /// Adds the return of a training to its curve.
    fn measure(&mut self, stage: &str, values: &BTreeMap<String, f64>) {
        if let (Some(seen), Some(value)) = (self.seen.get_mut(stage), values.get("return_mean")) {
            seen.curve.get_or_insert_with(|| Curve::new(CURVE_WIDTH)).add(seen.share, *value);
        }
    }

    fn curve(&self, stage: &str) -> Option<String> {
        self.seen.get(stage)?.curve.as_ref().map(Curve::blocks)
    }

    /// A line of progress, unless the last one is too recent.
    fn progress(&mut self, stage: &str, [done, total]: [u64; 2], interval: Duration) -> Option<String> {
        let now = Instant::now();
        let share = done as f64 / total.max(1) as f64;
        let Some(seen) = self.seen.get_mut(stage) else {
            let pace = Pace::new(done, now);
            self.seen.insert(stage.to_owned(), Seen { pace, told: now, share, curve: None });
            return None;
        };
        seen.share = share;
        seen.pace.advance(done, now);
        if now.duration_since(seen.told) < interval {
            return None;
        }
        seen.told = now;
        let rate = seen.pace.rate().unwrap_or(0.0);
        let percent = 100 * done / total.max(1);
        let eta = seen.pace.left(total).map(|left| format!(", {} left", span(left))).unwrap_or_default();
        // Rates of long episodes can be below one per second.
        let digits = usize::from(rate < 9.95);
        Some(format!("{percent:>3} %  {done} of {total} {{unit}}, {rate:.digits$}/s{eta}"))
    }
}

/// Shows only failures and warnings.
pub struct Quiet<W>(Mutex<W>);

impl<W: Write> Quiet<W> {
    /// Writes to this stream.
    pub fn new(stream: W) -> Self {
        Self(Mutex::new(stream))
    }
}

impl<W: Write + Send> Events for Quiet<W> {
    fn emit(&self, event: Event) {
        if let (Event::StageFailed { .. } | Event::Warning { .. }, Some(text)) = (&event, told(&event, false))
        {
            let _ = writeln!(lock(&self.0), "{}", text.as_str());
        }
    }
}

/// The text of ends and warnings, with or without a terminal. The command counts cached stages itself.
pub(super) fn told(event: &Event, colored: bool) -> Option<Painted> {
    let coded = |word: &str, code: &Option<String>| match code {
        Some(code) => format!("{word}[{code}]"),
        None => word.to_owned(),
    };
    let begun = |style: Style, word: &str| Painted::new(colored).styled(style, word);
    let advised = |text: Painted, help: &Option<String>| match help {
        Some(help) => {
            text.plain("\n").styled(Style::Help, "help").plain(&format!(": {}", terminal::line(help)))
        }
        None => text,
    };
    match event {
        Event::StageFinished { stage, cached: false, wall_s, .. } => {
            let name = Painted::new(colored).plain(&format!("{:<NAME_WIDTH$} ", terminal::line(stage)));
            Some(name.styled(Style::Done, "done").plain(&format!(" in {}", span(*wall_s))))
        }
        Event::StageFailed { stage, code, message, help, .. } => {
            let text = begun(Style::Error, &coded("error", code));
            Some(advised(text.plain(&format!(": {}", terminal::line(&format!("{stage}: {message}")))), help))
        }
        Event::Warning { stage, code, message, help } => {
            let place = stage.as_ref().map(|stage| format!("{stage}: ")).unwrap_or_default();
            let text = format!("{place}{message}");
            Some(advised(
                begun(Style::Warning, &coded("warning", code)).plain(&format!(": {}", terminal::line(&text))),
                help,
            ))
        }
        Event::Note { stage, message } => Some(
            Painted::new(colored).plain(&format!("note: {}", terminal::line(&format!("{stage}: {message}")))),
        ),
        _ => None,
    }
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn progress(done: u64) -> Event {
        let (stage, unit, note) = ("learner".into(), "samples".into(), "return 3.5".into());
        Event::Progress { stage, done, total: 400, unit, note }
    }

    #[test]
    fn plain_lines_tell_beginning_and_end_and_keep_progress_rare() {
        let lines = Lines::new(Vec::new());
        let (stage, key) = ("learner".to_owned(), "k".to_owned());
        let reasons = vec!["learn.seed: 1 -> 2".into()];
        lines.emit(Event::StageStarted {
            stage: stage.clone(),
            key: key.clone(),
            kind: stage.clone(),
            reasons,
        });
        for done in 0..100 {
            lines.emit(progress(done));
        }
        lines.emit(Event::StageFinished { stage, key, cached: false, wall_s: 75.0 });
        let text = String::from_utf8(lines.into_inner()).expect("text");
        let told: Vec<&str> = text.lines().collect();
        assert_eq!(told.len(), 2, "{text}");
        assert!(told[0].ends_with("started (learn.seed: 1 -> 2)"));
        assert!(told[1].ends_with("done in 1 min 15 s"));
    }

    #[test]
    fn a_note_is_no_warning_and_is_not_told_when_only_those_are() {
        let note = Event::Note { stage: "learner".into(), message: "continues training".into() };
        assert_eq!(told(&note, false).expect("a text").as_str(), "note: learner: continues training");
        let quiet = Quiet::new(Vec::new());
        quiet.emit(note);
        assert!(quiet.0.into_inner().expect("no panic").is_empty());
    }

    #[test]
    fn a_line_of_a_training_ends_with_the_course_of_its_return() {
        let lines = Lines::new(Vec::new()).every(Duration::ZERO);
        for done in [100, 200, 300] {
            lines.emit(progress(done));
            let values = BTreeMap::from([("return_mean".to_owned(), done as f64), ("kl".to_owned(), 1e9)]);
            lines.emit(Event::Metric { stage: "learner".into(), values });
        }
        lines.emit(progress(300));
        let text = String::from_utf8(lines.into_inner()).expect("text");
        assert!(text.lines().last().expect("lines").ends_with("return 3.5      ▃▃▃▃▃▆▆▆▆▆█·····"), "{text}");
    }

    #[test]
    fn what_is_slower_than_one_a_second_has_a_rate_all_the_same() {
        let lines = Lines::new(Vec::new()).every(Duration::ZERO);
        lines.emit(progress(200));
        std::thread::sleep(Duration::from_millis(1100));
        lines.emit(progress(201));
        let text = String::from_utf8(lines.into_inner()).expect("text");
        assert!(text.contains("samples, 0.") && !text.contains(", 0.0/s"), "{text}");
    }

    #[test]
    fn a_line_of_progress_counts_from_where_a_resumed_stage_began() {
        let lines = Lines::new(Vec::new()).every(Duration::ZERO);
        lines.emit(progress(200));
        std::thread::sleep(Duration::from_millis(20));
        lines.emit(progress(300));
        let text = String::from_utf8(lines.into_inner()).expect("text");
        assert!(
            text.contains(" 75 %  300 of 400 samples, ") && text.contains("s left; return 3.5"),
            "{text}"
        );
        let rate: f64 = text
            .split("samples, ")
            .nth(1)
            .and_then(|rest| rest.split("/s").next())
            .expect("a rate")
            .parse()
            .expect("a number");
        assert!((1_000.0..=5_000.0).contains(&rate), "100 samples in 20 ms or a little more: {rate}");
    }
}
