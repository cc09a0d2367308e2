//! The frame of the base: x forward, y left, z up, its origin in the plane of symmetry.
//!
//! The lateral axis follows from the positions of both legs' joints, up from the joint axes or from level
//! soles, and forward from [`super::heading`]. A frame that follows the convention is preserved exactly.

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

use super::foot::angle;
use super::heading::{self, Evidence};
use super::legs::Legs;
use super::sole::Sole;
use super::turn::{apart, nearest_permutation, rotation, upright};

/// Tolerance of mirror images: distance in m, and length of the difference of unit vectors.
const MIRRORED: f64 = 2e-3;
/// Distance in m of the origin from the plane of symmetry within the tolerance of mirror images.
const BESIDE: f64 = 0.5 * MIRRORED;
/// Angle in rad up to which a frame is assumed to follow the convention.
pub(super) const NEAR: f64 = 0.52;
/// Angle tolerance in rad between z and the normal of a level sole.
const LEVEL: f64 = 1e-3;
/// The same for a mesh, whose points are rounded.
const LEVEL_MESH: f64 = 1e-2;
/// Maximum angle in rad between the normals of both soles for them to define up.
const AGREE: f64 = 0.02;
/// Length tolerance between a unit joint axis and a coordinate axis: angles in files are rounded.
const ALIGNED: f64 = 1e-4;
/// Range of the origin's height above the hips, relative to leg length, for an origin in the pelvis.
const PELVIS: [f64; 2] = [-0.1, 0.35];
/// Maximum distance of the origin in front of or behind the hips, relative to leg length.
const AHEAD: f64 = 0.3;
/// Minimum distance in m between two joints for a bone with a direction.
const BONE: f64 = 0.05;

/// The result for a base.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// Whether the two legs mirror each other. If not, all frames are preserved.
    pub mirrored: bool,
    /// The new frame relative to the file's; `None` if that is preserved.
    pub frame: Option<Isometry3<f64>>,
    /// The index of the left leg.
    pub left: usize,
    /// Shift of the origin in m to the left, into the plane of symmetry.
    pub beside: f64,
    /// Shift of the origin in m forward and up, to the middle of the hips.
    pub hips: Option<[f64; 2]>,
    /// Whether up is that of the key frame.
    pub stands: bool,
    /// The evidence for the forward direction.
    pub evidence: Evidence,
    /// 1 if the robot faces the direction that the evidence refers to, -1 if the opposite.
    pub way: i32,
}

/// Why no frame can be determined.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Unclear {
    /// Forward is ambiguous.
    Heading(Evidence),
    /// Up is ambiguous.
    Up,
}

/// Additional information about a base.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hints {
    /// From the base's frame to the file's upright world.
    pub upright: UnitQuaternion<f64>,
    /// The same in the key frame that the default positions come from.
    pub stance: Option<UnitQuaternion<f64>>,
    /// The lateral axis from the axes of the legs' joints, if the joint positions do not define one.
    pub lateral: Option<Vector3<f64>>,
    /// Up along legs that touch the ground with the tips of their feet.
    pub tiptoe: Option<Vector3<f64>>,
    /// Whether the user named the left and the right foot, in the order of the legs.
    pub named: bool,
}

/// Whether the positions of both legs' joints mirror each other.
pub(super) fn places_mirror(legs: &Legs) -> bool {
    let pairs = legs.pairs();
    let across: Vec<Vector3<f64>> = pairs.iter().map(|[first, second]| first - second).collect();
    let Some(mean) = across.iter().sum::<Vector3<f64>>().try_normalize(1e-3) else { return false };
    let parallel = across.iter().all(|way| (way - mean * way.dot(&mean)).norm() < MIRRORED);
    let middles: Vec<f64> = pairs.iter().map(|[first, second]| 0.5 * (first + second).dot(&mean)).collect();
    let middle = middles.iter().sum::<f64>() / middles.len() as f64;
    let alike = legs.own[0].len() == legs.own[1].len();
    alike && parallel && middles.iter().all(|place| (place - middle).abs() < MIRRORED)
}

