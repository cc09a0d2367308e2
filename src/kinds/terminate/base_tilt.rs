//! The termination `base_tilt`.

use crate::kinds::{Entry, Signals, Termination, TerminationKind};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: TerminationKind = Entry {
    kind: Kind {
        name: "base_tilt",
        since: Edition::ONE,
        doc: include_str!("base_tilt.md"),
        params: &[Param::required("above", Ty::Quantity(Dimension::ANGLE))
            .range(0.0, 3.2)
            .doc("The episode ends when the base's z axis leans more than this.")],
        needs: &[Signal::BaseOrientation],
    },
    build: |section| Box::new(Term { cosine: libm::cos(section.si("above")) }),
};

struct Term {
    cosine: f64,
}

impl Termination for Term {
    fn ends(&self, signals: &Signals, _memory: &mut [f64; 2]) -> bool {
        let [_, x, y, _] = signals.base_orientation;
        // The z component of the rotated z axis.
        1.0 - 2.0 * (x * x + y * y) < self.cosine
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn pitch_counts_and_yaw_does_not() {
        let term = Term { cosine: libm::cos(0.6) };
        let mut world = Sample::new(1);
        for (angle, ends) in [(0.59f64, false), (0.61, true), (-0.61, true)] {
            world.base_orientation = [libm::cos(angle / 2.0), 0.0, libm::sin(angle / 2.0), 0.0];
            assert_eq!(term.ends(&world.signals(), &mut [0.0; 2]), ends);
        }
        world.base_orientation = [0.0, 0.0, 0.0, 1.0];
        assert!(!term.ends(&world.signals(), &mut [0.0; 2]));
    }
}
