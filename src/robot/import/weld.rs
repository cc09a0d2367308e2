//! Welding: bodies on joints that are not selected become part of their parents.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Vector3};

use super::biped;
use super::ends::{Feet, Joints};
use super::feet;
use super::frames::{self, Known};
use super::passive;
use super::physical::{self, impossible};
use super::remains;
use super::round;
use super::selection::Selection;
use super::tree::{Hinge, MeshBox, Part, Tree, Weight, massless};
use super::welded::{Moving, Owner, Welded};
use crate::diag::{Diagnostic, Sink, Span};
use crate::robot::checks::{self, MOST_JOINTS};
use crate::robot::{Body, Collision};

/// Welds bodies on unselected joints. `None` if the rest is not a robot; the sink has the diagnostics.
pub fn weld(tree: &Tree, selection: &Selection, sink: &mut Sink) -> Option<Welded> {
    let balanced = selection.balance.then(|| physical::balanced(tree));
    let tree = balanced.as_ref().unwrap_or(tree);
    physical::check(tree, sink);
    if sink.has_errors() {
        return None;
    }
    welded(tree, selection, sink).map_err(|error| sink.emit(error)).ok().filter(|_| !sink.has_errors())
}

fn welded(tree: &Tree, selection: &Selection, sink: &mut Sink) -> Result<Welded, Diagnostic> {
    let kept = kept(tree, selection)?;
    let tree = &tree.posed(&kept);
    let root = frames::root(tree, &kept);
    let name = tree.parts.get(root.body).map_or("base", |part| part.body.name.as_str());
    let mut welded = Welded {
        base: massless(name),
        weigh_base: false,
        unweighed: BTreeMap::new(),
        links: Vec::new(),
        feet: [(0, None), (0, None)],
        fixed: Vec::new(),
        notes: tree.notes.clone(),
    };
    welded.notes.extend(root.remark(tree));
    // For each body of the file: the body it became part of, and its pose there.
    let mut places: Vec<(Owner, Isometry3<f64>)> = Vec::with_capacity(tree.parts.len());
    for (index, (part, kept)) in tree.parts.iter().zip(kept.iter().copied()).enumerate() {
        let (owner, carrier) = part.parent.map_or((None, root.pose.inverse()), |parent| places[parent]);
        // Exactly the base's own frame.
        let pose = if index == root.body { Isometry3::identity() } else { carrier * part.pose };
        let place = welded.take(part, kept, owner, &pose);
        if part.weight == Weight::Unknown {
            welded.unweighed.entry(place.0).or_default().push(part.body.name.clone());
        }
        places.push(place);
    }
    judge(tree, &mut welded, &places, sink);
    let owner =
        |name: &str| tree.parts.iter().position(|part| part.body.name == name).map(|index| places[index].0);
    let upright = tree.upright * root.pose.rotation;
    let feet = match &selection.feet {
        Some(names) => feet::named(names, owner, &welded)?,
        None => feet::lowest_ends(&welded, &(upright.inverse() * Vector3::z()))?,
    };
    let named = selection.feet.is_some();
    let body =
        |link: usize| tree.parts.iter().position(|part| part.body.name == welded.links[link].body.name);
    if !named
        && let [Some(left), Some(right)] = feet.map(body)
        && let Some(refusal) = biped::refusal(tree, [left, right], &(tree.upright.inverse() * Vector3::z()))
    {
        return Err(refusal);
    }
    let stance = tree.stance.map(|stance| stance * root.pose.rotation);
    let known = Known { upright, stance, fills: &selection.fills, meshes: &meshes(tree, &places), named };
    let mut remarks = Vec::new();
    let feet = frames::express(&mut welded, feet, &known, &mut remarks, sink)?;
    if !named {
        let [left, right] = feet.map(|foot| welded.links[foot].body.name.as_str());
        welded.notes.push(format!(
            "the feet were not named: `{left}` and `{right}` are the ends of the tree that reach lowest \
             (--feet names others)"
        ));
    }
    welded.notes.extend(remarks);
    for link in feet {
        if let Some(wheel) = round::wheel(&welded, link) {
            sink.emit(wheel);
        }
    }
    welded.feet = feet.map(|link| (link, feet::sole(&mut welded, link)));
    let remarks = remains::remarks(tree, &kept, &welded);
    welded.notes.extend(remarks);
    let hinges: Vec<&Hinge> = welded.links.iter().map(|link| &link.hinge).collect();
    let remark = passive::remark(&hinges, selection);
    welded.notes.extend(remark);
    Ok(welded)
}

