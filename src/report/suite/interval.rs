//! The names of intervals over an arm's seeds: with few seeds a percentile interval covers less than its
//! nominal confidence.

use crate::report::group::Group;
use crate::statistics::mean::coverage;

/// Number of runs of the smallest arm.
pub fn fewest(groups: &[Group<'_>]) -> usize {
    groups.iter().map(|group| group.runs.len()).min().unwrap_or(0)
}

/// `95 % bootstrap intervals over seeds`, or their actual coverage for arms with few seeds.
pub fn over_seeds(groups: &[Group<'_>]) -> String {
    match of_few(fewest(groups)) {
        Some(words) => format!("bootstrap intervals over seeds, {words}"),
        None => "95 % bootstrap intervals over seeds".to_owned(),
    }
}

/// The actual coverage with so few seeds; `None` if it is nominal or if intervals are missing.
pub fn of_few(count: usize) -> Option<String> {
    let [mean, difference] = coverage(count)?;
    let what =
        if count < 4 { format!("the range of {count} seeds") } else { format!("over {count} seeds only") };
    Some(format!("{what}, which covers about {mean} to {difference} %, not 95 %"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::model::Arm;

    #[test]
    fn an_interval_over_few_seeds_is_called_what_it_is() {
        let run = Arm::default();
        let called = |count: usize| over_seeds(&[Group { name: "a", points: &[], runs: vec![&run; count] }]);
        assert_eq!(
            called(3),
            "bootstrap intervals over seeds, the range of 3 seeds, which covers about 75 to 80 %, not 95 %"
        );
        assert!(called(4).contains("over 4 seeds only, which covers about 80 to 86 %"), "{}", called(4));
        assert_eq!([1, 5].map(called), ["95 % bootstrap intervals over seeds"; 2]);
    }
}
