//! Progress at a terminal: one line per running stage, never wider than the terminal.
//!
//! In place of a bar, a training's line shows its return over time:
//! `⠹ tocabi_walk_torque  ▁▂▃▅▆▇▇██······  return 412     60 %   4117/s  32 min left`.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressState, ProgressStyle};

use super::curve::Curve;
use super::events::{Event, Events};
use super::pace::Pace;
use super::progress::{NAME_WIDTH, lock, told};
use crate::escape::terminal;

/// Columns that a line needs besides the name and the curve.
const REST: usize = 48;
/// Assumed width of a terminal whose width is unknown.
const COLUMNS: usize = 80;

/// One line per running stage, for terminals.
pub struct Bars {
    group: MultiProgress,
    rows: Mutex<BTreeMap<String, Row>>,
    layout: Layout,
    colored: bool,
}

/// The pace of a stage, as its bar draws it. The bar's own estimate would count what a checkpoint had.
type Shared = Arc<Mutex<Option<Pace>>>;

/// The line of one stage.
#[derive(Clone)]
struct Row {
    bar: ProgressBar,
    /// `None` until the first report. Shared with the bar's style, which prints rate and remaining time.
    pace: Shared,
    /// The return of a training so far; `None` until there is one.
    curve: Option<Curve>,
}

/// Column widths of a line that fits into the terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layout {
    name: usize,
    curve: usize,
}

impl Layout {
    /// Divides what the numbers leave of a terminal of this width between the name and the curve.
    fn of(columns: usize) -> Self {
        let free = columns.saturating_sub(REST).max(10);
        let name = (free * 3 / 5).min(NAME_WIDTH);
        Self { name, curve: (free - name).min(30) }
    }
}

impl Bars {
    /// Bars on standard error.
    pub fn new(colored: bool) -> Self {
        let size = terminal_size::terminal_size_of(std::io::stderr());
        let columns = size.map_or(COLUMNS, |(terminal_size::Width(columns), _)| usize::from(columns));
        Self { group: MultiProgress::new(), rows: Mutex::default(), layout: Layout::of(columns), colored }
    }

    fn row(&self, stage: &str) -> Row {
        let mut rows = lock(&self.rows);
        if let Some(row) = rows.get(stage) {
            return row.clone();
        }
        let (bar, pace) = (self.group.add(ProgressBar::new_spinner()), Shared::default());
        bar.set_style(style("{spinner} {prefix}  {elapsed:>4}", &pace));
        bar.set_prefix(fitted(&terminal::line(called(stage)), self.layout.name));
        bar.enable_steady_tick(Duration::from_millis(250));
        let row = Row { bar, pace, curve: None };
        rows.insert(stage.to_owned(), row.clone());
        row
    }

    fn progress(&self, stage: &str, [done, total]: [u64; 2]) {
        let Row { bar, pace, .. } = self.row(stage);
        let now = Instant::now();
        lock(&pace).get_or_insert_with(|| Pace::new(done, now)).advance(done, now);
        if bar.length().is_none() && total > 0 {
            let width = self.layout.curve;
            let template =
                format!("{{spinner}} {{prefix}}  {{bar:{width}}}  {{percent:>3}} %  {{speed}}  {{left}}");
            bar.set_style(style(&template, &pace));
            bar.set_length(total);
        }
        bar.set_position(done);
    }

    /// Adds the return of a training to its curve.
    fn measure(&self, stage: &str, values: &BTreeMap<String, f64>) {
        let Some(value) = values.get("return_mean") else { return };
        let mut rows = lock(&self.rows);
        let Some(Row { bar, pace, curve }) = rows.get_mut(stage) else { return };
        let Some(total) = bar.length().filter(|total| *total > 0) else { return };
        if curve.is_none() {
            bar.set_style(style("{spinner} {prefix}  {msg}  {percent:>3} %  {speed}  {left}", pace));
        }
        let curve = curve.get_or_insert_with(|| Curve::new(self.layout.curve));
        curve.add(bar.position() as f64 / total as f64, *value);
        bar.set_message(format!("{}  return {:<5}", curve.blocks(), format!("{value:.0}")));
    }

