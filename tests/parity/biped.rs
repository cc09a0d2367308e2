//! The biped of the engine tests: TOCABI's legs and trunk, left and right exact mirror images.

use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use specforge::robot::model::Body;
use specforge::robot::{Collision, Foot, Joint, Link, Robot, Shape};
use specforge::sim::State;

/// Figures of one leg link: mass, centre of mass, ixx iyy izz ixy ixz iyz, joint origin, axis, limits,
/// effort limit, friction, armature, gains, default position.
type Row = (f64, [f64; 3], [f64; 6], [f64; 3], usize, [f64; 2], [f64; 6]);

const LEG: [Row; 6] = [
    (
        2.679,
        [-0.06477, 0.0, 0.05149],
        [0.11407, 0.11407, 0.11407, 0.0, 0.0, 0.0],
        [0.11, 0.1025, -0.1025],
        2,
        [-0.6, 0.6],
        [333.0, 8.22, 0.614, 2000.0, 15.0, 0.0],
    ),
    (
        2.67,
        [-0.04801, 0.0022, 2e-5],
        [0.124407, 0.124407, 0.124407, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        0,
        [-3.0, 3.0],
        [232.0, 4.3, 0.862, 5000.0, 50.0, 0.0],
    ),
    (
        5.65,
        [-0.0003, 0.00032, -0.247],
        [0.0794, 0.08, 0.009967, 4.1e-5, 0.000727, -0.001537],
        [0.0, 0.0, 0.0],
        1,
        [-1.5, 3.0],
        [263.0, 3.77, 1.09, 4000.0, 20.0, -0.24],
    ),
    (
        2.614,
        [0.007, 0.00214, -0.1686],
        [0.23895, 0.23895, 0.23895, 0.0, 0.0, 0.0],
        [0.0, 0.0, -0.35],
        1,
        [-0.5, 3.0],
        [289.0, 4.18, 1.09, 3700.0, 25.0, 0.6],
    ),
    (
        2.833,
        [-0.00228, -0.0006, 0.0],
        [0.003548, 0.004046, 0.00397, 4e-6, 2.2e-6, 5e-6],
        [0.0, 0.0, -0.35],
        1,
        [-1.4, 1.0],
        [222.0, 7.09, 1.09, 3200.0, 24.0, -0.36],
    ),
    (
        4.45,
        [-0.026755, -4.2e-5, -0.068218],
        [0.021, 0.044009, 0.030622, 3.9e-5, 0.012526, -1.7e-5],
        [0.0, 0.0, 0.0],
        0,
        [-0.664, 0.664],
        [166.0, 3.41, 0.36, 3200.0, 24.0, 0.0],
    ),
];

fn tensor([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

fn body(name: &str, mass: f64, com: [f64; 3], inertia: [f64; 6], collisions: Vec<Collision>) -> Body {
    Body { name: name.into(), mass, com: Point3::from(com), inertia: tensor(inertia), collisions }
}

fn link(side: &str, sign: f64, index: usize, first: usize) -> Link {
    let (mass, com, [xx, yy, zz, xy, xz, yz], origin, axis, [lower, upper], drive) = LEG[index];
    let mut direction = Vector3::zeros();
    direction[axis] = 1.0;
    let collisions = match index {
        3 => vec![Collision {
            shape: Shape::Capsule(0.1, 0.05),
            pose: Isometry3::translation(0.0, 0.0, -0.175),
        }],
        _ => Vec::new(),
    };
    // Yaw and roll of the right leg move the other way, so do their limits.
    let (lower, upper) = if axis == 1 || sign > 0.0 { (lower, upper) } else { (-upper, -lower) };
    Link {
        body: body(
            &format!("{side}{index}"),
            mass,
            [com[0], sign * com[1], com[2]],
            [xx, yy, zz, sign * xy, xz, sign * yz],
            collisions,
        ),
        parent: if index == 0 { None } else { Some(first + index - 1) },
        joint: Joint {
            name: format!("{side}_joint_{index}"),
            origin: Isometry3::translation(origin[0], sign * origin[1], origin[2]),
            axis: Unit::new_normalize(direction),
            lower,
            upper,
            effort_limit: drive[0],
            velocity_limit: 4.03,
            damping: 2.0,
            friction: drive[1],
            armature: drive[2],
            stiffness_gain: drive[3],
            damping_gain: drive[4],
            default_position: drive[5],
        },
    }
}

/// A 13-link, 18-dof biped of 104.5 kg.
pub fn biped() -> Robot {
    let trunk = Collision {
        shape: Shape::Box(Vector3::new(0.1, 0.15, 0.25)),
        pose: Isometry3::translation(0.05, 0.0, 0.25),
    };
    let inertia = [4.068448, 2.782296, 2.374281, -0.000243, -0.080192, 0.000220];
    let links =
        (0..6).map(|i| link("left", 1.0, i, 0)).chain((0..6).map(|i| link("right", -1.0, i, 6))).collect();
    let foot = |link| Foot {
        link,
        half_extents: Vector3::new(0.15, 0.085, 0.0135),
        centre: Point3::new(0.03, 0.0, -0.145),
        friction: 1.0,
    };
    let flip = [-1.0, -1.0, 1.0, 1.0, 1.0, -1.0];
    Robot {
        name: "biped".into(),
        base: body("trunk", 62.69512, [0.0702289679, 0.001087465819, 0.2380589941], inertia, vec![trunk]),
        links,
        feet: [foot(5), foot(11)],
        mirror: (0..12).map(|i| ((i + 6) % 12, flip[i % 6])).collect(),
        // Hip to ankle of the knee-bent leg, plus hip drop and sole.
        standing_height: 0.1025 + 0.35 * (libm::cos(0.24) + libm::cos(0.36)) + 0.1585,
    }
}

fn orientation(state: &State) -> UnitQuaternion<f64> {
    let [w, x, y, z] = state.base_orientation;
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// Centre of mass of the whole robot in the world, in m.
pub fn centre_of_mass(robot: &Robot, state: &State) -> Vector3<f64> {
    let base =
        Isometry3::from_parts(Translation3::from(Vector3::from(state.base_position)), orientation(state));
    let mut sum = robot.base.mass * (base * robot.base.com).coords;
    let mut poses: Vec<Isometry3<f64>> = Vec::new();
    for (link, angle) in robot.links.iter().zip(&state.position) {
        let parent = link.parent.map_or(base, |parent| poses[parent]);
        let turn = UnitQuaternion::from_axis_angle(&link.joint.axis, *angle);
        let pose = parent * link.joint.origin * turn;
        sum += link.body.mass * (pose * link.body.com).coords;
        poses.push(pose);
    }
    sum / robot.total_mass()
}

/// The state a short time later, moved along its velocities.
pub fn advanced(state: &State, time: f64) -> State {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::from(state.base_rate) * time) * orientation(state);
    let mut next = state.clone();
    for axis in 0..3 {
        next.base_position[axis] += state.base_velocity[axis] * time;
    }
    next.base_orientation = [turn.w, turn.i, turn.j, turn.k];
    for (position, velocity) in next.position.iter_mut().zip(&state.velocity) {
        *position += velocity * time;
    }
    next
}
