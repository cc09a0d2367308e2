//! W0523: values within a key's range but so small or large that what they configure does nothing, or ends
//! every episode at once.
//!
//! Each bound is at least ten times away from the values of the shipped specs.

use std::f64::consts::{PI, TAU};

use super::Subject;
use super::odd::Odd;
use super::scheduled::is_inherited;
use super::subject::{duration, short};
use crate::diag::Sink;
use crate::kinds::evaluate::{Episodes, Evaluation, Speeds};
use crate::kinds::learn::Ppo;
use crate::kinds::learn::ppo::{Critic, LearningRate};
use crate::kinds::observe::Observations;
use crate::kinds::observe::joint_velocity::JointVelocity;
use crate::kinds::reward::Rewards;
use crate::kinds::task::{Command, Walk};
use crate::kinds::terminate::Terminations;
use crate::kinds::terminate::base_height::BaseHeight;
use crate::kinds::terminate::base_tilt::BaseTilt;
use crate::kinds::terminate::contact_schedule::ContactSchedule;
use crate::kinds::terminate::joint_error::JointError;
use crate::kinds::terrain::flat::Flat;
use crate::kinds::{evaluate, fine_tune, task};
use crate::robot::{GRAVITY, hip_height};
use crate::spec::Value;
use crate::spec::typed::Part;

/// An inspected observation: the largest raw value that must not be cut off by `clip`, and the smallest that
/// must not vanish in `scale`.
struct Seen {
    kind: &'static str,
    /// Values up to this occur in every step.
    usual: f64,
    /// No value exceeds this.
    most: f64,
    unit: &'static str,
}

const SEEN: [Seen; 5] = [
    Seen { kind: "base_orientation", usual: 0.01, most: PI, unit: "rad" },
    Seen { kind: "joint_position", usual: 0.02, most: PI, unit: "rad" },
    Seen { kind: "joint_velocity", usual: 0.05, most: 40.0, unit: "rad/s" },
    Seen { kind: "command", usual: 0.01, most: 10.0, unit: "m/s" },
    Seen { kind: "phase", usual: 0.5, most: 1.0, unit: "(sine and cosine)" },
];

/// Share of the range of a normalised input below which the policy cannot make anything of it.
const FAINT: f64 = 1e-2;

/// The error that a reward term measures: `slight` is never undercut, `gross` never exceeded by a robot that
/// does its task.
struct Kernel {
    kind: &'static str,
    slight: f64,
    gross: f64,
}

const KERNELS: [Kernel; 10] = [
    Kernel { kind: "base_orientation", slight: 1e-2, gross: 1.0 },
    Kernel { kind: "joint_tracking", slight: 1e-2, gross: 10.0 },
    Kernel { kind: "velocity_tracking", slight: 1e-3, gross: 1.0 },
    Kernel { kind: "mean_velocity_tracking", slight: 1e-3, gross: 1.0 },
    Kernel { kind: "joint_velocity", slight: 0.1, gross: 100.0 },
    Kernel { kind: "joint_velocity_change", slight: 1e-3, gross: 10.0 },
    Kernel { kind: "contact_force", slight: 20.0, gross: 5000.0 },
    Kernel { kind: "contact_force_change", slight: 20.0, gross: 5000.0 },
    Kernel { kind: "torque", slight: 1.0, gross: 1000.0 },
    Kernel { kind: "torque_change", slight: 0.1, gross: 1000.0 },
];

/// Cut-off frequency in Hz below which a filter follows no step of a walk.
const SLOWEST_FILTER: f64 = 0.1;
/// Friction coefficient on which no robot can walk; wet ice has 0.05.
const SLIPPERY: f64 = 0.03;
/// The norm to which gradients are usually clipped.
const USUAL_NORM: f64 = 0.5;
/// Product of `k` and the gross error below which a term is paid in full.
const PAID: f64 = 0.05;
/// Clip in scales of an observation below which the usual values of a step are cut off.
const CLIPPED: f64 = 0.3;
/// Tilt in rad at which a robot lies on the ground.
const FALLEN: f64 = 1.6;
/// Joint error in rad that no robot on its feet has.
const ASTRAY: f64 = 2.5;
/// Tilt in rad that every standing robot has.
const SWAY: f64 = 0.01;
/// Joint error in rad that every moving robot has.
const LAG: f64 = 0.01;
/// Share of the standing height at which a robot lies on the ground.
const LYING: f64 = 0.1;
/// Adam's step size below which no weight moves in a training.
const FROZEN: f64 = 1e-8;
/// Adam's step size above which networks diverge.
const DIVERGING: f64 = 0.1;
/// Exploration in shares of the action range below which advantages are rounding errors.
const SILENT: f64 = 1e-4;
/// Discount per step below which only the next reward counts.
const BLIND: f64 = 0.5;
/// Froude number (v^2 / g L) of the fastest runners; walking ends at 1.
const FASTEST: f64 = 9.0;
/// The same for a walk, which has no flight phase.
const WALKING: f64 = 1.0;

