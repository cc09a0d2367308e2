//! Selects the part of a trace to show: whole cycles from the middle of the episode, so that the policies of
//! different arms start at the same phase.

use std::ops::Range;

use crate::outcome::Trace;

/// The rows of `cycles` whole cycles from the first start of a cycle in the second half of the trace; the
/// last `seconds` if there are fewer cycles, and the whole trace if it is shorter.
pub fn cycles(trace: &Trace, cycles: usize, seconds: f64) -> Range<usize> {
    let rows = trace.time.len();
    let starts: Vec<usize> = (1..rows.min(trace.phase.len()))
        .filter(|row| trace.phase[*row] < trace.phase[row - 1] - 0.5)
        .collect();
    let half = 0.5 * trace.time.last().copied().unwrap_or(0.0);
    let first = starts.iter().position(|row| trace.time[*row] >= half);
    if let Some(first) = first
        && let Some(end) = starts.get(first + cycles)
    {
        return starts[first]..*end + 1;
    }
    let end = trace.time.last().copied().unwrap_or(0.0);
    let start = trace.time.iter().position(|time| *time >= end - seconds).unwrap_or(0);
    start..rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(seconds: f64, period: f64) -> Trace {
        let time: Vec<f64> = (0..(seconds * 100.0) as usize).map(|row| row as f64 * 0.01).collect();
        let phase = time.iter().map(|time| (time / period) % 1.0).collect();
        Trace { time, phase, ..Trace::default() }
    }

    #[test]
    fn whole_cycles_from_the_middle_are_shown() {
        let rows = cycles(&trace(10.0, 0.7), 2, 2.0);
        assert!((rows.start as f64 * 0.01 - 5.6).abs() < 0.02, "{rows:?}");
        assert!((rows.len() as f64 * 0.01 - 1.41).abs() < 0.02, "{rows:?}");
    }

    #[test]
    fn a_short_trace_is_shown_to_its_end() {
        let rows = cycles(&trace(1.0, 0.7), 2, 0.5);
        assert_eq!(rows.end, 100);
        assert!(rows.len() >= 50 && rows.len() <= 51, "{rows:?}");
        assert_eq!(cycles(&Trace::default(), 2, 0.5), 0..0);
    }
}