/// The frame of a base.
pub(super) fn frame(legs: &Legs, soles: &[Option<Sole>; 2], hints: &Hints) -> Result<Found, Unclear> {
    let Some(survey) = Survey::of(legs, soles, hints).filter(|_| places_mirror(legs)) else {
        // Left and right are undefined, or the sides do not mirror each other; such robot files are rejected
        // later.
        let beside = |leg: usize| legs.straight[legs.feet[leg]].translation.y;
        let left = if hints.named || beside(0) >= beside(1) { 0 } else { 1 };
        let evidence = Evidence::default();
        return Ok(Found {
            mirrored: false,
            frame: None,
            left,
            beside: 0.0,
            hips: None,
            stands: false,
            evidence,
            way: 1,
        });
    };
    let forward = survey.lateral.cross(&survey.up);
    let mut evidence = heading::evidence(legs, soles, &forward, &survey.lateral);
    evidence.file = survey.file(&forward);
    evidence.asked = i32::from(hints.named);
    let way = evidence.decide().ok_or(Unclear::Heading(evidence))?;
    let estimate = survey.frame(way);
    let stance = survey.in_key_frame(&estimate, hints);
    let stands = stance.is_some();
    let turn = stance.or_else(|| survey.choose(&estimate, hints)).ok_or(Unclear::Up)?;
    let left = if way > 0 { 0 } else { 1 };
    let axis = |index: usize| Vector3::from(turn.column(index));
    let beside = survey.beside(&axis(1)).unwrap_or(0.0);
    let hips = survey.way_to_hips(&turn);
    let [ahead, above] = hips.unwrap_or_default();
    let stays = turn == Matrix3::identity() && beside == 0.0 && hips.is_none();
    let shift = axis(1) * beside + axis(0) * ahead + axis(2) * above;
    let pose = Isometry3::from_parts(Translation3::from(shift), rotation(&turn));
    Ok(Found { mirrored: true, frame: (!stays).then_some(pose), left, beside, hips, stands, evidence, way })
}

/// The directions given by the geometry, in the file's frame.
struct Survey<'a> {
    legs: &'a Legs,
    soles: &'a [Option<Sole>; 2],
    /// Unit vector from the second leg to the first one.
    lateral: Vector3<f64>,
    /// Up, perpendicular to the lateral axis, unit length.
    up: Vector3<f64>,
    /// The same from soles that agree.
    level: Option<Vector3<f64>>,
}

impl<'a> Survey<'a> {
    fn of(legs: &'a Legs, soles: &'a [Option<Sole>; 2], hints: &Hints) -> Option<Self> {
        let pairs = legs.pairs();
        let across: Vec<Vector3<f64>> = pairs.iter().map(|[first, second]| first - second).collect();
        let mean = across.iter().sum::<Vector3<f64>>().try_normalize(1e-3)?;
        let lateral = hints.lateral.unwrap_or_else(|| exact_lateral(legs, &mean));
        let flattened =
            |direction: Vector3<f64>| (direction - lateral * direction.dot(&lateral)).try_normalize(1e-3);
        let normals = [0, 1].map(|side| {
            soles[side].as_ref().map(|sole| (legs.posed[legs.feet[side]].rotation * sole.normal, sole.flat))
        });
        let middles = [0, 1].map(|side| {
            let balls = &soles[side].as_ref()?.balls;
            Some(balls.iter().map(|ball| ball.centre).sum::<Vector3<f64>>() / balls.len() as f64)
        });
        let leg = flattened(hints.tiptoe.unwrap_or_else(|| legs.upwards(middles)))?;
        let (level, soles_up) = match normals {
            [Some((a, flat)), Some((b, other))] => {
                let mean = flattened(a + b).filter(|mean| mean.dot(&leg) > 0.0);
                (mean.filter(|_| flat && other && angle(&a, &b) < AGREE), mean)
            }
            _ => (None, None),
        };
        let up = soles_up.filter(|up| angle(up, &leg) < NEAR).unwrap_or(leg);
        Some(Self { legs, soles, lateral, up, level })
    }

    /// x forward, y left, z up, estimated from the geometry.
    fn frame(&self, way: i32) -> Matrix3<f64> {
        let y = self.lateral * f64::from(way);
        Matrix3::from_columns(&[y.cross(&self.up), y, self.up])
    }

