//! Adam (Kingma and Ba 2015) on flat parameters, in one pass over memory, with moments that are stored
//! exactly.

/// Decay of the first moment.
pub(super) const FIRST_DECAY: f64 = 0.9;
/// Decay of the second moment.
pub(super) const SECOND_DECAY: f64 = 0.999;

/// Adam's state for one network.
#[derive(Clone, Debug, PartialEq)]
pub struct Adam {
    /// Mean of the gradients, one number per parameter.
    pub first: Vec<f32>,
    /// Mean of the squared gradients.
    pub second: Vec<f32>,
    /// Steps taken.
    pub steps: u64,
}

/// Factors of one step, shared by all parameters.
#[derive(Clone, Copy)]
pub(super) struct Factors {
    /// Factor that clips the gradient to its bound.
    pub(super) shrink: f32,
    /// Step sizes, with the first moment's bias correction, of the hidden layers and of the last layer.
    pub(super) rates: [f32; 2],
    /// Square root of the second moment's bias correction.
    pub(super) correction: f32,
    pub(super) epsilon: f32,
}

impl Factors {
    /// The factors of step `step`, counted from 1, for a gradient of norm `norm`.
    pub(super) fn new(norm: f64, rule: Rule, step: u64) -> Self {
        let decayed = |decay: f64| 1.0 - libm::pow(decay, step as f64);
        Self {
            shrink: if norm > rule.bound { (rule.bound / (norm + 1e-6)) as f32 } else { 1.0 },
            rates: rule.rates.map(|rate| (rate / decayed(FIRST_DECAY)) as f32),
            correction: decayed(SECOND_DECAY).sqrt() as f32,
            epsilon: rule.epsilon as f32,
        }
    }
}

impl Adam {
    /// The state before the first step.
    pub fn new(parameters: usize) -> Self {
        Self { first: vec![0.0; parameters], second: vec![0.0; parameters], steps: 0 }
    }

    /// Whether the state belongs to this number of parameters.
    pub fn fits(&self, parameters: usize) -> bool {
        self.first.len() == parameters && self.second.len() == parameters
    }

    /// Moves the parameters against the gradient, which has this norm and is first clipped to the rule's
    /// bound. The last layer's parameters begin at `last`.
    pub fn step(&mut self, parameters: &mut [f32], gradient: &[f32], norm: f64, last: usize, rule: Rule) {
        self.steps += 1;
        let factors = Factors::new(norm, rule, self.steps);
        let (hidden_parameters, parameters) = parameters.split_at_mut(last);
        let (hidden_gradient, gradient) = gradient.split_at(last);
        let (hidden_first, first) = self.first.split_at_mut(last);
        let (hidden_second, second) = self.second.split_at_mut(last);
        let [hidden_rate, rate] = factors.rates;
        let hidden = Moments { first: hidden_first, second: hidden_second };
        advance(hidden_parameters, hidden_gradient, hidden, factors, hidden_rate);
        advance(parameters, gradient, Moments { first, second }, factors, rate);
    }
}

/// Settings of one step of Adam.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Step sizes of the hidden layers and of the last layer.
    pub rates: [f64; 2],
    /// Added to the root of the second moment.
    pub epsilon: f64,
    /// Bound of the gradient's norm.
    pub bound: f64,
}

/// Euclidean norm, summed in sixteen interleaved parts so that the compiler can use vector registers.
pub(super) fn norm(gradient: &[f32]) -> f64 {
    let (chunks, rest) = gradient.as_chunks::<16>();
    let mut parts = [0.0f32; 16];
    for chunk in chunks {
        for i in 0..16 {
            parts[i] += chunk[i] * chunk[i];
        }
    }
    let sum = parts
        .iter()
        .chain(&rest.iter().map(|x| x * x).collect::<Vec<_>>())
        .map(|x| f64::from(*x))
        .sum::<f64>();
    sum.sqrt()
}

/// Both moments of some of the parameters.
struct Moments<'a> {
    first: &'a mut [f32],
    second: &'a mut [f32],
}

/// The step, with the widest vector registers of the processor. All versions give the same bits.
fn advance(parameters: &mut [f32], gradient: &[f32], moments: Moments, factors: Factors, rate: f32) {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2.
        return unsafe { advance_avx2(parameters, gradient, moments, factors, rate) };
    }
    advance_any(parameters, gradient, moments, factors, rate);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn advance_avx2(parameters: &mut [f32], gradient: &[f32], moments: Moments, factors: Factors, rate: f32) {
    advance_any(parameters, gradient, moments, factors, rate);
}

#[inline(always)]
fn advance_any(parameters: &mut [f32], gradient: &[f32], moments: Moments, factors: Factors, rate: f32) {
    let (keep, take) = (FIRST_DECAY as f32, (1.0 - FIRST_DECAY) as f32);
    let (keep_square, take_square) = (SECOND_DECAY as f32, (1.0 - SECOND_DECAY) as f32);
    let count = parameters.len();
    let (gradient, first, second) =
        (&gradient[..count], &mut moments.first[..count], &mut moments.second[..count]);
    for index in 0..count {
        let slope = factors.shrink * gradient[index];
        first[index] = keep * first[index] + take * slope;
        second[index] = keep_square * second[index] + take_square * slope * slope;
        let root = second[index].sqrt() / factors.correction + factors.epsilon;
        parameters[index] -= rate * first[index] / root;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_steps_equal_adams_definition() {
        let mut adam = Adam::new(2);
        let mut parameters = [1.0, -2.0];
        let (rates, unbounded) = ([0.1, 0.02], f64::INFINITY);
        let rule = Rule { rates, epsilon: 1e-5, bound: unbounded };
        let gradients = [[3.0f64, -0.5], [-1.0, 0.25], [0.5, 0.125]];
        let (mut m, mut v, mut expected) = ([0.0f64; 2], [0.0f64; 2], [1.0f64, -2.0]);
        for (step, gradient) in gradients.iter().enumerate() {
            for i in 0..2 {
                m[i] = 0.9 * m[i] + 0.1 * gradient[i];
                v[i] = 0.999 * v[i] + 0.001 * gradient[i] * gradient[i];
                let t = step as i32 + 1;
                let (m_hat, v_hat) = (m[i] / (1.0 - 0.9f64.powi(t)), v[i] / (1.0 - 0.999f64.powi(t)));
                expected[i] -= rates[i] * m_hat / (v_hat.sqrt() + 1e-5);
            }
            adam.step(&mut parameters, &gradient.map(|x| x as f32), 1.0, 1, rule);
        }
        for i in 0..2 {
            assert!((f64::from(parameters[i]) - expected[i]).abs() < 1e-5, "{parameters:?} {expected:?}");
        }
    }

    #[test]
    fn a_long_gradient_is_shortened() {
        let mut adam = Adam::new(2);
        let rule = Rule { rates: [0.1; 2], epsilon: 1e-5, bound: 0.5 };
        let norm = norm(&[3.0, 4.0]);
        assert!((norm - 5.0).abs() < 1e-6);
        adam.step(&mut [0.0, 0.0], &[3.0, 4.0], norm, 0, rule);
        assert!((adam.first[0] - 0.1 * 0.3).abs() < 1e-6 && (adam.first[1] - 0.1 * 0.4).abs() < 1e-6);
    }
}
