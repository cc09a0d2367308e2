//! The termination `contact_schedule`.

use crate::kinds::{Entry, Signals, Termination, TerminationKind};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Section, Signal, Ty};

/// The registry entry.
pub static KIND: TerminationKind = Entry {
    kind: Kind {
        name: "contact_schedule",
        since: Edition::ONE,
        doc: include_str!("contact_schedule.md"),
        params: &[
            Param::required("tolerance", Ty::Ratio("one cycle of the motion"))
                .range(0.0, 1.0)
                .doc("Share of a cycle in uninterrupted contradiction that ends the episode."),
            Param::default("grace", Ty::Quantity(Dimension::TIME), "\"0 s\"")
                .range(0.0, 1e3)
                .doc("Time after a start from the standing pose in which nothing is counted."),
            Param::default("flight", Ty::Flag, "false")
                .doc("Whether scheduled air time and double support are watched too, as running needs."),
        ],
        needs: &[Signal::FootForce, Signal::ContactSchedule, Signal::Phase],
    },
    build: |section| Box::new(Term::new(section)),
};

struct Term {
    tolerance: f64,
    grace: f64,
    everything: bool,
}

impl Term {
    fn new(section: Section) -> Self {
        Self { tolerance: section.si("tolerance"), grace: section.si("grace"), everything: section.flag("flight") }
    }
}

impl Termination for Term {
    fn ends(&self, signals: &Signals, memory: &mut [f64; 2]) -> bool {
        let schedule = signals.reference.contact;
        let watched = self.everything || schedule[0] != schedule[1];
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
        let term = Term { tolerance: 0.055, grace: 0.0, everything: false };
        let mut world = standing();
        world.reference.contact = [false, true];
        let mut memory = [0.0; 2];
        let ended = (1..100).find(|_| term.ends(&world.signals(), &mut memory));
        assert_eq!(ended, Some(6));
    }

    #[test]
    fn agreement_and_leaving_the_window_start_the_count_anew() {
        let term = Term { tolerance: 0.055, grace: 0.0, everything: false };
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
            let term = Term { tolerance: 0.055, grace: 0.0, everything };
            let mut memory = [0.0; 2];
            assert_eq!((0..20).any(|_| term.ends(&world.signals(), &mut memory)), ends);
        }
    }

    #[test]
    fn the_grace_of_a_standing_start_counts_nothing() {
        let term = Term { tolerance: 0.055, grace: 0.8, everything: true };
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
