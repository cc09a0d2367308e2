//! How long an episode must last to show whether a robot does its task. In a shorter one every robot survives,
//! even one that is falling.

/// Angle in rad by which a robot leans at the start: that of the usual perturbation of an evaluation.
const LEAN: f64 = 0.01;
/// Angle in rad at which it has fallen.
const FALLEN: f64 = 1.0;
/// Standard gravity in m/s^2.
const GRAVITY: f64 = 9.81;

/// The shortest episode that shows whether a task is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shortest {
    /// Its duration in s.
    pub seconds: f64,
    /// What takes that long.
    pub reason: &'static str,
}

impl Shortest {
    /// One cycle of the reference motion of this period in s, or the time in which a robot falls over that
    /// does nothing about it, whichever is longer. The robot is a pendulum of the height in m of the standing
    /// robot's base: its angle grows as `lean * cosh(t * sqrt(g / h))`.
    pub fn of(period: Option<f64>, height: f64) -> Self {
        let fall = libm::sqrt(height.max(0.0) / GRAVITY) * libm::acosh(FALLEN / LEAN);
        match period.filter(|period| *period > fall) {
            Some(period) => Self { seconds: period, reason: "one cycle of the reference motion" },
            None => Self { seconds: fall, reason: "the time in which a robot without balance falls" },
        }
    }

    /// Whether episodes of this time limit in s are long enough.
    pub fn is_reached_by(&self, time_limit: f64) -> bool {
        time_limit >= self.seconds - 1e-9
    }

    /// `1.8 s, one cycle of the reference motion`.
    pub fn in_words(&self) -> String {
        format!("{} s, {}", libm::ceil(self.seconds * 100.0) / 100.0, self.reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_episode_lasts_a_cycle_and_as_long_as_a_fall() {
        // A pendulum of 0.9 m: sqrt(0.9 / 9.81) acosh(100) = 0.30289 * 5.29829.
        let stand = Shortest::of(None, 0.9);
        assert!((stand.seconds - 1.6048).abs() < 1e-3, "{stand:?}");
        assert_eq!(stand.in_words(), "1.61 s, the time in which a robot without balance falls");
        let run = Shortest::of(Some(0.66), 0.9);
        assert_eq!(run, stand);
        let walk = Shortest::of(Some(1.8), 0.9);
        assert_eq!(walk.in_words(), "1.8 s, one cycle of the reference motion");
        assert!(walk.is_reached_by(1.8) && !walk.is_reached_by(1.799) && !walk.is_reached_by(0.2));
    }
}
