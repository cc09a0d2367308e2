//! Joints whose labels the fitted actor misses, relative to the motor's limit.

use super::PretrainReport;
use crate::robot::Robot;

/// Share of its effort limit from which a joint's error is reported. TOCABI's errors are at most a tenth.
const LARGE: f64 = 0.2;
/// Largest number of joints that are named.
const NAMED: usize = 3;

/// The suggested fix.
pub const FIX: &str = "give the pre-training more `samples` or `epochs`, or a narrower `position_noise`, and \
    compare the \
                       labels with the motors in the robot's file";

/// The joints whose torques the fitted actor misses by a large share of their effort limits, worst first
/// (W0609); the error is the root mean square on held-out states, in N m.
pub fn large(report: &PretrainReport, robot: &Robot) -> Option<String> {
    let joints = robot.links.iter().map(|link| &link.joint);
    let mut missed: Vec<(f64, String)> = joints
        .filter_map(|joint| {
            let error = *report.rmse_by_joint_nm.get(&joint.name)?;
            let share = error / joint.effort_limit;
            (share > LARGE).then(|| {
                (
                    share,
                    format!("`{}` by {error:.1} N m, {:.0} % of its effort limit", joint.name, 100.0 * share),
                )
            })
        })
        .collect();
    missed.sort_by(|a, b| b.0.total_cmp(&a.0));
    let more = missed.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(", and {more} more joints") } else { String::new() };
    let worst: Vec<&str> = missed.iter().take(NAMED).map(|(_, text)| text.as_str()).collect();
    (!worst.is_empty()).then(|| {
        format!(
            "the pre-trained actor misses its labels: {}{more}; the labels are {:.1} N m (root mean square, \
             held-out states)",
            worst.join(", "),
            report.label_rms_nm
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// W0609 names the worst joints first, and is silent on what shipped robots reach.
    #[test]
    fn errors_of_a_fifth_of_a_motor_are_told_worst_first() {
        let robot = crate::robot::shipped("tocabi").unwrap();
        let report = |shares: &[f64]| {
            let joints = robot.links.iter().map(|link| &link.joint).zip(shares);
            let errors = joints.map(|(joint, share)| (joint.name.clone(), share * joint.effort_limit));
            PretrainReport {
                rmse_by_joint_nm: errors.collect(),
                label_rms_nm: 45.0,
                ..PretrainReport::default()
            }
        };
        assert_eq!(large(&report(&[0.1; 12]), &robot), None);
        assert_eq!(large(&PretrainReport::default(), &robot), None);
        let mut shares = [0.1; 12];
        shares[3] = 0.75;
        shares[9] = 0.8;
        let [third, ninth] = [3, 9].map(|index| robot.links[index].joint.clone());
        let said = large(&report(&shares), &robot).expect("two are beyond");
        let expected = format!(
            "`{}` by {:.1} N m, 80 % of its effort limit, `{}` by {:.1} N m, 75 % of its effort limit; the \
             labels are 45.0 N m",
            ninth.name,
            0.8 * ninth.effort_limit,
            third.name,
            0.75 * third.effort_limit
        );
        assert!(said.contains(&expected), "{said}");
        assert!(large(&report(&[0.3; 12]), &robot).expect("all are").contains("and 9 more joints"));
    }
}
