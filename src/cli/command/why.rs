//! `specforge why FILE STAGE`: why a stage would run, down to the field that changed.

use std::path::PathBuf;

use serde_json::json;

use crate::bounded;
use crate::cli::specs::Variant;
use crate::cli::study::{self, Source};
use crate::cli::{Exit, Format, Global, output};
use crate::escape::terminal::one_line;
use crate::exec::Store;
use crate::exec::journal::{CrashLine, Past};
use crate::kinds::fine_tune::{self, FineTuning};
use crate::kinds::learn::Ppo;
use crate::plan::why::{self, Change, State, Status};
use crate::plan::{History, Plan, Selection, Stage};
use crate::spec::Section;

/// Arguments of `why`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// The spec
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The stage: `learner`, `evaluate.nominal`, `ARM/learner`, or digits of its key
    #[arg(value_name = "STAGE")]
    stage: String,
    #[command(flatten)]
    variant: Variant,
}

/// Prints the reasons.
pub fn run(options: &Options, global: &Global) -> Exit {
    let source = Source { files: vec![options.file.clone()], variant: options.variant.clone() };
    let study = match study::read(&source, global) {
        Ok(study) => study,
        Err(exit) => return exit,
    };
    let reports = study.reports();
    let study = match study::settled(study, &reports, global) {
        Ok(settled) => settled.study,
        Err(exit) => return exit,
    };
    let plan = &study.plan;
    let selection = Selection { only: vec![options.stage.clone()], ..Selection::default() };
    if let Err(error) = selection.apply(plan) {
        output::complain(global, &error.to_string(), None);
        return Exit::Usage;
    }
    let store = match study::store(&study, global) {
        Ok(store) => store,
        Err(exit) => return exit,
    };
    let answers: Vec<Answer> =
        plan.find(&options.stage).into_iter().map(|stage| answer(plan, stage, &store)).collect();
    if global.format == Format::Json {
        output::json(&json!({ "stages": answers.iter().map(Answer::json).collect::<Vec<_>>() }));
    } else {
        output::data(
            &answers.iter().map(|answer| answer.text(global.verbose > 0)).collect::<Vec<_>>().join("\n"),
        );
    }
    Exit::Ok
}

/// Why one stage would run.
struct Answer {
    label: String,
    key: String,
    status: Status,
    /// When the current or the earlier artefact was made.
    made: Option<String>,
    /// For a stage that was never made: differences from the most similar artefact of its kind.
    nearest: Option<(String, Vec<Change>)>,
    /// Progress of an interrupted training: samples done and samples in total.
    checkpoint: Option<[u64; 2]>,
    /// Attempts at the stage that ended their process.
    crashes: Vec<CrashLine>,
}

/// Maximum number of differences from the most similar artefact that are listed.
const TOLD: usize = 20;

fn answer(plan: &Plan, stage: &Stage, store: &Store) -> Answer {
    let past = Past::of(store, plan);
    let status = why::status(plan, stage, &past);
    let previous = past.previous(stage);
    let made_at = |stage: &Stage| {
        let manifest = store.manifest(stage.kind, &stage.fingerprint).ok().flatten();
        manifest.map(|manifest| manifest.provenance.finished)
    };
    let made = match status.state {
        State::Cached => made_at(stage),
        State::Changed => previous.as_ref().and_then(|previous| made_at(&previous.stage)),
        State::Missing => None,
    };
    let nearest = previous.filter(|_| status.state == State::Missing).map(|previous| {
        let user = &previous.stage.users[0];
        let changes = why::changes(plan, stage, &previous.stage, &past);
        (format!("{}/{} {}", user.arm, user.stage, previous.stage.fingerprint.short()), changes)
    });
    let (label, key) = (plan.label(stage), stage.fingerprint.to_string());
    let checkpoint = checkpoint(stage, store).filter(|_| status.state != State::Cached);
    let crashes = past.crashes(&stage.fingerprint);
    Answer { label, key, status, made, nearest, checkpoint, crashes }
}

/// Progress of a training whose checkpoint is in the store. Its last metrics may be a few updates ahead of
/// the checkpoint.
fn checkpoint(stage: &Stage, store: &Store) -> Option<[u64; 2]> {
    let scratch = store.root().join("scratch").join(stage.fingerprint.as_str());
    let metrics = bounded::text(&scratch.join("metrics.jsonl"), bounded::RECORD).ok()?;
    let last: serde_json::Value = metrics.lines().rev().find_map(|line| serde_json::from_str(line).ok())?;
    let fields = Section::new(&stage.fields);
    let is_there = scratch.join("checkpoint.safetensors").is_file();
    let end = match fields.within::<FineTuning>() {
        Some(tuning) => tuning.value(fine_tune::Ppo::samples)?,
        None => fields.at(Ppo::samples)?.min(fields.at(Ppo::stop_at).unwrap_or(u64::MAX)),
    };
    is_there.then_some([last["samples"].as_u64()?, end])
}

