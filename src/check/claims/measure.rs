//! E0804, E0201, E0203, E0101 and E1001: the arms of a claim produce its metric, and its numbers have the
//! metric's unit.

use super::training::Budget;
use super::{ArmScope, Scope, arms_in, at, name};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::deploy::{Deployment, Transfer};
use crate::kinds::evaluate::{Evaluation, NOMINAL, ParameterSets, Setting};
use crate::kinds::fine_tune::{self, FineTuning, Trained};
use crate::kinds::learn::Learner;
use crate::kinds::metric::{self, MetricKind, Scale, Source};
use crate::kinds::statistic::{Method, StatisticKind};
use crate::kinds::task::Task;
use crate::kinds::terrain::Ground;
use crate::quantity::{self, Dimension};
use crate::robot::SelfCollision;
use crate::spec::claim::cases::twin;
use crate::spec::claim::{ArmPattern, Case, Claim, Expectation, MetricPath, Operand, keys};
use crate::spec::suggest::{listed, nearest};
use crate::spec::typed::InSection;
use crate::spec::{Quantity, Section, Signal, Table};

/// The metric of a claim; E0804 if it is unknown.
pub fn metric(claim: &Claim, sink: &mut Sink) -> Option<&'static MetricKind> {
    let found = metric::find(&claim.metric.name);
    if found.is_none() {
        let error = Diagnostic::error("E0804", format!("there is no metric `{}`", claim.metric.name));
        let error = at(claim, MetricPath::NAME, error, "not a metric");
        let names = || metric::KINDS.iter().map(|metric| metric.kind.name);
        let span = claim.marks.get(MetricPath::NAME).map(|mark| mark.value);
        sink.emit(match (nearest(&claim.metric.name, names()), span) {
            (Some(near), Some(span)) => error.help(format!("did you mean `{near}`?")).fix(span, near),
            _ => error.help("`specforge list metric` prints the metrics"),
        });
    }
    let needs_threshold = found.is_some_and(|metric| metric.scale == Scale::Censored);
    if needs_threshold && claim.threshold.is_none() {
        let error = Diagnostic::error(
            "E0101",
            format!("missing key `threshold`: `{}` waits for it", claim.metric.name),
        );
        let error = at(claim, MetricPath::NAME, error, "until which return?");
        sink.emit(error.help("add a line such as `threshold = 100`"));
        return None;
    }
    match found {
        Some(metric) if !asks_for_what_it_takes(claim, metric, sink) => None,
        found => found,
    }
}

/// E0101 and E0105: a failure metric requires its parameter; keys of one type of metric are not allowed for
/// another.
fn asks_for_what_it_takes(claim: &Claim, metric: &MetricKind, sink: &mut Sink) -> bool {
    let (name, is_of_failures) = (metric.kind.name, matches!(metric.source, Source::Failures(_)));
    let wrong = if is_of_failures && claim.parameter.is_none() {
        let error = Diagnostic::error("E0101", format!("missing key `parameter`: `{name}` is about one"));
        let error = at(claim, MetricPath::NAME, error, "of which parameter?");
        Some(error.help("add a line such as `parameter = \"action_delay\"`"))
    } else if claim.parameter.is_some() && !is_of_failures {
        let error = Diagnostic::error(
            "E0105",
            format!("`parameter` is a key of metrics of failures, not of `{name}`"),
        );
        Some(
            at(claim, keys::Claim::parameter.name, error, "of no use here")
                .help("remove it, or measure `failure_loading`"),
        )
    } else if claim.threshold.is_some() && metric.scale != Scale::Censored {
        let message = format!("`threshold` is a key of `samples_to_threshold`, not of `{name}`");
        let error =
            at(claim, keys::Claim::threshold.name, Diagnostic::error("E0105", message), "of no use here");
        Some(error.help("remove it, or measure `learn.samples_to_threshold`"))
    } else if claim.until.is_some() && !matches!(metric.source, Source::Learning(_)) {
        let error =
            Diagnostic::error("E0105", format!("`until` is a key of metrics of a training, not of `{name}`"));
        Some(
            at(claim, keys::Claim::until.name, error, "until which sample?")
                .help("remove it, or measure `learn.area_under_curve`"),
        )
    } else {
        None
    };
    let sound = wrong.is_none();
    wrong.into_iter().for_each(|error| sink.emit(error));
    sound
}

