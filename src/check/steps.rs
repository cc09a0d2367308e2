//! E0506: durations are whole numbers of steps.

use super::Subject;
use super::subject::{duration, whole};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::evaluate::Setting;
use crate::kinds::task::{Command, Walk};

/// The episode, the time between commands and the time limits of evaluations are whole numbers of control
/// steps. (A delay need not be: `control::Delay`.)
///
/// If the rates conflict (E0501), the length of a step is not final.
pub fn times_are_whole_steps(subject: &Subject, sink: &mut Sink) {
    if sink.diagnostics.iter().any(|found| found.code == "E0501") {
        return;
    }
    let Some(step) = subject.control_step() else { return };
    counted(subject, &Walk::episode.path(), step, sink);
    counted(subject, &Command::every.below(&Walk::command.path()), step, sink);
    for (protocol, _) in subject.protocols() {
        time_limit_is_whole_steps(subject, &protocol, sink);
    }
}

/// The time limit of the evaluation at this path is a whole number of control steps.
pub(super) fn time_limit_is_whole_steps(subject: &Subject, protocol: &str, sink: &mut Sink) {
    if let Some(step) = subject.control_step() {
        counted(subject, &Setting::time_limit.below(protocol), step, sink);
    }
}

/// A duration is a whole number of control steps of `step` seconds.
fn counted(subject: &Subject, path: &str, step: f64, sink: &mut Sink) {
    let Some(time) = subject.number(path) else { return };
    let steps = time / step;
    if whole(steps).is_some() {
        return;
    }
    let message = format!("`{path}` ({}) is not a whole number of control steps", subject.written(path));
    let remark = format!("{} steps of {}", (steps * 1e3).round() / 1e3, duration(step));
    let mut diagnostic = Diagnostic::error("E0506", message);
    if let Some(place) = subject.place(path) {
        diagnostic = diagnostic.at(place, remark);
    }
    let (below, above) = (duration(steps.floor() * step), duration(steps.ceil() * step));
    sink.emit(diagnostic.help(format!("the nearest durations are \"{below}\" and \"{above}\"")));
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn a_command_of_one_and_a_half_control_steps_is_e0506_and_a_delay_may_be_any_time() {
        let text = "physics = { rate = 500.0 }\naction = { rate = 250.0, delay = 0.0031 }\ntask = \
            { command = { every = 0.006 } }";
        let found = found(times_are_whole_steps, text, None);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].code, "E0506");
        assert_eq!(found[0].help, ["the nearest durations are \"4 ms\" and \"8 ms\""]);
    }

    #[test]
    fn an_episode_counts_in_control_steps() {
        let text =
            "physics = { rate = 500.0 }\naction = { rate = 62.5, delay = 0.004 }\ntask = { episode = 16.0 }";
        assert_eq!(found(times_are_whole_steps, text, None), []);
        let text =
            "physics = { rate = 500.0 }\naction = { rate = 62.5, delay = 0.004 }\ntask = { episode = 16.01 }";
        assert_eq!(found(times_are_whole_steps, text, None).len(), 1);
    }
}
