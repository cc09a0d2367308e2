//! A robot on the ground: position control, static torques in double and single support, and what they carry.

use nalgebra::{DMatrix, DVector, Isometry3, Matrix2, Matrix6xX, Vector2};
use specforge::robot::{GravityCompensation, Kinematics, Leg, Robot, Weighting};
use specforge::sim::{Engine, State};

use super::lab::{at_rest, base, each, kinematics, standing, velocity, weight, world};
use super::table::{Row, within};

/// Step in s.
const STEP: f64 = 0.001;
/// Multiple of the robot's own gains: at 100 % the ankles of Atlas and G1 do not carry a stiff body.
const GAIN: f64 = 8.0;

/// All quantities of a robot.
pub fn rows(robot: &Robot) -> Vec<Row> {
    let mut rows = position_control(robot);
    rows.extend(double_support(robot));
    rows.extend(single_support(robot));
    rows
}

/// A robot with the damping of its position control in its joints, where both engines integrate it
/// implicitly, and without dry friction, which would make static torques ambiguous.
pub fn braced(robot: &Robot) -> Robot {
    let mut braced = robot.clone();
    for link in &mut braced.links {
        link.joint.damping += link.joint.damping_gain * GAIN.sqrt();
        link.joint.friction = 0.0;
    }
    braced
}

/// Torques of the position control around a pose with a feed-forward torque, within the effort limits.
pub fn control(robot: &Robot, state: &State, target: &[f64], forward: &[f64]) -> Vec<f64> {
    let torque = |(index, forward): (usize, &f64)| {
        let joint = &robot.links[index].joint;
        let pull = joint.stiffness_gain * GAIN * (target[index] - state.position[index]);
        (forward + pull).clamp(-joint.effort_limit, joint.effort_limit)
    };
    forward.iter().enumerate().map(torque).collect()
}

/// A moment of a robot that is held still.
struct Sample {
    /// The state.
    state: State,
    /// Mean joint torques in N m since the moment before.
    torque: Vec<f64>,
    /// Mean acceleration since the moment before.
    acceleration: DVector<f64>,
}

/// What an engine showed of a robot that was held still.
struct Held {
    /// The state at the end.
    state: State,
    /// Moments of the last three quarters.
    samples: Vec<Sample>,
    /// Mean vertical force on the left and the right foot in N over the same time.
    force: [f64; 2],
}

/// Holds a pose for four seconds. Light feet rock slowly on rapier's contacts, so figures are means over some
/// seconds.
fn hold(engine: &dyn Engine, robot: &Robot, pose: &State, forward: &[f64]) -> Held {
    let (steps, head, stride) = (4000, 1000, 50);
    let mut world = world(engine, robot, STEP, pose);
    let mut held = Held { state: pose.clone(), samples: Vec::new(), force: [0.0; 2] };
    let mut mean = vec![0.0; robot.joints()];
    let mut before = velocity(pose);
    for step in 0..steps {
        let torque = control(robot, &held.state, &pose.position, forward);
        world.step(&torque);
        world.read(&mut held.state);
        mean.iter_mut().zip(&torque).for_each(|(mean, torque)| *mean += torque / f64::from(stride));
        let contacts = world.contacts();
        if step >= head {
            (0..2)
                .for_each(|side| held.force[side] += contacts.foot_force[side][2] / f64::from(steps - head));
        }
        if step % stride == stride - 1 {
            let (torque, now) =
                (std::mem::replace(&mut mean, vec![0.0; robot.joints()]), velocity(&held.state));
            let acceleration =
                (&now - std::mem::replace(&mut before, now.clone())) / (STEP * f64::from(stride));
            if step >= head {
                held.samples.push(Sample { state: held.state.clone(), torque, acceleration });
            }
        }
    }
    held
}

/// The largest entry of the mean of vectors.
fn mean_amax(vectors: impl ExactSizeIterator<Item = DVector<f64>>) -> f64 {
    let count = vectors.len() as f64;
    vectors.reduce(|sum, vector| sum + vector).map_or(f64::INFINITY, |sum| sum.amax() / count)
}

/// The part of `g + M a - tau`, in N and N m, that no wrenches on the carrying soles explain: `J^T f`.
fn unexplained(robot: &Robot, sample: &Sample, contact: [bool; 2]) -> DVector<f64> {
    let kinematics = kinematics(robot, &sample.state);
    let size = 6 + robot.joints();
    let mut load = DVector::zeros(size);
    kinematics.gravity(&mut load);
    load += kinematics.mass_matrix() * &sample.acceleration;
    sample.torque.iter().enumerate().for_each(|(joint, torque)| load[6 + joint] -= torque);
    let carrying: Vec<usize> = (0..2).filter(|side| contact[*side]).collect();
    let mut transposed = DMatrix::zeros(size, 6 * carrying.len());
    let mut jacobian = Matrix6xX::zeros(size);
    for (place, &side) in carrying.iter().enumerate() {
        let sole = kinematics.sole(side).translation.vector.into();
        kinematics.jacobian(Some(kinematics.foot_link(side)), &sole, &mut jacobian);
        transposed.columns_mut(6 * place, 6).copy_from(&jacobian.transpose());
    }
    // The columns of Q span what the wrenches can do.
    let reach = transposed.qr().q();
    &load - &reach * (reach.transpose() * &load)
}

