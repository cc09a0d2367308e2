//! E0512: scheduled events after the end of the episode or of their interval, which never happen.

use std::cmp::Reverse;

use super::Subject;
use super::subject::duration;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::deploy::Deployment;
use crate::kinds::evaluate::{Episodes, Evaluation, Setting, Spread};
use crate::kinds::randomize::Rows;
use crate::kinds::randomize::push::Pushes;
use crate::kinds::task::{Command, Task, Walk};
use crate::kinds::terminate::Terminations;
use crate::kinds::terminate::contact_schedule::ContactSchedule;
use crate::kinds::terrain::Ground;
use crate::kinds::terrain::box_obstacle::{BoxObstacle, Measured};
use crate::kinds::terrain::height_field::HeightField;
use crate::robot::hip_height;
use crate::spec::typed::{InSection, Part};
use crate::spec::{Mark, Sampler, Section};
use crate::syntax::Layer;

/// Factor on the commanded distance within which an obstacle counts as reachable: policies overshoot.
const OVERSHOOT: f64 = 1.15;
/// Length of a step relative to the height of the hips.
const STEP: f64 = 0.5;
/// Relative slack of comparisons of times.
const SLACK: f64 = 1e-9;

/// The time limit of episodes, and the key that states it.
#[derive(Clone, Debug)]
struct Limit {
    seconds: f64,
    key: String,
}

/// Pushes, command changes, obstacles and graces happen before the episode ends.
pub fn events_are_within_the_episode(subject: &Subject, sink: &mut Sink) {
    let Some(trained) = limit(subject, None) else { return };
    for (path, row) in rows(subject, Rows::SECTION) {
        push(subject, &path, row, &trained, sink);
    }
    for (path, table) in subject.protocols() {
        evaluated_pushes(subject, &path, table, &trained, sink);
    }
    changes(subject, &trained, sink);
    graces(subject, &trained, sink);
    let own = |path: &str| path.strip_suffix(&format!(".{}", Ground::SECTION)).map(str::to_owned);
    for path in subject.grounds() {
        let protocol = own(&path);
        let protocol =
            protocol.and_then(|own| subject.protocols().into_iter().find(|(path, _)| *path == own));
        let protocol = protocol.as_ref().map(|(path, table)| (path.as_str(), *table));
        ground(subject, &path, protocol, sink);
    }
}

/// The events of the evaluation at this path happen before its episodes end; those of the training are not
/// checked.
pub(super) fn evaluated_events_are_within_the_episode(subject: &Subject, path: &str, sink: &mut Sink) {
    let (Some(trained), Some(table)) = (limit(subject, None), subject.section(path)) else { return };
    evaluated_pushes(subject, path, table, &trained, sink);
    ground(subject, &Setting::terrain.below(path), Some((path, table)), sink);
}

/// The pushes of an evaluation: its own, or those of the training.
fn evaluated_pushes(subject: &Subject, path: &str, table: Section, trained: &Limit, sink: &mut Sink) {
    let Some(own) = limit(subject, Some((path, table))) else { return };
    for (path, row) in own_rows(subject, path) {
        push(subject, &path, row, &own, sink);
    }
    // The training's pushes in a shorter episode; those that the training lacks, too, are reported there.
    if repeats_training(subject, path) && own.seconds < trained.seconds {
        for (path, row) in rows(subject, Rows::SECTION) {
            let mut within = Sink::default();
            push(subject, &path, row, trained, &mut within);
            if within.diagnostics.is_empty() {
                push(subject, &path, row, &own, sink);
            }
        }
    }
}

/// The pushes of an evaluation's own table of randomizations.
fn own_rows<'a>(subject: &Subject<'a>, protocol: &str) -> Vec<(String, Section<'a>)> {
    rows(subject, &Spread::randomize.below(protocol))
}

/// Whether an evaluation has the randomization of the training.
fn repeats_training(subject: &Subject, protocol: &str) -> bool {
    matches!(subject.value(&Spread::randomize.below(protocol)), Some(crate::spec::Value::Flag(true)))
}