/// Every value has an effect.
pub fn values_have_an_effect(subject: &Subject, sink: &mut Sink) {
    let mut said = Odd { subject, sink };
    observations(&mut said);
    kernels(&mut said);
    terminations(&mut said);
    grounds(&mut said);
    learning(&mut said);
    commands(&mut said);
    speeds(&mut said);
}

impl Odd<'_, '_> {
    fn written(&self, path: &str) -> String {
        self.subject.written(path)
    }
}

/// The numbers of a key that is a number or a list of numbers.
fn numbers(subject: &Subject, path: &str) -> Vec<f64> {
    let number = |value: &Value| match value {
        Value::Quantity(quantity) => Some(quantity.si),
        Value::Count(count) => Some(*count as f64),
        _ => None,
    };
    match subject.value(path) {
        Some(Value::List(items)) => items.iter().filter_map(number).collect(),
        Some(value) => number(value).into_iter().collect(),
        None => Vec::new(),
    }
}

fn observations(said: &mut Odd) {
    let subject = said.subject;
    for (path, term) in subject.terms::<Observations>() {
        let Some(seen) = SEEN.iter().find(|seen| term.kind() == Some(seen.kind)) else { continue };
        let (scale_key, clip) =
            (format!("{path}.scale"), subject.number(&format!("{path}.clip")).unwrap_or(8.0));
        let scales = numbers(subject, &scale_key);
        let help = "write the value that the input has in a usual step; the policy sees value / scale";
        if let Some(scale) = scales.iter().find(|scale| **scale * clip < seen.usual) {
            let message = format!(
                "`{path}` is cut off: with a scale of {} {} every value above {} {} is {} for the policy",
                short(*scale),
                seen.unit,
                short(scale * clip),
                seen.unit,
                short(clip)
            );
            said.warn(&scale_key, message, help);
        } else if let Some(scale) = scales.iter().find(|scale| seen.most / **scale < FAINT) {
            let message = format!(
                "`{path}` is nearly constant: with a scale of {} {} no input exceeds {}",
                short(*scale),
                seen.unit,
                short(seen.most / scale)
            );
            said.warn(&scale_key, message, help);
        } else if clip < CLIPPED {
            let message = format!(
                "`{path}` is cut off: its clip of {} is a fraction of the value that a usual step has, 1 scale",
                short(clip)
            );
            said.warn(&format!("{path}.clip"), message, "write a clip of several scales, such as 8");
        }
        let Some(cutoff) = term.value(JointVelocity::low_pass).filter(|_| term.is::<JointVelocity>()) else {
            continue;
        };
        let key = JointVelocity::low_pass.below(&path);
        if cutoff < SLOWEST_FILTER {
            let message = format!(
                "the filter of `{path}` hides the velocities: its time constant is {}",
                duration((1e3 / (TAU * cutoff)).round() / 1e3)
            );
            said.warn(&key, message, "write a cut-off above the motion's frequency, for example \"4 Hz\"");
        } else if let Some(rate) =
            subject.physics_step().map(|step| 1.0 / step).filter(|rate| cutoff >= *rate)
        {
            let message = format!(
                "the filter of `{path}` changes nothing: it samples at {} Hz, its cut-off is {} Hz",
                short(rate),
                short(cutoff)
            );
            said.warn(&key, message, "write a lower cut-off, or remove `low_pass`");
        }
    }
}

