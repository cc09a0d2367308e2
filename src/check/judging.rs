//! W0514: evaluations that are too short to judge the task.

use super::Subject;
use super::subject::duration;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::deploy::{Export, Transfer};
use crate::kinds::evaluate::{self, Setting, last_push};
use crate::kinds::task::{Judged, Shortest, Walk};

/// Evaluations that are too short.
struct Short {
    /// The key of their time limit.
    path: String,
    /// Their judged time.
    judged: Judged,
    /// Their tables.
    tables: Vec<String>,
}

/// Every evaluation lasts as long as a cycle of the reference motion, whose period in s this is, and as long
/// as a fall, after its last scheduled push if it has one. Those with the same time limit and push are one
/// finding.
pub fn evaluations_are_long_enough(subject: &Subject, period: Option<f64>, sink: &mut Sink) {
    let Some(robot) = subject.robot else { return };
    let shortest = Shortest::of(period, robot.standing_height);
    let mut short: Vec<Short> = Vec::new();
    for (table, term) in subject.protocols() {
        if term.is::<Export>() {
            continue;
        }
        // A transfer without a time limit has that of `evaluate.nominal`.
        let nominal = term.is::<Transfer>().then(|| Setting::time_limit.below(&evaluate::nominal()));
        let own = [Some(Setting::time_limit.below(&table)), nominal].into_iter().flatten();
        let path = own.chain([Walk::episode.path()]).find(|path| subject.value(path).is_some());
        let path = path.unwrap_or_default();
        let judged = subject.number(&path).map(|limit| Judged::of(limit, last_push(subject.spec(), term)));
        let Some(judged) = judged.filter(|judged| !shortest.is_reached_by(*judged)) else { continue };
        match short.iter_mut().find(|known| known.path == path && known.judged == judged) {
            Some(known) => known.tables.push(table),
            None => short.push(Short { path, judged, tables: vec![table] }),
        }
    }
    for Short { path, judged, tables } in short {
        let names: Vec<String> = tables.iter().map(|table| format!("`{table}`")).collect();
        let verb = if names.len() == 1 { "is" } else { "are" };
        let message = format!(
            "{} {verb} too short to judge the task: {}",
            names.join(", "),
            judged.span_in_words(duration)
        );
        let mut diagnostic = Diagnostic::warning("W0514", message);
        if let Some(place) = subject.place(&path) {
            diagnostic = diagnostic.at(place, "");
        }
        sink.emit(diagnostic.help(format!(
            "a report says `not judged` for it; a verdict takes at least {}",
            shortest.in_words()
        )));
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::table;
    use super::*;
    use crate::spec::Marks;

    #[test]
    fn an_evaluation_shorter_than_a_cycle_or_a_fall_is_w0514_once_for_the_task_s_duration() {
        let robot = crate::robot::tests::robot("tocabi");
        let told = |text: &str, period: Option<f64>| -> Vec<String> {
            let fields = table(text);
            let subject = Subject { fields: &fields, marks: &Marks::default(), robot: Some(&robot) };
            let mut sink = Sink::default();
            evaluations_are_long_enough(&subject, period, &mut sink);
            sink.diagnostics.into_iter().map(|found| format!("{} {}", found.code, found.message)).collect()
        };
        let spec = |episode: &str, own: &str| {
            format!(
                "[task]\nepisode = {episode}\n[evaluate.a]\nkind = \"episodes\"\n{own}\n\
                 [deploy.b]\nkind = \"transfer\"\n[deploy.policy]\nkind = \"export\"\n"
            )
        };
        let none: Vec<String> = Vec::new();
        assert_eq!(told(&spec("16.0", ""), Some(1.8)), none);
        let all = told(&spec("0.2", ""), Some(1.8));
        assert_eq!(all, ["W0514 `evaluate.a`, `deploy.b` are too short to judge the task: 200 ms"]);
        let one = told(&spec("16.0", "time_limit = 1.0"), None);
        assert_eq!(one, ["W0514 `evaluate.a` is too short to judge the task: 1 s"]);
        assert_eq!(told(&spec("0.2", "time_limit = 4.0"), Some(1.8)).len(), 1);
        assert_eq!(told(&spec("2.0", ""), None), none);
        let pushed = |limit: &str, keys: &str| {
            let rows = format!(
                "[evaluate.a.randomize.push]\nkind = \"push\"\nimpulse = 9.0\nduration = 0.1\n{keys}"
            );
            told(&spec("16.0", &format!("time_limit = {limit}\n{rows}")), Some(1.8))
        };
        // A push at a random time is not scheduled; of repeated pushes the first one counts.
        assert_eq!(
            [pushed("6.0", "at = 4.0"), pushed("6.0", ""), pushed("6.0", "at = 1.0\nevery = 2.0")],
            [(); 3].map(|()| none.clone())
        );
        let late = "W0514 `evaluate.a` is too short to judge the task: 1 s after the push at 5 s";
        assert_eq!(pushed("6.0", "at = 5.0"), [late]);
        assert_eq!(pushed("6.0", "at = [2.0, 5.0]"), [late]);
        let nominal = spec("16.0", "time_limit = 1.0").replace("evaluate.a", "evaluate.nominal");
        let both = "W0514 `evaluate.nominal`, `deploy.b` are too short to judge the task: 1 s";
        assert_eq!(told(&nominal, None), [both]);
    }
}