/// The time limit of the training (`None`) or of a protocol: its own, that of `evaluate.nominal` for a
/// transfer, or `task.episode`.
fn limit(subject: &Subject, protocol: Option<(&str, Section)>) -> Option<Limit> {
    let at = |key: String| subject.number(&key).map(|seconds| Limit { seconds, key });
    let own = protocol.and_then(|(path, _)| at(Setting::time_limit.below(path)));
    let transfer = protocol.is_some_and(|(path, _)| path.split('.').next() == Some(Deployment::SECTION));
    let nominal = || at(Setting::time_limit.below(&format!("{}.nominal", Evaluation::SECTION)));
    own.or_else(|| transfer.then(nominal).flatten()).or_else(|| at(Walk::episode.path()))
}

/// The pushes of a table of randomizations.
fn rows<'a>(subject: &Subject<'a>, table: &str) -> Vec<(String, Section<'a>)> {
    let Some(rows) = subject.section(table) else { return Vec::new() };
    let named = rows.sections().map(|(name, row)| (format!("{table}.{name}"), row));
    named.filter(|(_, row)| row.is::<Pushes>()).collect()
}

/// A push begins and ends within its interval and the episode.
fn push(subject: &Subject, path: &str, row: Section, limit: &Limit, sink: &mut Sink) {
    let every = row.value(Pushes::every);
    let at = row.value(Pushes::at);
    let length = row.value(Pushes::duration).map(|length: Sampler| length.bounds());
    let [every_key, at_key, length_key] =
        [Pushes::every.below(path), Pushes::at.below(path), Pushes::duration.below(path)];
    let Limit { seconds: episode, key: end } = limit;
    if let Some(every) = every.filter(|every| *every > episode * (1.0 + SLACK)) {
        let message = format!(
            "`{every_key}` ({}) is longer than the episode (`{end}`, {}): the only push may come after its end",
            duration(every),
            duration(*episode)
        );
        let help =
            format!("write at most \"{}\", or remove `every` for one push per episode", duration(*episode));
        return report(subject, [&every_key, end], message, &help, sink);
    }
    // Without `every` the interval is the episode.
    let (interval, bound) = match every.filter(|every| *every < *episode) {
        Some(every) => (every, every_key.as_str()),
        None => (*episode, end.as_str()),
    };
    if let Some([_, longest]) = length.filter(|[_, longest]| *longest > interval * (1.0 + SLACK)) {
        let message = format!(
            "`{length_key}` (up to {}) is longer than the interval of the push (`{bound}`, {})",
            duration(longest),
            duration(interval)
        );
        let help = format!("write a `duration` below \"{}\": pushes last about 0.1 s", duration(interval));
        return report(subject, [&length_key, bound], message, &help, sink);
    }
    let Some([first, last]) = at.map(|at: Sampler| at.bounds()) else { return };
    if first >= interval * (1.0 - SLACK) || last > interval * (1.0 + SLACK) {
        let message = format!(
            "`{at_key}` ({}) is not before the end of {} (`{bound}`, {}): {}",
            interval_of([first, last]),
            if bound == end { "the episode" } else { "the interval" },
            duration(interval),
            if first >= interval { "the push never happens" } else { "some pushes never happen" }
        );
        let help = format!("write an `at` below \"{}\"", duration(interval));
        return report(subject, [&at_key, bound], message, &help, sink);
    }
    if let Some([shortest, _]) = length
        && first + shortest > episode * (1.0 + SLACK)
    {
        let message = format!(
            "the push at {} lasts {} and the episode (`{end}`) ends at {}: part of the impulse is lost",
            duration(first),
            duration(shortest),
            duration(*episode)
        );
        let help = format!("write an `at` of at most \"{}\"", duration(episode - shortest));
        report(subject, [&at_key, end], message, &help, sink);
    }
}

fn interval_of([first, last]: [f64; 2]) -> String {
    if first == last { duration(first) } else { format!("{} to {}", duration(first), duration(last)) }
}

/// Whether the bound was written after the value, by a child or an assignment: someone who shortens an episode
/// for a trial does not want to adapt the rest of the spec.
pub(super) fn is_inherited(subject: &Subject, value: &str, bound: &str) -> bool {
    let (Some(value), Some(bound)) = (subject.marks.get(value), subject.marks.get(bound)) else {
        return false;
    };
    // Children are read before their parents.
    let rank = |mark: &Mark| (mark.layer.max(Layer::Profile), Reverse(mark.value.source));
    rank(bound) > rank(value)
}