    fn remove(&self, stage: &str) {
        if let Some(row) = lock(&self.rows).remove(stage) {
            row.bar.finish_and_clear();
        }
    }

    fn print(&self, text: &str) {
        // A closed terminal must not stop a training.
        let _ = self.group.println(text);
    }
}

impl Events for Bars {
    fn emit(&self, event: Event) {
        match &event {
            Event::StageStarted { stage, .. } => drop(self.row(stage)),
            Event::Progress { stage, done, total, .. } => self.progress(stage, [*done, *total]),
            Event::Metric { stage, values } => self.measure(stage, values),
            Event::StageFinished { stage, .. } | Event::StageFailed { stage, .. } => self.remove(stage),
            Event::RunFinished { .. } => lock(&self.rows).values().for_each(|row| row.bar.finish_and_clear()),
            Event::Warning { .. } | Event::Note { .. } => {}
        }
        if let Some(text) = told(&event, self.colored) {
            self.print(text.as_str());
        }
    }
}

fn style(template: &str, pace: &Shared) -> ProgressStyle {
    let style = ProgressStyle::with_template(template).expect("the template is constant and valid");
    let (of_speed, of_rest) = (pace.clone(), pace.clone());
    style
        .progress_chars("=> ")
        .with_key("speed", move |_: &ProgressState, line: &mut dyn std::fmt::Write| {
            let rate = lock(&of_speed).and_then(|pace| pace.rate()).unwrap_or(0.0);
            // A line that cannot be formatted is not shown.
            let _ = write!(line, "{:>7}", speed(rate));
        })
        .with_key("left", move |state: &ProgressState, line: &mut dyn std::fmt::Write| {
            let rest = lock(&of_rest).and_then(|pace| pace.left(state.len()?)).unwrap_or(0.0);
            let _ = write!(line, "{:>11}", left(rest));
        })
}

/// A rate in six characters.
fn speed(rate: f64) -> String {
    match rate {
        rate if rate < 9.95 => format!("{rate:.1}/s"),
        rate if rate < 99_999.5 => format!("{rate:.0}/s"),
        rate => format!("{:.0}k/s", rate / 1e3),
    }
}

/// The remaining time, in its largest unit.
fn left(seconds: f64) -> String {
    match seconds {
        s if s < 0.5 => String::new(),
        s if s < 99.5 => format!("{s:.0} s left"),
        s if s < 5970.0 => format!("{:.0} min left", s / 60.0),
        s if s < 360_000.0 => format!("{:.1} h left", s / 3600.0),
        _ => String::new(),
    }
}

/// The name shown for a stage; a learner, the stage that takes longest, is shown by its arm alone.
fn called(stage: &str) -> &str {
    stage.strip_suffix("/learner").unwrap_or(stage)
}

/// Fits a name to this many characters; cuts the middle, because names of arms often differ at the end.
fn fitted(name: &str, width: usize) -> String {
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= width {
        return format!("{name:<width$}");
    }
    let tail = width * 2 / 3;
    let head = width - 1 - tail;
    let text = |letters: &[char]| letters.iter().collect::<String>();
    format!("{}\u{2026}{}", text(&letters[..head]), text(&letters[letters.len() - tail..]))
}

#[cfg(test)]
mod tests {
    use std::io;
    use std::sync::Arc;

    use indicatif::{ProgressDrawTarget, TermLike};

    use super::*;

    /// A terminal that records what is written to it.
    #[derive(Clone, Debug)]
    struct Paper {
        columns: u16,
        written: Arc<Mutex<Vec<String>>>,
    }

    impl TermLike for Paper {
        fn width(&self) -> u16 {
            self.columns
        }

