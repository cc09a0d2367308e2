//! Selecting combinations: partial patterns over the axes, the tables `[[sweep.include]]` and
//! `[[sweep.exclude]]`.

use std::collections::BTreeMap;

use super::axis::Axis;
use super::point::written;
use super::wrong_type;
use crate::diag::{Diagnostic, Sink, Span};
use crate::spec::suggest::{listed, nearest};
use crate::syntax::{Item, Map, Node, Number};

/// Points by axis; an axis that is not named matches at any point.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pattern {
    /// The allowed points of each axis that is named.
    pub points: BTreeMap<String, Vec<String>>,
    /// The selected learning seeds; empty for all.
    pub seeds: Vec<u64>,
}

/// The key of a pattern that names learning seeds.
const SEEDS: &str = "seeds";

/// A name in a pattern that no axis has.
struct Unknown {
    /// What is wrong.
    message: String,
    /// What to write.
    help: String,
    /// The suggested name.
    near: Option<String>,
}

impl Pattern {
    /// Whether an arm matches.
    pub fn matches(&self, arm: &[(String, String)]) -> bool {
        self.points.iter().all(|(axis, points)| {
            arm.iter().any(|(own, point)| own == axis && points.iter().any(|allowed| allowed == point))
        })
    }

    /// Decodes a table of `[[sweep.exclude]]`, which may exclude some of an arm's seeds. E0702 for unknown
    /// names.
    pub fn decode_with_seeds(map: &Map, place: Span, axes: &[Axis], sink: &mut Sink) -> Option<Self> {
        let Some(entry) = map.entries.get(SEEDS) else { return Self::decode(map, place, axes, sink) };
        let seeds: Option<Vec<u64>> = items(&entry.node).into_iter().map(seed).collect();
        let Some(seeds) = seeds.filter(|seeds| !seeds.is_empty()) else {
            sink.emit(wrong_type(SEEDS, "a learning seed or a list of them", &entry.node));
            return None;
        };
        let mut rest = map.clone();
        rest.entries.remove(SEEDS);
        if rest.entries.is_empty() {
            let error =
                Diagnostic::error("E0703", "this pattern names seeds and no axis, so every arm matches it");
            sink.emit(error.at(place, "").help("name a point, or remove the seeds from `sweep.seeds`"));
            return None;
        }
        Some(Self { seeds, ..Self::decode(&rest, place, axes, sink)? })
    }

    /// Decodes a table of `[[sweep.include]]`. E0702 for unknown names.
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
                    let error = Diagnostic::error("E0702", unknown.message).at(place, "").help(unknown.help);
                    sink.emit(match unknown.near {
                        Some(near) if axis_is_known => error.fix(place, format!("\"{near}\"")),
                        Some(near) => error.fix(place, near),
                        None => error,
                    });
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

/// A learning seed.
fn seed(node: &Node) -> Option<u64> {
    match node.item {
        Item::Number(Number { whole: Some(seed @ 0..), .. }) => Some(seed as u64),
        _ => None,
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
    let Some(known) = axes.iter().find(|known| known.name == axis) else {
        let names: Vec<&str> = axes.iter().map(|axis| axis.name.as_str()).collect();
        return Err(Unknown::new(format!("the sweep has no axis `{axis}`"), axis, "the axes", &names));
    };
    if known.point(point).is_some() {
        return Ok(());
    }
    let points: Vec<&str> = known.points.iter().map(|point| point.name.as_str()).collect();
    Err(Unknown::new(format!("the axis `{axis}` has no point `{point}`"), point, "its points", &points))
}

impl Unknown {
    /// A word that is not among these names.
    fn new(message: String, word: &str, noun: &str, names: &[&str]) -> Self {
        let near = nearest(word, names.iter().copied());
        let help = match near {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("{noun} are {}", listed(names.iter().copied())),
        };
        Self { message, help, near: near.map(str::to_owned) }
    }
}
