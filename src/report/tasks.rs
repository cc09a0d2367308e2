//! Which arms do their task. Readers must know this before any claim, as a claim that passes may compare
//! failures.

use serde::{Deserialize, Serialize};

use super::group::groups;
use super::model::{Arm, Measured, ReportInput};
use super::table::conditions::conditions;
use super::verdict::judge;
use super::wording::{arm_in_words, labels, listed};

/// Most arms that are listed by name at the top of a page.
const NAMED: usize = 8;
/// Most failing arms that are described in full there.
const DESCRIBED: usize = 4;

/// How well the policies of an arm do their task in one evaluation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TaskRecord {
    /// The arm.
    pub arm: String,
    /// The stage of the evaluation.
    pub stage: String,
    /// The task as a verb: `walks`.
    pub verb: String,
    /// Number of evaluated policies, with those that are not judged.
    pub policies: usize,
    /// Number of policies that fail the task.
    pub failing: usize,
    /// The learning seeds of the failing policies; empty in records of earlier versions and for single specs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub seeds: Vec<u64>,
    /// The criteria that failing policies do not meet.
    pub missed: Vec<String>,
    /// Number of policies that are not judged.
    #[serde(default, skip_serializing_if = "is_none")]
    pub unjudged: usize,
    /// Why.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub reason: String,
}

fn is_none(count: &usize) -> bool {
    *count == 0
}

impl TaskRecord {
    /// Whether all policies of the arm fail the task.
    pub fn fails(&self) -> bool {
        self.policies > 0 && self.failing == self.policies
    }

    /// A summary for programs.
    pub fn brief(&self) -> serde_json::Value {
        let Self { arm, stage, policies, failing, missed, .. } = self;
        serde_json::json!({ "arm": arm, "stage": stage, "policies": policies, "failing": failing,
                "missed": missed })
    }

    /// A summary of what is not judged for programs.
    pub fn unjudged_brief(&self) -> serde_json::Value {
        let Self { arm, stage, policies, unjudged, reason, .. } = self;
        serde_json::json!({ "arm": arm, "stage": stage, "policies": policies, "unjudged": unjudged,
                "reason": reason })
    }

    /// `walk: 2 of 3 policies are not judged in evaluate.nominal (its episodes end after 0.2 s ...)`.
    pub fn unjudged_sentence(&self) -> String {
        let Self { arm, stage, policies, unjudged, reason, .. } = self;
        let who = match (policies, unjudged) {
            (1, _) => "the policy is".to_owned(),
            (_, 1) => format!("1 of {policies} policies is"),
            _ => format!("{unjudged} of {policies} policies are"),
        };
        format!("{}: {who} not judged in `{stage}` ({reason})", arm_in_words(arm))
    }

    /// `control=torque: 2 of 3 policies do not walk in evaluate.nominal (not met: ...)`.
    pub fn sentence(&self) -> String {
        let Self { arm, stage, verb, policies, failing, missed, .. } = self;
        let stem = verb.strip_suffix('s').unwrap_or(verb);
        let who = match policies {
            1 => format!("the policy does not {stem}"),
            _ => {
                let verb = if *failing == 1 { "does" } else { "do" };
                let seeds = self.seeds_in_words().map_or(String::new(), |seeds| format!(" ({seeds})"));
                format!("{failing} of {policies} policies{seeds} {verb} not {stem}")
            }
        };
        format!("{}: {who} in `{stage}` (not met: {})", arm_in_words(arm), missed.join("; "))
    }
}

impl TaskRecord {
    /// `2 of 3, seeds 1, 3`
    fn share(&self) -> String {
        let seeds = self.seeds_in_words().map_or(String::new(), |seeds| format!(", {seeds}"));
        format!("{} of {}{seeds}", self.failing, self.policies)
    }

    /// `seeds 1, 3`; `None` if all policies fail or if the seeds are unknown.
    fn seeds_in_words(&self) -> Option<String> {
        if self.seeds.is_empty() || self.fails() {
            return None;
        }
        let seeds: Vec<String> = self.seeds.iter().map(u64::to_string).collect();
        let plural = if seeds.len() == 1 { "" } else { "s" };
        Some(format!("seed{plural} {}", seeds.join(", ")))
    }
}

/// Every arm in every evaluation of its own task, in report order.
pub fn records(input: &ReportInput) -> Vec<TaskRecord> {
    if input.suite.is_some() {
        return groups(input).iter().flat_map(|group| of_arm(group.name, &group.runs)).collect();
    }
    input.arms.iter().zip(labels(&input.arms)).flat_map(|(arm, name)| of_arm(&name, &[arm])).collect()
}

