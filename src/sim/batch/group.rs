//! Robots that are stepped together, one per lane.

#![expect(
    clippy::needless_range_loop,
    reason = "iterators are not inlined into code for an instruction set (see the module above)"
)]

use std::sync::Arc;

use super::super::scene::{Contacts, State};
use super::compile::Compiled;
use super::contact::Touch;
use super::dynamics::Smooth;
use super::figures::{Figures, Topology};
use super::lane::{Kernel, Lane, Mask};
use super::math::{V3, dot, scaled, sin_cos};
use super::model::Ground;
use super::newton;
use super::scratch::Scratch;
use super::work::{Motion, Work};

/// Joint speed in rad/s, and base speed in SI units, above which a state counts as diverged.
const MAX_RATE: f64 = 1000.0;
/// Distance in m from the origin above which a state counts as diverged.
const MAX_DISTANCE: f64 = 1000.0;

/// An instruction set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Set {
    /// One environment at a time.
    Scalar,
    /// Four (AVX2 and FMA).
    Avx2,
    /// Eight (AVX-512).
    Avx512,
}

impl Set {
    /// The sets that this processor has, smallest first.
    pub fn available() -> Vec<Self> {
        let mut sets = vec![Self::Scalar];
        #[cfg(target_arch = "x86_64")]
        {
            sets.extend(pulp::x86::V3::try_new().map(|_| Self::Avx2));
            sets.extend(pulp::x86::V4::try_new().map(|_| Self::Avx512));
        }
        sets
    }

    /// Number of lanes.
    pub fn lanes(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Avx2 => 4,
            Self::Avx512 => 8,
        }
    }

    /// The set of this name: `scalar`, `avx2` or `avx512`.
    pub fn named(name: &str) -> Option<Self> {
        [("scalar", Self::Scalar), ("avx2", Self::Avx2), ("avx512", Self::Avx512)]
            .into_iter()
            .find_map(|(known, set)| (known == name).then_some(set))
    }
}

/// Robots of one topology on one ground. Empty lanes hold a robot at rest in the air and cost nothing extra.
pub trait Group: Send {
    /// Number of robots.
    fn lanes(&self) -> usize;
    /// Puts a robot in a state into a lane; `compiled` must fit the one that the group was made with.
    fn load(&mut self, lane: usize, compiled: &Compiled, state: &State);
    /// Sets the torques of a lane's next step in N m, in the model's joint order.
    fn apply(&mut self, lane: usize, torque: &[f64]);
    /// Applies a force in N (world axes) at the base's centre of mass of a lane until it is changed.
    fn push(&mut self, lane: usize, force: [f64; 3]);
    /// Advances by one physics step every lane whose torques were set since the last call.
    fn advance(&mut self);
    /// Writes the state of a lane.
    fn read(&self, lane: usize, state: &mut State);
    /// Contacts of a lane in the last step.
    fn contacts(&self, lane: usize) -> Contacts;
    /// Whether every number of a lane's state is finite and within physical bounds.
    fn is_sane(&self, lane: usize) -> bool;
}

/// A group of robots for an instruction set, or `None` if the processor lacks it.
pub fn group(set: Set, compiled: &Compiled, ground: &Arc<Ground>) -> Option<Box<dyn Group>> {
    match set {
        Set::Scalar => Some(Box::new(Lanes::<f64>::new(compiled, ground))),
        #[cfg(target_arch = "x86_64")]
        Set::Avx2 => {
            pulp::x86::V3::try_new()?;
            Some(Box::new(Lanes::<super::lane::F64x4>::new(compiled, ground)))
        }
        #[cfg(target_arch = "x86_64")]
        Set::Avx512 => {
            pulp::x86::V4::try_new()?;
            Some(Box::new(Lanes::<super::lane::F64x8>::new(compiled, ground)))
        }
        #[cfg(not(target_arch = "x86_64"))]
        Set::Avx2 | Set::Avx512 => None,
    }
}

struct Lanes<L: Lane> {
    topology: Arc<Topology>,
    /// The tree's joint for each joint of the model.
    counted: Vec<usize>,
    ground: Arc<Ground>,
    figures: Figures<L>,
    state: Motion<L>,
    work: Work<L>,
}

impl<L: Lane> Lanes<L> {
    fn new(compiled: &Compiled, ground: &Arc<Ground>) -> Self {
        let topology = compiled.topology.clone();
        let mut counted = vec![0; topology.order.len()];
        topology.order.iter().enumerate().for_each(|(own, joint)| counted[*joint] = own);
        let mut lanes = Self {
            figures: Figures::room(&topology),
            state: Motion::at_rest(topology.tree.joints()),
            work: Work::new(&topology),
            ground: ground.clone(),
            counted,
            topology,
        };
        let joints = lanes.counted.len();
        let state = State {
            // High above any ground.
            base_position: [0.0, 0.0, 1e6],
            base_orientation: [1.0, 0.0, 0.0, 0.0],
            position: vec![0.0; joints],
            velocity: vec![0.0; joints],
            ..State::default()
        };
        (0..L::LANES).for_each(|lane| lanes.load(lane, compiled, &state));
        lanes
    }

