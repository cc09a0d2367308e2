//! W0509: a reference motion that is below the height at which episodes end.
//!
//! The bound of the shipped parents is for robots as tall as the paper's; others need their own.

use super::Subject;
use super::reference::OnDemand;
use super::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::motion::Motion;
use crate::kinds::terminate::Terminations;
use crate::kinds::terminate::base_height::BaseHeight;
use crate::robot::hip_height;

/// TOCABI's episodes end at this share of its standing height.
const SHARE: f64 = 0.65;

/// For shipped motions only bounds above this share of the standing height are checked, to save time.
const NEAR: f64 = 0.8;

/// `terminate.base_height` is below the reference motion on this robot.
pub fn references_stay_above(subject: &Subject, reference: &mut OnDemand, sink: &mut Sink) {
    let Some(robot) = subject.robot else { return };
    let bounds = subject.terms::<Terminations>().into_iter().filter(|(_, term)| term.is::<BaseHeight>());
    for (path, term) in bounds {
        let near = |bound: &f64| !reference.shipped || *bound > NEAR * robot.standing_height;
        let Some(bound) = term.value(BaseHeight::below).filter(near) else { continue };
        let name = subject.motion();
        let (lowest, cause) = match (reference.make)().as_deref().map(|made| &made.motion) {
            Some(Ok(motion)) => (
                lowest(motion),
                format!("the reference motion `{name}` lowers the base of `{}` to", robot.name),
            ),
            _ => (robot.standing_height, format!("in the default pose the base of `{}` is at", robot.name)),
        };
        if bound < lowest {
            continue;
        }
        let key = BaseHeight::below.below(&path);
        let message =
            format!("episodes end below {}, but {cause} {} m", subject.written(&key), short(lowest));
        let mut diagnostic = Diagnostic::warning("W0509", message);
        if let Some(place) = subject.place(&key) {
            diagnostic = diagnostic.at(place, "");
        }
        let sinks = (1.0 - SHARE) * hip_height(robot);
        let bound = f64::min(robot.standing_height - sinks, lowest - 0.15 * hip_height(robot));
        let robot_height = short(robot.standing_height);
        let diagnostic = diagnostic.help(format!(
            "write `{key} = \"{bound:.2} m\"`: the base of `{}` is {robot_height} m high in the default pose",
            robot.name
        ));
        sink.emit(subject.edited(&key, format!("\"{bound:.2} m\""), diagnostic));
    }
}

/// The minimum height of the base in m.
fn lowest(motion: &Motion) -> f64 {
    motion.samples.iter().map(|frame| frame.base_height).fold(f64::INFINITY, f64::min)
}
