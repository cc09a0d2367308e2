//! The reference motion of the labels, and its velocities as the actor observes them.

use crate::control::low_pass::LowPass;
use crate::kinds::motion::{Frame, Motion};
use crate::kinds::observe::Observations;
use crate::kinds::observe::joint_velocity::JointVelocity;
use crate::kinds::physics::Physics;
use crate::kinds::pretrain::{Pretraining, Tracking};
use crate::spec::Section;
use crate::spec::typed::{Declared, InSection};

/// The reference motion, and the same with observed velocities.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The motion.
    pub motion: Motion,
    /// The same frames with velocities after the observation's filter.
    pub seen: Motion,
}

impl Reference {
    /// Reads `pretrain.filter_lag`, `observe` and `physics.rate`.
    pub fn new(sections: Section, motion: &Motion) -> Self {
        let lag = matches!(sections.part(), Some(Pretraining::Tracking(Tracking { filter_lag: true, .. })));
        let seen = match filter(sections) {
            Some((filter, step)) if lag => filtered(motion, filter, step),
            _ => motion.clone(),
        };
        Self { motion: motion.clone(), seen }
    }
}

/// The observation's velocity filter with its step in s, if there is one.
fn filter(sections: Section) -> Option<(LowPass, f64)> {
    let step = 1.0 / sections.section(Physics::SECTION)?.value(Physics::rate)?;
    let mut terms = sections.within::<Observations>()?.sections();
    let (_, term) = terms.find(|(name, term)| term.kind().unwrap_or(name) == JointVelocity::KIND.name)?;
    term.value(JointVelocity::low_pass).map(|cutoff| (LowPass::new(cutoff, step), step))
}

/// The motion with velocities after a low-pass filter in steady state, at every frame.
fn filtered(motion: &Motion, filter: LowPass, step: f64) -> Motion {
    let mut seen = motion.clone();
    let mut frame = Frame::default();
    let mut output = vec![0.0; motion.samples[0].velocity.len()];
    let share = step / motion.period;
    let mut phase = 0.0;
    // One cycle to settle (ten time constants of 40 ms at the slowest), one to record.
    let settle = (1.0 / share).ceil().max(20.0 / (filter.share() + 1e-9)) as usize;
    for _ in 0..settle {
        phase = (phase + share) % 1.0;
        motion.at(phase, &mut frame);
        output.iter_mut().zip(&frame.velocity).for_each(|(y, x)| *y = filter.next(*y, *x));
    }
    let count = motion.samples.len();
    let mut travelled = 0.0;
    while travelled < 1.0 + share {
        let before = phase;
        let previous = output.clone();
        phase += share;
        travelled += share;
        motion.at(phase, &mut frame);
        output.iter_mut().zip(&frame.velocity).for_each(|(y, x)| *y = filter.next(*y, *x));
        // Frames between the two filter steps are interpolated.
        let mut index = (before * count as f64).ceil();
        while index / count as f64 <= phase {
            let mix = (index / count as f64 - before) / share;
            let target = &mut seen.samples[index as usize % count].velocity;
            for (joint, velocity) in target.iter_mut().enumerate() {
                *velocity = previous[joint] + mix * (output[joint] - previous[joint]);
            }
            index += 1.0;
        }
        phase %= 1.0;
    }
    seen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_filter_delays_a_sine_by_its_phase_and_weakens_it_by_its_gain() {
        let count = 256;
        let frame = |index: usize| Frame {
            velocity: vec![libm::sin(std::f64::consts::TAU * index as f64 / f64::from(count))],
            position: vec![0.0],
            acceleration: vec![0.0],
            ..Frame::default()
        };
        let samples = (0..count as usize).map(frame).collect();
        let motion = Motion { name: "sine".into(), period: 0.66, speed: 0.0, samples };
        let seen = filtered(&motion, LowPass::new(4.0, 1e-4), 1e-4);
        let ratio = 1.0 / 0.66 / 4.0;
        for (index, sample) in seen.samples.iter().enumerate() {
            let angle = std::f64::consts::TAU * index as f64 / f64::from(count) - libm::atan(ratio);
            let expected = libm::sin(angle) / libm::sqrt(1.0 + ratio * ratio);
            assert!(
                (sample.velocity[0] - expected).abs() < 2e-3,
                "{index}: {} is not {expected}",
                sample.velocity[0]
            );
        }
    }
}
