//! `specforge bench FILE`: how fast the spec's training runs on this machine.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use crate::check::Checked;
use crate::cli::specs::{self, Variant};
use crate::cli::{Exit, Global, interruption, output};
use crate::env::Blueprint;
use crate::kinds::motion::{self, clip::Clip};
use crate::kinds::physics::Physics;
use crate::sim::{ENGINES, INSTRUCTIONS};
use crate::spec::Section;
use crate::spec::section::Robot;

/// Arguments of `bench`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// The spec whose robot, engine, rates and learner are measured
    #[arg(value_name = "FILE", default_value = "specs/atlas_run_torque.toml")]
    file: PathBuf,
    /// Another robot than the spec's, by its name
    #[arg(long, value_name = "NAME")]
    robot: Option<String>,
    /// Another engine than the spec's
    #[arg(long, value_name = "NAME", value_parser = clap::builder::PossibleValuesParser::new(ENGINES))]
    engine: Option<String>,
    /// Another physics rate than the spec's, with its unit: `--rate "500 Hz"`
    #[arg(long, value_name = "RATE")]
    rate: Option<String>,
    /// Instruction set of the batch engine [default: the widest of this processor]; its numbers do not depend
    /// on it
    #[arg(long, value_name = "SET", value_parser = clap::builder::PossibleValuesParser::new(INSTRUCTIONS))]
    instructions: Option<String>,
    #[command(flatten)]
    variant: Variant,
    /// Threads [default: the machine's cores]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
}

impl Options {
    /// The spec's variant with the requested robot, engine and rate.
    fn variant(&self) -> Variant {
        let mut variant = self.variant.clone();
        let wishes = [
            (Robot::model.path(), &self.robot),
            (Physics::engine.path(), &self.engine),
            (Physics::rate.path(), &self.rate),
        ];
        let wishes = wishes.into_iter().filter_map(|(path, wish)| Some(format!("{path}={}", wish.as_ref()?)));
        variant.sets.extend(wishes);
        variant
    }
}

/// Measures and prints the speed.
pub fn run(options: &Options, global: &Global) -> Exit {
    // Nothing in it is kept, so the command may end at any time.
    let scratch: Arc<OnceLock<PathBuf>> = Arc::default();
    let left = scratch.clone();
    let leave = move || {
        if let Some(folder) = left.get() {
            let _ = std::fs::remove_dir_all(folder);
        }
    };
    if let Err(exit) = interruption::listen(global, leave) {
        return exit;
    }
    let checked = match specs::require(&options.file, &options.variant(), global) {
        Ok(checked) => checked,
        Err(exit) => return exit,
    };
    match blueprint(&checked).and_then(|blueprint| measured(options, &checked, &blueprint, &scratch, global))
    {
        Ok(()) => Exit::Ok,
        Err(message) => {
            output::complain(global, &message, None);
            Exit::StageFailed
        }
    }
}

/// The environment of a checked spec.
fn blueprint(checked: &Checked) -> Result<Blueprint, String> {
    let (experiment, robot) = checked.sound().ok_or("the spec has errors")?;
    let motion = match (&checked.motion, &experiment.motion) {
        (Some(table), Some(file)) => {
            let table = Section::new(table);
            Some(
                motion::build(&file.name, table, robot, table.value(Clip::TEXT).as_deref())
                    .map_err(|error| error.to_string())?,
            )
        }
        _ => None,
    };
    Blueprint::new(experiment.table.clone(), robot.clone(), motion).map_err(|error| error.to_string())
}

