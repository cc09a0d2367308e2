//! The termination `ground_contact`.

use crate::kinds::{Entry, Signals, Termination, TerminationKind};
use crate::spec::{Edition, Kind, Signal};

/// The registry entry.
pub static KIND: TerminationKind = Entry {
    kind: Kind {
        name: "ground_contact",
        since: Edition::ONE,
        doc: include_str!("ground_contact.md"),
        params: &[],
        needs: &[Signal::BodyContact],
    },
    build: |_| Box::new(Term),
};

struct Term;

impl Termination for Term {
    fn ends(&self, signals: &Signals, _memory: &mut [f64; 2]) -> bool {
        signals.body_contact
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn a_knee_on_the_ground_ends_the_episode() {
        let mut world = Sample::new(1);
        assert!(!Term.ends(&world.signals(), &mut [0.0; 2]));
        world.body_contact = true;
        assert!(Term.ends(&world.signals(), &mut [0.0; 2]));
    }
}
