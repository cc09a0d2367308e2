//! The initial state `reference`: reference-state initialisation.

use crate::spec::typed::prelude::*;

reference! {
    /// Reference of `standing_share`.
    pub AllEpisodes = "all episodes";
}

choice! {
    /// Velocities at a start on the reference motion.
    pub enum Velocities {
        /// Those of the reference.
        Reference = "reference",
        /// Zero plus noise.
        Rest = "rest",
    }
}

kind! {
    pub struct OnReference = "reference", needs [Reference] {
        /// Share of the episodes that start in the default pose at rest.
        #[range(0.0, 1.0)]
        #[default("\"20 %\"")]
        standing_share: Ratio<AllEpisodes>,
        /// Phases of standing starts, drawn with equal probability; evaluations, which always start standing,
        /// take them in turn.
        #[range(0.0, 1.0)]
        #[default("[0.0, 0.5]")]
        phases: Vec<f64>,
        /// Added to each joint position of the standing starts, like the `perturbation` of evaluations;
        /// without it all standing starts are the same.
        #[range(-3.2, 3.2)]
        standing_noise: Option<Sampled<Radian>>,
        /// Velocities at the start, before noise: those of the reference (default), or zero.
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
