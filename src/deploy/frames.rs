//! A reference motion as tensors of a policy's file: one row per sample, in f64, so that it is stored
//! exactly.
//!
//! A signal that is the same in every sample has one row.

use crate::kinds::motion::{Frame, Motion};
use crate::learn::file::Doubles;

/// Prefix of the tensors' names.
const PREFIX: &str = "motion";

/// A signal of a motion: its name, and its values in a frame.
type Signal = (&'static str, fn(&Frame) -> Vec<f64>);

const SIGNALS: [Signal; 9] = [
    ("position", |frame| frame.position.clone()),
    ("velocity", |frame| frame.velocity.clone()),
    ("acceleration", |frame| frame.acceleration.clone()),
    ("base_height", |frame| vec![frame.base_height]),
    ("base_orientation", |frame| frame.base_orientation.to_vec()),
    ("base_velocity", |frame| frame.base_velocity.to_vec()),
    ("base_rate", |frame| frame.base_rate.to_vec()),
    ("base_acceleration", |frame| frame.base_acceleration.to_vec()),
    ("contact", |frame| frame.contact.map(|contact| if contact { 1.0 } else { 0.0 }).to_vec()),
];

/// The samples of a motion as tensors.
pub fn tensors(motion: &Motion) -> Doubles {
    let mut tensors = Doubles::new();
    for (name, of) in SIGNALS {
        let mut rows: Vec<Vec<f64>> = motion.samples.iter().map(of).collect();
        let bits = |row: &[f64]| row.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        if name != "contact" && rows.iter().all(|row| bits(row) == bits(&rows[0])) {
            rows.truncate(1);
        }
        let shape = vec![rows.len(), rows.first().map_or(0, Vec::len)];
        tensors.insert(format!("{PREFIX}.{name}"), (shape, rows.concat()));
    }
    tensors
}

/// The samples of a motion from tensors; the error names the tensor that is missing or has the wrong shape.
pub fn samples(tensors: &Doubles, joints: usize) -> Result<Vec<Frame>, String> {
    let count = signal(tensors, "contact", 2, None)?.len();
    let rows = |name: &str, width: usize| signal(tensors, name, width, Some(count));
    let (position, velocity) = (rows("position", joints)?, rows("velocity", joints)?);
    let (acceleration, height) = (rows("acceleration", joints)?, rows("base_height", 1)?);
    let (orientation, base_velocity) = (rows("base_orientation", 4)?, rows("base_velocity", 3)?);
    let (rate, base_acceleration) = (rows("base_rate", 3)?, rows("base_acceleration", 3)?);
    let contact = rows("contact", 2)?;
    if contact.iter().flat_map(|row| row.iter()).any(|contact| *contact != 0.0 && *contact != 1.0) {
        return Err(format!("tensor `{PREFIX}.contact` has a number that is neither 0 nor 1"));
    }
    let frame = |at: usize| Frame {
        position: row(&position, at).to_vec(),
        velocity: row(&velocity, at).to_vec(),
        acceleration: row(&acceleration, at).to_vec(),
        base_height: row(&height, at)[0],
        base_orientation: fixed(row(&orientation, at)),
        base_velocity: fixed(row(&base_velocity, at)),
        base_rate: fixed(row(&rate, at)),
        base_acceleration: fixed(row(&base_acceleration, at)),
        contact: fixed::<2>(row(&contact, at)).map(|contact| contact > 0.5),
    };
    Ok((0..count).map(frame).collect())
}

/// The rows of a signal; with `count`, the signal has that many rows or one.
fn signal<'a>(
    tensors: &'a Doubles,
    name: &str,
    width: usize,
    count: Option<usize>,
) -> Result<Vec<&'a [f64]>, String> {
    let name = format!("{PREFIX}.{name}");
    let (shape, data) = tensors.get(&name).ok_or_else(|| format!("tensor `{name}` is missing"))?;
    let fits = |rows: usize| rows > 0 && count.is_none_or(|count| rows == count || rows == 1);
    match shape.as_slice() {
        [rows, columns] if *columns == width && fits(*rows) && data.iter().all(|x| x.is_finite()) => {
            Ok(data.chunks_exact(width).collect())
        }
        _ => Err(format!("tensor `{name}` of shape {shape:?} does not fit or is not finite")),
    }
}

fn row<'a>(rows: &[&'a [f64]], at: usize) -> &'a [f64] {
    if rows.len() == 1 { rows[0] } else { rows[at] }
}

fn fixed<const N: usize>(row: &[f64]) -> [f64; N] {
    std::array::from_fn(|at| row[at])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::motion::shipped;
    use crate::robot::shipped as robot;

    fn motion(name: &str) -> Motion {
        shipped(name, &robot("tocabi").expect("it is shipped"))
            .expect("it is shipped")
            .expect("it suits TOCABI")
    }

    #[test]
    fn every_shipped_motion_survives_its_tensors_bit_for_bit() {
        for name in ["walk", "squat", "run_gait", "run_clip"] {
            let motion = motion(name);
            let tensors = tensors(&motion);
            assert_eq!(samples(&tensors, 12).unwrap(), motion.samples, "{name}");
            // None of the closed-form motions rotates the base, so its rate needs a single row.
            assert!(name == "run_clip" || tensors["motion.base_rate"].0 == [1, 3], "{name}");
        }
    }

    #[test]
    fn a_missing_tensor_a_wrong_width_and_a_hole_are_named() {
        let mut tensors = tensors(&motion("squat"));
        assert!(samples(&tensors, 11).unwrap_err().contains("motion.position"));
        tensors.get_mut("motion.base_height").unwrap().1[0] = f64::NAN;
        assert!(samples(&tensors, 12).unwrap_err().contains("motion.base_height"));
        tensors.get_mut("motion.base_height").unwrap().1[0] = 0.8;
        tensors.get_mut("motion.contact").unwrap().1[0] = 0.5;
        assert!(
            samples(&tensors, 12)
                .unwrap_err()
                .contains("`motion.contact` has a number that is neither 0 nor 1")
        );
        tensors.get_mut("motion.contact").unwrap().1[0] = 1.0;
        tensors.remove("motion.velocity");
        assert_eq!(samples(&tensors, 12).unwrap_err(), "tensor `motion.velocity` is missing");
    }
}
