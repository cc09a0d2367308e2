//! W0524: keys that another key overrides or disables.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::action::Position;
use crate::kinds::evaluate::Spread;
use crate::kinds::learn::Ppo;
use crate::kinds::observe::Observations;
use crate::kinds::observe::joint_position::JointPosition;
use crate::kinds::randomize::Rows;
use crate::kinds::randomize::action_delay::ActionDelay;
use crate::spec::typed::InSection;
use crate::spec::{Experiment, Mark, Value};
use crate::syntax::Layer;

/// Keys that the spec itself sets are read. A parent's key that a profile overrides is intended.
pub fn keys_are_read(subject: &Subject, experiment: &Experiment, sink: &mut Sink) {
    // Parents are completed by their children.
    if experiment.is_abstract {
        return;
    }
    let own = |path: &str| {
        let mark = subject.marks.get(path)?;
        let is_own = mark.layer >= Layer::Point || mark.value.source == experiment.source;
        (mark.layer != Layer::Default && is_own).then_some(mark)
    };
    let gamma = Ppo::gamma.path();
    let time = subject.marks.get(&Ppo::discount_time.path());
    // A profile may replace what the spec has otherwise.
    if let Some((mark, time)) = own(&gamma).zip(time).filter(|(mark, time)| mark.layer >= time.layer) {
        let message = "`learn.gamma` has no effect: `learn.discount_time` overrides it".to_owned();
        let help = "write the horizon as `discount_time`: gamma = exp(-step / discount_time)";
        tell(mark, message, Some((time, "overrides it")), help, sink);
    }
    // A profile may switch off what the spec has otherwise.
    let own = |path: &str| own(path).filter(|mark| experiment.profile.is_none() || mark.layer > Layer::File);
    for (path, _) in subject.protocols() {
        let key = Spread::randomize.below(&path);
        let draws = subject.section(Rows::SECTION).is_some_and(|rows| rows.sections().next().is_some());
        if let (Some(mark), Some(Value::Flag(true)), false) = (own(&key), subject.value(&key), draws) {
            let message = format!("`{key}` has no effect: the training randomizes nothing");
            tell(mark, message, None, "write the rows as a table, or remove the key", sink);
        }
        let key = Spread::noise.below(&path);
        let noisy = subject.terms::<Observations>().iter().any(|(_, term)| term.holds(JointPosition::noise));
        if let (Some(mark), Some(Value::Flag(true)), false) = (own(&key), subject.value(&key), noisy) {
            let message = format!("`{key}` has no effect: no observation has noise");
            tell(mark, message, None, "write `observe.joint_position.noise`, or remove the key", sink);
        }
    }
    let delay = Position::delay.path();
    for (path, row) in subject.randomizations() {
        let key = format!("{path}.scale");
        if let (true, Some(mark), Some(0.0)) = (row.is::<ActionDelay>(), own(&key), subject.number(&delay)) {
            let message = format!("`{path}` has no effect: it scales `{delay}`, which is 0");
            let zero = subject.marks.get(&delay).filter(|mark| mark.layer != Layer::Default);
            tell(mark, message, zero.map(|mark| (mark, "nothing to scale")), "write a delay", sink);
        }
    }
}

fn tell(mark: &Mark, message: String, other: Option<(&Mark, &str)>, help: &str, sink: &mut Sink) {
    let mut diagnostic = Diagnostic::warning("W0524", message).at(mark.value, "not read");
    if let Some((other, words)) = other {
        diagnostic = diagnostic.note(other.value, words);
    }
    sink.emit(diagnostic.help(help));
}
