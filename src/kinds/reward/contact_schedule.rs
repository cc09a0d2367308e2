//! The reward term `contact_schedule`.

use crate::kinds::{Reward, Signals};
use crate::spec::typed::prelude::*;

kind! {
    pub struct ContactSchedule = "contact_schedule", needs [FootForce, ContactSchedule, Phase] {}
}

impl Reward for ContactSchedule {
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
        assert_eq!(ContactSchedule {}.value(&world.signals()), 1.0);
        world.reference.contact = [true, true];
        assert_eq!(ContactSchedule {}.value(&world.signals()), 0.0);
    }
}
