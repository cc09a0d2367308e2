//! E0513: `learn.symmetry = "phase_mirror"` with a motion that is not its own mirror image.

use super::Subject;
use super::reference::OnDemand;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::learn::Ppo;
use crate::kinds::learn::ppo::Symmetry;
use crate::kinds::motion::MIRROR_TOLERANCE;
use crate::kinds::motion::squat::Squat;
use crate::kinds::task::walk::Walk;
use crate::spec::{Section, Table};

/// A mirrored actor needs a motion whose second half cycle is the mirror image of the first.
///
/// Making a motion takes milliseconds, so of the embedded motions on embedded robots only squats are looked at:
/// walks and runs are symmetric, as the tests of the shipped specs show.
pub fn motions_are_mirrored(
    subject: &Subject,
    file: Option<&Table>,
    reference: &mut OnDemand,
    sink: &mut Sink,
) {
    if subject.at(Ppo::symmetry) != Some(Symmetry::PhaseMirror) {
        return;
    }
    if reference.shipped && !file.is_some_and(|file| Section::new(file).is::<Squat>()) {
        return;
    }
    let Some(robot) = subject.robot else { return };
    let Some(made) = (reference.make)() else { return };
    // A motion that cannot be made is reported by another rule.
    let Ok(motion) = &made.motion else { return };
    if motion.samples.iter().any(|frame| frame.position.len() != robot.mirror.len()) {
        return;
    }
    let difference = motion.asymmetry(&robot.mirror);
    if difference <= MIRROR_TOLERANCE {
        return;
    }
    let message = format!(
        "`learn.symmetry` mirrors the second half of the cycle, and the motion `{}` is not its own mirror image \
         half a cycle later: a joint differs by {difference:.3} rad",
        subject.motion()
    );
    let error = Diagnostic::error("E0513", message);
    let place = subject.place(&Walk::motion.path()).or_else(|| subject.place(&Ppo::symmetry.path()));
    let error = match place {
        Some(place) => error.at(place, "not symmetric"),
        None => error,
    };
    let advice = "name a motion of the task's own kind, or write `learn.symmetry = \"none\"`";
    sink.emit(error.help(advice));
}