impl Welded {
    /// Adds a body of the file at its pose in its owner; returns the owner and the body's pose there.
    fn take(
        &mut self,
        part: &Part,
        kept: bool,
        owner: Owner,
        pose: &Isometry3<f64>,
    ) -> (Owner, Isometry3<f64>) {
        let place = match &part.hinge {
            Some(hinge) if kept => {
                let origin = pose * Translation3::from(hinge.anchor);
                let body = massless(&part.body.name);
                self.links.push(Moving { body, parent: owner, origin, hinge: hinge.clone(), weigh: false });
                (Some(self.links.len() - 1), Translation3::from(-hinge.anchor).into())
            }
            hinge => {
                self.fixed.extend(hinge.iter().map(|hinge| match &hinge.other {
                    Some(kind) => format!("{} ({kind})", hinge.name),
                    None => hinge.name.clone(),
                }));
                (owner, *pose)
            }
        };
        let (body, weigh) = match place.0 {
            Some(link) => {
                let Moving { body, weigh, .. } = &mut self.links[link];
                (body, weigh)
            }
            None => (&mut self.base, &mut self.weigh_base),
        };
        *weigh |= part.weight == Weight::Unknown;
        join(body, &part.body, &place.1);
        place
    }
}

/// Minimum sum of the moments of inertia relative to the mass, in m^2: that of a body of 30 micrometres.
const NO_INERTIA: f64 = 1e-9;

/// Checks the moving bodies: one whose parts have no mass must be filled in, an impossible one is reported.
fn judge(tree: &Tree, welded: &mut Welded, places: &[(Owner, Isometry3<f64>)], sink: &mut Sink) {
    let parts = |owner: Owner| tree.parts.iter().zip(places).filter(move |(_, place)| place.0 == owner);
    let mut notes = Vec::new();
    let mut judged = |body: &Body, weigh: &mut bool, owner: Owner| -> Option<(String, Option<Span>, &str)> {
        if body.mass <= 0.0 && parts(owner).any(|(part, _)| part.weight == Weight::Absent) {
            *weigh = true;
        }
        if *weigh {
            return None;
        }
        let first = parts(owner).find_map(|(part, _)| part.span);
        if body.mass <= 0.0 {
            let fault = format!("the mass of `{}` is {:e} kg, and it moves", body.name, body.mass);
            return Some((
                fault,
                first,
                "give it its mass and inertia, or weld it by leaving its joint out of --joints",
            ));
        }
        if body.inertia.trace() < NO_INERTIA * body.mass {
            let fault =
                format!("`{}` has a mass of {:e} kg and no inertia, and it moves", body.name, body.mass);
            return Some((
                fault,
                first,
                "write its inertia into the file, or weld it by leaving its joint out of --joints",
            ));
        }
        let unsound =
            || parts(owner).filter_map(|(part, _)| Some((part, physical::inertia(&part.body.inertia)?)));
        let Some(fault) = checks::inertia(&body.inertia) else {
            notes.extend(unsound().map(|(part, fault)| {
                let (part, whole) = (&part.body.name, &body.name);
                format!("`{part}`: its inertia {fault}; that of `{whole}`, of which it is a part, is sound")
            }));
            return None;
        };
        let span = unsound().find_map(|(part, _)| part.span).or(first);
        Some((format!("the inertia of `{}` {fault}", body.name), span, physical::CURE))
    };
    let mut faults: Vec<_> = judged(&welded.base, &mut welded.weigh_base, None).into_iter().collect();
    for (index, link) in welded.links.iter_mut().enumerate() {
        faults.extend(judged(&link.body, &mut link.weigh, Some(index)));
    }
    for (message, span, help) in faults {
        let error = match span {
            Some(span) => impossible(message, span),
            None => Diagnostic::error("E0405", message),
        };
        sink.emit(error.help(help));
    }
    welded.notes.extend(notes);
}