fn kernels(said: &mut Odd) {
    for (path, term) in said.subject.terms::<Rewards>() {
        let Some(kernel) = KERNELS.iter().find(|kernel| term.kind() == Some(kernel.kind)) else { continue };
        let key = format!("{path}.k");
        let Some(k) = said.subject.number(&key) else { continue };
        let help = "write about one over the error at which the term should have fallen to 37 %";
        if k * kernel.gross < PAID {
            let message =
                format!("`{path}` is always paid in full: its `k` ({}) is too small", said.written(&key));
            said.warn(&key, message, help);
        } else if k * kernel.slight > 5.0 {
            let message = format!("`{path}` is never paid: its `k` ({}) is too large", said.written(&key));
            said.warn(&key, message, help);
        }
    }
}

fn terminations(said: &mut Odd) {
    for (path, term) in said.subject.terms::<Terminations>() {
        if term.is::<BaseTilt>() {
            let key = BaseTilt::above.below(&path);
            bounded(said, &path, &key, [SWAY, FALLEN], "write an angle such as \"1 rad\"");
        } else if term.is::<JointError>() {
            let key = JointError::above.below(&path);
            bounded(said, &path, &key, [LAG, ASTRAY], "write an angle such as \"0.5 rad\"");
        } else if term.is::<ContactSchedule>() {
            let key = ContactSchedule::tolerance.below(&path);
            bounded(said, &path, &key, [1e-3, 1.0], "write a share of the cycle such as \"15 %\"");
        } else if term.is::<BaseHeight>() {
            let key = BaseHeight::below.below(&path);
            let Some((robot, below)) = said.subject.robot.zip(said.subject.number(&key)) else { continue };
            if below < LYING * robot.standing_height {
                let message = format!(
                    "`{path}` never ends an episode: a robot that lies on the ground is above {}",
                    said.written(&key)
                );
                let help = format!("write about \"{:.2} m\"", 0.65 * robot.standing_height);
                said.warn(&key, message, &help);
            }
        }
    }
}

/// A limit that is exceeded at once, or never.
fn bounded(said: &mut Odd, path: &str, key: &str, [least, most]: [f64; 2], help: &str) {
    let Some(limit) = said.subject.number(key) else { return };
    let written = said.written(key);
    if limit < least {
        said.warn(key, format!("`{path}` ends every episode at once: its limit is {written}"), help);
    } else if limit >= most {
        said.warn(key, format!("`{path}` never ends an episode: its limit is {written}"), help);
    }
}

fn grounds(said: &mut Odd) {
    for path in said.subject.grounds() {
        let key = Flat::friction.below(&path);
        if said.subject.number(&key).is_some_and(|friction| friction < SLIPPERY) {
            let message = format!("`{path}` has the friction {}: no robot can push off", said.written(&key));
            said.warn(&key, message, "write a coefficient such as 1.0; wet ice has 0.05");
        }
    }
}

/// The step sizes of a rate: its path and its largest value.
fn largest(rate: Option<LearningRate>) -> Option<f64> {
    Some(match rate? {
        LearningRate::Constant(rate) => rate,
        LearningRate::Linear(linear) => linear.linear.into_iter().fold(0.0, f64::max),
        LearningRate::Steered(steered) => steered.start,
    })
}

