//! The initial state `reference`: reference-state initialisation.

use crate::spec::typed::prelude::*;

reference! {
    /// What `standing_share` is a share of.
    pub AllEpisodes = "all episodes";
}

choice! {
    /// What a robot on the reference motion moves with.
    pub enum Velocities {
        /// The velocities of the reference.
        Reference = "reference",
        /// Nothing but noise.
        Rest = "rest",
    }
}

kind! {
    pub struct OnReference = "reference", needs [Reference] {
        /// Share of the episodes that start in the default pose at rest.
        #[range(0.0, 1.0)]
        #[default("\"20 %\"")]
        standing_share: Ratio<AllEpisodes>,
        /// Phases of those standing starts, drawn with equal chance; evaluations, which all stand, take
        /// them in turn.
        #[range(0.0, 1.0)]
        #[default("[0.0, 0.5]")]
        phases: Vec<f64>,
        /// Added to each joint position of the standing starts, as evaluations do by their `perturbation`;
        /// without it they are all alike.
        #[range(-3.2, 3.2)]
        standing_noise: Option<Sampled<Radian>>,
        /// What the robot moves with: the reference's velocities, which is also what is meant without
        /// this key, or none, but for the noise below.
        velocities: Option<Velocities>,
        /// Added to each joint position.
        #[range(-3.2, 3.2)]
        #[default("{ normal = [\"0 rad\", \"0.02 rad\"] }")]
        position_noise: Sampled<Radian>,
        /// Added to each joint velocity.
        #[range(-100.0, 100.0)]
        #[default("{ normal = [\"0 rad/s\", \"0.1 rad/s\"] }")]
        velocity_noise: Sampled<RadianPerSecond>,
        /// Added to each component of the base velocity.
        #[range(-10.0, 10.0)]
        #[default("{ normal = [\"0 m/s\", \"0.04 m/s\"] }")]
        base_velocity_noise: Sampled<MetrePerSecond>,
        /// Added to each component of the base's angular velocity.
        #[range(-100.0, 100.0)]
        #[default("{ normal = [\"0 rad/s\", \"0.04 rad/s\"] }")]
        base_rate_noise: Sampled<RadianPerSecond>,
    }
}