/// The command changes before the end. An interval as long as the episode is one draw per episode.
fn changes(subject: &Subject, limit: &Limit, sink: &mut Sink) {
    let key = Command::every.below(&Walk::command.path());
    let is_late = |every: &f64| *every > limit.seconds * (1.0 + SLACK);
    let Some(every) =
        subject.number(&key).filter(is_late).filter(|_| !is_inherited(subject, &key, &limit.key))
    else {
        return;
    };
    let episode = duration(limit.seconds);
    let message = format!(
        "the command never changes: `{key}` ({}) is longer than the episode (`{}`, {episode})",
        duration(every),
        limit.key
    );
    let help = format!("write a shorter time, or \"{episode}\" for one command per episode");
    report(subject, [&key, &limit.key], message, &help, sink);
}

/// The grace of a termination ends before the episode.
fn graces(subject: &Subject, limit: &Limit, sink: &mut Sink) {
    let terms = subject.terms::<Terminations>().into_iter().filter(|(_, term)| term.is::<ContactSchedule>());
    for (path, term) in terms {
        let Some(grace) = term.value(ContactSchedule::grace).filter(|grace| *grace >= limit.seconds) else {
            continue;
        };
        let key = ContactSchedule::grace.below(&path);
        if is_inherited(subject, &key, &limit.key) {
            continue;
        }
        let message = format!(
            "`{path}` never ends an episode that starts standing: its grace ({}) is not shorter than the \
             episode (`{}`, {})",
            duration(grace),
            limit.key,
            duration(limit.seconds)
        );
        report(subject, [&key, &limit.key], message, "write about one cycle of the motion", sink);
    }
}

/// What is special about the ground at a path, that of the training or of an evaluation, is within reach.
fn ground(subject: &Subject, path: &str, protocol: Option<(&str, Section)>, sink: &mut Sink) {
    let (Some(robot), Some(ground)) = (subject.robot, subject.section(path)) else { return };
    let Some(limit) = limit(subject, protocol) else { return };
    let task = Task::commanded(subject.spec()).map(|command| command.speed.bounds()[1]);
    let speed = protocol.map_or(task, |(path, table)| fastest(subject, path, table).or(task));
    let is_pushed = match protocol {
        Some((path, _)) if !repeats_training(subject, path) => !own_rows(subject, path).is_empty(),
        _ => !rows(subject, Rows::SECTION).is_empty(),
    };
    let sole = robot.feet.iter().map(|foot| 2.0 * foot.half_extents.x).fold(0.0, f64::max);
    // Without a forward command and without pushes, a robot reaches as far as its soles.
    let around = match speed {
        _ if is_pushed => 2.0 * hip_height(robot),
        Some(speed) if speed > 0.0 => sole + STEP * hip_height(robot),
        _ => sole,
    };
    let speed = speed.unwrap_or(0.0);
    let reach = around + OVERSHOOT * speed.max(0.0) * limit.seconds;
    let Some((key, away, what)) = first_feature(path, ground) else { return };
    if ground.is::<BoxObstacle>() && away < 0.5 * sole && is_around_the_start(ground) {
        let message = format!("{what} `{path}` is under the robot at the start");
        let help = format!("write a distance of at least \"{:.1} m\" to its front", sole.max(0.1));
        report(subject, [&key, &key], message, &help, sink);
        return;
    }
    if away <= reach {
        return;
    }
    let message = format!(
        "{what} `{path}` is never reached: it begins {away:.1} m from the start, and {} at up to {speed} m/s take \
         the robot {:.1} m",
        duration(limit.seconds),
        speed.max(0.0) * limit.seconds
    );
    let help = "write a shorter distance, a longer episode or a faster command";
    report(subject, [&key, &limit.key], message, help, sink);
}

/// Whether a box begins before the start and ends behind it.
fn is_around_the_start(ground: Section) -> bool {
    let length = ground.value(BoxObstacle::length).unwrap_or(0.0);
    let distance = ground.value(BoxObstacle::distance).unwrap_or(0.0);
    let back = match ground.value(BoxObstacle::reference) {
        Some(Measured::Front) => distance + length,
        _ => distance + 0.5 * length,
    };
    back > 0.0
}

/// The fastest command of a protocol in m/s, if it has its own.
fn fastest(subject: &Subject, path: &str, table: Section) -> Option<f64> {
    use crate::kinds::evaluate::Command;
    if let Some(Evaluation::Speeds(speeds)) = Evaluation::of_section(table) {
        return speeds.grid().into_iter().reduce(f64::max);
    }
    subject.number(&Command::speed.below(&Episodes::command.below(path)))
}

