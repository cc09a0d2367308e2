//! W0509: an episode that ends where its reference motion is.
//!
//! The parents' bound is that of robots as tall as the paper's; another robot needs its own.

use super::Subject;
use super::reference::OnDemand;
use super::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::motion::Motion;
use crate::kinds::terminate::Terminations;
use crate::kinds::terminate::base_height::BaseHeight;
use crate::robot::hip_height;

/// The share of its standing height at which TOCABI's episodes end.
const SHARE: f64 = 0.65;

/// Only bounds above this share of the standing height are compared with a motion that has not been made yet.
const NEAR: f64 = 0.8;

/// `terminate.base_height` is below the reference motion on this robot.
pub fn references_stay_above(subject: &Subject, reference: &mut OnDemand, sink: &mut Sink) {
    let Some(robot) = subject.robot else { return };
    let bounds = subject.terms::<Terminations>().into_iter().filter(|(_, term)| term.is::<BaseHeight>());
    for (path, term) in bounds {
        let near = |bound: &f64| !reference.shipped || *bound > NEAR * robot.standing_height;
        let Some(bound) = term.value(BaseHeight::below).filter(near) else { continue };
        let name = subject.motion();
        let (lowest, who) = match (reference.make)().as_deref().map(|made| &made.motion) {
            Some(Ok(motion)) => (lowest(motion), format!("the reference motion `{name}` comes down to")),
            _ => (robot.standing_height, "it stands at".to_owned()),
        };
        if bound < lowest {
            continue;
        }
        let key = BaseHeight::below.below(&path);
        let message = format!(
            "episodes end below {}, and on `{}` {who} {} m",
            subject.written(&key),
            robot.name,
            short(lowest)
        );
        let mut diagnostic = Diagnostic::warning("W0509", message);
        if let Some(place) = subject.place(&key) {
            diagnostic = diagnostic.at(place, "");
        }
        let sinks = (1.0 - SHARE) * hip_height(robot);
        let bound = f64::min(robot.standing_height - sinks, lowest - 0.15 * hip_height(robot));
        let robot_height = short(robot.standing_height);
        sink.emit(diagnostic.help(format!(
            "the base of `{}` stands {robot_height} m high: write `{key} = \"{bound:.2} m\"`",
            robot.name
        )));
    }
}

/// The least height of the base in m.
fn lowest(motion: &Motion) -> f64 {
    motion.samples.iter().map(|frame| frame.base_height).fold(f64::INFINITY, f64::min)
}
