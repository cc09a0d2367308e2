//! The analysis of failures over parameter sets: it agrees with independent implementations
//! (`tests/reference/`), and it finds a synthetic truth that centred components miss.

use nalgebra::{DMatrix, SymmetricEigen};
use serde_json::Value;
use specforge::statistics::failure::logistic::{Design, RIDGE};
use specforge::statistics::failure::{Sets, deciles, difference, loadings};
use specforge::stream::Stream;

const PRIMES: [f64; 8] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0];

fn reference() -> Value {
    serde_json::from_str(include_str!("reference/failures.json")).expect("JSON")
}

fn numbers(value: &Value) -> Vec<f64> {
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("a number: {value}"));
    value.as_array().unwrap_or_else(|| panic!("numbers: {value}")).iter().map(number).collect()
}

#[track_caller]
fn close(ours: &[f64], theirs: &[f64], tolerance: f64) {
    assert_eq!(ours.len(), theirs.len());
    let off = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off <= tolerance, "{ours:?} is not {theirs:?}");
}

/// The sets of the reference, to the bit.
fn formula() -> Vec<Vec<f64>> {
    (1..=400).map(|set| PRIMES.map(|prime| 2.0 * spread(set, prime) - 1.0).to_vec()).collect()
}

fn spread(set: u32, prime: f64) -> f64 {
    let multiple = f64::from(set) * libm::sqrt(prime);
    multiple - libm::floor(multiple)
}

fn with_failures(rows: Vec<Vec<f64>>, failed: impl Fn(usize, &[f64]) -> bool) -> Sets {
    Sets {
        names: (0..rows[0].len()).map(|at| format!("p{at}")).collect(),
        failures: rows.iter().enumerate().map(|(at, row)| f64::from(u8::from(failed(at, row)))).collect(),
        trials: vec![1.0; rows.len()],
        rows,
    }
}

fn chance(odds: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-odds))
}

fn sets() -> Sets {
    with_failures(formula(), |at, x| {
        let odds = -1.2 + 2.0 * x[0] + 0.8 * x[1] - 0.6 * x[2] + 1.5 * x[3] * x[3];
        spread(at as u32 + 1, 23.0) < chance(odds)
    })
}

fn once(sets: &Sets) -> Vec<f64> {
    vec![1.0; sets.rows.len()]
}

#[test]
fn the_direction_of_failure_is_numpys_first_right_singular_vector() {
    let (sets, reference) = (sets(), reference());
    assert_eq!(sets.counts()[0], reference["failures"].as_f64().expect("a count"));
    let found = loadings::of(&sets, &once(&sets)).expect("failures");
    close(&found.direction, &numbers(&reference["direction"]), 1e-10);
    close(&[found.share], &[reference["share"].as_f64().expect("a share")], 1e-12);
}

#[test]
fn the_logistic_regression_is_that_of_statsmodels_and_the_penalised_one_that_of_scikit_learn() {
    let (sets, reference) = (sets(), reference());
    let fit = Design::new(&sets).fit(&once(&sets), None).expect("a maximum");
    assert_eq!(fit.ridge, None);
    let ours = [fit.linear.clone(), fit.quadratic.clone()].concat();
    close(&ours, &numbers(&reference["logit"]["coefficients"]), 1e-8);
    close(&[fit.intercept], &[reference["logit"]["intercept"].as_f64().expect("a number")], 1e-8);
    let apart = with_failures(formula(), |_, x| x[0] > 0.3);
    let fit = Design::new(&apart).fit(&once(&apart), None).expect("a penalised maximum");
    assert_eq!(fit.ridge, Some(RIDGE));
    let ours = [fit.linear.clone(), fit.quadratic.clone()].concat();
    close(&ours, &numbers(&reference["separated"]["ridge"]["coefficients"]), 1e-6);
}

#[test]
fn differences_and_deciles_are_those_of_numpy() {
    let (sets, reference) = (sets(), reference());
    close(&difference::of(&sets, &once(&sets)).expect("spread"), &numbers(&reference["differences"]), 1e-12);
    for (parameter, theirs) in reference["deciles"].as_array().expect("parameters").iter().enumerate() {
        let ours: Vec<f64> =
            deciles::of(&sets, parameter, 0.95).iter().map(|part| part.count[0] as f64).collect();
        close(&ours, &numbers(theirs), 0.0);
    }
}

/// The first component of the failed sets after their mean is taken away: what libraries call PCA.
fn centred_component(sets: &Sets) -> Vec<f64> {
    let failed: Vec<&Vec<f64>> = sets
        .rows
        .iter()
        .zip(&sets.failures)
        .filter(|(_, failures)| **failures > 0.0)
        .map(|(row, _)| row)
        .collect();
    let columns = sets.names.len();
    let mean = |at: usize| failed.iter().map(|row| row[at]).sum::<f64>() / failed.len() as f64;
    let means: Vec<f64> = (0..columns).map(mean).collect();
    let covariance = DMatrix::from_fn(columns, columns, |i, j| {
        failed.iter().map(|row| (row[i] - means[i]) * (row[j] - means[j])).sum::<f64>()
    });
    let eigen = SymmetricEigen::new(covariance);
    eigen.eigenvectors.column(eigen.eigenvalues.imax()).iter().copied().collect()
}

