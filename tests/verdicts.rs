//! A made-up record with claims of every form, which `tests/reference/recompute_verdicts.py` judges again
//! with scipy.

#[path = "report/made_up_claims.rs"]
mod made_up_claims;

use std::fs;
use std::path::Path;

use specforge::outcome::{Episode, Evaluation};
use specforge::plan::{RunRecord, SuiteRecord};
use specforge::report::agreement::disagreements;
use specforge::report::model::{Arm, Measured, ReportInput, Update};
use specforge::report::runs;
use specforge::report::sidecar::{RULES, Sidecar};
use specforge::report::suite::judged;
use specforge::stream::Stream;

const CLAIMS: &str = include_str!("golden/verdicts/claims.toml");

/// The share of surviving episodes, the speed and its spread of an arm.
const ARMS: [(&str, &str, f64, f64, f64); 6] = [
    ("torque", "flat", 0.95, 0.50, 0.02),
    ("torque", "box", 1.0, 0.45, 0.03),
    ("position", "flat", 0.80, 0.30, 0.05),
    ("position", "box", 0.40, 0.20, 0.05),
    ("perfect", "flat", 1.0, 0.50, 0.0),
    ("perfect", "box", 1.0, 0.40, 0.0),
];

/// The runs of an arm: of each some episodes survive, and their speeds differ.
fn run((control, ground, survival, speed, spread): (&str, &str, f64, f64, f64), seed: u64) -> Arm {
    let name = format!("control={control},ground={ground}");
    let mut stream = Stream::new(&format!("test/verdicts/{name}/{seed}"));
    let own = (speed + spread * stream.normal(), (survival + 0.05 * stream.normal()).min(survival.max(0.97)));
    let mut measured = |stage: &str, factor: f64| {
        let episode = |at: usize, stream: &mut Stream| Episode {
            stream: format!("1000/episode/{at}"),
            survived: survival == 1.0 || stream.uniform() < own.1,
            speed: factor * own.0 + 0.2 * spread * stream.normal(),
            ..Episode::default()
        };
        let episodes = (0..40).map(|at| episode(at, &mut stream)).collect();
        Measured {
            stage: stage.into(),
            evaluation: Evaluation { engine: "rapier".into(), episodes, ..Evaluation::default() },
        }
    };
    let evaluations = vec![measured("evaluate.nominal", 1.0), measured("evaluate.push", 0.8)];
    let updates = (1..=10).map(|update| Update {
        samples: 100 * update,
        return_mean: Some(own.0 * update as f64),
        ..Update::default()
    });
    Arm {
        name: format!("{name},seed={seed}"),
        updates: updates.collect(),
        evaluations,
        run: Some(RunRecord {
            id: format!("{seed}"),
            arm: name,
            points: vec![("control".into(), control.into()), ("ground".into(), ground.into())],
            seed,
        }),
        ..Arm::default()
    }
}

#[test]
fn the_made_up_record_is_what_the_rules_give() {
    let arms = ARMS.iter().flat_map(|arm| (1..=5).map(|seed| run(*arm, seed))).collect();
    let suite = SuiteRecord {
        claims: made_up_claims::decoded(CLAIMS),
        seeds: (1..=5).collect(),
        ..SuiteRecord::default()
    };
    let input = ReportInput { name: "made_up".into(), arms, suite: Some(suite), ..ReportInput::default() };
    let claims = judged(&input);
    for verdict in ["PASS", "FAIL", "NOT ESTABLISHED", "NOT MEANINGFUL"] {
        let has = claims.iter().any(|claim| claim.verdict.word() == verdict);
        assert!(
            has,
            "no claim is {verdict}: {:?}",
            claims.iter().map(|c| (&c.id, c.verdict, c.p)).collect::<Vec<_>>()
        );
    }
    let record = Sidecar {
        report: "made_up".into(),
        rules: RULES,
        runs: runs::records(&input),
        claims,
        ..Sidecar::default()
    };
    // The program judges them again from what the record keeps of them, to the same numbers.
    assert_eq!(disagreements(&record), Vec::<String>::new());
    let read: Sidecar = serde_json::from_str(&record.to_json()).expect("a record");
    assert_eq!(disagreements(&read), Vec::<String>::new());
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/verdicts/made_up.json");
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        fs::write(&path, record.to_json()).expect("the record can be written");
    }
    let committed = fs::read_to_string(path).unwrap_or_default();
    // As text: what is never reached has no number in JSON.
    assert!(
        committed == record.to_json(),
        "run `SPECFORGE_BLESS=1 cargo test --test verdicts`, then recompute_verdicts.py"
    );
}