    /// Evidence of the file's x axis for a direction: 0 if it points sideways, or z not up.
    fn file(&self, forward: &Vector3<f64>) -> i32 {
        let clear = std::f64::consts::FRAC_1_SQRT_2;
        match forward.x {
            along if self.up.z < clear || along.abs() < clear => 0,
            along if along > 0.0 => 1,
            _ => -1,
        }
    }

    /// The most plausible frame: the file's own with permuted axes, the upright one of the file, that of the
    /// joint axes, or that of the level soles.
    fn choose(&self, estimate: &Matrix3<f64>, hints: &Hints) -> Option<Matrix3<f64>> {
        let world = hints.upright.inverse().to_rotation_matrix().into_inner();
        let own = nearest_permutation(estimate);
        let stands = world * nearest_permutation(&(world.transpose() * estimate));
        let is_turned = hints.upright.angle() > 1e-9;
        let near = |frame: &Matrix3<f64>| apart(frame, estimate) < NEAR;
        let follows =
            |frame: &Matrix3<f64>| near(frame) && (frame.column(1) - estimate.column(1)).norm() < MIRRORED;
        let files: Vec<Matrix3<f64>> = if is_turned { vec![own, stands] } else { vec![own] };
        let exact =
            |frame: &&Matrix3<f64>| follows(frame) && (self.is_level(frame) || self.is_aligned(frame));
        if let Some(frame) = files.iter().find(exact) {
            return Some(*frame);
        }
        let mechanism = || self.mechanism(estimate).filter(|frame| self.is_aligned(frame));
        let soles = || self.level.and_then(|up| upright(&up, &estimate.column(0).into()));
        // If no frame is exact, the pose is more likely to be inaccurate than the file's frame.
        let meant = || {
            let levels = soles().filter(|_| self.legs.known).map_or(0, |frame| self.aligned(&frame));
            files.iter().rev().find(|frame| follows(frame) && self.aligned(frame) >= levels).copied()
        };
        let mirrored = || {
            let frame = files.iter().rev().find(|frame| near(frame))?;
            let y = Vector3::from(estimate.column(1));
            let z = upright(&y, &frame.column(2).into())?;
            Some(Matrix3::from_columns(&[y.cross(&z.column(0)), y, z.column(0).into()]))
        };
        mechanism().or_else(meant).or_else(soles).or_else(mirrored)
    }

    /// The frame that is upright in the key frame, if the soles are level there but not in the file's own
    /// frame.
    fn in_key_frame(&self, estimate: &Matrix3<f64>, hints: &Hints) -> Option<Matrix3<f64>> {
        let stance =
            hints.stance.filter(|stance| stance.inverse().transform_vector(&Vector3::z()).z < 1.0 - 1e-9)?;
        let near = |frame: &Matrix3<f64>| apart(frame, estimate) < NEAR;
        let own = nearest_permutation(estimate);
        if near(&own) && self.is_level(&own) {
            return None;
        }
        let y = Vector3::from(estimate.column(1));
        let up = stance.inverse() * Vector3::z();
        let z = (up - y * up.dot(&y)).try_normalize(0.5).filter(|z| angle(z, &up) < LEVEL_MESH)?;
        let frame = Matrix3::from_columns(&[y.cross(&z), y, z]);
        if near(&frame) && self.is_level(&frame) {
            return Some(frame);
        }
        // Key frames have rounded values; the soles are exact.
        let level = self.level.filter(|level| angle(level, &up) < LEVEL_MESH)?;
        Some(Matrix3::from_columns(&[y.cross(&level), y, level]))
    }

    /// Position in m of the middle of the hips in front of and above the origin, if the origin is outside the
    /// pelvis.
    fn way_to_hips(&self, turn: &Matrix3<f64>) -> Option<[f64; 2]> {
        let hips = turn.transpose() * self.legs.hips(&self.lateral)?;
        let feet =
            self.legs.feet.map(|foot| (turn.transpose() * self.legs.straight[foot].translation.vector).z);
        let length = hips.z - 0.5 * (feet[0] + feet[1]);
        let inside = (PELVIS[0]..=PELVIS[1]).contains(&(-hips.z / length)) && hips.x.abs() <= AHEAD * length;
        (length > BONE && !inside).then_some([hips.x, hips.z])
    }

