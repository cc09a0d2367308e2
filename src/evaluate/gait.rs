//! Gait of an episode from its foot contacts: steps, support phases, flight phases.
//!
//! Rigid contacts bounce: a foot touches for one step and lifts again. Steps and flight phases are therefore
//! counted after contacts shorter than [`TAP`] are removed; shares of time use the raw contacts.

/// Contacts and flight phases shorter than this, in s, are ignored.
pub const TAP: f64 = 0.02;

/// Foot contacts of an episode.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gait {
    /// Share of the time in single support on the left foot.
    pub left_support: f64,
    /// Share of the time in single support on the right foot.
    pub right_support: f64,
    /// Share of the time with no foot on the ground.
    pub flight: f64,
    /// Touch-downs of the left and the right foot.
    pub steps: [u32; 2],
    /// Flight phases from one foot to the other.
    pub alternating_flights: u32,
    /// Share of the foot changes with such a flight phase.
    pub flight_per_step: f64,
    /// Foot changes up to the last one without a flight phase: the steps from standing into running.
    pub starting_steps: u32,
}

impl Gait {
    /// The gait of contacts (left, right) at control steps of this duration in s.
    pub fn of(contacts: &[[bool; 2]], step: f64) -> Self {
        let share = |pattern: [bool; 2]| {
            let count = contacts.iter().filter(|contact| **contact == pattern).count();
            count as f64 / contacts.len().max(1) as f64
        };
        let firm = firm(contacts, step);
        let events = touch_downs(&firm);
        let changes = events.windows(2).filter(|pair| pair[0].foot != pair[1].foot);
        let flown: Vec<bool> = changes.map(|pair| flies(&firm, pair[1], step)).collect();
        Self {
            left_support: share([true, false]),
            right_support: share([false, true]),
            flight: share([false, false]),
            steps: [0, 1].map(|foot| events.iter().filter(|event| event.foot == foot).count() as u32),
            alternating_flights: events.iter().filter(|event| flies(&firm, **event, step)).count() as u32,
            flight_per_step: flown.iter().filter(|flown| **flown).count() as f64 / flown.len().max(1) as f64,
            starting_steps: flown.iter().rposition(|flown| !flown).map_or(0, |last| last as u32 + 1),
        }
    }
}

/// A touch-down at a control step.
#[derive(Clone, Copy, Debug)]
struct TouchDown {
    at: usize,
    foot: usize,
}

/// The contacts without those that are too short.
fn firm(contacts: &[[bool; 2]], step: f64) -> Vec<[bool; 2]> {
    let mut firm = contacts.to_vec();
    for foot in 0..2 {
        let mut start = 0;
        while start < firm.len() {
            let length = firm[start..].iter().take_while(|contact| contact[foot]).count();
            if (length as f64) * step < TAP - 1e-9 {
                firm[start..start + length].iter_mut().for_each(|contact| contact[foot] = false);
            }
            start += length.max(1);
        }
    }
    firm
}

fn touch_downs(firm: &[[bool; 2]]) -> Vec<TouchDown> {
    let mut events = Vec::new();
    for (before, pair) in firm.windows(2).enumerate() {
        let changes = pair[0].iter().zip(&pair[1]).enumerate();
        let down = changes.filter(|(_, (was, is))| !**was && **is);
        events.extend(down.map(|(foot, _)| TouchDown { at: before + 1, foot }));
    }
    events
}

/// Whether a touch-down ends a flight phase that is long enough and began on the other foot alone.
fn flies(firm: &[[bool; 2]], event: TouchDown, step: f64) -> bool {
    let length = firm[..event.at].iter().rev().take_while(|contact| **contact == [false, false]).count();
    let before = event.at - length;
    let lands_alone = !firm[event.at][1 - event.foot];
    let takes_off = before > 0 && firm[before - 1][1 - event.foot] && !firm[before - 1][event.foot];
    (length as f64) * step >= TAP - 1e-9 && lands_alone && takes_off
}

#[cfg(test)]
mod tests {
    use super::*;

    const L: [bool; 2] = [true, false];
    const R: [bool; 2] = [false, true];
    const B: [bool; 2] = [true, true];
    const F: [bool; 2] = [false, false];

    /// Contacts from runs of (pattern, control steps).
    fn contacts(runs: &[([bool; 2], usize)]) -> Vec<[bool; 2]> {
        runs.iter().flat_map(|(pattern, count)| std::iter::repeat_n(*pattern, *count)).collect()
    }

    #[test]
    fn a_walk_has_steps_and_no_flight() {
        let gait = Gait::of(&contacts(&[(B, 20), (L, 40), (B, 10), (R, 40), (B, 10), (L, 40)]), 0.008);
        assert_eq!(gait.steps, [1, 1]);
        assert_eq!((gait.alternating_flights, gait.flight_per_step), (0, 0.0));
        assert_eq!((gait.left_support, gait.right_support, gait.flight), (0.5, 0.25, 0.0));
    }

    #[test]
    fn a_run_flies_from_foot_to_foot_at_every_step() {
        let stride = [(L, 30), (F, 10), (R, 30), (F, 10)];
        let gait = Gait::of(&contacts(&[stride, stride, stride].concat()), 0.008);
        // The first stance on the left is not a touch-down; then R L R L R, each after a flight phase.
        assert_eq!(gait.steps, [2, 3]);
        assert_eq!((gait.alternating_flights, gait.flight_per_step), (5, 1.0));
        assert_eq!((gait.flight, gait.starting_steps), (0.25, 0));
    }

    #[test]
    fn the_steps_out_of_standing_end_with_the_last_that_does_not_fly() {
        let stride = [(L, 30), (F, 10), (R, 30), (F, 10)];
        let start = [(B, 50), (L, 20), (B, 5), (R, 30), (B, 5), (L, 30), (F, 10), (R, 30), (F, 10)];
        let gait = Gait::of(&contacts(&[start.as_slice(), &stride, &stride].concat()), 0.008);
        // R after L is the first touch-down; the L without one is the only foot change without a flight
        // phase.
        assert_eq!((gait.starting_steps, gait.alternating_flights), (1, 5));
        assert_eq!(gait.flight_per_step, 5.0 / 6.0);
    }

    #[test]
    fn taps_are_no_steps_and_do_not_end_a_flight() {
        // Two control steps of 8 ms are shorter than 20 ms, three are not.
        let tapped = Gait::of(&contacts(&[(L, 30), (F, 5), (R, 2), (F, 5), (R, 30)]), 0.008);
        assert_eq!((tapped.steps, tapped.alternating_flights), ([0, 1], 1));
        let landed = Gait::of(&contacts(&[(L, 30), (F, 5), (R, 3), (F, 5), (R, 30)]), 0.008);
        assert_eq!((landed.steps, landed.alternating_flights), ([0, 2], 1));
    }

    #[test]
    fn hops_on_one_foot_and_jumps_are_no_alternating_flights() {
        let hops =
            Gait::of(&contacts(&[(L, 30), (F, 10), (L, 30), (F, 10), (B, 30), (F, 10), (R, 30)]), 0.008);
        assert_eq!((hops.steps, hops.alternating_flights), ([2, 2], 0));
        assert_eq!(Gait::of(&[], 0.008), Gait::default());
    }
}
