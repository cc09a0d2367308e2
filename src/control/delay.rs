//! A delay line for torque commands, of any length in physics steps (docs/explanation/paper.md, A17).

/// Tolerance in steps within which a length counts as a whole number of steps: products of a rate and a time
/// are not exact.
const WHOLE: f64 = 1e-9;

/// Delays commands by a fixed time. Until the first command has passed through, the output is that command,
/// so that a robot does not start without torque.
///
/// A length of n + f physics steps, f a fraction, changes the torque within a step. The output for that step
/// is the torque's mean over it: (1 - f) times the command of n steps ago plus f times the one of n + 1 steps
/// ago. If f is 0, the output is exactly the command of n steps ago.
#[derive(Clone, Debug, Default)]
pub struct Delay {
    /// Earlier commands, a ring of `slots` times `width` numbers.
    line: Vec<f64>,
    width: usize,
    slots: usize,
    /// Share of the older command.
    fraction: f64,
    /// The oldest command's slot.
    place: usize,
    empty: bool,
}

impl Delay {
    /// Empties the line and sets its width (numbers per command) and its length in physics steps, at least
    /// zero. Allocates only when it grows.
    pub fn reset(&mut self, width: usize, steps: f64) {
        let nearest = steps.round();
        let (whole, fraction) = match (steps - nearest).abs() < WHOLE {
            true => (nearest, 0.0),
            false => (steps.floor(), steps - steps.floor()),
        };
        let slots = whole as usize + usize::from(fraction > 0.0);
        self.line.resize(width * slots, 0.0);
        (self.width, self.slots, self.fraction, self.place, self.empty) = (width, slots, fraction, 0, true);
    }

    /// Takes the command of a physics step and replaces it with the delayed one for that step.
    pub fn pass(&mut self, command: &mut [f64]) {
        if self.slots == 0 {
            return;
        }
        if self.empty {
            self.line.chunks_mut(self.width).for_each(|slot| slot.copy_from_slice(command));
            self.empty = false;
        }
        let (oldest, next) = (self.place, (self.place + 1) % self.slots);
        self.line[oldest * self.width..][..self.width].swap_with_slice(command);
        if self.fraction > 0.0 {
            // With a single slot the newer command is the one just stored.
            let newer = &self.line[next * self.width..][..self.width];
            command
                .iter_mut()
                .zip(newer)
                .for_each(|(older, newer)| *older = newer + self.fraction * (*older - newer));
        }
        self.place = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The outputs for the commands 1, 2, 3, ...
    fn outputs(steps: f64) -> Vec<f64> {
        let mut delay = Delay::default();
        delay.reset(1, steps);
        (1..8)
            .map(|command| {
                let mut command = [f64::from(command)];
                delay.pass(&mut command);
                command[0]
            })
            .collect()
    }

    #[test]
    fn a_command_comes_out_so_many_steps_later() {
        assert_eq!(outputs(0.0), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!(outputs(1.0), [1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(outputs(3.0), [1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn within_a_step_the_mean_of_both_commands_is_in_force() {
        // On a ramp of one per step a delay of s steps is the ramp, s lower.
        assert_eq!(outputs(0.25), [1.0, 1.75, 2.75, 3.75, 4.75, 5.75, 6.75]);
        assert_eq!(outputs(1.5), [1.0, 1.0, 1.5, 2.5, 3.5, 4.5, 5.5]);
        assert_eq!(outputs(2.75), [1.0, 1.0, 1.0, 1.25, 2.25, 3.25, 4.25]);
    }

    #[test]
    fn a_step_in_the_command_has_its_whole_impulse_after_the_delay() {
        for steps in [0.0, 0.3, 0.999, 1.0, 2.6, 7.05] {
            let mut delay = Delay::default();
            delay.reset(2, steps);
            let missing: f64 = (0..20)
                .map(|step| {
                    let on = if step == 0 { 0.0 } else { 1.0 };
                    let mut command = [on, 5.0];
                    delay.pass(&mut command);
                    assert_eq!(command[1], 5.0, "a constant command is unchanged");
                    on - command[0]
                })
                .sum();
            assert!((missing - steps).abs() < 1e-12, "{steps}: {missing}");
        }
    }

    #[test]
    fn a_length_that_is_whole_but_for_rounding_is_whole() {
        for steps in [2.0 - 4e-16, 3.0 * (0.1 + 0.2) / 0.9 * 2.0, 2.0 + 1e-12] {
            assert_eq!(outputs(steps), outputs(2.0));
        }
    }

    #[test]
    fn a_reset_line_forgets() {
        let mut delay = Delay::default();
        delay.reset(2, 2.0);
        delay.pass(&mut [5.0, 6.0]);
        delay.reset(2, 1.5);
        let mut command = [1.0, 2.0];
        delay.pass(&mut command);
        assert_eq!(command, [1.0, 2.0]);
    }
}