/// For each moving body the boxes of its parts that replace meshes.
fn meshes<'a>(tree: &'a Tree, places: &[(Owner, Isometry3<f64>)]) -> BTreeMap<usize, Vec<&'a MeshBox>> {
    let mut meshes: BTreeMap<usize, Vec<&MeshBox>> = BTreeMap::new();
    for mesh in &tree.meshes {
        let part = tree.parts.iter().position(|part| part.body.name == mesh.body);
        if let Some(link) = part.and_then(|part| places[part].0) {
            meshes.entry(link).or_default().push(mesh);
        }
    }
    meshes
}

/// For each body of the file whether its joint is kept.
fn kept(tree: &Tree, selection: &Selection) -> Result<Vec<bool>, Diagnostic> {
    let selected = |hinge: &Hinge| match &selection.joints {
        Some(pattern) => pattern.is_match(&hinge.name),
        None => hinge.other.is_none(),
    };
    let mut kept: Vec<bool> =
        tree.parts.iter().map(|part| part.hinge.as_ref().is_some_and(selected)).collect();
    if selection.joints.is_none() {
        let named = |name: &String| tree.parts.iter().position(|part| part.body.name == *name);
        let feet = match &selection.feet {
            Some(feet) => feet.iter().filter_map(named).collect(),
            None => match Joints::of_tree(tree, &kept).feet(&(tree.upright.inverse() * Vector3::z())) {
                Feet::Pair(feet) => feet.to_vec(),
                Feet::Fewer(feet) => feet,
                Feet::Unclear => {
                    return Err(feet::unclear(tree.parts.first().map_or("base", |part| &part.body.name)));
                }
            },
        };
        // Fewer than two ends are reported by the search for the feet.
        if selection.feet.is_some() || feet.len() == 2 {
            let needed = above(tree, &feet);
            kept.iter_mut().zip(needed).for_each(|(kept, needed)| *kept &= needed);
        }
    }
    let hinges = || {
        tree.parts.iter().zip(&kept).filter(|(_, kept)| **kept).filter_map(|(part, _)| part.hinge.as_ref())
    };
    let placed = |code, message: String, hinge: &Hinge| match hinge.span {
        Some(span) => Diagnostic::error(code, message).at(span, ""),
        None => Diagnostic::error(code, message),
    };
    if let Some((hinge, kind)) = hinges().find_map(|hinge| hinge.other.as_ref().map(|kind| (hinge, kind))) {
        let message = format!("joint `{}` is {kind}, and a robot is a tree of revolute joints", hinge.name);
        return Err(placed("E0413", message, hinge).help("leave it out of --joints to weld it"));
    }
    if let Some(refusal) = passive::refusal(&hinges().collect::<Vec<_>>(), tree, selection) {
        return Err(refusal);
    }
    let count = hinges().count();
    if let Some(hinge) = hinges().nth(MOST_JOINTS) {
        let message = format!("{count} joints are selected, and a robot has at most {MOST_JOINTS}");
        return Err(placed("E0407", message, hinge)
            .help("select fewer with --joints REGEX, or the legs alone with --feet LEFT,RIGHT"));
    }
    // Named feet without joints are reported by name.
    if count == 0 && (selection.joints.is_some() || selection.feet.is_none()) {
        return Err(no_joint(tree, selection));
    }
    Ok(kept)
}

