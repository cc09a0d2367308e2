//! Averages over the physics steps of a control step.

use crate::sim::Contacts;

/// Vertical force in N from which a foot is in contact.
const CONTACT: f64 = 10.0;

/// Means over the physics steps of one control step.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    count: f64,
    force: [[f64; 3]; 2],
    body: bool,
    torque: Vec<f64>,
}

impl Tally {
    /// Averages for a robot with this many joints.
    pub fn new(joints: usize) -> Self {
        Self { torque: vec![0.0; joints], ..Self::default() }
    }

    /// Resets it for the next control step.
    pub fn clear(&mut self) {
        self.torque.fill(0.0);
        (self.count, self.force, self.body) = (0.0, [[0.0; 3]; 2], false);
    }

    /// Adds a physics step: its contacts and the torques in N m that were commanded for it.
    pub fn add(&mut self, contacts: &Contacts, torque: &[f64]) {
        self.count += 1.0;
        for foot in 0..2 {
            for axis in 0..3 {
                self.force[foot][axis] += contacts.foot_force[foot][axis];
            }
        }
        self.body |= contacts.body;
        self.torque.iter_mut().zip(torque).for_each(|(sum, torque)| *sum += torque);
    }

    /// Mean force of the ground on each foot in N, world frame.
    pub fn foot_force(&self) -> [[f64; 3]; 2] {
        self.force.map(|foot| foot.map(|sum| sum / self.count))
    }

    /// Whether anything but the feet touched the ground.
    pub fn body_contact(&self) -> bool {
        self.body
    }

    /// Writes the mean commanded torque in N m.
    pub fn torque(&self, mean: &mut [f64]) {
        mean.iter_mut().zip(&self.torque).for_each(|(mean, sum)| *mean = sum / self.count);
    }
}

/// Whether each foot with this mean force in N carries load.
pub fn contact(force: &[[f64; 3]; 2]) -> [bool; 2] {
    force.map(|foot| foot[2] > CONTACT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_and_torques_are_means_and_any_touch_counts() {
        let mut tally = Tally::new(1);
        tally.clear();
        let tap = Contacts { foot_force: [[1.0, 2.0, 30.0], [0.0; 3]], body: true };
        tally.add(&tap, &[8.0]);
        tally.add(&Contacts::default(), &[-2.0]);
        let mut torque = [0.0];
        tally.torque(&mut torque);
        assert_eq!(tally.foot_force(), [[0.5, 1.0, 15.0], [0.0; 3]]);
        assert_eq!(contact(&tally.foot_force()), [true, false]);
        assert!(tally.body_contact() && torque == [3.0]);
        tally.clear();
        tally.add(&Contacts::default(), &[0.0]);
        assert!(!tally.body_contact() && tally.foot_force() == [[0.0; 3]; 2]);
    }
}