/// E0804: every arm has the stage, and the stage produces the metric.
pub fn produced(claim: &Claim, metric: &MetricKind, scope: &Scope, cases: &[Case], sink: &mut Sink) {
    if produced_by(
        claim,
        metric,
        Written { stage: &claim.metric.stage, key: MetricPath::STAGE },
        scope,
        cases,
        sink,
    ) {
        if let Some(baseline) = &claim.baseline {
            let key = claim.key_of_baseline();
            let twins = baseline.twin.as_ref().map(|pattern| twins(pattern, scope, cases));
            let compared = twins.as_deref().unwrap_or(cases);
            produced_by(claim, metric, Written { stage: &baseline.stage, key }, scope, compared, sink);
        }
        measurable(claim, metric, scope, cases, sink);
    }
}

/// E1001: the metric is defined for the arms' task and robot.
fn measurable(claim: &Claim, metric: &MetricKind, scope: &Scope, cases: &[Case], sink: &mut Sink) {
    let name_of = metric.kind.name;
    let trouble = |arm: &&ArmScope| {
        let spec = Section::new(arm.fields);
        let task = spec.within::<Task>().and_then(|task| task.kind()).unwrap_or_default();
        if !task.is_empty() && !metric.suits(task) {
            let help =
                format!("it is measured for {}; name another metric, or other arms", listed(metric.tasks()));
            return Some((format!("the task `{task}` does not measure `{name_of}`"), help));
        }
        let is_blind = arm.robot.is_some_and(|robot| !SelfCollision::is_measurable(robot));
        (name_of == "self_collision" && is_blind).then(|| {
            let help = "give its links collision shapes, or name another metric".to_owned();
            ("the robot has no collision shapes, so self-collisions cannot be measured".to_owned(), help)
        })
    };
    let found = arms_in(cases, scope).into_iter().find_map(|arm| Some((arm, trouble(&arm)?)));
    if let Some((arm, (message, help))) = found {
        let error = at(
            claim,
            MetricPath::NAME,
            Diagnostic::error("E1001", message),
            &format!("in the arm `{}`", name(arm.points)),
        );
        sink.emit(error.help(help));
    }
}

/// A stage as written in a claim.
struct Written<'a> {
    stage: &'a str,
    /// The key of its mark.
    key: &'static str,
}

/// The arms that those of some cases are compared with, as cases.
fn twins(pattern: &ArmPattern, scope: &Scope, cases: &[Case]) -> Vec<Case> {
    let points = scope.points();
    let arms = cases.iter().flat_map(|case| [Some(case.a), case.b]).flatten();
    let case = |arm| Some(Case { label: String::new(), a: twin(pattern, &points, arm)?, b: None });
    arms.filter_map(case).collect()
}

/// Whether a stage of every arm produces the metric; E0804 if not.
fn produced_by(
    claim: &Claim,
    metric: &MetricKind,
    Written { stage, key }: Written,
    scope: &Scope,
    cases: &[Case],
    sink: &mut Sink,
) -> bool {
    let learned = matches!(metric.source, Source::Learning(_));
    if learned != TRAININGS.contains(&stage) {
        let message = format!("`{stage}` does not produce `{}`", metric.kind.name);
        let help = match learned {
            true => format!("it is a metric of a training: write `learn.{}`", metric.kind.name),
            false => format!("it is measured by an evaluation: write `evaluate.NAME.{}`", metric.kind.name),
        };
        let error = at(claim, key, Diagnostic::error("E0804", message), "another stage");
        sink.emit(error.help(help));
        return false;
    }
    let lacking = arms_in(cases, scope).into_iter().find(|arm| !has(arm.fields, stage));
    if let Some(arm) = lacking {
        let known = stages(arm.fields);
        let message = format!("the arm `{}` has no stage `{stage}` that is measured", name(arm.points));
        let error = at(claim, key, Diagnostic::error("E0804", message), "not produced");
        let span = claim.marks.get(key).map(|mark| mark.value);
        sink.emit(match (nearest(stage, known.iter().map(String::as_str)), span) {
            (Some(near), Some(span)) => {
                let near = near.to_owned();
                let written =
                    if key == keys::Claim::baseline.name { format!("\"{near}\"") } else { near.clone() };
                error.help(format!("did you mean `{near}`?")).fix(span, written)
            }
            _ => error.help(format!("its measured stages are {}", listed(known.iter().map(String::as_str)))),
        });
        return false;
    }
    if learned && !has_samples(claim, Written { stage, key }, scope, cases, sink) {
        return false;
    }
    if matches!(metric.source, Source::Failures(_)) && !varies(claim, stage, scope, cases) {
        let message = format!("`{stage}` does not produce `{}`", metric.kind.name);
        let error = at(claim, key, Diagnostic::error("E0804", message), "no such parameter is varied there");
        sink.emit(varied_instead(claim, stage, scope, cases, error));
        return false;
    }
    let needs_obstacle = metric.kind.needs.contains(&Signal::Obstacle);
    let open =
        arms_in(cases, scope).into_iter().find(|arm| needs_obstacle && ground(arm.fields, stage) != OBSTACLE);
    if let Some(arm) = open {
        let (ground, measured) = (ground(arm.fields, stage), metric.kind.name);
        let message = format!("`{stage}` of the arm `{}` does not produce `{measured}`", name(arm.points));
        let error = at(claim, key, Diagnostic::error("E0804", message), &format!("on `{ground}` ground"));
        let example =
            "terrain = { kind = \"box_obstacle\", friction = 1.0, height = \"1 cm\", distance = \"60 cm\" }";
        sink.emit(error.help(format!("it needs an obstacle to cross: add `{example}` to `[{stage}]`")));
        return false;
    }
    true
}

