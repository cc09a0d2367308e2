//! The termination `base_height`.

use crate::kinds::{Entry, Signals, Termination, TerminationKind};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: TerminationKind = Entry {
    kind: Kind {
        name: "base_height",
        since: Edition::ONE,
        doc: include_str!("base_height.md"),
        params: &[Param::required("below", Ty::Quantity(Dimension::LENGTH))
            .range(0.0, 10.0)
            .doc("The episode ends when the base origin is less than this above the ground.")],
        needs: &[Signal::BaseHeight],
    },
    build: |section| Box::new(Term { below: section.si("below") }),
};

struct Term {
    below: f64,
}

impl Termination for Term {
    fn ends(&self, signals: &Signals, _memory: &mut [f64; 2]) -> bool {
        signals.base_height < self.below * signals.stature
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn the_bound_itself_is_still_standing() {
        let mut world = Sample::new(1);
        world.base_height = 0.6;
        assert!(!Term { below: 0.6 }.ends(&world.signals(), &mut [0.0; 2]));
        world.base_height = 0.599;
        assert!(Term { below: 0.6 }.ends(&world.signals(), &mut [0.0; 2]));
    }

    #[test]
    fn the_bound_follows_the_legs_of_the_episode() {
        let mut world = Sample::new(1);
        (world.base_height, world.stature) = (0.55, 0.9);
        assert!(!Term { below: 0.6 }.ends(&world.signals(), &mut [0.0; 2]));
        world.base_height = 0.53;
        assert!(Term { below: 0.6 }.ends(&world.signals(), &mut [0.0; 2]));
    }
}
