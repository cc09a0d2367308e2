//! The motor's speed limit: torque that would accelerate a joint beyond it fades out.

/// Speed, in units of the limit, at which driving torque reaches zero.
const FADED: f64 = 1.25;

/// Torque in N m that a motor delivers at this joint velocity in rad/s: driving torque falls linearly from
/// its full value at the limit to zero at 1.25 times the limit; braking torque is unaffected.
pub fn limited(torque: f64, velocity: f64, limit: f64) -> f64 {
    if torque * velocity <= 0.0 {
        return torque;
    }
    let excess = (velocity.abs() / limit - 1.0) / (FADED - 1.0);
    torque * (1.0 - excess.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn driving_torque_fades_between_the_limit_and_a_quarter_more() {
        let at = |velocity| limited(100.0, velocity, 4.0);
        assert_eq!(at(4.0), 100.0);
        assert!((at(4.5) - 50.0).abs() < 1e-12);
        assert_eq!(at(5.0), 0.0);
        assert_eq!(at(9.0), 0.0);
    }

    #[test]
    fn braking_torque_is_untouched() {
        assert_eq!(limited(-100.0, 9.0, 4.0), -100.0);
        assert_eq!(limited(100.0, -9.0, 4.0), 100.0);
    }
}
