//! What a robot loses by welding and the choice of two feet: joints fixed outside their range, joints of
//! other kinds, additional legs, and bodies without collision shapes.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Point3, Vector3};

use super::naming::some;
use super::tree::{Hinge, Part, Tree};
use super::welded::{Moving, Welded};
use crate::spec::suggest::listed;

/// An end of the tree is a leg if it reaches this share of the feet's depth below the base. Hanging arms
/// reach about half.
const REACH: f64 = 0.75;
/// Or if it has as many joints as the leg of a foot and, within this tolerance, the same mass.
const ALIKE: f64 = 0.02;

/// The remarks on a tree, given the remaining joints.
pub(super) fn remarks(tree: &Tree, kept: &[bool], welded: &Welded) -> Vec<String> {
    let loose = || {
        tree.parts.iter().zip(kept).filter(|(_, kept)| !**kept).filter_map(|(part, _)| part.hinge.as_ref())
    };
    let mut lines = Vec::new();
    lines.extend(at_key(tree.key.as_deref(), loose()));
    lines.extend(at_rest(loose()));
    lines.extend(outside(loose()));
    lines.extend(coupled(loose()));
    lines.extend(of_other_kinds(tree, kept, welded));
    lines.extend(legs(tree, kept, welded));
    lines.extend(void_ranges(welded));
    lines.extend(zeros(welded));
    lines.extend(shapeless(tree, welded));
    lines
}

/// Joints welded outside their range.
fn outside<'a>(welded: impl Iterator<Item = &'a Hinge>) -> Option<String> {
    let ranges = welded.filter_map(|hinge| {
        let (lower, upper) = (hinge.lower.unwrap_or(f64::NEG_INFINITY), hinge.upper.unwrap_or(f64::INFINITY));
        let unit = if hinge.slides() { "m" } else { "rad" };
        let place = hinge.welded_at();
        let at = if place == 0.0 { String::new() } else { format!(" at {}", short(place)) };
        hinge
            .is_welded_outside()
            .then(|| format!("`{}`{at} ({} .. {} {unit})", hinge.name, short(lower), short(upper)))
    });
    let ranges: Vec<String> = ranges.collect();
    let shown = first(&ranges)?;
    let pose =
        if ranges.iter().any(|range| range.contains("` at ")) { "where the file has it" } else { "at zero" };
    Some(format!(
        "welded {pose}, which is outside of the joint's range: {shown}; keep such a joint with --joints, or \
         give the file a pose \
         within the range"
    ))
}

/// Joints welded at the positions of a key frame.
fn at_key<'a>(key: Option<&str>, welded: impl Iterator<Item = &'a Hinge>) -> Option<String> {
    let places: Vec<String> =
        welded.filter(|hinge| hinge.default_position.is_some()).filter_map(away_from_zero).collect();
    Some(format!("welded at the positions of the key frame `{}`: {}", key?, first(&places)?))
}

/// Joints welded at the rest positions of their springs.
fn at_rest<'a>(welded: impl Iterator<Item = &'a Hinge>) -> Option<String> {
    let places: Vec<String> =
        welded.filter(|hinge| hinge.default_position.is_none()).filter_map(away_from_zero).collect();
    Some(format!("welded where their springs are at rest, because nothing drives them: {}", first(&places)?))
}

/// A joint with the position at which it is welded, unless that is zero.
fn away_from_zero(hinge: &Hinge) -> Option<String> {
    let (place, unit) = (hinge.welded_at(), if hinge.slides() { "m" } else { "rad" });
    (place != 0.0).then(|| format!("`{}` at {} {unit}", hinge.name, short(place)))
}

/// Joints welded because other joints drive them.
fn coupled<'a>(welded: impl Iterator<Item = &'a Hinge>) -> Option<String> {
    let joints = welded.filter(|hinge| hinge.is_coupled());
    let joints: Vec<String> = joints.filter_map(|hinge| kind(hinge, "")).collect();
    let shown = first(&joints)?;
    Some(format!("welded, because the joints of a robot file turn independently of each other: {shown}"))
}

/// Joints welded because they are not hinges, those of the legs first: without them a leg moves differently.
fn of_other_kinds(tree: &Tree, kept: &[bool], welded: &Welded) -> Option<String> {
    let index = |name: &str| tree.parts.iter().position(|part| part.body.name == name);
    let feet = welded.feet.each_ref().map(|(link, _)| index(&welded.links[*link].body.name));
    let on_a_leg: BTreeSet<usize> = match feet {
        [Some(left), Some(right)] => {
            let [left, right] = [left, right].map(|foot| above(tree, foot).collect::<BTreeSet<usize>>());
            left.symmetric_difference(&right).copied().collect()
        }
        _ => BTreeSet::new(),
    };
    let loose = tree.parts.iter().enumerate().filter(|(body, _)| !kept[*body]);
    let (mut legs, mut others) = (Vec::new(), Vec::new());
    for (body, hinge) in loose.filter_map(|(body, part)| Some((body, part.hinge.as_ref()?))) {
        // A joint below the last one that is kept is of the leg, too.
        match above(tree, body).any(|body| on_a_leg.contains(&body)) {
            _ if hinge.is_coupled() => {}
            true => legs.extend(kind(hinge, " of a leg")),
            false => others.extend(kind(hinge, "")),
        }
    }
    let warning = if legs.is_empty() {
        ""
    } else {
        "; legs without their sliding or ball joints move differently from those of the file"
    };
    legs.extend(others);
    let shown = first(&legs)?;
    Some(format!("welded, because the joints of a robot file are hinges: {shown}{warning}"))
}

