//! Intervals for means: Student's, and the stratified percentile bootstrap.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::Interval;
use super::resample::RESAMPLES;
use super::summary::{deviation, mean, quantile_of_sorted};
use crate::stream::Stream;

/// Smallest number of values for which the percentile interval is labelled with its confidence and gets a p
/// value.
pub const FEWEST: usize = 5;

/// Actual coverage in per cent of the 95 % percentile interval over so few normal values: for a mean, and for
/// a difference of two means. `None` from [`FEWEST`] values on (83 and 87 % there), and if there is no
/// interval.
///
/// With two or three values the interval of a mean is their range: one resample in 4 or 27 consists of the
/// smallest value alone, which exceeds the 2.5 % that are cut off at each end.
pub fn coverage(count: usize) -> Option<[u32; 2]> {
    match count {
        2 => Some([50, 67]),
        3 => Some([75, 80]),
        4 => Some([80, 86]),
        _ => None,
    }
}

/// Student's interval for the mean of independent values; `None` with fewer than two values.
pub fn student(values: &[f64], confidence: f64) -> Option<Interval> {
    let centre = mean(values)?;
    let error = deviation(values)? / libm::sqrt(values.len() as f64);
    let freedom = (values.len() - 1) as f64;
    let t = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(0.5 + 0.5 * confidence);
    Some(Interval { low: centre - t * error, high: centre + t * error })
}

/// Percentile bootstrap interval for the mean over strata of the strata's means: values are resampled within
/// their stratum (Agarwal et al. 2021). One stratum gives the ordinary bootstrap. `None` without strata or if
/// one has fewer than two values.
pub fn bootstrap(strata: &[&[f64]], confidence: f64, stream: &mut Stream) -> Option<Interval> {
    if strata.is_empty() || strata.iter().any(|stratum| stratum.len() < 2) {
        return None;
    }
    let resampled = |stratum: &[f64], stream: &mut Stream| {
        let sum: f64 = (0..stratum.len()).map(|_| stratum[stream.below(stratum.len())]).sum();
        sum / stratum.len() as f64
    };
    let mut means: Vec<f64> = (0..RESAMPLES)
        .map(|_| strata.iter().map(|stratum| resampled(stratum, stream)).sum::<f64>() / strata.len() as f64)
        .collect();
    means.sort_by(f64::total_cmp);
    let tail = 0.5 - 0.5 * confidence;
    Some(Interval { low: quantile_of_sorted(&means, tail)?, high: quantile_of_sorted(&means, 1.0 - tail)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn students_interval_of_sleep_data_is_the_published_one() {
        // Student 1908: extra sleep, group 2 minus group 1, paired; mean 1.58, 95 % interval 0.700 to 2.460.
        let gain = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4];
        let interval = student(&gain, 0.95).expect("ten values");
        assert!((interval.low - 0.7001142).abs() < 1e-6, "{interval:?}");
        assert!((interval.high - 2.4598858).abs() < 1e-6, "{interval:?}");
        assert_eq!(student(&[1.0], 0.95), None);
    }

    #[test]
    fn the_bootstrap_of_a_large_sample_agrees_with_the_normal_theory() {
        let values: Vec<f64> = (0..400).map(|index| f64::from(index % 20)).collect();
        let interval = bootstrap(&[&values], 0.95, &mut Stream::new("test/bootstrap")).expect("many values");
        // Standard deviation sqrt(33.25) = 5.766, standard error 0.2883.
        assert!((interval.low - (9.5 - 1.96 * 0.2883)).abs() < 0.03, "{interval:?}");
        assert!((interval.high - (9.5 + 1.96 * 0.2883)).abs() < 0.03, "{interval:?}");
    }

    #[test]
    fn strata_take_the_difference_between_them_out_of_the_interval() {
        let (low, high) = ([0.0, 0.2, 0.1, 0.1], [10.0, 10.2, 10.1, 10.1]);
        let pooled: Vec<f64> = low.iter().chain(&high).copied().collect();
        let width = |interval: Interval| interval.high - interval.low;
        let stratified =
            bootstrap(&[&low, &high], 0.95, &mut Stream::new("test/strata")).expect("two strata");
        let plain = bootstrap(&[&pooled], 0.95, &mut Stream::new("test/strata")).expect("eight values");
        assert!(width(stratified) < 0.2 && width(plain) > 5.0, "{stratified:?} {plain:?}");
        assert!(stratified.contains(5.1));
    }

    #[test]
    fn the_same_stream_gives_the_same_interval() {
        let values = [1.0, 2.0, 4.0, 8.0];
        let draw = || bootstrap(&[&values], 0.95, &mut Stream::new("test/again"));
        assert_eq!(draw(), draw());
    }
}