/// The records of arms with at least one failing policy.
pub fn failing(records: &[TaskRecord]) -> impl Iterator<Item = &TaskRecord> {
    records.iter().filter(|record| record.failing > 0)
}

/// The records of arms with at least one policy that is not judged.
pub fn unjudged(records: &[TaskRecord]) -> impl Iterator<Item = &TaskRecord> {
    records.iter().filter(|record| record.unjudged > 0)
}

/// A paragraph for the top of a page on policies that are not judged; `None` if all are.
pub fn unjudged_paragraph(records: &[TaskRecord]) -> Option<String> {
    let told: Vec<String> = unjudged(records).map(TaskRecord::unjudged_sentence).collect();
    let more = told.len().saturating_sub(NAMED);
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    let told = told.iter().take(NAMED).cloned().collect::<Vec<_>>().join("; ");
    (!told.is_empty()).then(|| format!("**Not every policy is judged.** {told}{more}."))
}

/// A paragraph for the top of a page; `None` if every policy does its task or is not judged.
pub fn paragraph(records: &[TaskRecord]) -> Option<String> {
    let failing: Vec<&TaskRecord> = failing(records).collect();
    if failing.is_empty() {
        return None;
    }
    let count = |of: &dyn Fn(&TaskRecord) -> bool| {
        let mut arms: Vec<&str> =
            records.iter().filter(|record| of(record)).map(|record| record.arm.as_str()).collect();
        arms.dedup();
        arms.len()
    };
    let (arms, failed) = (count(&|_| true), count(&|record| record.failing > 0));
    let whole = if records.iter().all(TaskRecord::fails) {
        " No policy does its task, so a claim that passes compares failures."
    } else {
        ""
    };
    let verb = if failed == 1 { "has" } else { "have" };
    let by_arm: Vec<&[&TaskRecord]> = failing.chunk_by(|one, next| one.arm == next.arm).collect();
    let tell = if by_arm.len() > DESCRIBED { briefly } else { of_one_arm };
    let told: Vec<String> = by_arm.iter().take(NAMED).map(|records| tell(records)).collect();
    let more = by_arm.len().saturating_sub(NAMED);
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    Some(format!(
        "**{failed} of {arms} arms {verb} policies that do not do their task.**{whole} {}{more}.",
        told.join("; ")
    ))
}

/// What the failing policies do not do, in one paragraph per arm; empty if the top of the page says it.
pub fn in_full(records: &[TaskRecord]) -> Vec<String> {
    let failing: Vec<&TaskRecord> = failing(records).collect();
    let by_arm: Vec<&[&TaskRecord]> = failing.chunk_by(|one, next| one.arm == next.arm).collect();
    if by_arm.len() <= DESCRIBED {
        return Vec::new();
    }
    by_arm.into_iter().map(|records| format!("{}.", of_one_arm(records))).collect()
}

/// An arm with its evaluation in which most policies fail: `g1, torque (2 of 3, seeds 1, 3)`.
fn briefly(records: &[&TaskRecord]) -> String {
    let worst = records.iter().max_by_key(|record| record.failing);
    worst.map_or(String::new(), |worst| format!("{} ({})", arm_in_words(&worst.arm), worst.share()))
}

/// What the failing policies of one arm do not do: in one evaluation a sentence about it, in several
/// `g1, torque: policies do not run in v60 and v80 (1 of 3, seed 1) and in v100 (3 of 3) (not met: ...)`.
fn of_one_arm(records: &[&TaskRecord]) -> String {
    let [first, _, ..] = records else {
        return records.iter().map(|record| record.sentence()).collect();
    };
    let stem = first.verb.strip_suffix('s').unwrap_or(&first.verb);
    // Evaluations in which the same policies fail are named together.
    let mut places: Vec<(String, Vec<String>)> = Vec::new();
    for record in records {
        let (share, stage) = (record.share(), format!("`{}`", record.stage));
        match places.iter_mut().find(|(known, _)| *known == share) {
            Some((_, stages)) => stages.push(stage),
            None => places.push((share, vec![stage])),
        }
    }
    let places: Vec<String> =
        places.iter().map(|(share, stages)| format!("{} ({share})", listed(stages))).collect();
    let mut missed: Vec<&str> = Vec::new();
    for criterion in records.iter().flat_map(|record| &record.missed) {
        if !missed.contains(&criterion.as_str()) {
            missed.push(criterion);
        }
    }
    format!(
        "{}: policies do not {stem} in {} (not met: {})",
        arm_in_words(&first.arm),
        places.join(" and in "),
        missed.join("; ")
    )
}

