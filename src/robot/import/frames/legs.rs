//! The legs of a welded tree before its frames are changed: joints, poses and axes in the base's frame.

use nalgebra::{Isometry3, Vector3};

use super::super::fill::{Fill, figure};
use super::super::tree::Hinge;
use super::super::welded::Welded;
use crate::robot::{Kinematics, legs};

/// Excess in rad of a default position over the joint's limits that is attributed to rounding.
const BEYOND: f64 = 1e-4;

/// Both legs, in the order of the given feet.
#[derive(Clone, Debug)]
pub(super) struct Legs {
    /// The feet's links.
    pub feet: [usize; 2],
    /// The joints of each leg from the hip down, without shared ones.
    pub own: [Vec<usize>; 2],
    /// Poses of all links with all joints at zero.
    pub straight: Vec<Isometry3<f64>>,
    /// Poses of all links in the default pose. Joints without a default position are at zero, and all joints
    /// if one is outside its limits.
    pub posed: Vec<Isometry3<f64>>,
    /// Axes of all joints with all joints at zero.
    pub axes: Vec<Vector3<f64>>,
    /// Whether the default positions of all joints of the legs are known.
    pub known: bool,
    /// Centre of mass of each leg with all joints at zero; `None` for one without mass.
    pub coms: [Option<Vector3<f64>>; 2],
    /// Names of the bodies and joints of each leg.
    pub names: [Vec<String>; 2],
    /// Names of the joints whose default positions are outside their limits.
    pub outside: Vec<String>,
    ranges: Vec<Option<[f64; 2]>>,
}

impl Legs {
    /// The legs of a tree with these feet; default positions come from the file or the fills.
    pub fn of(welded: &Welded, feet: [usize; 2], fills: &[Fill]) -> Self {
        let mut skeleton = welded.skeleton();
        skeleton.feet.iter_mut().zip(feet).for_each(|(foot, link)| foot.link = link);
        let mut kinematics = Kinematics::new(&skeleton);
        let mut poses = |position: &[f64]| -> Vec<Isometry3<f64>> {
            kinematics.place(&Isometry3::identity(), position);
            (0..position.len()).map(|link| *kinematics.pose(link)).collect()
        };
        let given = |key: &str, hinge: &Hinge, known: Option<f64>| figure(key, hinge, known, fills, welded);
        let mut defaults: Vec<Option<f64>> =
            welded.hinges().map(|hinge| given("default_position", hinge, hinge.default_position)).collect();
        let beyond = |(hinge, position): (&Hinge, &Option<f64>)| {
            let lower = given("lower", hinge, hinge.lower).unwrap_or(f64::NEG_INFINITY);
            let upper = given("upper", hinge, hinge.upper).unwrap_or(f64::INFINITY);
            position
                .filter(|position| *position < lower - BEYOND || *position > upper + BEYOND)
                .map(|_| hinge.name.clone())
        };
        let outside: Vec<String> = welded.hinges().zip(&defaults).filter_map(beyond).collect();
        // An impossible pose contains no information about the frames.
        if !outside.is_empty() {
            defaults.iter_mut().for_each(|position| *position = None);
        }
        let positions: Vec<f64> = defaults.iter().map(|position| position.unwrap_or(0.0)).collect();
        let posed = poses(&positions);
        let straight = poses(&vec![0.0; positions.len()]);
        let axes = (0..positions.len()).map(|joint| *kinematics.axis(joint)).collect();
        let own = [0, 1].map(|side| {
            let mut joints = legs::own(&kinematics, side);
            joints.reverse();
            joints
        });
        let known = own.iter().flatten().all(|joint| defaults[*joint].is_some());
        let names = own.clone().map(|joints| {
            let both = |joint: usize| {
                [welded.links[joint].body.name.clone(), welded.links[joint].hinge.name.clone()]
            };
            joints.into_iter().flat_map(both).collect()
        });
        let coms = own.each_ref().map(|joints| {
            let masses = || joints.iter().map(|joint| (welded.links[*joint].body.mass, *joint));
            let whole: f64 = masses().map(|(mass, _)| mass).sum();
            let place = |joint: usize| (straight[joint] * welded.links[joint].body.com).coords;
            (whole > 0.0)
                .then(|| masses().map(|(mass, joint)| place(joint) * mass).sum::<Vector3<f64>>() / whole)
        });
        let ranges = welded.links.iter().map(|link| Some([link.hinge.lower?, link.hinge.upper?])).collect();
        Self { feet, own, straight, posed, axes, known, coms, names, outside, ranges }
    }

    /// The middle of a joint's range in rad, if the file has one.
    pub fn middle_of_range(&self, joint: usize) -> Option<f64> {
        self.ranges[joint].map(|[lower, upper]| 0.5 * (lower + upper))
    }

    /// Pairs of points in m, with all joints at zero, that mirror each other if the legs do.
    pub fn pairs(&self) -> Vec<[Vector3<f64>; 2]> {
        let place = |joint: usize| self.straight[joint].translation.vector;
        let [first, second] = &self.own;
        if first.len() == second.len() {
            return first.iter().zip(second).map(|(a, b)| [place(*a), place(*b)]).collect();
        }
        vec![self.feet.map(place)]
    }

    /// The vector in m from the lowest points of the feet along `down` to the hips in the default pose: the
    /// up direction for legs on tiptoe with bent knees. `tips` are those points in the frames of the feet.
    pub fn upwards_from(&self, tips: [Vector3<f64>; 2]) -> Vector3<f64> {
        let way = |side: usize| {
            let (foot, hip) = (self.feet[side], self.own[side].first().copied().unwrap_or(self.feet[side]));
            self.posed[hip].translation.vector
                - (self.posed[foot] * nalgebra::Point3::from(tips[side])).coords
        };
        0.5 * (way(0) + way(1))
    }

    /// The midpoint of the hips, at the height of their pitch axes, with all joints at zero, in m.
    pub fn hips(&self, lateral: &Vector3<f64>) -> Option<Vector3<f64>> {
        let pitch = |joint: &&usize| self.axes[**joint].dot(lateral).abs() > std::f64::consts::FRAC_1_SQRT_2;
        let hip = |side: usize| self.own[side].iter().find(pitch).or_else(|| self.own[side].first());
        let place = |joint: &usize| self.straight[*joint].translation.vector;
        Some(0.5 * (place(hip(0)?) + place(hip(1)?)))
    }

    /// The vector in m from the middle of the feet to the middle of the hips in the default pose; feet with
    /// one joint are located by `soles`.
    pub fn upwards(&self, soles: [Option<Vector3<f64>>; 2]) -> Vector3<f64> {
        let place = |joint: usize| self.posed[joint].translation.vector;
        let mut along = Vector3::zeros();
        for (side, sole) in soles.into_iter().enumerate() {
            let (foot, hip) = (self.feet[side], self.own[side].first().copied().unwrap_or(self.feet[side]));
            let leg = place(hip) - place(foot);
            let sole = sole.filter(|_| leg.norm() < 0.05).map(|sole| self.posed[foot].rotation * sole);
            along += leg - sole.unwrap_or_default();
        }
        0.5 * along
    }
}