/// Whether a training of every arm has samples and thus a learning curve; E0804 if not. A profile and `--set`
/// may omit the training for a quick look.
fn has_samples(
    claim: &Claim,
    Written { stage, key }: Written,
    scope: &Scope,
    cases: &[Case],
    sink: &mut Sink,
) -> bool {
    let is_empty = |arm: &&ArmScope| Budget::of(arm, stage).is_some_and(|budget| budget.samples == 0.0);
    let Some(arm) = arms_in(cases, scope).into_iter().find(is_empty).filter(|_| !scope.shortened) else {
        return true;
    };
    let message = format!("`{stage}` does not produce `{}`: it has no samples", claim.metric.name);
    let remark = format!("the arm `{}` learns from no sample", name(arm.points));
    let error = at(claim, key, Diagnostic::error("E0804", message), &remark);
    let first = Budget::of(arm, stage).map_or(1.0, |budget| budget.first);
    sink.emit(error.help(format!("give `{stage}` {first} samples or more, or measure an evaluation")));
    false
}

/// Whether a stage of every arm uses parameter sets that include the claim's parameter.
fn varies(claim: &Claim, stage: &str, scope: &Scope, cases: &[Case]) -> bool {
    let parameter = claim.parameter.as_deref().unwrap_or_default();
    arms_in(cases, scope).into_iter().all(|arm| {
        let protocol = stage
            .split_once('.')
            .and_then(|(section, name)| Section::new(arm.fields).section(section)?.section(name));
        protocol.is_some_and(|protocol| {
            let parameters = protocol.value(ParameterSets::parameters).unwrap_or_default();
            protocol.is::<ParameterSets>() && parameters.iter().any(|own| own.word() == parameter)
        })
    })
}

/// What to write if a stage does not vary the claim's parameter: a parameter that it varies, or another
/// stage.
fn varied_instead(
    claim: &Claim,
    stage: &str,
    scope: &Scope,
    cases: &[Case],
    error: Diagnostic,
) -> Diagnostic {
    let arms = arms_in(cases, scope);
    let Some(arm) = arms.first() else { return error };
    let evaluations = Section::new(arm.fields).within::<Evaluation>();
    let varied = |name: &str| -> Option<Vec<&'static str>> {
        let protocol = evaluations?.section(name).filter(|protocol| protocol.is::<ParameterSets>())?;
        let parameters = protocol.value(ParameterSets::parameters).unwrap_or_default();
        Some(parameters.iter().map(|parameter| parameter.word()).collect())
    };
    if let Some(known) = stage.split_once('.').and_then(|(_, name)| varied(name)) {
        let written = claim.parameter.as_deref().unwrap_or_default();
        return match nearest(written, known.iter().copied()) {
            Some(near) => error.help(format!("write `parameter = \"{near}\"`")),
            None => error.help(format!("the parameters that it varies are {}", listed(known))),
        };
    }
    let names: Vec<String> = stages(arm.fields)
        .into_iter()
        .filter(|stage| stage.split_once('.').is_some_and(|(_, name)| varied(name).is_some()))
        .collect();
    match names.as_slice() {
        [] => error.help(format!(
            "add an evaluation of `kind = \"parameter_sets\"` that varies it, for example `[evaluate.sets]`, and \
             write `metric = \"evaluate.sets.{}\"`",
            claim.metric.name
        )),
        names => error.help(format!("name another evaluation: {}", listed(names.iter().map(String::as_str)))),
    }
}

/// The terrain with something to cross.
const OBSTACLE: &str = "box_obstacle";

/// The trainings, as named in claims.
pub(super) const TRAININGS: [&str; 2] = [Learner::SECTION, FineTuning::SECTION];

