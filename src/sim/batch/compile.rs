//! Compiles a model into what the worlds of a group share and the parameters of one world.

use super::dynamics;
use super::figures::{Figures, IMPEDANCE, ShapeKind, ShapeOf, Topology};
use super::lane::Lane;
use super::math::V3;
use super::model::{IDENTITY, Kind, Model, Rows, Settings};
use super::tree::Tree;
use super::work::{Motion, Work};

/// Time constant in s of joint limits and joint friction (MuJoCo's default `solref`, damping ratio 1).
const ROW_TIME: f64 = 0.02;
/// Tolerance of the solver, relative to the mean inertia as in MuJoCo.
const TOLERANCE: f64 = 1e-10;
/// MuJoCo's `mjMINVAL`.
const SMALLEST: f64 = 1e-15;

/// A world's model, ready to be loaded into a lane.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// The part that all worlds of its group share.
    pub(crate) topology: std::sync::Arc<Topology>,
    pub(crate) figures: Figures<f64>,
}

impl Compiled {
    /// Compiles a model.
    pub fn new(model: &Model, settings: &Settings) -> Self {
        let (topology, mut figures) = translate(model, settings);
        derive(&topology, &mut figures);
        Self { topology: std::sync::Arc::new(topology), figures }
    }

    /// Whether both can be in one group.
    pub fn fits(&self, other: &Self) -> bool {
        std::sync::Arc::ptr_eq(&self.topology, &other.topology) || self.topology == other.topology
    }

    /// Inverse weights as MuJoCo defines them: of each joint (`dof_invweight0`) and, for translation, of each
    /// body (`body_invweight0`), in the model's order.
    pub fn inverse_weights(&self) -> (Vec<f64>, Vec<f64>) {
        let joints = self.topology.order.len();
        let (mut of_joints, mut of_bodies) = (vec![0.0; joints], vec![self.figures.weight[0]; joints + 1]);
        for (own, &joint) in self.topology.order.iter().enumerate() {
            of_joints[joint] = self.figures.joint_weight[own];
            of_bodies[joint + 1] = self.figures.weight[own + 1];
        }
        (of_joints, of_bodies)
    }
}

fn times(a: &Rows, b: &Rows) -> Rows {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn transposed(a: &Rows) -> Rows {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

fn apply(a: &Rows, v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i][0] * v[0] + a[i][1] * v[1] + a[i][2] * v[2])
}

/// A frame in which the axis is the positive unit vector of the returned index. The frame is not rotated if
/// the axis already is a unit vector.
fn straightened(axis: [f64; 3]) -> (Rows, usize) {
    for k in 0..3 {
        let (u, v) = ((k + 1) % 3, (k + 2) % 3);
        if axis[u] == 0.0 && axis[v] == 0.0 && axis[k].abs() == 1.0 {
            let mut turn = IDENTITY;
            // Half a turn about the next axis.
            if axis[k] < 0.0 {
                (turn[k][k], turn[v][v]) = (-1.0, -1.0);
            }
            return (turn, k);
        }
    }
    // The columns x, y, axis, with x orthogonal to the axis and to the unit vector that is furthest from it.
    let far = (0..3).fold(0, |far, k| if axis[k].abs() < axis[far].abs() { k } else { far });
    let mut x: [f64; 3] = std::array::from_fn(|i| if i == far { 1.0 } else { 0.0 } - axis[far] * axis[i]);
    let length = (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]).sqrt();
    x = x.map(|part| part / length);
    let y =
        [axis[1] * x[2] - axis[2] * x[1], axis[2] * x[0] - axis[0] * x[2], axis[0] * x[1] - axis[1] * x[0]];
    (std::array::from_fn(|i| [x[i], y[i], axis[i]]), 2)
}

