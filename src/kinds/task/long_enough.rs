//! How long an episode must last to show whether a robot does its task. In a shorter one every robot survives,
//! even one that is falling.

/// Angle in rad by which a robot leans at the start: that of the usual perturbation of an evaluation.
const LEAN: f64 = 0.01;
/// Angle in rad at which it has fallen.
const FALLEN: f64 = 1.0;
/// Standard gravity in m/s^2.
const GRAVITY: f64 = 9.81;

/// The time of an episode that is judged: what comes before a push says nothing about the robot after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// Time limit of the episode in s.
    pub time_limit: f64,
    /// Time in s at which the last scheduled push begins, if it does so before the end.
    push: Option<f64>,
}

impl Judged {
    /// The judged time of an episode with a time limit and a last scheduled push in s.
    pub fn of(time_limit: f64, push: Option<f64>) -> Self {
        Self { time_limit, push: push.filter(|push| *push < time_limit) }
    }

    /// Its duration in s.
    pub fn seconds(&self) -> f64 {
        self.time_limit - self.push.unwrap_or(0.0)
    }

    /// The judged time in words, with times written by `shown`: `2 s`, `1 s after the push at 1 s`.
    pub fn span_in_words(&self, shown: impl Fn(f64) -> String) -> String {
        match self.push {
            Some(_) => self.end_in_words(shown),
            None => shown(self.time_limit),
        }
    }

    /// The end of the episode in words, with times written by `shown`: `after 2 s`, `1 s after the push at 1 s`.
    pub fn end_in_words(&self, shown: impl Fn(f64) -> String) -> String {
        match self.push {
            Some(push) => format!("{} after the push at {}", shown(self.seconds()), shown(push)),
            None => format!("after {}", shown(self.time_limit)),
        }
    }
}

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

    /// Whether the time in s that is judged is long enough.
    pub fn is_reached_by(&self, judged: Judged) -> bool {
        judged.seconds() >= self.seconds - 1e-9
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
        let reached = |limit, push| walk.is_reached_by(Judged::of(limit, push));
        assert!(reached(1.8, None) && !reached(1.799, None) && !reached(0.2, None));
        assert!(reached(5.8, Some(4.0)) && !reached(5.7, Some(4.0)));
        // A push after the end does not happen.
        assert!(reached(4.0, Some(4.0)));
    }
}