    #[inline]
    fn set(values: &mut [L], index: usize, lane: usize, number: f64) {
        L::numbers_mut(values)[index * L::LANES + lane] = number;
    }

    #[inline]
    fn get(values: &[L], index: usize, lane: usize) -> f64 {
        L::numbers(values)[index * L::LANES + lane]
    }

    #[inline]
    fn array<const N: usize>(values: &[L; N], lane: usize) -> [f64; N] {
        let mut numbers = [0.0; N];
        for index in 0..N {
            numbers[index] = Self::get(values, index, lane);
        }
        numbers
    }
}

impl<L: Lane> Group for Lanes<L> {
    fn lanes(&self) -> usize {
        L::LANES
    }

    fn load(&mut self, lane: usize, compiled: &Compiled, state: &State) {
        assert!(*compiled.topology == *self.topology, "the worlds of a group have one topology");
        self.figures.load(lane, &compiled.figures);
        let motion = &mut self.state;
        for axis in 0..3 {
            Self::set(&mut motion.position, axis, lane, state.base_position[axis]);
            Self::set(&mut motion.velocity, axis, lane, state.base_velocity[axis]);
            Self::set(&mut motion.rate, axis, lane, state.base_rate[axis]);
            Self::set(&mut motion.push, axis, lane, 0.0);
            motion.foot_force.iter_mut().for_each(|force| Self::set(force, axis, lane, 0.0));
        }
        let [w, x, y, z] = state.base_orientation;
        let length = (w * w + x * x + y * y + z * z).sqrt();
        for (index, part) in state.base_orientation.into_iter().enumerate() {
            Self::set(&mut motion.orientation, index, lane, part / length);
        }
        for (joint, &own) in self.counted.iter().enumerate() {
            Self::set(&mut motion.joints, own, lane, state.position[joint]);
            Self::set(&mut motion.joint_rates, own, lane, state.velocity[joint]);
            Self::set(&mut motion.torque, own, lane, 0.0);
        }
        (0..motion.warm.len()).for_each(|index| Self::set(&mut motion.warm, index, lane, 0.0));
        Self::set(std::slice::from_mut(&mut motion.body_touch), 0, lane, 0.0);
        Self::set(std::slice::from_mut(&mut motion.due), 0, lane, 0.0);
        Self::set(std::slice::from_mut(&mut motion.fresh), 0, lane, 1.0);
        L::call(Look(motion));
    }

    fn apply(&mut self, lane: usize, torque: &[f64]) {
        for (torque, &own) in torque.iter().zip(&self.counted) {
            Self::set(&mut self.state.torque, own, lane, *torque);
        }
        Self::set(std::slice::from_mut(&mut self.state.due), 0, lane, 1.0);
    }

    fn push(&mut self, lane: usize, force: [f64; 3]) {
        (0..3).for_each(|axis| Self::set(&mut self.state.push, axis, lane, force[axis]));
    }

    fn advance(&mut self) {
        let Self { topology, ground, figures, state, work, .. } = self;
        if L::numbers(&[state.due]).iter().all(|due| *due == 0.0) {
            return;
        }
        L::call(Smooth { topology, figures, state, work });
        L::call(Touch { topology, figures, ground, state, work });
        L::call(newton::Solve { topology, figures, state, work });
        L::call(Integrate { topology, figures, state, work });
        state.due = L::zero();
    }

    fn read(&self, lane: usize, state: &mut State) {
        let motion = &self.state;
        state.base_position = Self::array(&motion.position, lane);
        state.base_orientation = Self::array(&motion.orientation, lane);
        state.base_velocity = Self::array(&motion.velocity, lane);
        state.base_rate = Self::array(&motion.rate, lane);
        state.position.clear();
        state.velocity.clear();
        for &own in &self.counted {
            state.position.push(Self::get(&motion.joints, own, lane));
            state.velocity.push(Self::get(&motion.joint_rates, own, lane));
        }
    }

    fn contacts(&self, lane: usize) -> Contacts {
        let [left, right] = &self.state.foot_force;
        let foot_force = [Self::array(left, lane), Self::array(right, lane)];
        Contacts { foot_force, body: Self::get(&[self.state.body_touch], 0, lane) != 0.0 }
    }

    fn is_sane(&self, lane: usize) -> bool {
        Self::get(&[self.state.sane], 0, lane) != 0.0
    }
}

