//! Attitudes: unit quaternions `w x y z` (world from body) as plain arrays.

/// Fixed-XYZ angles (roll, pitch, yaw) in rad: the rotation is Rz(yaw) Ry(pitch) Rx(roll).
pub fn angles([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    let sine = (2.0 * (w * y - z * x)).clamp(-1.0, 1.0);
    [libm::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)), libm::asin(sine), yaw([w, x, y, z])]
}

/// The heading: the yaw of the fixed-XYZ angles, in rad.
pub fn yaw([w, x, y, z]: [f64; 4]) -> f64 {
    libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
}

/// A vector rotated about z by an angle in rad.
pub fn turned([x, y, z]: [f64; 3], angle: f64) -> [f64; 3] {
    let (sine, cosine) = libm::sincos(angle);
    [cosine * x - sine * y, sine * x + cosine * y, z]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        [
            a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
            a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
        ]
    }

    fn about(axis: usize, angle: f64) -> [f64; 4] {
        let mut quaternion = [libm::cos(angle / 2.0), 0.0, 0.0, 0.0];
        quaternion[axis + 1] = libm::sin(angle / 2.0);
        quaternion
    }

    #[test]
    fn angles_are_those_of_the_fixed_axes_in_the_order_x_y_z() {
        let (roll, pitch, yaw) = (0.3, -0.7, 2.1);
        let attitude = product(about(2, yaw), product(about(1, pitch), about(0, roll)));
        for (found, expected) in angles(attitude).into_iter().zip([roll, pitch, yaw]) {
            assert!((found - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_quarter_turn_to_the_left_takes_forward_to_left() {
        let turned = turned([1.0, 0.0, 5.0], std::f64::consts::FRAC_PI_2);
        assert!(turned[0].abs() < 1e-12 && (turned[1] - 1.0).abs() < 1e-12 && turned[2] == 5.0);
    }
}
