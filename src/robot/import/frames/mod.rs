//! Rewrites the frames of the base and the feet if they violate the convention of robot files: the base has x
//! forward, y left and z up; a foot's z is the normal of its sole and its x points forward.
//!
//! All quantities of a body are transformed to its new frame, so the robot stays the same. Every change is
//! reported as a remark. Undecidable frames are E0416, and feet that `--feet` names the wrong way round are
//! W0401.

mod base_frame;
mod foot;
mod heading;
mod legs;
mod lines;
mod root;
mod sole;
mod turn;

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};

use super::block::Block;
use super::fill::Fill;
use super::mesh;
use super::tree::MeshBox;
use super::welded::Welded;
use crate::diag::{Diagnostic, Sink};
use crate::robot::{Collision, Shape};
use crate::spec::suggest::listed;
use base_frame::{Found, Hints, Unclear};
use foot::Directions;
use legs::Legs;
pub(super) use root::root;
use sole::Piece;

/// Minimum angle in rad for a frame to count as rotated.
const TURNED: f64 = 1e-9;
/// Minimum angle in rad between z and up for a base to count as tilted.
const ASLANT: f64 = 1e-3;

/// Inputs for the choice of frames in addition to the welded tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known<'a> {
    /// From the base's frame to the file's upright world.
    pub upright: UnitQuaternion<f64>,
    /// The same in the key frame that the default positions come from.
    pub stance: Option<UnitQuaternion<f64>>,
    /// Filled-in values, including default positions.
    pub fills: &'a [Fill],
    /// For each moving body, the boxes that replace meshes.
    pub meshes: &'a BTreeMap<usize, Vec<&'a MeshBox>>,
    /// Whether the user named the left and the right foot.
    pub named: bool,
}

/// Changes the frames of the base and these feet to the convention; returns the left and the right foot.
pub(super) fn express(
    welded: &mut Welded,
    feet: [usize; 2],
    known: &Known,
    remarks: &mut Vec<String>,
    sink: &mut Sink,
) -> Result<[usize; 2], Diagnostic> {
    let mut legs = Legs::of(welded, feet, known.fills);
    remarks.extend(impossible(&legs));
    let mut shapes = feet.map(|foot| Hull::of(welded, foot, known.meshes));
    let mut middles = [0, 1].map(|side| sole::middle(&shapes[side].pieces));
    let mut lateral = None;
    if !base_frame::places_mirror(&legs)
        && let Some(plane) = lines::plane(&legs, &places(&legs, middles))
    {
        let soles =
            [0, 1].map(|side| Some((legs.straight[feet[side]] * Point3::from(middles[side]?)).coords));
        lateral = Some(plane.normal);
        remarks.extend(lines::slide(welded, &legs, soles, &plane));
        legs = Legs::of(welded, feet, known.fills);
        shapes = feet.map(|foot| Hull::of(welded, foot, known.meshes));
        middles = [0, 1].map(|side| sole::middle(&shapes[side].pieces));
    }
    let up = legs.upwards(middles);
    let tiptoe = on_tips(&legs, &shapes, &up, &(known.upright.inverse() * Vector3::z()));
    let down = -tiptoe.unwrap_or(up);
    let soles = [0, 1].map(|side| {
        let down = legs.posed[feet[side]].rotation.inverse() * down;
        sole::sole(&shapes[side].pieces, &nalgebra::Unit::try_new(down, 1e-6)?)
    });
    let stance = known.stance.filter(|_| legs.outside.is_empty());
    let hints = Hints { upright: known.upright, stance, named: known.named, tiptoe, lateral };
    let found = base_frame::frame(&legs, &soles, &hints).map_err(|unclear| refusal(welded, &unclear))?;
    if !found.mirrored {
        remarks.extend(aslant(welded, known));
        return Ok([feet[found.left], feet[1 - found.left]]);
    }
    if found.left == 1 && known.named {
        sink.emit(exchanged(welded, feet));
    }
    let turn =
        found.frame.map_or(Matrix3::identity(), |frame| frame.rotation.to_rotation_matrix().into_inner());
    let [forward, up] = [turn.column(0).into_owned(), turn.column(2).into_owned()];
    if found.frame.is_none_or(|frame| frame.rotation.angle() < TURNED) {
        remarks.extend(aslant(welded, known));
    }
    if let Some(frame) = &found.frame {
        remarks.push(express_base(welded, frame, &found));
    }
    for side in [found.left, 1 - found.left] {
        let back = legs.posed[feet[side]].rotation.inverse();
        let directions = Directions { up: back * up, forward: back * forward };
        if let Some(frame) = foot::frame(soles[side].as_ref(), &directions) {
            remarks.push(express_foot(welded, feet[side], &frame, &shapes[side]));
        }
    }
    Ok([feet[found.left], feet[1 - found.left]])
}

