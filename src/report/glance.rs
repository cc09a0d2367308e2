//! The first table of a report: per policy and engine whether it does its task, and the numbers that say so;
//! for a suite the claims with their verdicts.

use crate::report::claim::{self, Judged};
use crate::report::metric::Metric;
use crate::report::model::{Arm, ReportInput};
use crate::report::table::evaluation::{Column, columns};
use crate::report::table::{Cell, Table};
use crate::report::verdict::{asked_speed, judge};
use crate::report::wording::with_interval;

/// One row per policy and engine.
pub fn of_arms(input: &ReportInput) -> Table {
    let columns = columns(input);
    let travels = columns.iter().any(|column| column.arm.travels());
    let mut heads = vec!["", "does its task", "criteria met", "survival"];
    heads.extend(if travels { &["mean speed", "speed asked for"][..] } else { &["task metric"] });
    let mut table = Table::new("at_a_glance", "At a glance", heads.into_iter().map(String::from));
    table.sources = columns.iter().map(Column::source).collect();
    for column in &columns {
        let evaluation = &column.measured.evaluation;
        let verdict = judge(column.arm, evaluation);
        let measurable = || verdict.criteria.iter().filter(|criterion| criterion.unmeasured.is_none());
        let blind = match verdict.criteria.len() - measurable().count() {
            0 => String::new(),
            blind => format!(", {blind} not measurable"),
        };
        let met = measurable().filter(|criterion| criterion.holds).count();
        let met = format!("{met} of {}{blind}", measurable().count());
        let measured = |name: &str| {
            let metric = Metric::named(name).filter(|metric| metric.is_measured(evaluation));
            metric.map_or_else(
                || "\u{2013}".to_owned(),
                |metric| with_interval(&metric.estimate(evaluation), true),
            )
        };
        let mut cells = vec![verdict.phrase(), met, measured("survival")];
        if travels {
            let asked = asked_speed(column.arm, evaluation);
            cells.push(measured("speed"));
            cells.push(asked.map_or_else(|| "\u{2013}".to_owned(), |speed| format!("{speed:.2} m/s")));
        } else {
            cells.push(task_metric(column.arm, &measured));
        }
        table.row_from("", &column.label, cells.into_iter().map(Cell::Text), vec![column.source()]);
    }
    table
}

/// `largest joint distance from the reference 0.05 rad [0.04, 0.06]`.
fn task_metric(arm: &Arm, measured: &dyn Fn(&str) -> String) -> String {
    let evidence = arm.task().map(|task| &task.evidence);
    evidence.map_or_else(String::new, |evidence| format!("{} {}", evidence.words, measured(evidence.metric)))
}

/// One row per claim: the statement, what the paper reports if any claim has that, the measurement, the verdict.
pub fn of_claims(judged: &[Judged]) -> Table {
    let of_paper = judged.iter().any(|claim| claim.paper.is_some());
    let mut heads = vec!["claim"];
    heads.extend(of_paper.then_some("the paper"));
    heads.extend(["measured", "verdict"]);
    let mut table = Table::new("verdicts", "Verdicts", heads.into_iter().map(String::from));
    let claims = judged.len();
    for judged in judged {
        let paper = judged.paper.as_ref().map_or_else(|| "\u{2013}".to_owned(), |paper| paper.in_words());
        let mut cells: Vec<String> = of_paper.then_some(paper).into_iter().collect();
        cells.push(claim::in_brief(judged, claims));
        cells.push(format!("**{}**", judged.verdict.word()));
        let sources = judged.cases.iter().flat_map(|case| case.sources.clone()).collect();
        let label = judged.text.trim_end_matches('.');
        table.row_from(&judged.id, label, cells.into_iter().map(Cell::Text), sources);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::claim::Ruling;
    use crate::spec::claim::Paper;

    #[test]
    fn the_papers_column_is_there_only_where_a_claim_is_the_papers() {
        let mut claim = Judged { text: "It walks.".into(), verdict: Ruling::Pass, ..Judged::default() };
        let ours = of_claims(std::slice::from_ref(&claim));
        assert_eq!(ours.columns, ["claim", "measured", "verdict"]);
        claim.paper = Some(Paper { place: "Exp. 1".into(), value: "walks".into(), ..Paper::default() });
        let papers = of_claims(&[claim]);
        assert_eq!((papers.columns.len(), papers.rows[0].label.as_str()), (4, "It walks"));
        assert_eq!(papers.rows[0].cells[0], Cell::Text("Exp. 1: walks".into()));
        assert_eq!(papers.rows[0].cells[2], Cell::Text("**PASS**".into()));
    }
}