fn learning(said: &mut Odd) {
    let subject = said.subject;
    if subject.at(Ppo::samples).is_none_or(|samples| samples == 0) {
        return;
    }
    let critic = Critic::learning_rate.below(&Ppo::value.path());
    let rates = [
        (Ppo::learning_rate.path(), largest(subject.at(Ppo::learning_rate)), "actor"),
        (fine_tune::Ppo::learning_rate.path(), largest(subject.at(fine_tune::Ppo::learning_rate)), "actor"),
        (critic.clone(), subject.number(&critic), "critic"),
    ];
    for (key, rate, network) in rates {
        let Some(rate) = rate else { continue };
        if rate < FROZEN {
            let message = format!("the {network} does not learn: its step size is {}", short(rate));
            said.warn(&key, message, "write a step size such as 1e-4");
        } else if rate > DIVERGING {
            let message = format!("the {network} diverges with a step size of {}", short(rate));
            said.warn(&key, message, "write a step size such as 1e-4");
        }
    }
    let (norm, epsilon) = (subject.at(Ppo::max_grad_norm), subject.at(Ppo::adam_epsilon));
    if let Some((norm, epsilon)) = norm.zip(epsilon).filter(|(norm, epsilon)| *norm < 10.0 * epsilon) {
        let message = format!(
            "the networks hardly learn: gradients are clipped to {}, and Adam's epsilon is {}, so steps shrink to \
             {} % of the step size",
            short(norm),
            short(epsilon),
            short(100.0 * norm / (norm + epsilon))
        );
        // The advice must not lead to the same warning.
        let (key, help) = match 10.0 * epsilon > USUAL_NORM {
            true => (Ppo::adam_epsilon.path(), "write an `adam_epsilon` such as 1e-5"),
            false => (Ppo::max_grad_norm.path(), "write a `max_grad_norm` such as 0.5"),
        };
        said.warn(&key, message, help);
    }
    let (time, step) = (subject.at(Ppo::discount_time), subject.control_step());
    let gamma = match time.zip(step) {
        Some((time, step)) => Some((Ppo::discount_time.path(), libm::exp(-step / time))),
        None => subject.at(Ppo::gamma).map(|gamma| (Ppo::gamma.path(), gamma)),
    };
    if let Some((key, gamma)) = gamma.filter(|(_, gamma)| *gamma < BLIND) {
        let message =
            format!("rewards beyond the next step hardly count: the discount per step is {}", short(gamma));
        let help = if key == Ppo::gamma.path() {
            "write a discount such as 0.99"
        } else {
            "write a horizon of many control steps, such as \"1 s\""
        };
        said.warn(&key, message, help);
    }
    for key in [crate::kinds::action::Position::std.path(), fine_tune::Ppo::std.path()] {
        if subject.number(&key).is_some_and(|std| std < SILENT) {
            let message =
                format!("the policy does not explore: its standard deviation is {}", said.written(&key));
            said.warn(&key, message, "the paper explores with 1 % to 20 %");
        }
    }
}

/// A command is reached before the next one, and its ramp has something to lead to.
fn commands(said: &mut Odd) {
    let subject = said.subject;
    let table = Walk::command.path();
    let [every_key, ramp_key] = [Command::every.below(&table), Command::ramp.below(&table)];
    let Some(ramp) = subject.number(&ramp_key).filter(|ramp| *ramp > 0.0) else { return };
    let episode = subject.number(&Walk::episode.path()).unwrap_or(f64::INFINITY);
    match subject.number(&every_key) {
        Some(every) if ramp > every => {
            let message = format!(
                "no command is reached: a new one comes every {}, and its ramp takes {}",
                duration(every),
                duration(ramp)
            );
            said.warn(&ramp_key, message, "write a ramp shorter than `every`");
        }
        Some(every) if every < episode => {}
        _ if is_inherited(subject, &ramp_key, &Walk::episode.path()) => {}
        _ => {
            let message =
                format!("`{ramp_key}` has no effect: an episode has one command, with which it starts");
            said.warn(&ramp_key, message, "write an `every` shorter than the episode, or a ramp of \"0 s\"");
        }
    }
}

