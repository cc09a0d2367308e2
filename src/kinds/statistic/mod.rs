//! Tests of claims: their unit of analysis, the number of runs they need, and the metrics they accept.
//! `statistics/` implements them.

use super::metric::Scale;
use crate::spec::{Edition, Kind};

/// With fewer runs per arm, a test over runs has no p value below [`SMALLEST_OF_FEW`].
pub const FEW: usize = 5;

/// The smallest p value of a test over fewer than [`FEW`] runs per arm. So few values cannot show whether
/// they are normal, so the far tail of Student's distribution is not reliable.
pub const SMALLEST_OF_FEW: f64 = 0.002;

/// A registry entry.
#[derive(Debug)]
pub struct StatisticKind {
    /// Its name and documentation.
    pub kind: Kind,
    /// The computed quantity.
    pub method: Method,
    /// Number of arms.
    pub arms: Arms,
    /// The accepted types of metrics.
    pub takes: &'static [Scale],
    /// Smallest number of runs per arm that can decide a claim at this two-sided level.
    pub least: fn(alpha: f64) -> usize,
}

/// Computation of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// `episode_bootstrap`
    EpisodeBootstrap,
    /// `mann_whitney`
    MannWhitney,
    /// `mcnemar`
    Mcnemar,
    /// `newcombe`
    Newcombe,
    /// `probability_of_improvement`
    ProbabilityOfImprovement,
    /// `stratified_bootstrap`
    StratifiedBootstrap,
    /// `welch`
    Welch,
    /// `wilson`
    Wilson,
}

impl Method {
    /// Its unit of observation.
    pub fn unit(self) -> Unit {
        match self {
            Self::EpisodeBootstrap | Self::Mcnemar | Self::Newcombe | Self::Wilson => Unit::Episode,
            Self::MannWhitney | Self::ProbabilityOfImprovement | Self::StratifiedBootstrap | Self::Welch => {
                Unit::Seed
            }
        }
    }
}

/// Unit of observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// An episode: the claim is about policies.
    Episode,
    /// A run: the claim is about methods.
    Seed,
}

/// Number of arms that a test compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arms {
    /// One arm with a number.
    One,
    /// Two arms with each other.
    Two,
    /// Either.
    OneOrTwo,
}

impl StatisticKind {
    /// Its unit of observation.
    pub fn unit(&self) -> Unit {
        self.method.unit()
    }
}

impl Arms {
    /// Whether this number of arms can be compared.
    pub fn takes(self, count: usize) -> bool {
        match self {
            Self::One => count == 1,
            Self::Two => count == 2,
            Self::OneOrTwo => count == 1 || count == 2,
        }
    }
}

/// A test: its name, computation, number of arms, accepted types of metrics, and smallest number of runs. Its
/// page is the Markdown file with its name.
macro_rules! statistic {
    ($name:literal, $method:expr, $arms:expr, $takes:expr, $least:expr) => {
        StatisticKind {
            kind: Kind {
                name: $name,
                since: Edition::ONE,
                doc: include_str!(concat!($name, ".md")),
                params: &[],
                needs: &[],
            },
            method: $method,
            arms: $arms,
            takes: $takes,
            least: $least,
        }
    };
}

/// Every test, sorted by name.
pub static KINDS: &[&StatisticKind] = &[
    &statistic!(
        "episode_bootstrap",
        Method::EpisodeBootstrap,
        Arms::OneOrTwo,
        &[Scale::Success, Scale::Real],
        least::one
    ),
    &statistic!(
        "mann_whitney",
        Method::MannWhitney,
        Arms::Two,
        &[Scale::Success, Scale::Real, Scale::Censored],
        least::ranks
    ),
    &statistic!("mcnemar", Method::Mcnemar, Arms::Two, &[Scale::Success], least::one),
    &statistic!("newcombe", Method::Newcombe, Arms::Two, &[Scale::Success], least::one),
    &statistic!(
        "probability_of_improvement",
        Method::ProbabilityOfImprovement,
        Arms::Two,
        &[Scale::Success, Scale::Real, Scale::Censored],
        least::ten
    ),
    &statistic!(
        "stratified_bootstrap",
        Method::StratifiedBootstrap,
        Arms::OneOrTwo,
        &[Scale::Success, Scale::Real],
        least::ten
    ),
    &statistic!("welch", Method::Welch, Arms::OneOrTwo, &[Scale::Success, Scale::Real], least::student),
    &statistic!("wilson", Method::Wilson, Arms::One, &[Scale::Success], least::one),
];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.iter().map(|statistic| &statistic.kind).collect()
}

/// The test with this name.
pub fn find(name: &str) -> Option<&'static StatisticKind> {
    KINDS.iter().copied().find(|statistic| statistic.kind.name == name)
}

/// Additional facts for its page.
pub fn facts(kind: &Kind) -> String {
    let Some(statistic) = find(kind.name) else { return String::new() };
    let unit = match statistic.unit() {
        Unit::Episode => "the episode",
        Unit::Seed => "the run (seed)",
    };
    let arms = match statistic.arms {
        Arms::One => "one arm with a number",
        Arms::Two => "two arms",
        Arms::OneOrTwo => "two arms, or one arm with a number",
    };
    let word = |scale: &Scale| match scale {
        Scale::Success => "successes",
        Scale::Real => "real numbers",
        Scale::Censored => "censored numbers",
    };
    let takes: Vec<&str> = statistic.takes.iter().map(word).collect();
    format!(
        "Written in a claim as `test = \"{}\"`. Unit of analysis: {unit}. Compares {arms}. Takes {}. Runs \
         per arm at \
         `alpha = 0.05`: at least {}. Its p value is corrected over all claims of the suite by Holm's \
         method.\n",
        kind.name,
        takes.join(", "),
        (statistic.least)(0.05),
    )
}

/// Smallest numbers of runs per arm.
mod least {
    use super::{FEW, SMALLEST_OF_FEW};

    /// One run.
    pub fn one(_alpha: f64) -> usize {
        1
    }

    /// Two runs, for a variance; five if the level is below the smallest p value for fewer runs.
    pub fn student(alpha: f64) -> usize {
        if alpha < SMALLEST_OF_FEW { FEW } else { 2 }
    }

    /// Ten runs: with fewer, a percentile interval covers less than 92 % instead of 95 %.
    pub fn ten(_alpha: f64) -> usize {
        10
    }

    /// The smallest n for which the most extreme of all orders of two samples of size n has a two-sided p of
    /// at most alpha: 2 / C(2n, n).
    pub fn ranks(alpha: f64) -> usize {
        let mut orders = 1.0;
        let mut runs = 0;
        while 2.0 / orders > alpha && runs < 100 {
            runs += 1;
            let n = runs as f64;
            orders *= 2.0 * (2.0 * n - 1.0) / n;
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_need_as_many_runs_as_can_be_significant() {
        // 2 / C(6, 3) = 0.1, 2 / C(8, 4) = 0.029, 2 / C(10, 5) = 0.0079.
        assert_eq!([0.1, 0.05, 0.02, 0.001].map(least::ranks), [3, 4, 5, 7]);
    }

    #[test]
    fn a_page_says_unit_arms_and_runs() {
        let page = facts(&find("mann_whitney").expect("a test").kind);
        assert!(
            page.contains("the run (seed)") && page.contains("at least 4") && page.contains("two arms"),
            "{page}"
        );
        assert!(facts(&find("wilson").expect("a test").kind).contains("one arm with a number"));
    }
}
