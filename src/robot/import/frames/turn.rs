//! Frames as matrices whose columns are the axes, and transforming the properties of a body.

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::robot::Body;

/// The frame with this z and x nearest to a direction; `None` if both are parallel.
pub(super) fn upright(z: &Vector3<f64>, forward: &Vector3<f64>) -> Option<Matrix3<f64>> {
    let x = (forward - z * forward.dot(z)).try_normalize(1e-6)?;
    Some(Matrix3::from_columns(&[x, z.cross(&x), *z]))
}

/// The nearest right-handed frame whose axes are coordinate axes.
pub(super) fn nearest_permutation(frame: &Matrix3<f64>) -> Matrix3<f64> {
    let axis = |index: usize| {
        let mut axis = Vector3::zeros();
        axis[index / 2] = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        axis
    };
    let pairs = (0..6).flat_map(|x| (0..6).map(move |z| (x, z))).filter(|(x, z)| x / 2 != z / 2);
    let frames = pairs.map(|(x, z)| Matrix3::from_columns(&[axis(x), axis(z).cross(&axis(x)), axis(z)]));
    // Of equally near ones the first; the identity comes first.
    let nearness = |candidate: &Matrix3<f64>| candidate.component_mul(frame).sum();
    frames.fold(
        Matrix3::identity(),
        |best, next| if nearness(&next) > nearness(&best) + 1e-12 { next } else { best },
    )
}

/// A frame as a rotation.
pub(super) fn rotation(frame: &Matrix3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*frame))
}

/// The angle in rad between two frames.
pub(super) fn apart(a: &Matrix3<f64>, b: &Matrix3<f64>) -> f64 {
    let turn = a.transpose() * b;
    let sine = 0.5 * Vector3::new(turn.m32 - turn.m23, turn.m13 - turn.m31, turn.m21 - turn.m12).norm();
    libm::atan2(sine, 0.5 * (turn.trace() - 1.0))
}

/// A rotation as text: `90.0 degrees about (1, 0, 0)`.
pub(super) fn in_words(turn: &UnitQuaternion<f64>) -> String {
    let degrees = turn.angle().to_degrees();
    let axis = turn.axis().map_or(Vector3::x(), |axis| axis.into_inner());
    // Adding zero turns -0 into 0.
    let [x, y, z] = [axis.x, axis.y, axis.z].map(|part| (1e3 * part).round() / 1e3 + 0.0);
    format!("{degrees:.1} degrees about ({x}, {y}, {z})")
}

/// Transforms a body to a new frame, given its pose in the old one.
pub(super) fn express(body: &mut Body, frame: &Isometry3<f64>) {
    let back = frame.inverse();
    let turn = back.rotation.to_rotation_matrix().into_inner();
    body.com = back * body.com;
    let inertia = turn * body.inertia * turn.transpose();
    // Exactly symmetric.
    body.inertia = 0.5 * (inertia + inertia.transpose());
    for collision in &mut body.collisions {
        collision.pose = back * collision.pose;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::import::tree::massless;
    use crate::robot::import::weld::join;

    #[test]
    fn the_nearest_permutation_of_a_permutation_is_itself() {
        let mut known: Vec<Matrix3<f64>> = Vec::new();
        for quarters in 0..64 {
            let turn = |axis: Vector3<f64>, times: i32| {
                UnitQuaternion::from_scaled_axis(axis * (std::f64::consts::FRAC_PI_2 * f64::from(times)))
            };
            let exact = turn(Vector3::x(), quarters % 4)
                * turn(Vector3::y(), quarters / 4 % 4)
                * turn(Vector3::z(), quarters / 16);
            let slightly = exact * UnitQuaternion::from_scaled_axis(Vector3::new(0.1, -0.2, 0.1));
            let frame = nearest_permutation(&slightly.to_rotation_matrix().into_inner());
            assert!((frame - exact.to_rotation_matrix().into_inner()).norm() < 1e-12);
            assert!((rotation(&frame).angle_to(&exact)) < 1e-7);
            if !known.contains(&frame) {
                known.push(frame);
            }
        }
        assert_eq!(known.len(), 24);
    }

    #[test]
    fn a_body_in_a_new_frame_is_the_body_joined_at_the_inverse_pose() {
        let mut body = massless("a");
        (body.mass, body.com) = (2.0, nalgebra::Point3::new(0.1, -0.2, 0.3));
        body.inertia = Matrix3::new(0.3, 0.01, -0.02, 0.01, 0.2, 0.03, -0.02, 0.03, 0.4);
        let frame = Isometry3::new(Vector3::new(0.0, 0.1, 0.2), Vector3::new(0.5, -1.0, 2.0));
        let mut joined = massless("a");
        join(&mut joined, &body, &frame.inverse());
        express(&mut body, &frame);
        assert!((body.com - joined.com).norm() < 1e-12 && (body.inertia - joined.inertia).norm() < 1e-12);
    }

    #[test]
    fn angles_between_frames_are_those_of_rotations() {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.4, 0.0));
        let frame = turn.to_rotation_matrix().into_inner();
        assert!((apart(&Matrix3::identity(), &frame) - 0.5).abs() < 1e-12);
        assert_eq!(in_words(&turn), "28.6 degrees about (0.6, 0.8, 0)");
    }
}