/// Whether the simulation diverged in episodes of a stage of a run: their measurements say nothing about the
/// robot.
pub fn explodes(run: &Arm, stage: &str) -> bool {
    let of_stage = |measured: &&Measured| measured.stage == stage;
    run.evaluations.iter().filter(of_stage).any(|measured| measured.evaluation.diverged().next().is_some())
}

/// Whether a run does its task in a stage. If the stage has other conditions, its first evaluation under the
/// task's own conditions counts. `None` without evaluations.
pub fn does(run: &Arm, stage: &str) -> Option<bool> {
    let evaluated = || run.evaluations.iter().filter(|measured| !measured.evaluation.episodes.is_empty());
    let is_own = |measured: &&Measured| conditions(run, measured).is_none();
    let own = evaluated().find(|measured| measured.stage == stage && is_own(measured));
    let measured = own.or_else(|| evaluated().find(is_own)).or_else(|| evaluated().next())?;
    Some(judge(run, &measured.evaluation).holds)
}

/// The evaluations of an arm's own task: those under other conditions are omitted if there are others.
fn of_arm(name: &str, runs: &[&Arm]) -> Vec<TaskRecord> {
    let evaluated =
        |run: &&Arm| run.evaluations.iter().any(|measured| !measured.evaluation.episodes.is_empty());
    let Some(first) = runs.iter().find(|run| evaluated(run)) else { return Vec::new() };
    let with_episodes: Vec<&Measured> =
        first.evaluations.iter().filter(|measured| !measured.evaluation.episodes.is_empty()).collect();
    let mut own: Vec<&Measured> =
        with_episodes.iter().copied().filter(|measured| conditions(first, measured).is_none()).collect();
    if own.is_empty() {
        own.extend(with_episodes.first());
    }
    own.into_iter().map(|measured| of_stage(name, runs, &measured.stage)).collect()
}