/// Whether every number of the states is finite and within physical bounds, as 1 or 0. Comparisons with NaN
/// are false, so NaN is caught, too.
#[inline(always)]
fn sane<L: Lane>(motion: &Motion<L>) -> L {
    let mut sane = L::Mask::splat(true);
    let mut within = |values: &[L], bound: f64| {
        for value in values {
            sane = sane.and(value.abs().lt(L::splat(bound)));
        }
    };
    within(&motion.position, MAX_DISTANCE);
    within(&motion.orientation, MAX_DISTANCE);
    within(&motion.joints, MAX_DISTANCE);
    within(&motion.velocity, MAX_RATE);
    within(&motion.rate, MAX_RATE);
    within(&motion.joint_rates, MAX_RATE);
    L::keep(sane, L::splat(1.0))
}

/// Checks the states again after one was written.
struct Look<'a, L>(&'a mut Motion<L>);

impl<L: Lane> Kernel<L> for Look<'_, L> {
    type Out = ();
    #[inline(always)]
    fn run(self) {
        self.0.sane = sane(self.0);
    }
}

/// Semi-implicit Euler step, implicit in the joint damping as in MuJoCo.
struct Integrate<'a, L: Lane> {
    topology: &'a Topology,
    figures: &'a Figures<L>,
    state: &'a mut Motion<L>,
    work: &'a mut Work<L>,
}

impl<L: Lane> Kernel<L> for Integrate<'_, L> {
    type Out = ();
    #[inline(always)]
    fn run(self) {
        let Self { topology, figures, state, work } = self;
        let (tree, h) = (&topology.tree, figures.world[0].step);
        let damped = L::zero().lt(figures.world[0].damped);
        let Work { mass, scratch, solver, .. } = work;
        let Scratch { total, hessian, acceleration, foot_force, body_touch, .. } = solver;
        if damped.any() {
            hessian.copy(mass);
            for joint in 0..tree.joints() {
                let entry = &mut hessian.rows[tree.rows[joint].diagonal()];
                *entry = h.fma(figures.damping[joint], *entry);
            }
            hessian.factor(tree, scratch);
            hessian.solve(tree, total);
        }
        let due = L::zero().lt(state.due);
        let change = |index: usize| L::select(damped, total[index], acceleration[index]);
        for i in 0..3 {
            state.rate[i] = stepped(due, h.fma(change(i), state.rate[i]), state.rate[i]);
            state.velocity[i] = stepped(due, h.fma(change(3 + i), state.velocity[i]), state.velocity[i]);
            state.position[i] = stepped(due, h.fma(state.velocity[i], state.position[i]), state.position[i]);
        }
        for joint in 0..tree.joints() {
            state.joint_rates[joint] =
                stepped(due, h.fma(change(6 + joint), state.joint_rates[joint]), state.joint_rates[joint]);
            state.joints[joint] =
                stepped(due, h.fma(state.joint_rates[joint], state.joints[joint]), state.joints[joint]);
        }
        let orientation = turned_on(state.orientation, state.rate, h);
        for i in 0..4 {
            state.orientation[i] = stepped(due, orientation[i], state.orientation[i]);
        }
        let known = state.fresh.lt(L::splat(0.5));
        for i in 0..acceleration.len() {
            let (new, old) = (acceleration[i], state.acceleration[i]);
            state.warm[i] = stepped(due, new + L::keep(known, new - old), state.warm[i]);
            state.acceleration[i] = stepped(due, new, old);
        }
        state.fresh = stepped(due, L::zero(), state.fresh);
        for foot in 0..2 {
            for i in 0..3 {
                state.foot_force[foot][i] = stepped(due, foot_force[foot][i], state.foot_force[foot][i]);
            }
        }
        state.body_touch = stepped(due, *body_touch, state.body_touch);
        state.sane = sane(state);
    }
}

/// The new number in the lanes that are stepped, the old one elsewhere. Negative zeros become positive, so
/// that a lane's bits cannot depend on operations that are skipped when its neighbours do not need them.
#[inline(always)]
fn stepped<L: Lane>(due: L::Mask, new: L, old: L) -> L {
    L::select(due, new + L::zero(), old)
}

/// An orientation after rotating for a time at a rate in world axes.
#[inline(always)]
fn turned_on<L: Lane>([w, x, y, z]: [L; 4], rate: V3<L>, time: L) -> [L; 4] {
    let half = L::splat(0.5);
    let speed = dot(rate, rate).max(L::splat(1e-24)).sqrt();
    let (sine, cosine) = sin_cos(half * time * speed);
    let [a, b, c] = scaled(sine / speed, rate);
    // (cosine, a, b, c) times (w, x, y, z).
    let turned = [
        cosine * w - a * x - b * y - c * z,
        cosine * x + a * w + b * z - c * y,
        cosine * y - a * z + b * w + c * x,
        cosine * z + a * y - b * x + c * w,
    ];
    let [w, x, y, z] = turned;
    let length = w.fma(w, x.fma(x, y.fma(y, z * z))).sqrt();
    [w / length, x / length, y / length, z / length]
}