/// The remark on an impossible default pose.
fn impossible(legs: &Legs) -> Option<String> {
    let joints = listed(legs.outside.iter().map(String::as_str));
    (!legs.outside.is_empty()).then(|| {
        format!(
            "default positions outside of the joints' limits ({joints}): the frames of base and feet were \
             found with all joints at \
             zero, so correct the positions and import again"
        )
    })
}

/// Pairs of points, with all joints at zero, that mirror each other regardless of the joint origins: the
/// soles and the centres of mass of the legs.
fn places(legs: &Legs, middles: [Option<Vector3<f64>>; 2]) -> Vec<[Vector3<f64>; 2]> {
    let sole = |side: usize| Some((legs.straight[legs.feet[side]] * Point3::from(middles[side]?)).coords);
    let pair = |places: [Option<Vector3<f64>>; 2]| Some([places[0]?, places[1]?]);
    [pair([sole(0), sole(1)]), pair(legs.coms)].into_iter().flatten().collect()
}

/// Up according to the tips of the feet, if bent legs disagree with the file's up and their tips do not.
fn on_tips(
    legs: &Legs,
    shapes: &[Hull; 2],
    along: &Vector3<f64>,
    upright: &Vector3<f64>,
) -> Option<Vector3<f64>> {
    let aslant = |way: &Vector3<f64>| {
        foot::angle(&way.try_normalize(1e-6).unwrap_or_default(), upright) > base_frame::NEAR
    };
    if !aslant(along) {
        return None;
    }
    let tip = |side: usize| {
        let down = legs.posed[legs.feet[side]].rotation.inverse() * -upright;
        sole::furthest(&shapes[side].pieces, &down)
    };
    let way = legs.upwards_from([tip(0)?, tip(1)?]);
    (!aslant(&way)).then_some(way)
}

/// The remark on a base whose frame is preserved but upright neither in the source nor in its key frame.
fn aslant(welded: &Welded, known: &Known) -> Option<String> {
    let attitude = known.stance.unwrap_or(known.upright);
    let tilt = foot::angle(&(attitude * Vector3::z()), &Vector3::z());
    (tilt > ASLANT).then(|| {
        format!(
            "`{}`: in the source the base is turned by {}, with its z axis {:.1} degrees from up; a robot \
             file begins with its base \
             upright, so its figures stay in the frame of the base, and the attitude is left out",
            welded.base.name,
            turn::in_words(&attitude),
            tilt.to_degrees()
        )
    })
}

/// Transforms the base to a new frame, given its pose in the old one; returns a remark.
fn express_base(welded: &mut Welded, frame: &Isometry3<f64>, found: &Found) -> String {
    let name = &welded.base.name;
    let mut changes = Vec::new();
    if frame.rotation.angle() > TURNED {
        let turn = turn::in_words(&frame.rotation);
        let stands = if found.stands { " in the key frame, in which the soles are level" } else { "" };
        changes
            .push(format!("was turned by {turn}, so that x points forward, y to the left and z up{stands}"));
    }
    if found.beside != 0.0 {
        changes.push(format!("was moved by {:.1} mm into the plane of symmetry", 1e3 * found.beside.abs()));
    }
    if let Some([ahead, above]) = found.hips {
        let way = |by: f64, [one, other]: [&str; 2]| {
            let word = if by > 0.0 { one } else { other };
            (by.abs() > 5e-5).then(|| format!("{:.1} mm {word}", 1e3 * by.abs()))
        };
        let ways = [way(ahead, ["forward", "backward"]), way(above, ["up", "down"])];
        let ways: Vec<String> = ways.into_iter().flatten().collect();
        changes.push(format!("was moved by {} to the middle of the hips", ways.join(" and ")));
    }
    let mut remark = format!("`{name}`: the frame of the base {}", changes.join(" and "));
    if found.evidence.file == -found.way && found.evidence.file != 0 {
        remark += "; its x axis pointed backward";
    }
    turn::express(&mut welded.base, frame);
    let back = frame.inverse();
    for link in welded.links.iter_mut().filter(|link| link.parent.is_none()) {
        link.origin = back * link.origin;
    }
    remark
}