/// The key, the distance in m from the start and the noun of what distinguishes a ground from a plane.
fn first_feature(path: &str, ground: Section) -> Option<(String, f64, &'static str)> {
    if ground.is::<BoxObstacle>() {
        let (distance, length) = (ground.value(BoxObstacle::distance)?, ground.value(BoxObstacle::length)?);
        let front = match ground.value(BoxObstacle::reference) {
            Some(Measured::Front) => distance,
            _ => distance - 0.5 * length,
        };
        return Some((BoxObstacle::distance.below(path), front, "the obstacle of"));
    }
    if ground.is::<HeightField>() {
        let start = ground.value(HeightField::start)?;
        return Some((HeightField::start.below(path), start, "the uneven part of"));
    }
    None
}

fn report(subject: &Subject, [key, bound]: [&str; 2], message: String, help: &str, sink: &mut Sink) {
    let mut diagnostic = Diagnostic::error("E0512", message);
    if let Some(place) = subject.place(key) {
        diagnostic = diagnostic.at(place, "");
    }
    if let Some(place) = subject.place(bound).filter(|place| subject.place(key) != Some(*place)) {
        diagnostic = diagnostic.note(place, "the bound");
    }
    sink.emit(diagnostic.help(help));
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;
    use crate::robot::tests::robot;

    /// The messages for an episode of 10 s with these further lines.
    fn said(lines: &str) -> Vec<String> {
        let text = format!(
            "task = {{ kind = \"walk\", motion = \"walk\", episode = 10.0, command = {{ speed = 0.2 }} }}\n{lines}"
        );
        let tocabi = robot("tocabi");
        let found = found(events_are_within_the_episode, &text, Some(&tocabi));
        assert!(found.iter().all(|found| found.code == "E0512"), "{found:?}");
        found.into_iter().map(|found| found.message).collect()
    }

    fn push(keys: &str) -> String {
        format!("kind = \"push\"\nimpulse = 40.0\n{keys}\n")
    }

    #[test]
    fn a_push_after_the_end_of_its_episode_or_interval_is_e0512_with_the_bound() {
        for (keys, expected) in [
            ("duration = 0.1\nat = 9.9", None),
            (
                "duration = 0.1\nat = 10.0",
                Some("`randomize.push.at` (10 s) is not before the end of the episode"),
            ),
            (
                "duration = 0.1\nat = 500.0",
                Some("`randomize.push.at` (500 s) is not before the end of the episode"),
            ),
            ("duration = 0.1\nat = [8.0, 12.0]", Some("some pushes never happen")),
            ("duration = 0.1\nat = [4.0, 10.0]", None),
            (
                "duration = 0.1\nevery = 4.0\nat = 4.0",
                Some("the end of the interval (`randomize.push.every`, 4 s)"),
            ),
            (
                "duration = 0.1\nevery = 4.0\nat = 6.0",
                Some("the end of the interval (`randomize.push.every`, 4 s)"),
            ),
            ("duration = 0.1\nevery = 4.0\nat = 1.0", None),
            (
                "duration = 5.0\nevery = 4.0",
                Some("`randomize.push.duration` (up to 5 s) is longer than the interval"),
            ),
            ("duration = 11.0", Some("`randomize.push.duration` (up to 11 s) is longer than the interval")),
            ("duration = 0.1\nevery = 20.0", Some("the only push may come after its end")),
            ("duration = 2.0\nat = 9.0", Some("part of the impulse is lost")),
        ] {
            let told = said(&format!("[randomize.push]\n{}", push(keys)));
            assert_eq!(told.len(), usize::from(expected.is_some()), "{keys}: {told:?}");
            assert!(expected.is_none_or(|expected| told[0].contains(expected)), "{keys}: {told:?}");
        }
    }

    #[test]
    fn an_evaluations_own_time_limit_bounds_its_pushes_and_those_that_it_repeats() {
        let own = |limit: &str| {
            let rows = push("duration = 0.1\nat = 6.0");
            said(&format!(
                "[evaluate.pushed]\nkind = \"episodes\"\n{limit}\n[evaluate.pushed.randomize.push]\n{rows}"
            ))
        };
        assert_eq!(own(""), [""; 0]);
        assert_eq!(own("time_limit = 7.0"), [""; 0]);
        assert!(
            own("time_limit = 5.0")[0]
                .contains("(`evaluate.pushed.time_limit`, 5 s): the push never happens")
        );
        let repeated = |limit: &str| {
            let rows = push("duration = 0.1\nat = 6.0");
            said(&format!(
                "[evaluate.short]\nkind = \"episodes\"\nrandomize = true\n{limit}\n[randomize.push]\n{rows}"
            ))
        };
        assert_eq!(repeated(""), [""; 0]);
        assert!(repeated("time_limit = 5.0")[0].contains("evaluate.short.time_limit"), "{:?}", repeated(""));
        // A transfer takes its time limit from the nominal evaluation.
        let rows = push("duration = 0.1\nat = 6.0");
        let transfer = said(&format!(
            "[evaluate.nominal]\nkind = \"episodes\"\ntime_limit = 5.0\n[deploy.mujoco]\nkind = \
             \"transfer\"\n[deploy.mujoco.randomize.push]\n{rows}"
        ));
        assert!(transfer[0].contains("`evaluate.nominal.time_limit`"), "{transfer:?}");
    }

    #[test]
    fn changes_of_the_command_and_graces_beyond_the_episode_are_e0512() {
        let command = |every: &str| {
            let text = format!(
                "task = {{ kind = \"walk\", motion = \"walk\", episode = 10.0, command = {{ speed = [0.1, 0.5], every \
                 = {every} }} }}"
            );
            found(events_are_within_the_episode, &text, None).len()
        };
        assert_eq!(["4.0", "10.0", "10.5", "1000.0"].map(command), [0, 0, 1, 1]);
        let grace = |grace: &str| {
            said(&format!(
                "[terminate.contact_schedule]\nkind = \"contact_schedule\"\ntolerance = 0.15\ngrace = {grace}"
            ))
            .len()
        };
        assert_eq!(["0.8", "10.0", "60.0"].map(grace), [0, 1, 1]);
    }

    #[test]
    fn an_obstacle_that_the_robot_cannot_reach_is_e0512() {
        // 0.2 m/s for 10 s: 2 m.
        let obstacle = |distance: &str| {
            said(&format!(
                "[terrain]\nkind = \"box_obstacle\"\nfriction = 1.0\nheight = 0.01\nlength = 0.4\ndistance = {distance}"
            ))
            .len()
        };
        let found = ["0.6", "2.0", "3.0", "4.0", "20.0", "900.0"].map(obstacle);
        assert_eq!(found, [0, 0, 0, 1, 1, 1]);
        // A box around the start, where the robot would stand in it.
        assert_eq!(["0.0", "0.1", "0.2"].map(obstacle), [1, 1, 1]);
        let evaluated = |speed: &str| {
            said(&format!(
                "[evaluate.box]\nkind = \"episodes\"\ncommand = {{ speed = {speed} }}\n[evaluate.box.terrain]\nkind = \
                 \"box_obstacle\"\nfriction = 1.0\nheight = 0.01\nlength = 0.4\ndistance = 8.0"
            ))
            .len()
        };
        assert_eq!(["0.1", "0.3", "0.4", "1.0"].map(evaluated), [1, 1, 1, 0]);
        // A standing robot reaches only as far as its soles, unless it is pushed.
        let standing = |more: &str| {
            said(&format!(
                "[evaluate.box]\nkind = \"episodes\"\ncommand = {{ speed = 0.0 }}\n[evaluate.box.terrain]\nkind = \
                 \"box_obstacle\"\nfriction = 1.0\nheight = 0.01\nlength = 0.4\ndistance = 0.6\n{more}"
            ))
            .len()
        };
        let pushed = format!("[evaluate.box.randomize.push]\n{}", push("duration = 0.1"));
        assert_eq!(["", &pushed].map(standing), [1, 0]);
        let field = |start: &str| {
            said(&format!(
                "[terrain]\nkind = \"height_field\"\nfriction = 1.0\namplitude = 0.02\ncell = 0.1\nlength = \
                 24.0\nwidth = 6.0\nstart = {start}"
            ))
            .len()
        };
        assert_eq!(["0.4", "30.0"].map(field), [0, 1]);
    }
}
