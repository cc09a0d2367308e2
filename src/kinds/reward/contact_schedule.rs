//! The reward term `contact_schedule`.

use crate::kinds::{Entry, Reward, RewardKind, Signals};
use crate::spec::{Edition, Kind, Signal};

/// The registry entry.
pub static KIND: RewardKind = Entry {
    kind: Kind {
        name: "contact_schedule",
        since: Edition::ONE,
        doc: include_str!("contact_schedule.md"),
        params: &[],
        needs: &[Signal::FootForce, Signal::ContactSchedule, Signal::Phase],
    },
    build: |_| Box::new(Term),
};

struct Term;

impl Reward for Term {
    fn value(&self, signals: &Signals) -> f64 {
        f64::from(u8::from(signals.foot_contact == signals.reference.contact))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn one_wrong_foot_is_worth_nothing() {
        let mut world = Sample::new(1);
        world.foot_contact = [true, false];
        world.reference.contact = [true, false];
        assert_eq!(Term.value(&world.signals()), 1.0);
        world.reference.contact = [true, true];
        assert_eq!(Term.value(&world.signals()), 0.0);
    }
}
