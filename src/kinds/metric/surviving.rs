//! Metrics over the surviving episodes.

use crate::outcome::Episode;

/// The mean reward of the surviving episodes; `None` if none survives.
pub(super) fn mean(episodes: &[Episode]) -> Option<f64> {
    let rewards = rewards(episodes);
    (!rewards.is_empty()).then(|| rewards.iter().sum::<f64>() / rewards.len() as f64)
}

/// The sample standard deviation of their rewards; `None` if fewer than two survive.
pub(super) fn deviation(episodes: &[Episode]) -> Option<f64> {
    let (mean, rewards) = (mean(episodes)?, rewards(episodes));
    let squares: f64 = rewards.iter().map(|reward| (reward - mean) * (reward - mean)).sum();
    (rewards.len() > 1).then(|| libm::sqrt(squares / (rewards.len() - 1) as f64))
}

/// The rewards of the surviving episodes.
fn rewards(episodes: &[Episode]) -> Vec<f64> {
    let alive = episodes.iter().filter(|episode| episode.survived);
    alive.map(|episode| episode.duration * episode.reward_per_second.values().sum::<f64>()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Episodes with given survival and reward.
    fn episodes(of: &[(bool, f64)]) -> Vec<Episode> {
        let episode = |&(survived, reward): &(bool, f64)| Episode {
            survived,
            duration: 2.0,
            reward_per_second: [("a".to_owned(), 0.5 * reward)].into(),
            ..Episode::default()
        };
        of.iter().map(episode).collect()
    }

    #[test]
    fn only_episodes_that_survive_count() {
        let all = episodes(&[(true, 2.0), (false, 18.0), (true, 4.0)]);
        assert_eq!((mean(&all), mean(&all[1..2])), (Some(3.0), None));
    }

    #[test]
    fn the_deviation_is_that_of_the_survivors() {
        let all = episodes(&[(true, 1.0), (false, 9.0), (true, 3.0)]);
        assert_eq!((deviation(&all), deviation(&all[..2])), (Some(core::f64::consts::SQRT_2), None));
    }
}
