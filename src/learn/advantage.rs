//! Generalised advantage estimation (Schulman et al. 2016) of one environment's control steps.

/// What happened in one environment, step by step; all slices have one entry per control step.
#[derive(Clone, Copy, Debug)]
pub struct Track<'a> {
    /// Rewards, already scaled.
    pub rewards: &'a [f64],
    /// The critic's value of the state before each step.
    pub values: &'a [f32],
    /// For a step that ended its episode, the value of the continuation: zero after a failure, the critic's
    /// value of the last state at a time limit.
    pub ends: &'a [Option<f32>],
    /// The critic's value of the state after the last step; not used when that step ended its episode.
    pub last_value: f32,
}

/// Discount factors.
#[derive(Clone, Copy, Debug)]
pub struct Discount {
    /// Discount per control step.
    pub gamma: f64,
    /// Decay of the estimate per control step.
    pub lambda: f64,
}

/// Writes `A_t = sum_l (gamma lambda)^l delta_(t+l)` up to the end of the episode or of the track, where
/// `delta_t = r_t + gamma V_(t+1) - V_t`, and the critic's targets `A_t + V_t`.
pub fn estimate(track: Track, discount: Discount, advantages: &mut [f32], targets: &mut [f32]) {
    let mut advantage = 0.0;
    let mut next = f64::from(track.last_value);
    for step in (0..track.rewards.len()).rev() {
        if let Some(after) = track.ends[step] {
            next = f64::from(after);
            advantage = 0.0;
        }
        let value = f64::from(track.values[step]);
        let delta = track.rewards[step] + discount.gamma * next - value;
        advantage = delta + discount.gamma * discount.lambda * advantage;
        advantages[step] = advantage as f32;
        targets[step] = (advantage + value) as f32;
        next = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Stream;

    /// The definition, written as its sum.
    fn direct(track: Track, discount: Discount, start: usize) -> f64 {
        let mut sum = 0.0;
        for step in start..track.rewards.len() {
            let next = match track.ends[step] {
                Some(after) => after,
                None if step + 1 == track.rewards.len() => track.last_value,
                None => track.values[step + 1],
            };
            let delta =
                track.rewards[step] + discount.gamma * f64::from(next) - f64::from(track.values[step]);
            sum += (discount.gamma * discount.lambda).powi((step - start) as i32) * delta;
            if track.ends[step].is_some() {
                break;
            }
        }
        sum
    }

    #[test]
    fn estimates_equal_the_direct_sum_across_failures_and_time_limits() {
        let mut stream = Stream::new("test/advantage");
        let rewards: Vec<f64> = (0..40).map(|_| stream.normal()).collect();
        let values: Vec<f32> = (0..40).map(|_| stream.normal() as f32).collect();
        let mut ends = vec![None; 40];
        ends[7] = Some(0.0);
        ends[20] = Some(1.5);
        ends[21] = Some(0.0);
        let track = Track { rewards: &rewards, values: &values, ends: &ends, last_value: 0.7 };
        let discount = Discount { gamma: 0.9, lambda: 0.8 };
        let (mut advantages, mut targets) = (vec![0.0; 40], vec![0.0; 40]);
        estimate(track, discount, &mut advantages, &mut targets);
        for step in 0..40 {
            let expected = direct(track, discount, step);
            assert!((f64::from(advantages[step]) - expected).abs() < 1e-5, "step {step}");
            assert!((f64::from(targets[step]) - expected - f64::from(values[step])).abs() < 1e-5);
        }
    }

    #[test]
    fn with_lambda_one_the_target_is_the_discounted_return() {
        let (mut advantages, mut targets) = (vec![0.0; 3], vec![0.0; 3]);
        let track =
            Track { rewards: &[1.0, 2.0, 4.0], values: &[0.3, -0.2, 0.9], ends: &[None; 3], last_value: 8.0 };
        estimate(track, Discount { gamma: 0.5, lambda: 1.0 }, &mut advantages, &mut targets);
        assert!((targets[0] - (1.0 + 1.0 + 1.0 + 1.0)).abs() < 1e-6);
        assert!((targets[2] - 8.0).abs() < 1e-6);
    }
}
