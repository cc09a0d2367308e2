//! Tests of the embedded robots.

mod gravity;
mod kinematics;
mod model;

use crate::diag::{Sink, Sources};
use crate::robot::{Robot, shipped};

/// An embedded robot.
pub(crate) fn robot(name: &str) -> Robot {
    shipped(name).expect("a robot of this name, without mistakes")
}

/// The mistakes in TOCABI after changing its file's text: codes and the text they point at.
fn faults(from: &str, to: &str) -> Vec<(&'static str, String)> {
    let text = crate::robot::embedded("tocabi").expect("tocabi");
    assert!(text.contains(from), "{from}");
    let text = text.replacen(from, to, 1);
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("tocabi.toml", text.as_str());
    assert_eq!(crate::robot::load("tocabi", &sources, source, &mut sink), None);
    let place = |labels: &[crate::diag::Label]| text[labels[0].span.start..labels[0].span.end].to_owned();
    sink.diagnostics.iter().map(|diagnostic| (diagnostic.code, place(&diagnostic.labels))).collect()
}