/// Position control alone.
fn position_control(robot: &Robot) -> Vec<Row> {
    let (braced, pose) = (braced(robot), standing(robot, 0.0));
    let none = vec![0.0; robot.joints()];
    let held = each(|engine| hold(engine, &braced, &pose, &none));
    let sag = held.each_ref().map(|held| 1e3 * (pose.base_position[2] - held.state.base_position[2]));
    let bend = held.each_ref().map(|held| {
        let bends = held.state.position.iter().zip(&pose.position).map(|(is, was)| (is - was).abs());
        bends.fold(0.0, f64::max)
    });
    let force = held.each_ref().map(|held| held.force.iter().sum::<f64>() / weight(robot) - 1.0);
    let depth = held.each_ref().map(|held| {
        let kinematics = kinematics(&braced, &held.state);
        -1e3 * kinematics.lowest_corner(0).min(kinematics.lowest_corner(1))
    });
    vec![
        Row::apart("PD hold: base lower after 4 s", "mm", within(0.5, sag)),
        Row::apart("PD hold: largest deflection of a joint", "rad", within(0.25, bend)),
        Row::between("PD hold: depth of the soles in the ground", "mm", depth, (0.0, 5.0)),
        Row::below("PD hold: force on the feet", "the weight", "relative", within(5e-4, force)),
    ]
}

/// Both feet carry in the default pose.
fn double_support(robot: &Robot) -> [Row; 3] {
    let names = [
        "double support: torques that no foot forces explain",
        "double support: largest difference of a static torque",
        "double support: weight on the left foot",
    ];
    supported(robot, &standing(robot, 0.0), [true, true], names)
}

/// The left foot carries, the right leg is lifted.
fn single_support(robot: &Robot) -> [Row; 3] {
    let names = [
        "single support: torques that no foot forces explain",
        "single support: largest difference of a static torque",
        "single support: weight on the left foot",
    ];
    supported(robot, &on_the_left_foot(robot), [true, false], names)
}

/// The torques that hold a pose against those of gravity compensation in the pose that was reached.
fn supported(robot: &Robot, pose: &State, contact: [bool; 2], names: [&'static str; 3]) -> [Row; 3] {
    let braced = braced(robot);
    let balance = |state: &State| {
        let mut compensation = GravityCompensation::new(&braced, Weighting::Uniform);
        compensation.hold(&base(state), &state.position, contact).clone()
    };
    let planned = balance(pose);
    let held = each(|engine| hold(engine, &braced, pose, &planned.torque));
    let left = held
        .each_ref()
        .map(|held| mean_amax(held.samples.iter().map(|sample| unexplained(&braced, sample, contact))));
    let apart = held.each_ref().map(|held| {
        let apart = |sample: &Sample| {
            DVector::from_column_slice(&sample.torque) - DVector::from_vec(balance(&sample.state).torque)
        };
        mean_amax(held.samples.iter().map(apart))
    });
    let share = held.each_ref().map(|held| held.force[0] / balance(&held.state).wrench[0][2] - 1.0);
    let most = planned.torque.iter().fold(0.0, |most: f64, torque| most.max(torque.abs()));
    let load = planned.wrench[0][2];
    let [unexplained, difference, carried] = names;
    [
        Row::below(unexplained, "g + M a - tau = J^T f", "N m", within(1e-4 * weight(robot), left)),
        Row::below(difference, format!("up to {most:.1} N m"), "N m", within(0.03 * most, apart)),
        Row::below(carried, format!("{load:.1} N"), "relative", within(2e-3, share)),
    ]
}

/// A pose at rest on the left sole with the centre of mass above its centre and the right leg lifted.
pub fn on_the_left_foot(robot: &Robot) -> State {
    let [standing, lifted] = [0, 1].map(|side| Leg::of(robot, side).expect("a leg with six joints"));
    let mut position = robot.default_pose();
    for ((joint, sign), bend) in [(lifted.hip_pitch, -0.25), (lifted.knee, 0.5), (lifted.ankle_pitch, -0.25)]
    {
        position[joint] += sign * bend;
    }
    let mut kinematics = Kinematics::new(robot);
    // The sole lies flat at the origin whatever the ankle does: the ankle moves the rest of the robot.
    let mut settle = |position: &[f64]| {
        kinematics.place(&Isometry3::identity(), position);
        let base = kinematics.sole(0).inverse();
        (base, (base * kinematics.com()).coords.xy())
    };
    let ankle = [standing.ankle_roll.0, standing.ankle_pitch.0];
    for _ in 0..20 {
        let (_, miss) = settle(&position);
        let slopes = ankle.map(|joint| {
            let mut moved = position.clone();
            moved[joint] += 1e-6;
            (settle(&moved).1 - miss) / 1e-6
        });
        let step: Vector2<f64> = Matrix2::from_columns(&slopes).try_inverse().expect("an ankle tilts") * miss;
        (0..2).for_each(|axis| position[ankle[axis]] -= step[axis]);
    }
    let (base, miss) = settle(&position);
    assert!(miss.norm() < 1e-9, "{}: no balance on the left foot", robot.name);
    at_rest(&base, position)
}
