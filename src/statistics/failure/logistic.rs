//! Logistic regression of failure on the parameters and their squares, by Newton's method (iteratively
//! reweighted least squares).
//!
//! Columns are standardised, so that coefficients of different parameters can be compared: the log odds
//! change by the coefficient for one standard deviation. If failures and survivals are perfectly separable,
//! the likelihood has no maximum; the coefficients then get a ridge penalty, and the fit reports it.

use nalgebra::{DMatrix, DVector};

use super::Sets;

/// The penalty on the squared standardised coefficients (without the intercept) if the likelihood alone has
/// no maximum.
pub const RIDGE: f64 = 1.0;
/// A standardised coefficient above this shows that the likelihood has no maximum.
const RUNAWAY: f64 = 15.0;
/// Largest number of Newton steps.
const STEPS: usize = 60;
/// Newton's method ends when every coefficient changes by less than this.
const CLOSE: f64 = 1e-8;

/// The columns of a regression, standardised over all sets.
#[derive(Clone, Debug)]
pub struct Design<'a> {
    sets: &'a Sets,
    /// Number of columns: the intercept, and two for each parameter.
    columns: usize,
    /// Row by row.
    values: Vec<f64>,
}

/// A fitted regression.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Log odds of failure with every column at its mean.
    pub intercept: f64,
    /// Coefficient of each standardised parameter.
    pub linear: Vec<f64>,
    /// Coefficient of each standardised square of a standardised parameter.
    pub quadratic: Vec<f64>,
    /// The penalty if one was needed.
    pub ridge: Option<f64>,
}

impl<'a> Design<'a> {
    /// The columns of these sets.
    pub fn new(sets: &'a Sets) -> Self {
        let count = sets.names.len();
        let linear: Vec<Vec<f64>> =
            (0..count).map(|at| standardised(sets.rows.iter().map(|row| row[at]).collect())).collect();
        let quadratic: Vec<Vec<f64>> =
            linear.iter().map(|column| standardised(column.iter().map(|z| z * z).collect())).collect();
        let columns = 1 + 2 * count;
        let mut values = Vec::with_capacity(columns * sets.rows.len());
        for row in 0..sets.rows.len() {
            values.push(1.0);
            values.extend(linear.iter().chain(&quadratic).map(|column| column[row]));
        }
        Self { sets, columns, values }
    }

    /// The coefficients with each set weighted, starting from another fit; `None` if even the penalised
    /// likelihood cannot be maximised.
    pub fn fit(&self, weights: &[f64], from: Option<&Fit>) -> Option<Fit> {
        let start = from.filter(|fit| fit.ridge.is_none()).map(Fit::coefficients);
        let free = match from {
            Some(fit) if fit.ridge.is_some() => None,
            _ => self.climb(weights, 0.0, start),
        };
        match free {
            Some(found) => Some(Fit::new(&found, None)),
            None => {
                let start = from.filter(|fit| fit.ridge.is_some()).map(Fit::coefficients);
                self.climb(weights, RIDGE, start).map(|found| Fit::new(&found, Some(RIDGE)))
            }
        }
    }

    /// Newton's method; `None` if it diverges or does not converge.
    fn climb(&self, weights: &[f64], ridge: f64, start: Option<DVector<f64>>) -> Option<DVector<f64>> {
        let mut found = start.unwrap_or_else(|| DVector::zeros(self.columns));
        let mut height = self.likelihood(&found, weights, ridge);
        for _ in 0..STEPS {
            let (gradient, curvature) = self.slopes(&found, weights, ridge);
            let mut step = curvature.cholesky()?.solve(&gradient);
            let mut next = &found + &step;
            let mut reached = self.likelihood(&next, weights, ridge);
            // The likelihood is concave: a half step is better if a full one overshoots.
            while (reached.is_nan() || reached < height - 1e-12 * height.abs()) && step.amax() > CLOSE {
                step *= 0.5;
                next = &found + &step;
                reached = self.likelihood(&next, weights, ridge);
            }
            (found, height) = (next, reached);
            if ridge == 0.0 && found.amax() > RUNAWAY {
                return None;
            }
            if step.amax() <= CLOSE {
                return Some(found);
            }
        }
        None
    }

