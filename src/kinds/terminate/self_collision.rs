//! The termination `self_collision`.

use crate::kinds::{Entry, Signals, Termination, TerminationKind};
use crate::spec::{Edition, Kind, Signal};

/// The registry entry.
pub static KIND: TerminationKind = Entry {
    kind: Kind {
        name: "self_collision",
        since: Edition::ONE,
        doc: include_str!("self_collision.md"),
        params: &[],
        needs: &[Signal::SelfCollision],
    },
    build: |_| Box::new(Term),
};

struct Term;

impl Termination for Term {
    fn ends(&self, signals: &Signals, _memory: &mut [f64; 2]) -> bool {
        signals.self_collision
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn a_knee_inside_the_other_ends_the_episode() {
        let mut world = Sample::new(1);
        assert!(!Term.ends(&world.signals(), &mut [0.0; 2]));
        world.self_collision = true;
        assert!(Term.ends(&world.signals(), &mut [0.0; 2]));
    }
}