fn measured(
    options: &Options,
    checked: &Checked,
    blueprint: &Blueprint,
    place: &OnceLock<PathBuf>,
    global: &Global,
) -> Result<(), String> {
    use crate::cli::Format;
    use crate::exec::speed;
    use crate::learn::Settings;
    use crate::sim;

    let experiment = checked.experiment.as_ref().ok_or("the spec has errors")?;
    let learn = Section::new(&experiment.table).part().ok_or("the spec has no section [learn]")?;
    let settings = Settings::new(&learn, blueprint.deviations(), 1.0 / blueprint.control_rate());
    let threads =
        options.jobs.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    let engine = match options.instructions.as_deref() {
        None => sim::open(blueprint.engine()),
        Some(set) if blueprint.engine() == "batch" => sim::batch_under(set),
        Some(_) => {
            return Err(format!("--instructions is for the engine batch; this is {}", blueprint.engine()));
        }
    };
    let engine = engine.map_err(|error| error.to_string())?;
    let scratch = tempfile::tempdir().map_err(|error| format!("no temporary folder: {error}"))?;
    let _ = place.set(scratch.path().to_owned());
    output::note(global, "measuring a few updates; nothing else should run on this machine meanwhile");
    let speed = speed::measure(blueprint, engine, settings, scratch.path(), threads);
    let speed = speed.map_err(|error| error.to_string())?;
    if global.format == Format::Json {
        output::json(&serde_json::to_value(&speed).expect("figures are plain data"));
        return Ok(());
    }
    let conditions = &speed.settings;
    let part = &speed.rollout;
    let rows = [
        (
            "physics",
            format!(
                "{:.2} us of CPU per step on level ground, {:.2} times the engine called directly ({:.2} us)",
                speed.physics_us_per_step,
                speed.physics_us_per_step / speed.engine_us_per_step,
                speed.engine_us_per_step,
            ),
        ),
        (
            "",
            format!("{:.2} us of the engine while the robot follows its reference", speed.moving_us_per_step),
        ),
        (
            "rollout",
            format!(
                "{:.1} us of CPU per sample, {:.1} % of it physics:",
                part.total,
                100.0 * part.physics_share
            ),
        ),
        (
            "",
            format!(
                "steps {:.1}, states and contacts {:.1}, new worlds {:.1}; policy, controller and reward \
                 {:.1}",
                part.step, part.look, part.build, part.rest
            ),
        ),
        ("", format!("of that policy {:.1}, self-collision {:.1}", part.policy, part.self_collision)),
        ("values", format!("{:.1} us of CPU per sample, with the advantages, after the steps", part.values)),
        (
            "threads",
            format!(
                "{:.0} samples/s in rollouts on {}, {:.2} times one thread",
                speed.rollout_samples_per_s, speed.threads, speed.rollout_scaling
            ),
        ),
        ("learner", format!("{:.1} us of CPU per sample", speed.learner_us_per_sample)),
        (
            "all together",
            format!(
                "{:.0} samples/s, {:.1} us of CPU per sample",
                speed.samples_per_s, speed.cpu_us_per_sample
            ),
        ),
        ("peak memory", format!("{:.0} MB", speed.peak_memory_mb)),
    ];
    let mut text = format!(
        "{} in {} (worlds advanced together: {}), physics at {} Hz, control at {} Hz, {} environments, {} \
         threads,\n\
         {} samples per update in minibatches of {}, {} epochs\n\n",
        speed.robot,
        speed.engine,
        speed.lanes,
        conditions.physics_rate,
        conditions.control_rate,
        conditions.environments,
        speed.threads,
        conditions.rollout,
        conditions.minibatch,
        conditions.epochs,
    );
    for (name, figure) in rows {
        text += &format!("  {name:<14} {figure}\n");
    }
    text += &scaling(&speed.scaling);
    output::data(text.trim_end());
    Ok(())
}

/// The speed-up by threads, as a table.
fn scaling(scaling: &crate::exec::speed::Scaling) -> String {
    let parts = &scaling.parts;
    let mut text = format!(
        "\n  on one thread {:.1} us of rollout, {:.1} of actor, {:.1} of critic and {:.1} of the rest per \
         sample; samples/s:\n\
         {:>9} {:>12} {:>9}\n",
        parts.rollout, parts.actor, parts.critic, parts.serial, "threads", "undisturbed", "measured"
    );
    for row in &scaling.rows {
        text += &format!("{:>9} {:>12.0} {:>9.0}\n", row.threads, row.undisturbed, row.measured);
    }
    text + "  undisturbed: by the CPU time of the thread that the others wait for; measured: by the wall \
        clock\n"
}