fn of_stage(name: &str, runs: &[&Arm], stage: &str) -> TaskRecord {
    let mut record = TaskRecord { arm: name.to_owned(), stage: stage.to_owned(), ..TaskRecord::default() };
    for run in runs {
        let twin = run.evaluations.iter().find(|other| other.stage == stage);
        let Some(measured) = twin.filter(|measured| !measured.evaluation.episodes.is_empty()) else {
            continue;
        };
        let verdict = judge(run, &measured.evaluation);
        record.policies += 1;
        record.verb = verdict.verb;
        if let Some(reason) = verdict.unjudged {
            record.unjudged += 1;
            record.reason = reason;
            continue;
        }
        record.failing += usize::from(!verdict.holds);
        record.seeds.extend(run.run.as_ref().filter(|_| !verdict.holds).map(|run| run.seed));
        for criterion in verdict.criteria.into_iter().filter(|criterion| !criterion.holds) {
            if !record.missed.contains(&criterion.text) {
                record.missed.push(criterion.text);
            }
        }
    }
    record
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::outcome::{Episode, Evaluation};
    use crate::spec::Value;

    fn arm(name: &str, survived: bool) -> Arm {
        let kind = BTreeMap::from([("kind".to_string(), Value::Text("squat".into()))]);
        let episode = Episode { survived, ..Episode::default() };
        let evaluation = Evaluation { episodes: vec![episode; 4], ..Evaluation::default() };
        Arm {
            name: name.into(),
            fields: BTreeMap::from([("task".to_string(), Value::Table(kind))]),
            evaluations: vec![Measured { stage: "evaluate.nominal".into(), evaluation }],
            ..Arm::default()
        }
    }

    #[test]
    fn a_stage_explodes_if_one_of_its_episodes_did() {
        let mut found = arm("a", true);
        assert!(!explodes(&found, "evaluate.nominal"));
        found.evaluations[0].evaluation.episodes[2].end = "exploded".into();
        assert!(explodes(&found, "evaluate.nominal") && !explodes(&found, "evaluate.pushed"));
    }

    #[test]
    fn an_arm_whose_policies_all_fell_is_told_first() {
        let told = |arms: Vec<Arm>| paragraph(&records(&ReportInput { arms, ..ReportInput::default() }));
        assert_eq!(told(vec![arm("a", true), arm("b", true)]), None);
        let one = told(vec![arm("a", true), arm("b", false)]).expect("one fell");
        assert!(
            one.starts_with(
                "**1 of 2 arms has policies that do not do their task.** b: the policy does not squat"
            ),
            "{one}"
        );
        assert!(
            one.contains("(not met: survives at least 90 % of the episodes)")
                && !one.contains("compares failures"),
            "{one}"
        );
        let all = told(vec![arm("a", false), arm("b", false)]).expect("both fell");
        assert!(all.contains("No policy does its task, so a claim that passes compares failures."), "{all}");
    }

    #[test]
    fn failing_arms_are_told_with_their_seeds_and_as_data_and_of_many_the_first() {
        let record = |failing: usize, seeds: &[u64]| TaskRecord {
            arm: "control=torque".into(),
            stage: "evaluate.nominal".into(),
            verb: "walks".into(),
            policies: 3,
            failing,
            seeds: seeds.to_vec(),
            missed: vec!["is fast".into()],
            ..TaskRecord::default()
        };
        for (failing, seeds, words) in [
            (1, &[2][..], "1 of 3 policies (seed 2) does not walk"),
            (2, &[1, 3], "2 of 3 policies (seeds 1, 3) do not walk"),
            (3, &[1, 2, 3], "3 of 3 policies do not walk"),
            (2, &[], "2 of 3 policies do not walk"),
        ] {
            let expected = format!("torque: {words} in `evaluate.nominal` (not met: is fast)");
            assert_eq!(record(failing, seeds).sentence(), expected);
        }
        let expected = serde_json::json!({
            "arm": "control=torque", "stage": "evaluate.nominal", "policies": 3, "failing": 1,
            "missed": ["is fast"],
        });
        assert_eq!(record(1, &[2]).brief(), expected);
        assert_eq!(failing(&[record(0, &[]), record(1, &[2])]).count(), 1);
        let elsewhere = TaskRecord { stage: "deploy.mujoco".to_owned(), ..record(3, &[]) };
        assert_eq!(
            paragraph(&[record(1, &[2]), elsewhere]).as_deref(),
            Some(
                "**1 of 1 arms has policies that do not do their task.** torque: policies do not walk in \
                 `evaluate.nominal` (1 of 3, seed 2) and in `deploy.mujoco` (3 of 3) (not met: is fast)."
            )
        );
        let many: Vec<TaskRecord> =
            (0..10).map(|index| TaskRecord { arm: format!("arm={index}"), ..record(3, &[]) }).collect();
        let told = paragraph(&many).expect("all fail");
        assert!(told.starts_with("**10 of 10 arms have policies that do not do their task.**"), "{told}");
        assert!(told.contains("arm 7 (3 of 3)") && !told.contains("arm 8 "), "{told}");
        assert!(told.ends_with("; and 2 more.") && !told.contains("not met"), "{told}");
        let full = in_full(&many);
        assert_eq!(
            (full.len(), full[9].as_str()),
            (10, "arm 9: 3 of 3 policies do not walk in `evaluate.nominal` (not met: is fast).")
        );
        assert!(in_full(&many[..4]).is_empty(), "the top of the page describes four");
    }

    #[test]
    fn policies_that_are_not_judged_are_told_and_do_not_count_as_failing() {
        let brief = |survived: bool| {
            let mut arm = arm("a", survived);
            arm.evaluations[0].evaluation.time_limit = 0.2;
            arm
        };
        let record = of_stage("a", &[&brief(true), &arm("a", true), &brief(false)], "evaluate.nominal");
        assert_eq!((record.policies, record.failing, record.unjudged), (3, 1, 1));
        let told = unjudged_paragraph(std::slice::from_ref(&record)).expect("one is not judged");
        assert!(
            told.starts_with(
                "**Not every policy is judged.** a: 1 of 3 policies is not judged in `evaluate.nominal` (its"
            ),
            "{told}"
        );
        assert_eq!(record.unjudged_brief()["unjudged"], 1);
        let whole = records(&ReportInput { arms: vec![arm("a", true)], ..ReportInput::default() });
        assert_eq!(unjudged_paragraph(&whole), None);
        // Records of policies that are all judged are as before.
        let text = serde_json::to_string(&whole[0]).expect("plain data");
        assert!(!text.contains("unjudged") && !text.contains("reason"), "{text}");
        assert_eq!(does(&brief(true), "evaluate.nominal"), Some(false));
    }

    #[test]
    fn the_policies_of_an_arm_are_counted() {
        let runs = [arm("a", false), arm("a", true), arm("a", false)];
        let record = of_stage("control=torque", &runs.iter().collect::<Vec<_>>(), "evaluate.nominal");
        assert!(!record.fails());
        assert!(record.sentence().starts_with("torque: 2 of 3 policies do not squat in `evaluate.nominal`"));
    }
}