        fn move_cursor_up(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_down(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_right(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_left(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn write_line(&self, text: &str) -> io::Result<()> {
            self.write_str(text)
        }

        fn write_str(&self, text: &str) -> io::Result<()> {
            lock(&self.written).push(text.to_owned());
            Ok(())
        }

        fn clear_line(&self) -> io::Result<()> {
            Ok(())
        }

        fn flush(&self) -> io::Result<()> {
            Ok(())
        }
    }

    /// What a terminal of this width receives during the first half of a training.
    fn shown(columns: u16, name: &str) -> Vec<String> {
        let paper = Paper { columns, written: Arc::default() };
        let group = MultiProgress::with_draw_target(ProgressDrawTarget::term_like(Box::new(paper.clone())));
        let bars = Bars { group, layout: Layout::of(usize::from(columns)), ..Bars::new(false) };
        let stage = name.to_owned();
        for update in 1..=50u64 {
            let (done, note) = (update * 40_000, String::new());
            bars.emit(Event::Progress {
                stage: stage.clone(),
                done,
                total: 4_000_000,
                unit: "samples".into(),
                note,
            });
            let values = BTreeMap::from([("return_mean".to_owned(), update as f64 * 400.0)]);
            bars.emit(Event::Metric { stage: stage.clone(), values });
        }
        let written = lock(&paper.written);
        written.iter().filter(|text| !text.trim().is_empty()).cloned().collect()
    }

    #[test]
    fn a_training_has_one_line_that_fits_the_terminal() {
        for columns in [80, 120] {
            for (name, end) in [
                ("torque/learner", "torque "),
                ("control=position,stiffness=12.5 %,seed=3/learner", "seed=3 "),
            ] {
                let lines = shown(columns, name);
                let fits = |line: &String| line.trim_end().chars().count() <= usize::from(columns);
                assert!(lines.iter().all(fits), "{lines:#?}");
                let last = lines.last().expect("it draws");
                let words = [end, "return 20000", " 50 %", "/s", "\u{2588}\u{b7}"];
                assert!(words.iter().all(|word| last.contains(word)), "{last}");
            }
        }
    }

    #[test]
    fn a_resumed_training_shows_the_rate_of_this_process_only() {
        let paper = Paper { columns: 120, written: Arc::default() };
        let group = MultiProgress::with_draw_target(ProgressDrawTarget::term_like(Box::new(paper.clone())));
        let bars = Bars { group, layout: Layout::of(120), ..Bars::new(false) };
        let report = |done| {
            let (stage, unit, note) = ("torque/learner".into(), "samples".into(), String::new());
            bars.emit(Event::Progress { stage, done, total: 80_000_000, unit, note });
        };
        report(60_000_000);
        std::thread::sleep(Duration::from_millis(400));
        // At most 2500 samples per second, so at least 2 h for the rest; with the checkpoint's, 0.1 s.
        report(60_001_000);
        // Longer than the interval in which the bar draws itself again.
        std::thread::sleep(Duration::from_millis(600));
        let written = lock(&paper.written).join("");
        let last = written.rsplit("torque ").next().expect("it draws").to_owned();
        let rate = last.split("/s").next().and_then(|text| text.split_whitespace().last()).expect("a rate");
        let rate: f64 = rate.parse().expect("a number");
        assert!((500.0..=2500.0).contains(&rate), "{last}");
        assert!(last.contains(" h left"), "{last}");
    }

    #[test]
    fn names_keep_their_ends_and_numbers_their_width() {
        assert_eq!(fitted("learner", 10), "learner   ");
        assert_eq!(fitted("control=torque,seed=1/learner", 16), "contr\u{2026}=1/learner");
        assert_eq!([0.5, 12.3, 4117.0, 250_000.0].map(speed), ["0.5/s", "12/s", "4117/s", "250k/s"]);
        assert_eq!([42.0, 1941.0, 9000.0].map(left), ["42 s left", "32 min left", "2.5 h left"]);
    }
}
