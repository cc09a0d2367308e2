//! Claims about every one of several policies, each judged by its own episodes: trends of shares over the
//! points of an axis, and stages against their baselines. The resamples take minutes, so the outcome of each
//! simulated policy is committed, and the test repeats some of them.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use specforge::kinds::statistic::Method;
use specforge::spec::claim::Summary;
use specforge::statistics::test::{Sample, Test};
use specforge::stream::Stream;

use super::{ALPHA, Expected, SEEDS, percent};

/// Simulated policies of each row.
const POLICIES: usize = 1000;
/// The outcome of a policy whose test shows what is claimed.
const PASS: char = 'p';
/// Of one whose test shows nothing.
const OPEN: char = '.';
/// Of one that refutes a claim about at most 3, 5 and 10 policies.
const REFUTES: [char; 3] = ['a', 'b', 'c'];

/// What the episodes of a policy are.
#[derive(Clone, Copy)]
enum Episodes {
    /// Shares of successes at the points of an axis, 150 episodes each.
    Trend([f64; 5]),
    /// The quotient by the same episode of the baseline, lognormal: mean, and standard deviation of the
    /// logarithm; 128 episodes.
    Quotient(f64, f64),
    /// Two policies' quotients in the same episodes; half of the variance of the logarithms is the episode's.
    Quotients([f64; 2], f64),
    /// Survival less that of the baseline, where no episode falls: the share that falls; 128 episodes.
    Falls(f64),
}

impl Episodes {
    fn draw(self, stream: &mut Stream) -> Sample {
        let lognormal = |mean: f64, deviation: f64, normal: f64| {
            mean * libm::exp(deviation * normal - 0.5 * deviation * deviation)
        };
        let share = |count: usize, chance: f64, stream: &mut Stream| -> Vec<f64> {
            (0..count).map(|_| f64::from(u8::from(stream.uniform() < chance))).collect()
        };
        match self {
            Self::Trend(points) => {
                let sides = points.iter().map(|chance| share(150, *chance, stream)).collect();
                Sample::Episodes { sides, paired: false }
            }
            Self::Quotient(mean, deviation) => {
                let side = (0..128).map(|_| lognormal(mean, deviation, stream.normal())).collect();
                Sample::Episodes { sides: vec![side], paired: false }
            }
            Self::Quotients(means, deviation) => {
                let mut sides = vec![Vec::new(); 2];
                for _ in 0..128 {
                    let episode = stream.normal();
                    for (side, mean) in sides.iter_mut().zip(means) {
                        let normal = libm::sqrt(0.5) * (episode + stream.normal());
                        side.push(lognormal(mean, deviation, normal));
                    }
                }
                Sample::Episodes { sides, paired: true }
            }
            Self::Falls(chance) => {
                let side = share(128, chance, stream).into_iter().map(|falls| -falls).collect();
                Sample::Episodes { sides: vec![side], paired: false }
            }
        }
    }

    fn method(self) -> Method {
        if matches!(self, Self::Trend(_)) { Method::Newcombe } else { Method::EpisodeBootstrap }
    }

    /// Every so many policies are simulated again: all where that takes no resamples.
    fn stride(self) -> usize {
        if matches!(self, Self::Trend(_)) { 1 } else { POLICIES / 4 }
    }
}

/// A claim about every policy.
struct Row {
    claim: &'static str,
    truth: &'static str,
    episodes: Episodes,
    expected: Expected,
    /// Whether a PASS is false: the truth of one policy lies on the boundary, and the others are as claimed
    /// beyond doubt. Else all policies have the truth, and a FAIL is false.
    is_null: bool,
}

const ROWS: &[Row] = &[
    Row {
        claim: "trend of shares `a > 2.5 %`",
        truth: "null: 60 to 70 % over five points",
        episodes: Episodes::Trend([0.6, 0.625, 0.65, 0.675, 0.7]),
        expected: Expected::Above(0.025),
        is_null: true,
    },
    Row {
        claim: "trend of shares `a > 2.5 %`",
        truth: "null: 90 to 100 % over five points",
        episodes: Episodes::Trend([0.9, 0.925, 0.95, 0.975, 1.0]),
        expected: Expected::Above(0.025),
        is_null: true,
    },
    Row {
        claim: "trend of shares `a > 2.5 %`",
        truth: "effect of Exp. 5: 60, 72, 88, 88, 100 %",
        episodes: Episodes::Trend([0.6, 0.72, 0.88, 0.88, 1.0]),
        expected: Expected::Above(0.025),
        is_null: false,
    },
    Row {
        claim: "over its baseline `a == 1 within 0.15`",
        truth: "null: ratio 1.15, lognormal +-0.2",
        episodes: Episodes::Quotient(1.15, 0.175),
        expected: Expected::Within(0.85, 1.15),
        is_null: true,
    },
    Row {
        claim: "over its baseline `a > 1.2`",
        truth: "null: ratio 1.2, lognormal +-0.6",
        episodes: Episodes::Quotient(1.2, 0.5),
        expected: Expected::Above(1.2),
        is_null: true,
    },
    Row {
        claim: "over its baseline `a > b + 0.1`",
        truth: "null: ratios 1.29 and 1.19, lognormal +-0.2, paired",
        episodes: Episodes::Quotients([1.29, 1.19], 0.16),
        expected: Expected::Above(0.1),
        is_null: true,
    },
    Row {
        claim: "less its baseline `a < -50 %`",
        truth: "null: half of the episodes fall",
        episodes: Episodes::Falls(0.5),
        expected: Expected::Below(-0.5),
        is_null: true,
    },
    Row {
        claim: "over its baseline `a > 1.2`",
        truth: "effect of Exp. 8: ratio 1.29, lognormal +-0.2",
        episodes: Episodes::Quotient(1.29, 0.16),
        expected: Expected::Above(1.2),
        is_null: false,
    },
    Row {
        claim: "less its baseline `a < -50 %`",
        truth: "effect of Exp. 4: every episode falls",
        episodes: Episodes::Falls(1.0),
        expected: Expected::Below(-0.5),
        is_null: false,
    },
];