/// A joint with its kind and place: `` `knee` (prismatic) of a leg ``; `None` for a hinge.
fn kind(hinge: &Hinge, place: &str) -> Option<String> {
    Some(format!("`{}` ({}){place}", hinge.name, hinge.other.as_ref()?))
}

/// The first of some texts, and the number of others.
fn first(texts: &[String]) -> Option<String> {
    const SHOWN: usize = 4;
    match texts.len() {
        0 => None,
        count if count > SHOWN + 1 => {
            Some(format!("{} and {} others", texts[..SHOWN].join(", "), count - SHOWN))
        }
        _ => Some(texts.join(", ")),
    }
}

/// A number of a range with as few digits as necessary.
fn short(value: f64) -> String {
    if value.is_infinite() {
        return if value < 0.0 { "no lower limit" } else { "no upper limit" }.to_owned();
    }
    format!("{:.4}", value).parse::<f64>().unwrap_or(value).to_string()
}

/// The ends of the tree that are legs but not feet.
fn legs(tree: &Tree, kept: &[bool], welded: &Welded) -> Option<String> {
    let index = |name: &str| tree.parts.iter().position(|part| part.body.name == name);
    let [left, right] = welded.feet.each_ref().map(|(link, _)| index(&welded.links[*link].body.name));
    let feet = [left?, right?];
    let ends = further_legs(tree, feet, &(tree.upright.inverse() * Vector3::z()));
    let names: Vec<&str> = ends.iter().map(|end| tree.parts[*end].body.name.as_str()).collect();
    if names.is_empty() {
        return None;
    }
    let joints =
        ends.iter().flat_map(|end| above(tree, *end)).filter(|body| tree.parts[*body].hinge.is_some());
    let lost: BTreeSet<usize> = joints.filter(|body| !kept[*body]).collect();
    let (legs, names) = (counted(names.len(), "leg"), some(&names));
    Some(match lost.len() {
        0 => format!("a robot has two feet: {legs} more without a foot, {names}"),
        count => format!(
            "a robot has two feet: {legs} more dropped, {names}, whose {} welded at zero",
            if count == 1 { "joint is".to_owned() } else { format!("{count} joints are") }
        ),
    })
}

/// The ends of the tree that are not on the leg of a foot: toes and rods are not separate legs.
fn others(tree: &Tree, feet: [usize; 2]) -> Vec<usize> {
    let [left, right] = feet.map(|foot| above(tree, foot).collect::<BTreeSet<usize>>());
    let on_a_leg = |end: &usize| above(tree, *end).any(|body| left.contains(&body) != right.contains(&body));
    ends(tree).into_iter().filter(|end| !on_a_leg(end)).collect()
}

/// The ends that reach about as deep as the feet, on their own joints, or have a similar structure; `up` is
/// in the root frame.
pub(super) fn further_legs(tree: &Tree, feet: [usize; 2], up: &Vector3<f64>) -> Vec<usize> {
    let depths = depths(tree, up);
    let shallow = feet.iter().map(|foot| depths[*foot]).fold(f64::INFINITY, f64::min);
    let [own_joints, own_mass] = chain(tree, feet[0]);
    let is_leg = |end: &usize| {
        let [joints, mass] = chain(tree, *end);
        let alike = joints == own_joints && (mass - own_mass).abs() <= ALIKE * own_mass && own_mass > 0.0;
        alike || (shallow > 0.0 && depths[*end] >= REACH * shallow && joints > 1.0)
    };
    others(tree, feet).into_iter().filter(is_leg).collect()
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// The last bodies with revolute joints, for every branch of the tree.
fn ends(tree: &Tree) -> Vec<usize> {
    let turns = |part: &Part| part.hinge.as_ref().is_some_and(|hinge| hinge.other.is_none());
    let mut carries = vec![false; tree.parts.len()];
    for (index, part) in tree.parts.iter().enumerate().rev() {
        if let Some(parent) = part.parent {
            carries[parent] |= carries[index] || turns(part);
        }
    }
    (0..tree.parts.len()).filter(|index| turns(&tree.parts[*index]) && !carries[*index]).collect()
}

/// A body and its ancestors.
fn above(tree: &Tree, body: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(body), |body| tree.parts[*body].parent)
}