impl Answer {
    fn json(&self) -> serde_json::Value {
        let nearest =
            self.nearest.as_ref().map(|(name, changes)| json!({ "artefact": name, "changes": changes }));
        json!({
            "stage": self.label,
            "key": self.key,
            "state": self.status.state,
            "changes": self.status.changes,
            "note": self.status.note,
            "made": self.made,
            "nearest": nearest,
            "crashes": self.crashes,
            "checkpoint": self.checkpoint.map(|[done, of]| json!({ "samples": done, "of": of })),
        })
    }

    fn text(&self, verbose: bool) -> String {
        let checkpoint = self.checkpoint.map(|[done, of]| {
            one_line(&format!("It would resume from its checkpoint, at about {done} of {of} samples"))
        });
        let crashes = self.crashes.iter().map(|crash| {
            one_line(&format!("An attempt at it ended its process on {}: {}", crash.time, crash.message))
        });
        self.reason(verbose) + &checkpoint.unwrap_or_default() + &crashes.collect::<String>()
    }

    fn reason(&self, verbose: bool) -> String {
        let label = &self.label;
        let made = self.made.as_ref().map(|made| format!(" on {made}")).unwrap_or_default();
        match self.status.state {
            State::Cached => one_line(&format!("{label} would not run: its artefact was made{made}")),
            State::Changed => {
                one_line(&format!("{label} would run: its inputs changed since its artefact was made{made}"))
                    + &some(&self.status.changes, verbose)
            }
            State::Missing => {
                let note = self.status.note.as_deref().unwrap_or("never made");
                let nearest = self.nearest.iter().map(|(name, changes)| {
                    one_line(&format!("The most similar artefact of its kind is {name}, made with"))
                        + &some(changes, verbose)
                });
                one_line(&format!("{label} would run: {note}")) + &nearest.collect::<String>()
            }
        }
    }
}

/// The differences; only the first if there are many, as another robot is one difference, however long its
/// file. With `--verbose` all of them.
fn some(changes: &[Change], verbose: bool) -> String {
    if verbose {
        return changes.iter().map(change).collect();
    }
    let (robot, others): (Vec<&Change>, Vec<&Change>) =
        changes.iter().partition(|change| change.field.starts_with("robot file: "));
    let mut text: String = others.iter().take(TOLD).map(|other| change(other)).collect();
    match others.len().saturating_sub(TOLD) {
        0 => {}
        more => text += &one_line(&format!("  and {more} more: `--verbose` shows them all")),
    }
    match robot.as_slice() {
        [] => {}
        [only] => text += &change(only),
        many => {
            let count = many.len();
            text +=
                &one_line(&format!("  robot file: {count} figures are others; `--verbose` shows them all"));
        }
    }
    text
}

/// A change with both values and their origins.
fn change(change: &Change) -> String {
    let side = |value: &Option<String>, origin: &Option<String>| {
        let value = value.as_deref().unwrap_or("absent");
        origin.as_ref().map_or_else(|| value.to_owned(), |origin| format!("{value}  ({origin})"))
    };
    let mut text = one_line(&format!("  {}", change.field));
    text += &one_line(&format!("    before: {}", side(&change.from, &change.from_origin)));
    text += &one_line(&format!("    now:    {}", side(&change.to, &change.to_origin)));
    if !change.through.is_empty() {
        text += &one_line(&format!(
            "    through its input {}",
            change.through.join(", and that through its input ")
        ));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_changes_the_first_are_shown_and_the_others_counted() {
        let change = |field: String| Change {
            field,
            from: None,
            to: None,
            from_origin: None,
            to_origin: None,
            through: Vec::new(),
        };
        let robot = (0..1300).map(|index| change(format!("robot file: links.{index}.mass")));
        let changes: Vec<Change> =
            robot.chain((0..30).map(|index| change(format!("reward.term_{index:02}.weight")))).collect();
        let short = some(&changes, false);
        assert!(short.lines().count() < 70, "{}", short.lines().count());
        assert!(short.contains("and 10 more: `--verbose` shows them all"), "{short}");
        assert!(short.contains("robot file: 1300 figures are others"), "{short}");
        let long = some(&changes, true);
        assert!(changes.iter().all(|change| long.contains(&change.field)));
    }
}
