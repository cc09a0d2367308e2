//! W0417: values that differ between a joint or body and its mirror image, usually because of a mistake in
//! the file.

use super::{Examined, Outlier, level, mirrored, path_of, worst};
use crate::robot::checks::Issue;
use crate::robot::model::{Joint, Robot};

/// Relative difference, as a share of the larger value, up to which the two sides agree: measured halves
/// differ by less.
const SHARE: f64 = 0.1;
/// Difference of limits in rad up to which the two sides agree.
const ANGLE: f64 = 0.1;

/// Difference of default positions in rad up to which the two sides agree.
const POSE: f64 = 0.02;

/// A joint parameter to compare with the mirror image.
struct Figure {
    key: &'static str,
    unit: &'static str,
    of: fn(&Joint) -> f64,
}

const FIGURES: [Figure; 7] = [
    Figure { key: "effort_limit", unit: "N m", of: |joint| joint.effort_limit },
    Figure { key: "velocity_limit", unit: "rad/s", of: |joint| joint.velocity_limit },
    Figure { key: "damping", unit: "N m s/rad", of: |joint| joint.damping },
    Figure { key: "friction", unit: "N m", of: |joint| joint.friction },
    Figure { key: "armature", unit: "kg m^2", of: |joint| joint.armature },
    Figure { key: "stiffness_gain", unit: "N m/rad", of: |joint| joint.stiffness_gain },
    Figure { key: "damping_gain", unit: "N m s/rad", of: |joint| joint.damping_gain },
];

/// Joints and bodies of both sides have the same parameters.
pub fn check(robot: &Robot) -> Examined {
    let pairs: Vec<(usize, usize, f64)> = robot
        .mirror
        .iter()
        .enumerate()
        .filter(|(index, (image, _))| index < image)
        .map(|(index, (image, sign))| (index, *image, *sign))
        .collect();
    let mut found = Vec::new();
    for &(index, image, sign) in &pairs {
        found.extend(joints(robot, [index, image], sign));
        found.extend(masses(robot, [index, image]));
    }
    let help = "write the same figure on both sides, or, where the machine differs, allow this warning with \
        the reason";
    let issues: Vec<Issue> = worst("W0417", found, "figures", help).into_iter().collect();
    Examined {
        name: "left and right have the same figures",
        detail: format!("{} pairs of joints", pairs.len()),
        issues,
    }
}

/// The difference of two values as a share of the larger one, if they disagree.
fn apart(one: f64, other: f64) -> Option<f64> {
    let share = (one - other).abs() / one.abs().max(other.abs());
    (share > SHARE).then_some(share)
}

fn joints(robot: &Robot, pair: [usize; 2], sign: f64) -> Vec<Outlier> {
    let [one, other] = pair.map(|index| &robot.links[index].joint);
    let mut found = Vec::new();
    for Figure { key, unit, of } in &FIGURES {
        if let Some(excess) = apart(of(one), of(other)) {
            let message = format!(
                "`{key}` is {} {unit} of joint `{}` and {} {unit} of joint `{}`, its mirror image",
                of(one),
                one.name,
                of(other),
                other.name
            );
            found.push(Outlier { excess, path: format!("links.{}.joint.{key}", pair[1]), message });
        }
    }
    let mirrored = if sign < 0.0 { [-other.upper, -other.lower] } else { [other.lower, other.upper] };
    let off = (one.lower - mirrored[0]).abs().max((one.upper - mirrored[1]).abs());
    if off > ANGLE {
        let range = |joint: &Joint| format!("{:.3} .. {:.3} rad", joint.lower, joint.upper);
        let turned = if sign < 0.0 { " the other way round" } else { "" };
        let message = format!(
            "the range is {} of joint `{}` and {} of joint `{}`, its mirror image{turned}",
            range(one),
            one.name,
            range(other),
            other.name
        );
        let excess = off / (one.upper - one.lower).max(other.upper - other.lower);
        found.push(Outlier { excess, path: format!("links.{}.joint.lower", pair[1]), message });
    }
    let (apart, message) = mirrored::difference(robot, pair, sign);
    // If the soles are not level, the check of the pose reports it, with the positions to write.
    if apart > POSE && level::is_level(robot) {
        let excess = apart / (one.upper - one.lower).max(other.upper - other.lower);
        found.push(Outlier { excess, path: format!("links.{}.joint.default_position", pair[1]), message });
    }
    found
}

fn masses(robot: &Robot, pair: [usize; 2]) -> Option<Outlier> {
    let [one, other] = pair.map(|index| &robot.links[index].body);
    let excess = apart(one.mass, other.mass)?;
    // Bodies of a few grams are brackets, which may be on one side only.
    let counts = (one.mass - other.mass).abs() > 2e-3 * robot.total_mass();
    let message = format!(
        "the mass is {:.5} kg of `{}` and {:.5} kg of `{}`, its mirror image",
        one.mass, one.name, other.mass, other.name
    );
    counts.then(|| Outlier { excess, path: format!("{}.mass", path_of(pair[1] + 1)), message })
}