    /// Every set's columns, its failures and its trials, times the weight.
    fn counted<'s>(&'s self, weights: &'s [f64]) -> impl Iterator<Item = (&'s [f64], f64, f64)> {
        let counts = self.sets.failures.iter().zip(&self.sets.trials).zip(weights);
        let rows = self.values.chunks_exact(self.columns).zip(counts);
        let rows = rows.map(|(row, ((failures, trials), weight))| (row, failures * weight, trials * weight));
        rows.filter(|(_, _, trials)| *trials > 0.0)
    }

    fn likelihood(&self, at: &DVector<f64>, weights: &[f64], ridge: f64) -> f64 {
        let of = |(row, failures, trials): (&[f64], f64, f64)| {
            let odds = dot(row, at);
            // log(1 + e^odds) without overflow.
            failures * odds - trials * (odds.max(0.0) + libm::log1p(libm::exp(-odds.abs())))
        };
        let penalty: f64 = at.iter().skip(1).map(|entry| 0.5 * ridge * entry * entry).sum();
        self.counted(weights).map(of).sum::<f64>() - penalty
    }

    /// Gradient and negative Hessian of the likelihood.
    fn slopes(&self, at: &DVector<f64>, weights: &[f64], ridge: f64) -> (DVector<f64>, DMatrix<f64>) {
        let count = self.columns;
        let (mut gradient, mut curvature) = (vec![0.0; count], vec![0.0; count * count]);
        for (row, failures, trials) in self.counted(weights) {
            let chance = 1.0 / (1.0 + libm::exp(-dot(row, at)));
            let (residual, variance) = (failures - trials * chance, trials * chance * (1.0 - chance));
            for (i, x) in row.iter().enumerate() {
                gradient[i] += residual * x;
                let scaled = variance * x;
                let line = &mut curvature[i * count..i * count + i + 1];
                line.iter_mut().zip(row).for_each(|(entry, y)| *entry += scaled * y);
            }
        }
        let mut curvature = DMatrix::from_row_slice(count, count, &curvature);
        curvature.fill_upper_triangle_with_lower_triangle();
        let mut gradient = DVector::from_vec(gradient);
        for entry in 1..count {
            gradient[entry] -= ridge * at[entry];
            curvature[(entry, entry)] += ridge;
        }
        (gradient, curvature)
    }
}

impl Fit {
    fn new(coefficients: &DVector<f64>, ridge: Option<f64>) -> Self {
        let (first, rest) = (coefficients[0], &coefficients.as_slice()[1..]);
        let (linear, quadratic) = rest.split_at(rest.len() / 2);
        Self { intercept: first, linear: linear.to_vec(), quadratic: quadratic.to_vec(), ridge }
    }

    fn coefficients(&self) -> DVector<f64> {
        let all = [self.intercept]
            .into_iter()
            .chain(self.linear.iter().copied())
            .chain(self.quadratic.iter().copied());
        DVector::from_vec(all.collect())
    }
}

fn dot(row: &[f64], at: &DVector<f64>) -> f64 {
    row.iter().zip(at.as_slice()).map(|(x, y)| x * y).sum()
}

/// The values minus their mean, divided by their standard deviation (divisor n); zeros if they are all equal.
fn standardised(values: Vec<f64>) -> Vec<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let deviation = libm::sqrt(values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / n);
    let one = |value: f64| if deviation > 1e-12 { (value - mean) / deviation } else { 0.0 };
    values.into_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sets(values: &[f64], failures: &[f64], trials: f64) -> Sets {
        Sets {
            names: vec!["a".into()],
            rows: values.iter().map(|value| vec![*value]).collect(),
            failures: failures.to_vec(),
            trials: vec![trials; values.len()],
        }
    }

    #[test]
    fn three_points_are_met_exactly() {
        // Log odds -1, 0, 2 at -1, 0, 1: three coefficients fit them exactly.
        let share = |odds: f64| 1.0 / (1.0 + libm::exp(-odds));
        let trials = 1000.0;
        let failures = [-1.0, 0.0, 2.0].map(|odds| trials * share(odds));
        let sets = sets(&[-1.0, 0.0, 1.0], &failures, trials);
        let fit = Design::new(&sets).fit(&[1.0; 3], None).expect("a maximum");
        let deviation = libm::sqrt(2.0 / 3.0);
        assert!((fit.linear[0] - 1.5 * deviation).abs() < 1e-8, "{fit:?}");
        // Squares 1, 0, 1 (in x): mean 2/3, and the log odds have the curvature of 0.5 x^2.
        assert!((fit.quadratic[0] - 0.5 * libm::sqrt(2.0) / 3.0).abs() < 1e-8, "{fit:?}");
        assert_eq!(fit.ridge, None);
    }

    #[test]
    fn failures_that_are_told_apart_without_a_mistake_need_a_penalty_and_say_so() {
        let values: Vec<f64> = (0..40).map(|set| f64::from(set) / 20.0 - 1.0).collect();
        let failures: Vec<f64> = values.iter().map(|value| f64::from(u8::from(*value > 0.5))).collect();
        let sets = sets(&values, &failures, 1.0);
        let fit = Design::new(&sets).fit(&[1.0; 40], None).expect("a penalised maximum");
        assert_eq!(fit.ridge, Some(RIDGE));
        assert!(fit.linear[0] > 1.0 && fit.linear[0] < RUNAWAY, "{fit:?}");
    }

    #[test]
    fn a_weight_is_a_repetition() {
        let values = [-1.0, -0.4, 0.1, 0.5, 1.0, -0.8];
        let sets = sets(&values, &[1.0, 2.0, 1.0, 3.0, 4.0, 1.0], 5.0);
        let mut twice = sets.clone();
        twice.failures[0] *= 2.0;
        twice.trials[0] *= 2.0;
        let weighted = Design::new(&sets).fit(&[2.0, 1.0, 1.0, 1.0, 1.0, 1.0], None).expect("a maximum");
        let repeated = Design::new(&twice).fit(&[1.0; 6], None).expect("a maximum");
        assert!((weighted.linear[0] - repeated.linear[0]).abs() < 1e-9, "{weighted:?} {repeated:?}");
    }
}