/// E0402: no joint is kept.
fn no_joint(tree: &Tree, selection: &Selection) -> Diagnostic {
    let joints = tree.parts.iter().filter_map(|part| part.hinge.as_ref());
    let names: Vec<String> = joints
        .map(|hinge| match &hinge.other {
            Some(kind) => format!("`{}` ({kind})", hinge.name),
            None => format!("`{}`", hinge.name),
        })
        .collect();
    let message = match &selection.joints {
        Some(pattern) => format!("--joints `{pattern}` matches no joint"),
        None if names.is_empty() => {
            "the file has no joint: all its bodies are fixed to each other".to_owned()
        }
        None => "the file has no revolute joint".to_owned(),
    };
    let help = if names.is_empty() {
        "a robot has motors at revolute joints: make those of the legs `revolute` (URDF) or give their \
         bodies a hinge (MJCF)"
            .to_owned()
    } else {
        format!("the joints of the file are {}", first(&names, 60))
    };
    Diagnostic::error("E0402", message).help(help)
}

/// The first of some texts, and the number of others.
fn first(texts: &[String], shown: usize) -> String {
    match texts.len().saturating_sub(shown) {
        0 => texts.join(", "),
        more => format!("{} and {more} more", texts[..shown].join(", ")),
    }
}

/// For each body of the file whether it carries a foot.
fn above(tree: &Tree, feet: &[usize]) -> Vec<bool> {
    let mut above = vec![false; tree.parts.len()];
    for foot in feet {
        let mut next = Some(*foot);
        while let Some(index) = next {
            above[index] = true;
            next = tree.parts[index].parent;
        }
    }
    above
}

/// Adds a body at a pose to another one (parallel axis theorem).
pub(super) fn join(whole: &mut Body, part: &Body, pose: &Isometry3<f64>) {
    for collision in &part.collisions {
        whole.collisions.push(Collision { shape: collision.shape.clone(), pose: pose * collision.pose });
    }
    let turn = pose.rotation.to_rotation_matrix().into_inner();
    if part.mass <= 0.0 {
        // A moment without a mass is that of a rotor.
        whole.inertia += turn * part.inertia * turn.transpose();
        return;
    }
    let (mass, com) = (whole.mass + part.mass, pose * part.com);
    let shifted = |inertia: Matrix3<f64>, mass: f64, arm: Vector3<f64>| {
        inertia + (Matrix3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose()) * mass
    };
    let centre = Point3::from((whole.com.coords * whole.mass + com.coords * part.mass) / mass);
    let own = shifted(whole.inertia, whole.mass, whole.com - centre);
    whole.inertia = own + shifted(turn * part.inertia * turn.transpose(), part.mass, com - centre);
    (whole.mass, whole.com) = (mass, centre);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body made of point masses: mass, centre and inertia by direct sums.
    fn cluster(points: &[(f64, Vector3<f64>)]) -> Body {
        let mut body = massless("cluster");
        body.mass = points.iter().map(|(mass, _)| mass).sum();
        body.com = Point3::from(points.iter().map(|(mass, at)| at * *mass).sum::<Vector3<f64>>() / body.mass);
        for (mass, at) in points {
            let arm = at - body.com.coords;
            body.inertia +=
                (Matrix3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose()) * *mass;
        }
        body
    }

    #[test]
    fn two_welded_bodies_are_the_body_of_all_their_points() {
        let a =
            [(1.0, Vector3::new(0.1, 0.0, 0.2)), (2.0, Vector3::new(-0.1, 0.3, 0.0)), (0.5, Vector3::z())];
        let b =
            [(1.5, Vector3::new(0.0, 0.2, -0.2)), (0.7, Vector3::x()), (0.2, Vector3::new(0.3, 0.1, 0.4))];
        let pose = Isometry3::new(Vector3::new(0.4, -0.2, 0.7), Vector3::new(0.3, -0.5, 0.8));
        let mut whole = cluster(&a);
        join(&mut whole, &cluster(&b), &pose);
        let moved = b.map(|(mass, at)| (mass, (pose * Point3::from(at)).coords));
        let expected = cluster(&[a, moved].concat());
        assert!((whole.mass - expected.mass).abs() < 1e-12);
        assert!((whole.com - expected.com).norm() < 1e-12);
        assert!((whole.inertia - expected.inertia).norm() < 1e-12);
    }
}