/// Transforms a foot to a new frame, given in the old one; the box of a mesh is fitted to the new axes.
/// Returns a remark.
fn express_foot(welded: &mut Welded, foot: usize, frame: &Matrix3<f64>, hull: &Hull) -> String {
    let turn = turn::rotation(frame);
    let link = &mut welded.links[foot];
    let remark = format!(
        "`{}`: the frame of this foot was turned by {}, so that z is the normal of the sole and x points \
         forward",
        link.body.name,
        turn::in_words(&turn)
    );
    for (index, points) in &hull.meshes {
        link.body.collisions[*index] =
            boxed(points, &turn).unwrap_or_else(|| link.body.collisions[*index].clone());
    }
    let frame = Isometry3::from_parts(Translation3::identity(), turn);
    turn::express(&mut link.body, &frame);
    link.origin *= frame;
    link.hinge.axis = link.hinge.axis.map(|axis| turn.inverse() * axis);
    let back = frame.inverse();
    for child in welded.links.iter_mut().filter(|child| child.parent == Some(foot)) {
        child.origin = back * child.origin;
    }
    remark
}

/// The box around points along the axes of a rotated frame, in the frame of the points.
fn boxed(points: &[Vector3<f64>], turn: &UnitQuaternion<f64>) -> Option<Collision> {
    let back = turn.inverse();
    let seen = || points.iter().map(|point| back * point);
    let (low, high) = (seen().reduce(|a, b| a.inf(&b))?, seen().reduce(|a, b| a.sup(&b))?);
    let pose = Isometry3::from_parts(Translation3::from(turn * (0.5 * (low + high))), *turn);
    let half = 0.5 * (high - low);
    (half.min() > 0.0).then_some(Collision { shape: Shape::Box(half), pose })
}

/// The shapes of a foot: primitives, and the points of meshes.
struct Hull {
    pieces: Vec<Piece>,
    /// By index of the collision shape.
    meshes: BTreeMap<usize, Vec<Vector3<f64>>>,
}

impl Hull {
    fn of(welded: &Welded, foot: usize, meshes: &BTreeMap<usize, Vec<&MeshBox>>) -> Self {
        let mut hull = Self { pieces: Vec::new(), meshes: BTreeMap::new() };
        let boxes = meshes.get(&foot).map_or(&[][..], Vec::as_slice);
        for (index, collision) in welded.links[foot].body.collisions.iter().enumerate() {
            let same = |mesh: &&&MeshBox| collision.shape == Shape::Box(mesh.block.half);
            match boxes.iter().find(same).and_then(|mesh| points(mesh, collision)) {
                Some(points) => {
                    hull.pieces.push(Piece::mesh(points.iter().copied()));
                    hull.meshes.insert(index, points);
                }
                None => hull.pieces.push(Piece::of(collision)),
            }
        }
        hull
    }
}

/// The points of the mesh that a box replaces, in the frame of its body.
fn points(mesh: &MeshBox, collision: &Collision) -> Option<Vec<Vector3<f64>>> {
    let Block { centre, .. } = mesh.block;
    let frame = collision.pose * Translation3::from(-centre);
    let points = mesh::points(&mesh.path).ok()?;
    let scale = Vector3::from(mesh.scale);
    Some(points.iter().map(|point| (frame * Point3::from(point.component_mul(&scale))).coords).collect())
}

/// W0401: `--feet` names the feet the wrong way round.
fn exchanged(welded: &Welded, feet: [usize; 2]) -> Diagnostic {
    let [left, right] = feet.map(|foot| welded.links[foot].body.name.as_str());
    let message =
        format!("--feet: `{left}` is the right foot of this robot and `{right}` the left one, as it faces");
    Diagnostic::warning("W0401", message).help(format!("they were exchanged: write --feet {right},{left}"))
}

/// E0416: the frame is undecidable.
fn refusal(welded: &Welded, unclear: &Unclear) -> Diagnostic {
    let name = &welded.base.name;
    match unclear {
        Unclear::Heading(evidence) => {
            let message = format!("which way `{name}` faces is unclear: {}", evidence.in_words());
            Diagnostic::error("E0416", message).help(format!(
                "name the left and the right foot with --feet LEFT,RIGHT, or turn the frame of `{name}` so \
                 that x points forward, y to the \
                 left and z up"
            ))
        }
        Unclear::Up => {
            let message = format!(
                "where up is in the frame of `{name}` is unclear: its axes are not near those of the legs, \
                 and the soles are not level"
            );
            Diagnostic::error("E0416", message).help(format!(
                "turn the frame of `{name}` so that x points forward, y to the left and z up, or give the \
                 default pose, in which the soles \
                 are level, with --fill JOINT:default_position=VALUE"
            ))
        }
    }
}