/// The kind of terrain of a stage: its own, for a transfer that of `evaluate.nominal`, or else that of the
/// training.
fn ground<'a>(fields: &'a Table, stage: &str) -> &'a str {
    let spec = Section::new(fields);
    let table = |section: &str, name: &str| spec.section(section)?.section(name);
    let own = stage.split_once('.').and_then(|(section, name)| {
        let terrain = |section: &str, name: &str| table(section, name)?.below(Setting::terrain);
        let nominal = || terrain(Evaluation::SECTION, NOMINAL).filter(|_| section == Deployment::SECTION);
        terrain(section, name).or_else(nominal)
    });
    let trained = || {
        let named =
            stage.split_once('.').and_then(|(section, name)| table(section, name)?.value(Setting::policy));
        let tuned = spec.within::<FineTuning>().filter(|_| named != Some(Trained::Learner));
        tuned.and_then(|tuned| tuned.below(fine_tune::Ppo::terrain)).or_else(|| spec.within::<Ground>())
    };
    own.or_else(trained).and_then(|terrain| terrain.kind()).unwrap_or_default()
}

fn has(fields: &Table, stage: &str) -> bool {
    stages(fields).iter().any(|known| known == stage)
}

/// The measured stages of a spec: trainings, evaluations and transfers.
pub(in crate::check) fn stages(fields: &Table) -> Vec<String> {
    let spec = Section::new(fields);
    let named = |section: &str, keep: &dyn Fn(Section) -> bool| -> Vec<String> {
        let Some(terms) = spec.section(section) else { return Vec::new() };
        let kept = terms.sections().filter(|(_, term)| keep(*term));
        kept.map(|(name, _)| format!("{section}.{name}")).collect()
    };
    let mut stages = named(Evaluation::SECTION, &|_| true);
    stages.extend(named(Deployment::SECTION, &|term| term.is::<Transfer>()));
    stages.extend(
        TRAININGS
            .iter()
            .filter(|training| spec.get(training).is_some())
            .map(|training| (*training).to_owned()),
    );
    stages
}

/// E0201 and E0203: the claim's numbers have the metric's dimension.
pub fn units(claim: &Claim, statistic: &StatisticKind, metric: &MetricKind, sink: &mut Sink) {
    // A margin on the probability of improvement is a probability.
    let is_ratio = claim.baseline.as_ref().is_some_and(|baseline| baseline.relative);
    let expected = match statistic.method {
        Method::ProbabilityOfImprovement => Dimension::NONE,
        _ if is_ratio => Dimension::NONE,
        _ => metric.dimension,
    };
    let number = match &claim.expect.right {
        Operand::Number(number) => Some((Expectation::RIGHT, number)),
        Operand::Arm(_) => None,
    };
    let within = claim.expect.within.as_ref().map(|within| (Expectation::WITHIN, within));
    let margin = claim.margin.as_ref().map(|margin| (keys::Claim::margin.name, margin));
    let offset = claim.expect.offset.as_ref().map(|offset| (Expectation::OFFSET, offset));
    for (key, quantity) in [number, within, margin, offset].into_iter().flatten() {
        unit(claim, key, quantity, metric, expected, sink);
    }
    // The dimension of the metric itself, whatever the test computes from it.
    let measured = if is_ratio { Dimension::NONE } else { metric.dimension };
    let spread = claim.spread.as_ref().map(|spread| (keys::Claim::spread.name, spread));
    let effect = claim.effect.as_ref().map(|effect| (keys::Claim::effect.name, effect));
    let number = claim.paper.as_ref().and_then(|paper| paper.number.as_ref());
    let of_paper = keys::Paper::number.path();
    let number = number.map(|number| (of_paper.as_str(), number));
    for (key, quantity) in [spread, effect, number].into_iter().flatten() {
        unit(claim, key, quantity, metric, measured, sink);
    }
}

fn unit(
    claim: &Claim,
    key: &str,
    number: &Quantity,
    metric: &MetricKind,
    expected: Dimension,
    sink: &mut Sink,
) {
    let bare = number.text.trim().replace('_', "").parse::<f64>().is_ok();
    let found = quantity::quantity(&number.text).map_or(Dimension::NONE, |parsed| parsed.dimension);
    if found == expected {
        return;
    }
    let unit = expected.unit();
    let error = if bare {
        let error = Diagnostic::error(
            "E0201",
            format!("`{}` is {}: the number needs a unit", metric.kind.name, expected.name()),
        );
        error.help(format!("did you mean `{} {unit}`?", number.text))
    } else {
        let message = format!("wrong dimension: expected {}, found {}", expected.name(), found.name());
        let written =
            if unit.is_empty() { "`%` or as a bare number".to_owned() } else { format!("`{unit}`") };
        Diagnostic::error("E0203", message).help(format!("write it in {written}"))
    };
    sink.emit(at(claim, key, error, &format!("compared with `{}`", metric.kind.name)));
}
