//! The variables of a report that a template can use.

use serde::{Deserialize, Serialize};

use super::answer;
use super::claim::{self, Judged};
use super::deviations;
use super::figure::{self, Figure};
use super::headline;
use super::model::ReportInput;
use super::no_curve;
use super::policies;
use super::question::question;
use super::suite::{self, page::SuitePage};
use super::table::{Table, Tables, endings, evaluation, health, learning, setup, with_rows};
use super::tasks;
use super::warning::warnings;
use super::wording::{commit, labels};
use super::{glance, provenance};

/// The variables of a template.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Page {
    /// Name of the spec.
    pub name: String,
    /// The spec's one-line summary.
    pub summary: String,
    /// The profile; empty without one.
    pub profile: String,
    /// The question that the report answers.
    pub question: String,
    /// The answer in a few sentences.
    pub answer: String,
    /// Why the result may differ from the paper's, in the spec's sentences.
    pub reasons: Vec<String>,
    /// What each policy does, in one paragraph per arm; of a suite the failing ones, if they are many.
    pub result: Vec<String>,
    /// What a reader must know before relying on it: of a suite the runs and the arms with the best and the
    /// worst survival, and then warnings.
    pub warnings: Vec<String>,
    /// Deviations from the baseline, and those that the spec declares.
    pub deviations: Vec<String>,
    /// The names of the baselines as code, if any.
    pub baselines: Vec<String>,
    /// Remarks on the health of the trainings that supplement its table.
    pub health: Vec<String>,
    /// The arms.
    pub arms: Vec<ArmPage>,
    /// The tables.
    pub tables: Tables,
    /// The figures.
    pub figures: Figures,
    /// The copies of the exported policies.
    pub policies: Vec<PolicyPage>,
    /// The reason for a missing figure of learning curves; empty if the page has the figure.
    pub no_learning_curve: String,
    /// The suite; empty for other reports.
    pub suite: SuitePage,
    /// The claims with their verdicts; may be empty.
    pub claims: Table,
    /// The claims as sentences.
    pub claim_sentences: Vec<String>,
    /// Which claims are corrected for multiple testing.
    pub claim_correction: String,
    /// The claims with all their numbers.
    pub judged: Vec<Judged>,
    /// The command that reproduces the experiment.
    pub run_command: String,
    /// The command that renders the report again.
    pub report_command: String,
    /// Version of specforge that rendered.
    pub tool_version: String,
    /// Its commit, shortened.
    pub commit: String,
}

/// A copy of an exported policy.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PolicyPage {
    /// Its name.
    pub name: String,
    /// Its file, relative to the page.
    pub file: String,
}

/// An arm.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ArmPage {
    /// Name of its spec.
    pub name: String,
    /// Its short name.
    pub label: String,
    /// Its one-line summary.
    pub summary: String,
    /// Its file.
    pub spec: String,
    /// Its low-level law.
    pub law: String,
}

/// A figure as a template sees it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FigurePage {
    /// Its name in `specforge trace`.
    pub id: String,
    /// Its title.
    pub title: String,
    /// Its file, relative to the report.
    pub file: String,
    /// What it shows, with n.
    pub caption: String,
}

/// The figures; those without data are absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Learning curves.
    pub learning_curves: Option<FigurePage>,
    /// Those of the fine-tuning.
    pub fine_tuning_curves: Option<FigurePage>,
    /// Why training episodes ended.
    pub endings: Option<FigurePage>,
    /// Forward speed.
    pub speed: Option<FigurePage>,
    /// One time-lapse per arm.
    pub time_lapses: Vec<FigurePage>,
    /// Joint torques.
    pub torques: Option<FigurePage>,
    /// Vertical foot forces.
    pub contact_forces: Option<FigurePage>,
    /// Survival over the two axes of a suite.
    pub survival_grid: Option<FigurePage>,
    /// The claims of a suite with their intervals.
    pub claims: Option<FigurePage>,
    /// The other figures that a suite requests, in its order: all but learning curves and claims.
    pub outcomes: Vec<FigurePage>,
}

