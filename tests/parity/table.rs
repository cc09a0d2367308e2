//! A figure of each engine with the bound that the tests hold, and the tables of `docs/reference/parity.md`.
//!
//! Figures are written with two digits, and what is below the noise of the arithmetic as such, so that the
//! page is the same on every machine.

use std::fmt::Write;

/// A figure of each engine.
#[derive(Clone, Debug)]
pub struct Row {
    /// What was measured.
    pub quantity: &'static str,
    /// What it should be: the model's figure, a law, or the other engine.
    pub expected: String,
    /// Unit of the figures.
    pub unit: &'static str,
    /// The figures of rapier, MuJoCo and batch.
    pub figures: [f64; 3],
    /// What is bounded.
    pub bound: Bound,
}

/// How figures are judged.
#[derive(Clone, Copy, Debug)]
pub enum Bound {
    /// The figures are deviations, each at most this.
    Deviation(f64),
    /// Likewise, but the last bits of the start decide the figures: only that they are below is worth
    /// telling.
    Below(f64),
    /// The figures lie between these.
    Between(f64, f64),
    /// The figures differ by at most this share of the largest one.
    Apart(f64),
}

impl Row {
    /// Deviations of the engines from what is expected.
    pub fn deviation(
        quantity: &'static str,
        expected: impl Into<String>,
        unit: &'static str,
        of: Limited,
    ) -> Self {
        Self {
            quantity,
            expected: expected.into(),
            unit,
            figures: of.figures,
            bound: Bound::Deviation(of.limit),
        }
    }

    /// Deviations of the engines that the last bits of the start decide.
    pub fn below(
        quantity: &'static str,
        expected: impl Into<String>,
        unit: &'static str,
        of: Limited,
    ) -> Self {
        Self { bound: Bound::Below(of.limit), ..Self::deviation(quantity, expected, unit, of) }
    }

    /// Figures of the engines that have no law but each other.
    pub fn apart(quantity: &'static str, unit: &'static str, of: Limited) -> Self {
        Self {
            quantity,
            expected: "each other".into(),
            unit,
            figures: of.figures,
            bound: Bound::Apart(of.limit),
        }
    }

    /// Figures of the engines that must lie in a range.
    pub fn between(quantity: &'static str, unit: &'static str, figures: [f64; 3], range: (f64, f64)) -> Self {
        Self { quantity, expected: "-".into(), unit, figures, bound: Bound::Between(range.0, range.1) }
    }

    /// Whether the bound holds.
    pub fn holds(&self) -> bool {
        match self.bound {
            Bound::Deviation(limit) | Bound::Below(limit) => {
                self.figures.iter().all(|figure| figure.abs() <= limit)
            }
            Bound::Between(low, high) => self.figures.iter().all(|figure| (low..=high).contains(figure)),
            Bound::Apart(share) => {
                let [least, most] = [f64::min, f64::max]
                    .map(|pick| self.figures.iter().copied().reduce(pick).unwrap_or(f64::NAN));
                most - least <= share * least.abs().max(most.abs())
            }
        }
    }
}

/// Figures of the engines and a limit for them.
#[derive(Clone, Copy, Debug)]
pub struct Limited {
    pub figures: [f64; 3],
    pub limit: f64,
}

/// Figures within a limit.
pub fn within(limit: f64, figures: [f64; 3]) -> Limited {
    Limited { figures, limit }
}

/// A number with two digits; what double precision cannot tell from zero is said to be below 1e-9.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".into()
    } else if size < 1e-9 {
        "< 1e-9".into()
    } else if (0.01..1000.0).contains(&size) {
        let digits = (1.0 - size.log10().floor()).max(0.0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.1e}")
    }
}

/// A table in Markdown.
pub fn markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "| quantity | expected | rapier | MuJoCo | batch | unit | bound |\n|---|---|---|---|---|---|---|\n",
    );
    for Row { quantity, expected, unit, figures, bound } in rows {
        let [rapier, mujoco, batch] = figures.map(|figure| match bound {
            Bound::Below(limit) => format!("< {}", number(*limit)),
            _ => number(figure),
        });
        let bound = match bound {
            Bound::Deviation(limit) | Bound::Below(limit) => number(*limit),
            Bound::Between(low, high) => format!("{} to {}", number(*low), number(*high)),
            Bound::Apart(share) => format!("{} % apart", number(100.0 * share)),
        };
        writeln!(text, "| {quantity} | {expected} | {rapier} | {mujoco} | {batch} | {unit} | {bound} |")
            .unwrap();
    }
    text
}
