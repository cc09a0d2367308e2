//! E0103 and E0104: joint observations fit the robot, and are not repeated.

use super::Subject;
use crate::diag::{Diagnostic, Sink, Span};
use crate::kinds::observe::Observations;
use crate::kinds::observe::joint_position::JointPosition;
use crate::kinds::observe::joint_velocity::JointVelocity;
use crate::spec::typed::Declared;

/// The kinds that measure the joints: a robot has one encoder noise and one velocity filter.
const MEASURED: [&str; 2] = [JointPosition::KIND.name, JointVelocity::KIND.name];

/// Number of functions of a leg's joints, and of scales given by function.
const FUNCTIONS: usize = 6;

/// Two terms must not measure the same: there is only one filter and one noise.
pub fn joints_are_measured_once(subject: &Subject, sink: &mut Sink) {
    for kind in MEASURED {
        let terms = subject.terms::<Observations>().into_iter().map(|(path, _)| path);
        let terms: Vec<String> = terms.filter(|path| subject.kind(path) == Some(kind)).collect();
        let [first, second, ..] = terms.as_slice() else { continue };
        let message =
            format!("duplicate joint measurement: `{first}` and `{second}` both have the kind `{kind}`");
        let error = placed(Diagnostic::error("E0104", message), subject.place(second), "this term");
        let error = match subject.place(first) {
            Some(place) => error.note(place, "the other term"),
            None => error,
        };
        sink.emit(error.help("remove one of them; `enabled = false` removes an inherited term"));
    }
}

/// A list of scales has one item for all joints, six for the functions of a leg's joints, or one per joint.
pub fn scales_fit_the_joints(subject: &Subject, sink: &mut Sink) {
    let Some(robot) = subject.robot else { return };
    for (path, term) in subject.terms::<Observations>() {
        let measured = term.kind().is_some_and(|kind| MEASURED.contains(&kind));
        let scale = term.value(JointPosition::scale).filter(|_| measured);
        let (count, joints) = (scale.map_or(1, |scale| scale.len()), robot.joints());
        if [1, FUNCTIONS, joints].contains(&count) {
            continue;
        }
        let message = format!("`{path}.scale` has {count} numbers, but `{}` has {joints} joints", robot.name);
        let error = Diagnostic::error("E0103", message);
        let help = format!(
            "write one for all joints, {FUNCTIONS} (hip yaw, hip roll, hip pitch, knee, ankle pitch and \
             ankle roll) or {joints}"
        );
        sink.emit(placed(error, subject.place(&format!("{path}.scale")), "wrong length").help(help));
    }
}

fn placed(diagnostic: Diagnostic, place: Option<Span>, remark: &str) -> Diagnostic {
    match place {
        Some(place) => diagnostic.at(place, remark),
        None => diagnostic,
    }
}

#[cfg(test)]
mod tests {
    use super::super::robots::sample::biped;
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn scales_are_one_or_six_or_one_per_joint() {
        let codes = |scale: &str| -> Vec<&str> {
            let text = format!("[observe.joints]\nkind = \"joint_velocity\"\nscale = {scale}");
            found(scales_fit_the_joints, &text, Some(&biped())).iter().map(|found| found.code).collect()
        };
        for sound in ["[1]", "[1, 2]", "[1, 2, 3, 4, 5, 6]"] {
            assert_eq!(codes(sound), [""; 0], "{sound}");
        }
        assert_eq!(codes("[1, 2, 3]"), ["E0103"]);
    }

    #[test]
    fn two_terms_that_measure_the_joints_velocities_are_e0104() {
        let one = "[observe.joint_velocity]\nkind = \"joint_velocity\"\nlow_pass = 4.0\n";
        let other = "[observe.fast]\nkind = \"joint_velocity\"\n";
        assert_eq!(found(joints_are_measured_once, one, None), []);
        let both = found(joints_are_measured_once, &format!("{one}{other}"), None);
        assert_eq!(both.iter().map(|found| found.code).collect::<Vec<_>>(), ["E0104"]);
    }
}
