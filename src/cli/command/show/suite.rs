//! `show` for a suite: its axes, seeds and claims, and the arms with their run ids.

use serde_json::json;

use crate::check::{CheckedArm, CheckedSuite};
use crate::cli::Exit;
use crate::escape::terminal::one_line;
use crate::plan::suite::records;
use crate::spec::suite::Suite;
use crate::study::suite::lowered;

/// The suite as text or JSON.
pub fn show(checked: &CheckedSuite, as_json: bool) -> Result<String, Exit> {
    let (suite, arms) = checked.sound().ok_or(Exit::Invalid)?;
    let ids = ids(checked, suite, arms);
    Ok(if as_json { super::pretty(&document(checked, suite, &ids)) } else { text(checked, suite, &ids) })
}

/// The seed and the id of every run, by arm.
fn ids(checked: &CheckedSuite, suite: &Suite, arms: &[CheckedArm]) -> Vec<Vec<(u64, String)>> {
    let lowered = lowered(suite, arms, checked);
    let of_arm = |arm: &crate::plan::Arm| {
        let runs = arm.runs.as_ref().map(|runs| records(arm, runs)).unwrap_or_default();
        runs.into_iter().map(|run| (run.seed, run.id)).collect()
    };
    lowered.iter().map(of_arm).collect()
}

fn text(checked: &CheckedSuite, suite: &Suite, ids: &[Vec<(u64, String)>]) -> String {
    let arms = &checked.arms;
    let mut text = one_line(&format!("{}: {}", suite.name, suite.summary));
    for axis in &suite.sweep.axes {
        let points: Vec<&str> = axis.points.iter().map(|point| point.name.as_str()).collect();
        let path = axis.path.as_ref().map(|path| format!("   ({path})")).unwrap_or_default();
        text += &one_line(&format!("  {:<12} {}{path}", axis.name, points.join(", ")));
    }
    let seeds: Vec<String> = suite.sweep.seeds.iter().flatten().map(|(seed, _)| seed.to_string()).collect();
    text += &one_line(&format!(
        "  {:<12} {}",
        "seeds",
        if seeds.is_empty() { "each spec's own".to_owned() } else { seeds.join(", ") }
    ));
    if !suite.profiles.is_empty() {
        text += &one_line(&format!("  {:<12} {}", "profiles", suite.profiles.join(", ")));
    }
    for claim in &checked.claims {
        text += &one_line(&format!("  {:<12} {}: {}", "claim", claim.id, claim.text));
    }
    let runs: usize = ids.iter().map(Vec::len).sum();
    text += &one_line(&format!("\n{} arms, {runs} runs", arms.len()));
    let width = arms.iter().map(|arm| arm.arm.name.chars().count()).max().unwrap_or(0);
    for (arm, ids) in arms.iter().zip(ids) {
        let runs: Vec<String> = ids.iter().map(|(seed, id)| format!("{seed}: {id}")).collect();
        text += &one_line(&format!("  {:<width$}  {}", arm.arm.name, runs.join("  ")));
    }
    text
}

fn document(checked: &CheckedSuite, suite: &Suite, ids: &[Vec<(u64, String)>]) -> serde_json::Value {
    let arms = &checked.arms;
    let axes = suite.sweep.axes.iter().map(|axis| {
        let points: Vec<&str> = axis.points.iter().map(|point| point.name.as_str()).collect();
        json!({ "name": axis.name, "path": axis.path, "points": points })
    });
    let arms = arms.iter().zip(ids).map(|(arm, ids)| {
        let points: serde_json::Map<_, _> =
            arm.arm.points.iter().map(|(axis, point)| (axis.clone(), json!(point))).collect();
        let runs: Vec<_> = ids.iter().map(|(seed, id)| json!({ "seed": seed, "id": id })).collect();
        json!({ "name": arm.arm.name, "points": points, "runs": runs })
    });
    json!({
        "suite": suite.name,
        "summary": suite.summary,
        "axes": axes.collect::<Vec<_>>(),
        "profiles": suite.profiles,
        "claims": checked.claims.iter().map(|claim| claim.id.as_str()).collect::<Vec<_>>(),
        "arms": arms.collect::<Vec<_>>(),
    })
}
