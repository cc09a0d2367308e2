//! A delay line for torque commands, in whole physics steps (docs/design/paper.md, A17).

/// Holds commands back by a fixed number of steps. Until the first command has passed through, that
/// command itself comes out: a robot does not start limp.
#[derive(Clone, Debug, Default)]
pub struct Delay {
    line: Vec<f64>,
    width: usize,
    steps: usize,
    place: usize,
    empty: bool,
}

impl Delay {
    /// Empties the line and sets its width (numbers per command) and length in steps. Allocates only when
    /// it grows.
    pub fn reset(&mut self, width: usize, steps: usize) {
        self.line.resize(width * steps, 0.0);
        (self.width, self.steps, self.place, self.empty) = (width, steps, 0, true);
    }

    /// Length in steps.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Takes a command in and replaces it by the one of `steps` calls ago.
    pub fn pass(&mut self, command: &mut [f64]) {
        if self.steps == 0 {
            return;
        }
        if self.empty {
            self.line.chunks_mut(self.width).for_each(|slot| slot.copy_from_slice(command));
            self.empty = false;
        }
        let slot = &mut self.line[self.place * self.width..][..self.width];
        slot.swap_with_slice(command);
        self.place = (self.place + 1) % self.steps;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outputs(steps: usize) -> Vec<f64> {
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
        assert_eq!(outputs(0), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!(outputs(1), [1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(outputs(3), [1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn a_reset_line_forgets() {
        let mut delay = Delay::default();
        delay.reset(2, 2);
        delay.pass(&mut [5.0, 6.0]);
        delay.reset(2, 1);
        let mut command = [1.0, 2.0];
        delay.pass(&mut command);
        assert_eq!(command, [1.0, 2.0]);
    }
}
