//! E0402: names that select joints or links of the robot.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::observe::Observations;
use crate::kinds::randomize::joint_offset::JointOffset;
use crate::kinds::reward::Rewards;
use crate::kinds::terminate::Terminations;
use crate::robot::selector::matches;
use crate::spec::Value;

/// Every name under a `joints` or `links` key of an observation, randomization or termination matches the
/// robot.
pub fn selectors_match(subject: &Subject, sink: &mut Sink) {
    let Some(robot) = subject.robot else { return };
    let joints: Vec<&str> = robot.links.iter().map(|link| link.joint.name.as_str()).collect();
    let mut links: Vec<&str> = robot.links.iter().map(|link| link.body.name.as_str()).collect();
    links.push(&robot.base.name);
    let terms =
        [subject.terms::<Observations>(), subject.terms::<Terminations>(), subject.terms::<Rewards>()];
    for (path, term) in terms.concat().into_iter().chain(subject.randomizations()) {
        for (key, names) in [(JointOffset::joints.name, &joints), (LINKS, &links)] {
            for (index, wanted) in selected(term.get(key)).into_iter().enumerate() {
                if !names.iter().any(|name| matches(wanted, name)) {
                    sink.emit(nothing(subject, &format!("{path}.{key}.{index}"), wanted, names));
                }
            }
        }
    }
}

/// The key of terms that select links.
const LINKS: &str = "links";

/// The names that a value gives.
fn selected(value: Option<&Value>) -> Vec<&str> {
    let names = match value {
        Some(Value::List(names)) => names.as_slice(),
        Some(name) => std::slice::from_ref(name),
        None => &[],
    };
    names.iter().filter_map(|name| name.as_text().map(String::as_str)).collect()
}

fn nothing(subject: &Subject, path: &str, wanted: &str, names: &[&str]) -> Diagnostic {
    let robot = subject.robot.map_or("", |robot| robot.name.as_str());
    let mut diagnostic =
        Diagnostic::error("E0402", format!("`{wanted}` matches no joint or link of `{robot}`"));
    let place = subject.place(path);
    if let Some(place) = place {
        diagnostic = diagnostic.at(place, "");
    }
    let distance = |name: &&&str| strsim::damerau_levenshtein(wanted, name);
    match names.iter().min_by_key(distance).filter(|name| distance(name) <= 3) {
        Some(near) => {
            let diagnostic = diagnostic.help(format!("did you mean `{near}`?"));
            place
                .into_iter()
                .fold(diagnostic, |diagnostic, place| diagnostic.fix(place, format!("\"{near}\"")))
        }
        None => diagnostic.help(format!("available: {}", names.join(", "))),
    }
}

#[cfg(test)]
mod tests {
    use super::super::robots::sample::biped;
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn a_misspelt_joint_is_e0402_with_the_nearest_name() {
        let text = "[randomize.joint_offset]\njoints = [\"kne\", \"hip_*\"]";
        let found = found(selectors_match, text, Some(&biped()));
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].code, found[0].help[0].as_str()), ("E0402", "did you mean `knee`?"));
    }
}