    /// Whether both soles are level with z up.
    fn is_level(&self, frame: &Matrix3<f64>) -> bool {
        self.soles.iter().zip(self.legs.feet).all(|(sole, foot)| {
            let Some(sole) = sole.as_ref().filter(|sole| sole.flat) else { return false };
            let normal = self.legs.posed[foot].rotation * sole.normal;
            angle(&normal, &frame.column(2).into()) < if sole.mesh { LEVEL_MESH } else { LEVEL }
        })
    }

    /// The directions of the mechanism: axes of the legs' joints and, if all of them are pitch joints, bones.
    fn directions(&self) -> Vec<Vector3<f64>> {
        let joints = self.legs.own.iter().flatten();
        let mut directions: Vec<Vector3<f64>> = joints.map(|joint| self.legs.axes[*joint]).collect();
        if directions.iter().all(|axis| axis.cross(&self.lateral).norm() < MIRRORED) {
            let place = |joint: usize| self.legs.straight[joint].translation.vector;
            let ways = self
                .legs
                .own
                .iter()
                .flat_map(|own| own.windows(2))
                .map(|pair| place(pair[1]) - place(pair[0]));
            let bones = ways.map(|way| way - self.lateral * way.dot(&self.lateral));
            directions.extend(bones.filter(|bone| bone.norm() > BONE).map(|bone| bone.normalize()));
        }
        directions
    }

    /// The axis of a frame that a direction is parallel to.
    fn along(frame: &Matrix3<f64>, direction: &Vector3<f64>) -> Option<usize> {
        let seen = frame.transpose() * direction;
        let axis = seen.iamax();
        let mut exact = Vector3::zeros();
        exact[axis] = seen[axis].signum();
        ((seen - exact).norm() < ALIGNED).then_some(axis)
    }

    /// The number of directions of the mechanism parallel to x or z of a frame.
    fn aligned(&self, frame: &Matrix3<f64>) -> usize {
        let axes = self
            .directions()
            .iter()
            .filter_map(|direction| Self::along(frame, direction))
            .collect::<Vec<_>>();
        axes.into_iter().filter(|axis| *axis != 1).count()
    }

    /// Whether every direction of the mechanism is parallel to an axis of a frame, and not all to y.
    fn is_aligned(&self, frame: &Matrix3<f64>) -> bool {
        self.directions().iter().all(|direction| Self::along(frame, direction).is_some())
            && self.aligned(frame) > 0
    }

    /// The frame along the axes of the mechanism that is nearest to the estimate.
    fn mechanism(&self, estimate: &Matrix3<f64>) -> Option<Matrix3<f64>> {
        let y = Vector3::from(estimate.column(1));
        let directions = self.directions();
        let across = directions.iter().find(|direction| direction.dot(&y).abs() < ALIGNED)?;
        let along = (across - y * across.dot(&y)).normalize();
        let quarters = [along, y.cross(&along), -along, -y.cross(&along)];
        let z = quarters.into_iter().max_by(|a, b| a.dot(&self.up).total_cmp(&b.dot(&self.up)))?;
        Some(Matrix3::from_columns(&[y.cross(&z), y, z]))
    }

    /// Distance in m of the plane of symmetry from the origin along y, unless it contains the origin.
    fn beside(&self, y: &Vector3<f64>) -> Option<f64> {
        let pairs = self.legs.pairs();
        let middles = pairs.iter().map(|[first, second]| 0.5 * (first + second).dot(y));
        let middle = middles.sum::<f64>() / pairs.len() as f64;
        (middle.abs() > BESIDE).then_some(middle)
    }
}

/// The lateral axis of the pitch joints, which files specify more precisely than the joint positions.
fn exact_lateral(legs: &Legs, mean: &Vector3<f64>) -> Vector3<f64> {
    let along = |joint: &usize| legs.axes[*joint] * legs.axes[*joint].dot(mean).signum();
    let pitches: Vec<Vector3<f64>> =
        legs.own.iter().flatten().map(along).filter(|axis| (axis - mean).norm() < MIRRORED).collect();
    let Some(first) = pitches.first() else { return *mean };
    let parallel = pitches.iter().all(|axis| (axis - first).norm() < ALIGNED);
    if parallel { pitches.iter().sum::<Vector3<f64>>().normalize() } else { *mean }
}