/// No command is beyond what legs of this length can do.
fn speeds(said: &mut Odd) {
    let subject = said.subject;
    let Some(robot) = subject.robot else { return };
    let leg = hip_height(robot).max(1e-3);
    let walks = subject.spec().within::<task::Task>().is_some_and(|task| task.is::<Walk>());
    let trained = Command::speed.below(&Walk::command.path());
    let own = task::Task::commanded(subject.spec()).map(|command| command.speed.bounds());
    let mut commands: Vec<(String, f64, bool)> = Vec::new();
    commands.extend(own.map(|[low, high]| (trained, low.abs().max(high.abs()), walks)));
    for (path, table) in subject.protocols() {
        let own = Episodes::command.below(&path);
        let key = evaluate::Command::speed.below(&own);
        commands.extend(subject.number(&key).map(|speed| (key, speed.abs(), false)));
        if let (true, Some(Evaluation::Speeds(speeds))) =
            (table.is::<Speeds>(), Evaluation::of_section(table))
        {
            let fastest = speeds.grid().into_iter().map(f64::abs).reduce(f64::max);
            let key =
                if subject.value(&Speeds::to.below(&path)).is_some() { Speeds::to } else { Speeds::from };
            commands.extend(fastest.map(|speed| (key.below(&path), speed, false)));
        }
    }
    for (key, speed, walks) in commands {
        let froude = speed * speed / (GRAVITY * leg);
        let most = if walks { WALKING } else { FASTEST };
        if froude <= most {
            continue;
        }
        let fastest = (most * GRAVITY * leg).sqrt();
        let gait = if walks { "a walk" } else { "a run" };
        let message = format!(
            "{} m/s is faster than {gait} of `{}`, whose hips are {} m high, can be: at most {} m/s",
            short(speed),
            robot.name,
            short(leg),
            short(fastest)
        );
        let help = if walks { "write a lower speed, or `kind = \"run\"`" } else { "write a lower speed" };
        said.warn(&key, message, help);
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::{found, values};
    use super::*;
    use crate::robot::tests::robot;

    fn table(text: &str, sound: &[&str], odd: &[(&str, &str)]) {
        values(values_have_an_effect, text, sound, odd);
    }

    #[test]
    fn scales_and_filters_that_hide_an_observation_are_told() {
        let text = "[observe.velocity]\nkind = \"joint_velocity\"\nclip = 8.0\nscale = [0.5, 1.0, {}]";
        table(text, &["0.135", "0.01"], &[("1e-9", "is cut off"), ("1e6", "is nearly constant")]);
        let text = "[observe.position]\nkind = \"joint_position\"\nclip = {}\nscale = [0.15, 0.1, 0.2]";
        table(text, &["8.0", "0.5"], &[("0.001", "is cut off"), ("0.2", "is cut off")]);
        let text = "[observe.phase]\nkind = \"phase\"\nclip = {}\nscale = 0.7";
        table(text, &["8.0", "1.0"], &[("0.1", "is cut off")]);
        let text = "[observe.command]\nkind = \"command\"\nclip = {}";
        table(text, &["8.0", "1.0"], &[("0.01", "is cut off"), ("0.2", "is cut off")]);
        let text = "physics = { rate = 500.0 }\n[observe.velocity]\nkind = \"joint_velocity\"\nlow_pass = {}";
        table(text, &["4.0", "100.0"], &[("0.001", "hides the velocities"), ("500.0", "changes nothing")]);
    }

    #[test]
    fn reward_terms_that_are_always_or_never_paid_are_told() {
        for (kind, usual, small, large) in [
            ("base_orientation", "13.2", "0.01", "1000.0"),
            ("contact_force", "0.0005", "1e-6", "1.0"),
            ("contact_force_change", "0.0005", "1e-6", "1.0"),
            ("joint_tracking", "16.0", "0.001", "1000.0"),
            ("joint_velocity", "0.01", "1e-4", "100.0"),
            ("joint_velocity_change", "20.0", "0.001", "1e4"),
            ("mean_velocity_tracking", "300.0", "0.01", "1e4"),
            ("torque", "0.01", "1e-5", "10.0"),
            ("torque_change", "0.01", "1e-5", "100.0"),
            ("velocity_tracking", "40.0", "0.01", "1e4"),
        ] {
            let text = format!("[reward.term]\nkind = \"{kind}\"\nweight = 0.3\nk = {{}}");
            let odd = [(small, "always paid in full"), (large, "is never paid"), ("1e-9", "always paid")];
            table(&text, &[usual], &odd);
        }
    }

    #[test]
    fn terminations_that_end_everything_or_nothing_are_told() {
        let at_once = "ends every episode at once";
        let never = "never ends an episode";
        let text = "[terminate.base_tilt]\nkind = \"base_tilt\"\nabove = {}";
        table(text, &["0.1", "1.0"], &[("0.0001", at_once), ("3.1", never), ("1.7", never)]);
        let text = "[terminate.joint_error]\nkind = \"joint_error\"\nabove = {}";
        table(text, &["0.5"], &[("1e-6", at_once), ("3.0", never)]);
        let text = "[terminate.contact_schedule]\nkind = \"contact_schedule\"\ntolerance = {}";
        table(text, &["0.15"], &[("1e-6", at_once), ("1.0", never)]);
        let text = "[terminate.base_height]\nkind = \"base_height\"\nbelow = {}";
        table(text, &["0.6", "0.3"], &[("0.001", never)]);
    }

    #[test]
    fn a_ground_without_friction_is_told_wherever_it_is() {
        table(
            "terrain = { kind = \"flat\", friction = {} }",
            &["1.0", "0.2"],
            &[("0.0", "no robot can push off")],
        );
        let text = "evaluate.ice.terrain = { kind = \"flat\", friction = {} }";
        table(text, &["0.05"], &[("0.001", "no robot can push off")]);
    }

    #[test]
    fn learners_that_do_not_learn_are_told() {
        let text = "[learn]\nsamples = 1000000\nlearning_rate = {}";
        let still = "the actor does not learn";
        let odd = [
            ("0.0", still),
            ("{ linear = [0.0, 0.0, 0.0] }", still),
            ("{ kl_target = 0.02, start = 0.0 }", still),
            ("1.0", "the actor diverges"),
        ];
        table(text, &["5e-5", "{ kl_target = 0.02, start = 8e-5 }"], &odd);
        table("[learn]\nsamples = 0\nlearning_rate = {}", &["0.0"], &[]);
        let text = "[learn]\nsamples = 1000000\nvalue = { learning_rate = {} }";
        table(text, &["5e-4"], &[("0.0", "the critic does not learn")]);
        let text = "[learn]\nsamples = 1000000\nadam_epsilon = 1e-5\nmax_grad_norm = {}";
        table(text, &["0.5", "0.001"], &[("1e-9", "the networks hardly learn")]);
        table("[learn]\nsamples = 1000000\ngamma = {}", &["0.99"], &[("0.1", "hardly count")]);
        let text = "[learn]\nsamples = 1000000\ndiscount_time = {}\n[action]\nrate = 125.0";
        table(text, &["1.0"], &[("0.0001", "hardly count")]);
        table(
            "learn.samples = 1000000\naction.std = {}",
            &["0.0025", "0.1"],
            &[("1e-6", "does not explore")],
        );
    }

    #[test]
    fn following_the_advice_for_discounts_and_gradients_removes_the_warning() {
        let tocabi = robot("tocabi");
        let help = |text: &str| {
            let found = found(values_have_an_effect, text, Some(&tocabi));
            found.into_iter().flat_map(|found| found.help).collect::<Vec<_>>()
        };
        let rated = |line: &str| format!("[learn]\nsamples = 1000000\n{line}\n[action]\nrate = 125.0");
        assert_eq!(help(&rated("gamma = 0.1")), ["write a discount such as 0.99"]);
        let horizon = help(&rated("discount_time = 0.001"));
        assert!(horizon.len() == 1 && horizon[0].contains("\"1 s\""), "{horizon:?}");
        assert_eq!(help(&rated("discount_time = 1.0")), [""; 0]);
        let steps = help(&rated("adam_epsilon = 0.1\nmax_grad_norm = 0.001"));
        assert_eq!(steps, ["write an `adam_epsilon` such as 1e-5"]);
        assert_eq!(help(&rated("adam_epsilon = 1e-5\nmax_grad_norm = 0.001")), [""; 0]);
        assert_eq!(
            help(&rated("adam_epsilon = 1e-5\nmax_grad_norm = 1e-5")),
            ["write a `max_grad_norm` such as 0.5"]
        );
    }

    #[test]
    fn commands_beyond_the_legs_and_ramps_without_an_end_are_told() {
        let walk = |command: &str| {
            format!(
                "task = {{ kind = \"walk\", motion = \"walk\", episode = 16.0, command = {{ {command} }} }}"
            )
        };
        table(
            &walk("speed = {}"),
            &["0.5", "-0.3"],
            &[("9.0", "is faster than a walk"), ("3.0", "than a walk")],
        );
        let run = walk("speed = {}").replace("kind = \"walk\"", "kind = \"run\"");
        table(&run, &["3.0"], &[("9.0", "is faster than a run")]);
        let text = "evaluate.fast = { kind = \"episodes\", command = { speed = {} } }";
        table(text, &["2.0"], &[("9.9", "is faster than a run")]);
        let ramp = walk("speed = 0.5, every = 4.0, ramp = {}");
        table(&ramp, &["0.0", "1.0", "4.0"], &[("4.5", "no command is reached")]);
        table(&walk("speed = 0.5, ramp = {}"), &["0.0"], &[("1.0", "has no effect")]);
        table(&walk("speed = 0.5, every = 16.0, ramp = {}"), &["0.0"], &[("1.0", "has no effect")]);
    }
}