/// The model in the engine's frames: every link's frame is rotated so that its joint's axis is a coordinate
/// axis.
fn translate(model: &Model, settings: &Settings) -> (Topology, Figures<f64>) {
    let parents: Vec<usize> = model.joints.iter().map(|joint| joint.parent).collect();
    let order = Tree::depth_first(&parents);
    let mut counted = vec![0; order.len() + 1];
    order.iter().enumerate().for_each(|(own, joint)| counted[joint + 1] = own + 1);
    let tree = Tree::new(order.iter().map(|joint| counted[parents[*joint]]).collect());
    let mut turns = vec![IDENTITY];
    let mut axes = Vec::new();
    for &joint in &order {
        let (turn, axis) = straightened(model.joints[joint].axis);
        turns.push(turn);
        axes.push(axis);
    }
    let bodies = || std::iter::once(0).chain(order.iter().map(|joint| joint + 1));
    let mut shapes = Vec::new();
    for (own, body) in bodies().enumerate() {
        for shape in &model.bodies[body].shapes {
            let turn = times(&transposed(&turns[own]), &shape.turn);
            let plain = turn == IDENTITY;
            shapes.push(ShapeOf { body: own, kind: ShapeKind::of(&shape.kind), plain, foot: shape.foot });
        }
    }
    let mut topology = Topology { tree, order: order.clone(), axis: axes, plain: Vec::new(), shapes };
    let mut figures = Figures::<f64>::room(&topology);
    let mut next = 0;
    for (own, index) in bodies().enumerate() {
        let (body, back) = (&model.bodies[index], transposed(&turns[own]));
        figures.mass[own] = body.mass;
        figures.com[own] = apply(&back, body.com);
        let [xx, yy, zz, xy, xz, yz] = body.inertia;
        let tensor = times(&back, &times(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], &turns[own]));
        figures.tensor[own] =
            [tensor[0][0], tensor[1][1], tensor[2][2], tensor[0][1], tensor[0][2], tensor[1][2]];
        let first = next;
        for shape in &body.shapes {
            let turn = transposed(&times(&back, &shape.turn));
            figures.shape_place[next] = apply(&back, shape.place);
            figures.shape_turn[next] = turn;
            figures.shape_size[next] = shape.kind.size();
            figures.shape_friction[next] = shape.friction;
            next += 1;
        }
        figures.around[own] =
            around(&figures.shape_place[first..next], body.shapes.iter().map(|shape| shape.kind));
    }
    for (own, &index) in order.iter().enumerate() {
        let joint = &model.joints[index];
        let back = transposed(&turns[topology.tree.parent[own]]);
        figures.place[own] = apply(&back, joint.place);
        let turn = times(&times(&back, &joint.turn), &turns[own + 1]);
        topology.plain.push(turn == IDENTITY);
        // Columns.
        figures.turn[own] = transposed(&turn);
        figures.armature[own] = joint.armature;
        figures.damping[own] = joint.damping;
        figures.friction[own] = joint.friction;
        [figures.lower[own], figures.upper[own]] = joint.limits;
        figures.effort[own] = joint.effort;
    }
    let constants = |time: f64| {
        let time = time.max(2.0 * settings.step);
        (2.0 / (IMPEDANCE[1] * time), 1.0 / (IMPEDANCE[1] * IMPEDANCE[1] * time * time))
    };
    let world = &mut figures.world[0];
    (world.step, world.gravity) = (settings.step, settings.gravity);
    (world.contact_b, world.contact_k) = constants(settings.contact_time);
    (world.row_b, world.row_k) = constants(ROW_TIME);
    world.damped = if model.joints.iter().any(|joint| joint.damping > 0.0) { 1.0 } else { 0.0 };
    (topology, figures)
}

/// A bounding sphere of shapes, slightly larger than necessary.
fn around(places: &[V3<f64>], kinds: impl Iterator<Item = Kind>) -> [f64; 4] {
    let count = places.len().max(1) as f64;
    let centre: V3<f64> =
        std::array::from_fn(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / count);
    let reach = |(place, kind): (&V3<f64>, Kind)| {
        let apart: f64 = (0..3).map(|axis| (place[axis] - centre[axis]).powi(2)).sum();
        apart.sqrt() + kind.radius()
    };
    let radius = places.iter().zip(kinds).map(reach).fold(0.0, f64::max);
    [centre[0], centre[1], centre[2], radius * (1.0 + 1e-9) + 1e-9]
}

/// What MuJoCo's `mj_setConst` derives from the parameters in the zero pose: inverse weights and the mean
/// inertia.
fn derive(topology: &Topology, figures: &mut Figures<f64>) {
    let tree = &topology.tree;
    let (joints, size) = (tree.joints(), 6 + tree.joints());
    let mut work = Work::<f64>::new(topology);
    let state = Motion::<f64>::at_rest(joints);
    f64::call(dynamics::Smooth { topology, figures, state: &state, work: &mut work });
    let mut mean = (0..6).map(|i| work.mass.base[i][i]).sum::<f64>();
    mean += tree.rows.iter().map(|row| work.mass.rows[row.diagonal()]).sum::<f64>();
    mean /= size as f64;
    let mut factors = work.mass.clone();
    factors.factor(tree, &mut work.scratch);
    let weigh = |force: &[f64]| -> f64 {
        let mut motion = force.to_vec();
        factors.solve(tree, &mut motion);
        motion.iter().zip(force).map(|(motion, force)| motion * force).sum()
    };
    for joint in 0..joints {
        let mut unit = vec![0.0; size];
        unit[6 + joint] = 1.0;
        let weight = weigh(&unit).max(SMALLEST);
        figures.joint_weight[joint] = weight;
        let [low, _] = IMPEDANCE;
        figures.friction_d[joint] = 1.0 / ((1.0 - low) * weight / low).max(SMALLEST);
    }
    for body in 0..=joints {
        let at: V3<f64> = std::array::from_fn(|axis| {
            work.place[body][axis]
                + (0..3).map(|k| work.turn[body][k][axis] * figures.com[body][k]).sum::<f64>()
        });
        let mut sum = 0.0;
        for axis in 0..3 {
            let mut push = [0.0; 3];
            push[axis] = 1.0;
            let moment = [
                at[1] * push[2] - at[2] * push[1],
                at[2] * push[0] - at[0] * push[2],
                at[0] * push[1] - at[1] * push[0],
            ];
            let mut force = vec![0.0; size];
            force[..3].copy_from_slice(&moment);
            force[3..6].copy_from_slice(&push);
            let own = body.checked_sub(1);
            for joint in own.into_iter().flat_map(|own| tree.above[own].iter().copied().chain([own])) {
                let s = work.axes[joint];
                force[6 + joint] = (0..3).map(|k| s[k] * moment[k] + s[3 + k] * push[k]).sum();
            }
            sum += weigh(&force);
        }
        figures.weight[body] = sum / 3.0;
    }
    let scale = 1.0 / (mean * size as f64);
    let world = &mut figures.world[0];
    world.small_gradient = (TOLERANCE / scale).powi(2);
    world.small_decrement = 2.0 * TOLERANCE / scale;
}
