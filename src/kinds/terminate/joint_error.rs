//! The termination `joint_error`.

use crate::kinds::{Entry, Signals, Termination, TerminationKind};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: TerminationKind = Entry {
    kind: Kind {
        name: "joint_error",
        since: Edition::ONE,
        doc: include_str!("joint_error.md"),
        params: &[Param::required("above", Ty::Quantity(Dimension::ANGLE))
            .range(0.0, 10.0)
            .doc("The episode ends when any joint is further than this from the reference.")],
        needs: &[Signal::Joints, Signal::Reference],
    },
    build: |section| Box::new(Term { above: section.si("above") }),
};

struct Term {
    above: f64,
}

impl Termination for Term {
    fn ends(&self, signals: &Signals, _memory: &mut [f64; 2]) -> bool {
        let mut pairs = signals.position.iter().zip(&signals.reference.position);
        pairs.any(|(position, reference)| (position - reference).abs() > self.above)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn one_joint_is_enough() {
        let mut world = Sample::new(2);
        world.position = vec![0.0, -0.51];
        assert!(Term { above: 0.5 }.ends(&world.signals(), &mut [0.0; 2]));
        assert!(!Term { above: 0.52 }.ends(&world.signals(), &mut [0.0; 2]));
    }
}