/// Depth in m of each body's joint below the base, with all joints at zero.
fn depths(tree: &Tree, up: &Vector3<f64>) -> Vec<f64> {
    let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(tree.parts.len());
    let mut depths = Vec::with_capacity(tree.parts.len());
    for part in &tree.parts {
        let pose = part.parent.map_or(Isometry3::identity(), |parent| poses[parent]) * part.pose;
        let anchor = part.hinge.as_ref().map(|hinge| hinge.anchor).unwrap_or_default();
        depths.push(-(pose * Point3::from(anchor)).coords.dot(up));
        poses.push(pose);
    }
    depths
}

/// The number of revolute joints above an end, and the mass in kg of their bodies, excluding those above
/// several ends.
fn chain(tree: &Tree, end: usize) -> [f64; 2] {
    let children = |body: usize| tree.parts.iter().filter(|part| part.parent == Some(body)).count();
    let mut joints = 0.0;
    let mut mass = 0.0;
    for (steps, body) in above(tree, end).enumerate() {
        let part = &tree.parts[body];
        if part.parent.is_none() || (steps > 0 && children(body) > 2) {
            break;
        }
        joints += f64::from(u8::from(part.hinge.is_some()));
        mass += part.body.mass;
    }
    [joints, mass]
}

/// Joints with a range in the file that is not enforced.
fn void_ranges(welded: &Welded) -> Option<String> {
    let mut ranges: Vec<([f64; 2], Vec<&str>)> = Vec::new();
    for hinge in welded.links.iter().map(|link| &link.hinge) {
        let Some(range) = hinge.void_range else { continue };
        match ranges.iter_mut().find(|(known, _)| *known == range) {
            Some((_, names)) => names.push(&hinge.name),
            None => ranges.push((range, vec![&hinge.name])),
        }
    }
    let shown = |([lower, upper], names): &([f64; 2], Vec<&str>)| {
        format!("{} .. {} rad of {}", short(*lower), short(*upper), listed(names.iter().copied()))
    };
    let shown: Vec<String> = ranges.iter().map(shown).collect();
    (!shown.is_empty()).then(|| {
        format!(
            "not imported: ranges of joints that the file calls continuous or not limited, {}; fill in \
             `lower` and `upper`",
            shown.join(", ")
        )
    })
}

/// Limits that are zero in the file.
fn zeros(welded: &Welded) -> Option<String> {
    let of = |limit: &'static str| {
        let links = welded.links.iter().map(|link| &link.hinge);
        let names: Vec<&str> =
            links.filter(|hinge| hinge.zeros.contains(&limit)).map(|hinge| hinge.name.as_str()).collect();
        (!names.is_empty()).then(|| format!("{limit} of {}", some(&names)))
    };
    let limits: Vec<String> = ["range", "effort", "velocity"].into_iter().filter_map(of).collect();
    let known = welded.links.iter().any(|link| link.hinge.effort_limit.is_some());
    let is_idle = |link: &Moving| link.hinge.zeros.contains(&"effort");
    let idle = if known && welded.links.iter().any(is_idle) {
        "; weld a joint that nothing drives by leaving it out of --joints"
    } else {
        ""
    };
    (!limits.is_empty()).then(|| format!("limits of zero are taken for unknown: {}{idle}", limits.join(", ")))
}

/// Bodies with shapes in the file but not in the robot, and a robot without any.
fn shapeless(tree: &Tree, welded: &Welded) -> Vec<String> {
    let bare = |wanted: &dyn Fn(&Part) -> bool| -> Vec<&str> {
        let parts = tree.parts.iter().filter(|part| part.body.collisions.is_empty() && wanted(part));
        parts.map(|part| part.body.name.as_str()).collect()
    };
    let mut lines = Vec::new();
    let lost = bare(&|part| part.shapes.colliding > 0);
    if !lost.is_empty() {
        lines.push(format!("no collision shape is left of {}: nothing there touches anything", some(&lost)));
    }
    let idle = bare(&|part| part.shapes.colliding == 0 && part.shapes.idle > 0);
    if !idle.is_empty() {
        lines.push(format!(
            "the geoms of {} touch nothing in the file (contype and conaffinity are 0): no collision shape",
            some(&idle)
        ));
    }
    let is_foot = |link: usize| welded.feet.iter().any(|(foot, _)| *foot == link);
    let mut links =
        welded.links.iter().enumerate().filter(|(index, _)| !is_foot(*index)).map(|(_, link)| &link.body);
    if welded.base.collisions.is_empty() && links.all(|body| body.collisions.is_empty()) {
        lines.push("no body but the feet has a collision shape: self-collisions cannot be found".to_owned());
    }
    lines
}