#[test]
fn the_centred_component_is_that_of_scikit_learn() {
    let ours = centred_component(&sets());
    let theirs = numbers(&reference()["centred"]);
    let turned: Vec<f64> = ours.iter().map(|entry| -entry).collect();
    close(if ours[3] * theirs[3] > 0.0 { &ours } else { &turned }, &theirs, 1e-9);
}

const DELAY: usize = 6;
const LEG: usize = 7;
const MOTOR: usize = 5;
const MASS: usize = 0;

/// The paper's 4 870 sets of eight scales, uniform, of which about 30 % fail by these log odds.
fn demonstration(odds: impl Fn(&[f64]) -> f64) -> Sets {
    let mut stream = Stream::new("test/demonstration");
    let rows: Vec<Vec<f64>> =
        (0..4870).map(|_| (0..8).map(|_| 2.0 * stream.uniform() - 1.0).collect()).collect();
    let luck: Vec<f64> = (0..4870).map(|_| stream.uniform()).collect();
    let sets = with_failures(rows, |at, x| luck[at] < chance(odds(x)));
    let share = sets.counts()[0] / 4870.0;
    assert!((0.25..0.35).contains(&share), "{share}");
    sets
}

fn unit(values: &[f64]) -> Vec<f64> {
    let length = values.iter().map(|value| value * value).sum::<f64>().sqrt();
    values.iter().map(|value| value / length).collect()
}

#[test]
fn what_fails_on_one_side_is_found_where_a_centred_component_shows_noise() {
    let truth = [(DELAY, 0.92), (LEG, 0.28), (MOTOR, -0.23), (MASS, 0.14)];
    let sets = demonstration(|x| 5.0 * truth.iter().map(|(at, slope)| slope * x[*at]).sum::<f64>() - 1.7);
    let found = loadings::of(&sets, &once(&sets)).expect("failures").direction;
    let fit = Design::new(&sets).fit(&once(&sets), None).expect("a maximum");
    let linear = unit(&fit.linear);
    let centred = centred_component(&sets);
    for (at, slope) in truth {
        assert!((linear[at] - slope).abs() < 0.05, "regression {linear:?}");
    }
    let along = |direction: &[f64]| truth.iter().map(|(at, slope)| slope * direction[*at]).sum::<f64>();
    assert!(along(&linear) > 0.99 && along(&found) > 0.85 && found[DELAY] > 0.75, "direction {found:?}");
    assert!(
        along(&centred).abs() < 0.5 && centred[DELAY].abs() < 0.3,
        "the cause is missing from {centred:?}"
    );
}

#[test]
fn what_fails_at_both_extremes_is_found_by_the_squares() {
    let sets = demonstration(|x| 3.0 * x[DELAY] + 5.0 * x[LEG] * x[LEG] - 3.2);
    let found = loadings::of(&sets, &once(&sets)).expect("failures").direction;
    assert!(found[LEG].abs() > 0.8, "both extremes outweigh the side: {found:?}");
    let fit = Design::new(&sets).fit(&once(&sets), None).expect("a maximum");
    let linear = unit(&fit.linear);
    assert!(linear[DELAY] > 0.97 && linear[LEG].abs() < 0.1, "without squares the leg is missed: {linear:?}");
    assert!(fit.quadratic[LEG] > 1.0 && fit.quadratic[DELAY].abs() < 0.2, "{:?}", fit.quadratic);
}

#[test]
fn intervals_of_causes_leave_out_zero_and_those_of_others_mostly_hold_it() {
    let rows = |stream: &mut Stream| {
        (0..600).map(|_| (0..4).map(|_| 2.0 * stream.uniform() - 1.0).collect()).collect()
    };
    let mut stream = Stream::new("test/causes");
    let sets = {
        let rows: Vec<Vec<f64>> = rows(&mut stream);
        let luck: Vec<f64> = rows.iter().map(|_| stream.uniform()).collect();
        with_failures(rows, |at, x| luck[at] < chance(2.5 * x[0] - 1.0))
    };
    let found = sets.analyse(0.95, &mut Stream::new("test/causes/resamples")).expect("enough of both");
    let apart = |at: usize| found.linear[at].interval.is_some_and(|ends| !ends.contains(0.0));
    assert!(apart(0) && (1..4).filter(|at| apart(*at)).count() <= 1, "{:?}", found.linear);
    assert!(found.differences[0].interval.expect("an interval").low > 0.5, "{:?}", found.differences);
    let again = sets.analyse(0.95, &mut Stream::new("test/causes/resamples"));
    assert_eq!(again, Some(found), "the same stream gives the same intervals");
}

#[test]
fn nine_failures_are_too_few_to_say_why() {
    let sets = with_failures(formula(), |at, _| at < 9);
    assert_eq!(sets.analyse(0.95, &mut Stream::new("test/few")), None);
}