impl Page {
    /// The variables for an input and its figures.
    pub fn new(input: &ReportInput, figures: &[Figure]) -> Self {
        // A suite has too many runs for a column each; they are described in `suite`.
        let of_suite = input.suite.is_some();
        let judged = suite::judged(input);
        let result =
            if of_suite { tasks::in_full(&tasks::records(input)) } else { headline::paragraphs(input) };
        let warnings = if of_suite { suite::warning::warnings(input) } else { warnings(input) };
        let first = if of_suite { suite::page::paragraphs(input) } else { Vec::new() };
        let answer = match (of_suite, judged.is_empty()) {
            (false, _) => answer::of_arms(input),
            (true, false) => answer::of_claims(&judged),
            (true, true) => "The suite makes no claims; its numbers stand below.".to_owned(),
        };
        Self {
            name: input.name.clone(),
            summary: input.summary.clone(),
            profile: profile(input),
            question: question(input),
            answer,
            reasons: input.reasons.clone(),
            result,
            warnings: claim::meaningless(&judged).into_iter().chain(first).chain(warnings).collect(),
            deviations: deviations::sentences(input),
            baselines: deviations::baselines(input),
            health: health::sentences(input),
            arms: if of_suite { Vec::new() } else { arms(input) },
            tables: if of_suite {
                let (at_a_glance, cost) = (glance::of_claims(&judged), provenance::sum(input));
                Tables { at_a_glance, cost, ..suite::page::tables(input) }
            } else {
                tables(input, figures)
            },
            figures: figure_set(input, figures),
            policies: policies::copies(input)
                .into_iter()
                .map(|copy| PolicyPage { name: copy.id, file: copy.file })
                .collect(),
            no_learning_curve: no_curve::reason(input, figures),
            suite: SuitePage::new(input),
            claims: claim::table(&judged),
            claim_sentences: claim::sentences(&judged),
            claim_correction: claim::correction(&judged),
            judged,
            run_command: input.request.command("run"),
            report_command: input.request.command("report"),
            tool_version: input.tool_version.clone(),
            commit: commit(&input.commit),
        }
    }

    /// All tables in the order of the page.
    pub fn all_tables(&self) -> Vec<&Table> {
        let mut tables = self.tables.all();
        tables.push(&self.claims);
        tables
    }
}

/// The profile and what `--set` changed: `quick, with --set learn.seed=2`.
fn profile(input: &ReportInput) -> String {
    let profile = input.request.profile.as_deref().unwrap_or_default();
    let sets: Vec<String> = input.request.set.iter().map(|set| format!("--set {set}")).collect();
    match (profile, sets.is_empty()) {
        (_, true) => profile.to_owned(),
        ("", false) => format!("none, with {}", sets.join(" ")),
        (_, false) => format!("{profile}, with {}", sets.join(" ")),
    }
}

fn arms(input: &ReportInput) -> Vec<ArmPage> {
    let page = |(arm, label): (&super::model::Arm, String)| ArmPage {
        name: arm.name.clone(),
        label,
        summary: arm.summary.clone(),
        spec: arm.spec.clone(),
        law: arm.law.clone(),
    };
    input.arms.iter().zip(labels(&input.arms)).map(page).collect()
}

/// The tables of single specs.
fn tables(input: &ReportInput, figures: &[Figure]) -> Tables {
    let mut evaluations = vec![evaluation::evaluation(input)];
    evaluations.extend(evaluation::comparisons(input));
    evaluations.push(evaluation::reward(input));
    let mut tables = Tables {
        at_a_glance: glance::of_arms(input),
        setup: setup::setup(input),
        differences: with_rows(vec![setup::differences(input)]),
        learning: learning::learning(input),
        fine_tuning: learning::fine_tuning(input),
        health: health::health(input),
        endings: endings::endings(input),
        criteria: evaluation::criteria(input),
        evaluations: with_rows(evaluations),
        failures: Vec::new(),
        cost: provenance::cost(input),
        provenance: Table::default(),
        stages: provenance::stages(input),
    };
    let mut measured = tables.measured();
    measured.push(&tables.criteria);
    tables.provenance = provenance::items(input, figures, &measured);
    tables
}

/// The file of a figure, relative to the report.
pub fn figure_file(input: &ReportInput, figure: &Figure) -> String {
    format!("{}/{}.svg", input.name, figure.id)
}

fn figure_set(input: &ReportInput, figures: &[Figure]) -> Figures {
    let page = |figure: &Figure| FigurePage {
        id: figure.id.clone(),
        title: figure.title.clone(),
        file: figure_file(input, figure),
        caption: figure.caption.clone(),
    };
    let named = |id: &str| figures.iter().find(|figure| figure.id == id).map(page);
    let of_suite = input.suite.is_some();
    let of_specs = |id: &str| named(id).filter(|_| !of_suite);
    Figures {
        learning_curves: named(figure::learning_curves::ID),
        fine_tuning_curves: named(figure::learning_curves::TUNING_ID),
        endings: of_specs(figure::endings::ID),
        speed: of_specs(figure::speed::ID),
        time_lapses: figures
            .iter()
            .filter(|figure| !of_suite && figure.id.starts_with(figure::time_lapse::ID))
            .map(page)
            .collect(),
        torques: of_specs(figure::torques::ID),
        contact_forces: of_specs(figure::contact_forces::ID),
        survival_grid: named(figure::suite::grid::ID),
        claims: named(figure::suite::claims::ID),
        outcomes: if of_suite {
            let elsewhere = [figure::learning_curves::ID, figure::suite::claims::ID];
            figures.iter().filter(|figure| !elsewhere.contains(&figure.id.as_str())).map(page).collect()
        } else {
            Vec::new()
        },
    }
}
