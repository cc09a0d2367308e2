//! Which combinations are meant: partial patterns over the axes, the tables `[[sweep.include]]` and `[[sweep.exclude]]`.

use std::collections::BTreeMap;

use super::axis::Axis;
use super::point::written;
use super::wrong_type;
use crate::diag::{Diagnostic, Sink, Span};
use crate::spec::suggest::{listed, nearest};
use crate::syntax::{Item, Map, Node};

/// Points by axis; an axis that is not named may be at any point.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pattern {
    /// The allowed points of each axis that is named.
    pub points: BTreeMap<String, Vec<String>>,
}

/// What a pattern names and no axis has.
struct Unknown {
    /// What is wrong.
    message: String,
    /// What to write.
    help: String,
}

impl Pattern {
    /// Whether an arm is meant.
    pub fn matches(&self, arm: &[(String, String)]) -> bool {
        self.points.iter().all(|(axis, points)| {
            arm.iter().any(|(own, point)| own == axis && points.iter().any(|allowed| allowed == point))
        })
    }

    /// Decodes a table of `[[sweep.exclude]]` or `[[sweep.include]]`. E0702 for what does not exist.
    pub fn decode(map: &Map, place: Span, axes: &[Axis], sink: &mut Sink) -> Option<Self> {
        let mut pattern = Self::default();
        let mut sound = true;
        if map.entries.is_empty() {
            let error = Diagnostic::error("E0703", "this pattern names no axis, so every arm matches it");
            sink.emit(error.at(place, "").help("name a point: `control = \"torque\"`"));
            return None;
        }
        for (axis, entry) in &map.entries {
            let mut points = Vec::new();
            for node in items(&entry.node) {
                if matches!(node.item, Item::Table(_) | Item::Datetime | Item::List(_)) {
                    sink.emit(wrong_type(axis, "the name of a point or a list of them", node));
                    sound = false;
                    continue;
                }
                let name = written(node);
                if let Err(unknown) = known_point(axis, &name, axes) {
                    let axis_is_known = axes.iter().any(|known| known.name == *axis);
                    let place = if axis_is_known { node.span } else { entry.key };
                    sink.emit(Diagnostic::error("E0702", unknown.message).at(place, "").help(unknown.help));
                    sound = false;
                    if !axis_is_known {
                        break;
                    }
                }
                points.push(name);
            }
            pattern.points.insert(axis.clone(), points);
        }
        sound.then_some(pattern)
    }
}

/// A list's items, or the value itself.
fn items(node: &Node) -> Vec<&Node> {
    match &node.item {
        Item::List(items) => items.iter().collect(),
        _ => vec![node],
    }
}

fn known_point(axis: &str, point: &str, axes: &[Axis]) -> Result<(), Unknown> {
    let names = || axes.iter().map(|axis| axis.name.as_str());
    let Some(known) = axes.iter().find(|known| known.name == axis) else {
        let help = match nearest(axis, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the axes are {}", listed(names())),
        };
        return Err(Unknown { message: format!("the sweep has no axis `{axis}`"), help });
    };
    if known.point(point).is_some() {
        return Ok(());
    }
    let points = || known.points.iter().map(|point| point.name.as_str());
    let help = match nearest(point, points()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("its points are {}", listed(points())),
    };
    Err(Unknown { message: format!("the axis `{axis}` has no point `{point}`"), help })
}
