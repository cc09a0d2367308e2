//! Compares returns of several runs.
//!
//! A return is a sum over control steps, so the same behaviour at twice the control rate has twice the
//! return. Runs with different rates are compared by return times control step, the integral of the reward
//! over time.

use super::model::{Arm, Update};

/// How to print the returns of some runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Returns {
    integral: bool,
}

impl Returns {
    /// The format for these runs.
    pub fn of<'a>(runs: impl IntoIterator<Item = &'a Arm>) -> Self {
        let mut rates = runs.into_iter().map(Arm::control_rate);
        let first = rates.next();
        Self { integral: rates.any(|rate| Some(rate) != first) }
    }

    /// The label of an axis, or of a row or column of a table.
    pub fn label(self) -> &'static str {
        if self.integral { "return times control step (s)" } else { "return" }
    }

    /// The title of a panel.
    pub fn title(self) -> &'static str {
        if self.integral { "Return of an episode times the control step" } else { "Return of an episode" }
    }

    /// Unit and number of decimals in a table.
    pub fn format(self) -> (&'static str, usize) {
        if self.integral { ("s", 1) } else { ("", 0) }
    }

    /// A sentence for a caption; empty for plain returns.
    pub fn remark(self) -> &'static str {
        match self.integral {
            true => {
                " The control rates differ, and a return is a sum over control steps: it is multiplied by \
                 the control step."
            }
            false => "",
        }
    }

    /// The mean over the episodes that ended in an update.
    pub fn value(self, run: &Arm, update: &Update) -> Option<f64> {
        self.of_episode(run, update.return_mean?)
    }

    /// The return of an episode of a run.
    pub fn of_episode(self, run: &Arm, value: f64) -> Option<f64> {
        if self.integral { Some(value / run.control_rate()?) } else { Some(value) }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::spec::{Quantity, Value};

    fn run(hz: f64) -> Arm {
        let rate = Value::Quantity(Quantity { si: hz, text: format!("{hz} Hz") });
        let action = Value::Table(BTreeMap::from([("rate".to_owned(), rate)]));
        Arm { fields: BTreeMap::from([("action".to_owned(), action)]), ..Arm::default() }
    }

    #[test]
    fn the_same_behaviour_at_twice_the_rate_has_the_same_integral_of_its_reward() {
        let (slow, fast) = (run(125.0), run(250.0));
        let update = |mean: f64| Update { return_mean: Some(mean), ..Update::default() };
        let returns = Returns::of([&slow, &fast]);
        assert_eq!(returns.value(&slow, &update(2000.0)), Some(16.0));
        assert_eq!(returns.value(&fast, &update(4000.0)), Some(16.0));
        assert_eq!(returns.label(), "return times control step (s)");
    }

    #[test]
    fn at_one_rate_a_return_is_a_return() {
        let update = Update { return_mean: Some(2000.0), ..Update::default() };
        let returns = Returns::of([&run(125.0), &run(125.0)]);
        assert_eq!((returns.value(&run(125.0), &update), returns.label()), (Some(2000.0), "return"));
        assert_eq!(Returns::of([]), returns);
    }
}
