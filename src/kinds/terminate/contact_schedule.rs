//! The termination `contact_schedule`.

use crate::kinds::{Signals, Termination};
use crate::spec::typed::prelude::*;

reference! {
    /// Reference of `tolerance`.
    pub OfTolerance = "one cycle of the motion";
}

kind! {
    pub struct ContactSchedule = "contact_schedule", needs [FootForce, ContactSchedule, Phase] {
        /// Share of a cycle of uninterrupted contradiction that ends the episode.
        #[range(0.0, 1.0)]
        tolerance: Ratio<OfTolerance>,
        /// Time after a standing start during which nothing is counted.
        #[range(0.0, 1e3)]
        #[default("\"0 s\"")]
        grace: Quantified<Second>,
        /// Whether scheduled flight and double support are checked, too, as running needs.
        #[default("false")]
        flight: bool,
    }
}

impl Termination for ContactSchedule {
    fn ends(&self, signals: &Signals, memory: &mut [f64; 2]) -> bool {
        let schedule = signals.reference.contact;
        let watched = self.flight || schedule[0] != schedule[1];
        let graced = signals.standing_start && signals.time <= self.grace;
        for foot in 0..2 {
            let wrong = watched && !graced && signals.foot_contact[foot] != schedule[foot];
            memory[foot] = if wrong { memory[foot] + signals.phase_step } else { 0.0 };
        }
        memory.iter().any(|sum| *sum > self.tolerance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    fn standing() -> Sample {
        let mut world = Sample::new(1);
        world.foot_contact = [true, true];
        world.phase_step = 0.01;
        world
    }

    #[test]
    fn a_robot_that_stands_through_the_swing_window_ends_after_the_tolerance() {
        let term = ContactSchedule { tolerance: 0.055, grace: 0.0, flight: false };
        let mut world = standing();
        world.reference.contact = [false, true];
        let mut memory = [0.0; 2];
        let ended = (1..100).find(|_| term.ends(&world.signals(), &mut memory));
        assert_eq!(ended, Some(6));
    }

    #[test]
    fn agreement_and_leaving_the_window_start_the_count_anew() {
        let term = ContactSchedule { tolerance: 0.055, grace: 0.0, flight: false };
        let mut world = standing();
        let mut memory = [0.0; 2];
        for step in 0..100 {
            world.reference.contact = [step % 5 == 0, true];
            assert!(!term.ends(&world.signals(), &mut memory));
        }
    }

    #[test]
    fn scheduled_flight_is_watched_only_when_everything_is() {
        let mut world = standing();
        world.reference.contact = [false, false];
        for (everything, ends) in [(false, false), (true, true)] {
            let term = ContactSchedule { tolerance: 0.055, grace: 0.0, flight: everything };
            let mut memory = [0.0; 2];
            assert_eq!((0..20).any(|_| term.ends(&world.signals(), &mut memory)), ends);
        }
    }

    #[test]
    fn the_grace_of_a_standing_start_counts_nothing() {
        let term = ContactSchedule { tolerance: 0.055, grace: 0.8, flight: true };
        let mut world = standing();
        world.reference.contact = [false, false];
        world.time = 0.8;
        world.standing_start = true;
        let mut memory = [0.0; 2];
        assert!((0..20).all(|_| !term.ends(&world.signals(), &mut memory)));
        world.standing_start = false;
        assert!((0..20).any(|_| term.ends(&world.signals(), &mut memory)));
    }
}