impl Row {
    fn name(&self) -> String {
        format!("{}, {}", self.claim, self.truth)
    }

    fn outcome(&self, policy: usize) -> char {
        let name = format!("test/false_verdicts/{}/{policy}", self.name());
        let test = Test {
            method: self.episodes.method(),
            summary: Summary::Mean,
            trend: matches!(self.episodes, Episodes::Trend(_)),
            factor: 1.0,
            name: &name,
        };
        let sample = self.episodes.draw(&mut Stream::new(&name));
        let [p_for, p_against] = self.expected.p(&test, &sample);
        if p_for <= ALPHA {
            return PASS;
        }
        let refuted = SEEDS.iter().rposition(|policies| p_against <= ALPHA / *policies as f64);
        refuted.map_or(OPEN, |most| REFUTES[most])
    }

    /// Shares of PASS and FAIL of a claim about so many policies, `SEEDS[at]`.
    fn rates(&self, outcomes: &str, at: usize) -> [f64; 2] {
        let group = if self.is_null { 1 } else { SEEDS[at] };
        let outcomes: Vec<char> = outcomes.chars().collect();
        let claims = outcomes.chunks_exact(group);
        let of_all = claims.len() as f64;
        let passes = claims.clone().filter(|claim| claim.iter().all(|outcome| *outcome == PASS)).count();
        let fails =
            claims.filter(|claim| claim.iter().any(|outcome| REFUTES[at..].contains(outcome))).count();
        [passes as f64 / of_all, fails as f64 / of_all]
    }
}

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/false_verdicts/policies.txt")
}

/// Simulates all policies of all rows, two threads at a time.
fn simulate() -> String {
    let halves = |row: &Row| -> String {
        let part =
            |range: std::ops::Range<usize>| range.map(|policy| row.outcome(policy)).collect::<String>();
        std::thread::scope(|scope| {
            let first = scope.spawn(|| part(0..POLICIES / 2));
            let second = part(POLICIES / 2..POLICIES);
            first.join().expect("no panic") + &second
        })
    };
    ROWS.iter().map(|row| format!("{}: {}\n", row.name(), halves(row))).collect()
}

/// The table of claims about policies, whose rates were checked.
pub fn table() -> String {
    if std::env::var_os("SPECFORGE_SIMULATE").is_some() {
        fs::write(path(), simulate()).expect("the outcomes can be written");
    }
    let committed = fs::read_to_string(path()).expect("the outcomes are there");
    assert_eq!(committed.lines().count(), ROWS.len());
    let mut table =
        "| claim about every policy | truth | false | 3 policies: PASS, FAIL | 5 policies: PASS, FAIL | 10 \
         policies: PASS, FAIL |\n\
         |---|---|---|---|---|---|\n"
            .to_owned();
    for (row, line) in ROWS.iter().zip(committed.lines()) {
        let name = row.name();
        let outcomes = line.strip_prefix(&name).and_then(|rest| rest.strip_prefix(": "));
        let outcomes =
            outcomes.unwrap_or_else(|| panic!("`{name}` is not in its place: SPECFORGE_SIMULATE=1"));
        assert_eq!(outcomes.len(), POLICIES, "{name}");
        for (policy, outcome) in outcomes.chars().enumerate().step_by(row.episodes.stride()) {
            assert_eq!(row.outcome(policy), outcome, "{name}, {policy}");
        }
        let wrong = if row.is_null { "PASS" } else { "FAIL" };
        let found: Vec<[f64; 2]> = (0..SEEDS.len()).map(|at| row.rates(outcomes, at)).collect();
        for [pass, fail] in &found {
            assert!(*if row.is_null { pass } else { fail } <= 0.05, "{name}: {pass} and {fail}");
        }
        let cells: Vec<String> =
            found.iter().map(|[pass, fail]| format!("{}, {}", percent(*pass), percent(*fail))).collect();
        writeln!(table, "| {} | {} | {wrong} | {} |", row.claim, row.truth, cells.join(" | "))
            .expect("a text");
    }
    table
}
