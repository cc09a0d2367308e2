//! E04xx, W04xx and W0426: the simulated robot, with its payload, its joint damping and the extremes of its
//! randomization.

use std::collections::BTreeSet;

use super::Subject;
use crate::diag::{Diagnostic, Severity, Sink};
use crate::kinds::evaluate::{Evaluation, ParameterSets, Spread};
use crate::kinds::randomize::{Draft, KINDS, ONE_FOR_ALL, PER, Rows};
use crate::robot::examine::{changed, issues};
use crate::robot::{Issue, Robot};
use crate::spec::section::Robot as Stated;
use crate::spec::typed::{InSection, Part};
use crate::spec::{Sampler, Section, Table, Value};
use crate::stream::Stream;

/// The keys of randomizations that change the robot.
const CHANGED: [&str; 2] = ["mass", "scale"];
/// Randomizations whose small values are hard: weak motors. Of all others the large ones are.
const WEAKENING: &str = "motor_constant";

/// What decides the findings about a simulated robot.
#[derive(Clone, Debug, PartialEq)]
struct Case {
    /// As simulated.
    robot: Robot,
    /// Without its payload.
    own: Robot,
    /// Whether the spec states the damping.
    is_damped: bool,
    sets: Vec<Vec<Row>>,
}

/// A finding, before its place in a spec is known.
#[derive(Clone, Debug)]
struct Told {
    code: &'static str,
    severity: Severity,
    message: String,
    /// The key that causes it.
    key: String,
    remark: String,
    help: String,
}

/// Findings of earlier specs: most arms and profiles simulate the same robots. They depend on nothing but the
/// case.
#[derive(Clone, Debug, Default)]
pub struct Known {
    cases: Vec<(Case, Vec<Told>)>,
}

/// Number of cases that are remembered.
const REMEMBERED: usize = 16;

impl Known {
    fn told(&mut self, case: Case) -> &[Told] {
        let place = self.cases.iter().position(|(known, _)| *known == case).unwrap_or_else(|| {
            if self.cases.len() == REMEMBERED {
                self.cases.remove(0);
            }
            let told = case.judge();
            self.cases.push((case, told));
            self.cases.len() - 1
        });
        &self.cases[place].1
    }
}

/// The robot passes its checks as simulated. `own` is the robot without its payload.
pub fn robots_stay_usable(subject: &Subject, own: Option<&Robot>, known: &mut Known, sink: &mut Sink) {
    let (Some(robot), Some(own)) = (subject.robot, own) else { return };
    let sets = sets(subject);
    let is_damped = subject.number(&Stated::joint_damping.path()).is_some();
    if sets.is_empty() && robot.base.mass == own.base.mass && !is_damped {
        return;
    }
    for told in known.told(Case { robot: robot.clone(), own: own.clone(), is_damped, sets }) {
        let found = match told.severity {
            Severity::Error => Diagnostic::error(told.code, told.message.clone()),
            _ => Diagnostic::warning(told.code, told.message.clone()),
        };
        let place = subject.place(&told.key);
        let found = place.into_iter().fold(found, |found, place| found.at(place, told.remark.clone()));
        sink.emit(found.help(told.help.clone()));
    }
}

impl Case {
    fn judge(&self) -> Vec<Told> {
        let (payload, damping) = (Stated::payload.path(), Stated::joint_damping.path());
        let stated = issues(changed(&self.robot));
        let of_damping = |issue: &Issue| self.is_damped && issue.path.ends_with(".damping");
        let is_loaded = self.robot.base.mass != self.own.base.mass;
        let unloaded = if is_loaded { known(&issues(changed(&self.own))) } else { known(&stated) };
        let new = stated.iter().filter(|issue| of_damping(issue) || !unloaded.contains(&identity(issue)));
        let told = new.map(|issue| {
            let key = if of_damping(issue) { &damping } else { &payload };
            Told {
                code: issue.code,
                severity: issue.severity(),
                message: issue.message.clone(),
                key: key.clone(),
                remark: "the robot as simulated".to_owned(),
                help: format!("write a smaller `{key}`"),
            }
        });
        let mut told: Vec<Told> = told.collect();
        let before = known(&stated);
        told.extend(self.sets.iter().flat_map(|set| extremes(&self.robot, set, &before)));
        told
    }
}

type Identity = (&'static str, String);

fn identity(issue: &Issue) -> Identity {
    (issue.code, issue.path.clone())
}

fn known(issues: &[Issue]) -> BTreeSet<Identity> {
    issues.iter().map(identity).collect()
}

/// A randomization of the robot: its path, its kind, its table and the key that is drawn.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    path: String,
    kind: &'static str,
    table: Table,
    key: &'static str,
    bounds: [f64; 2],
}

/// The rows that are drawn together: those of the training, of each evaluation with its own, and of parameter
/// sets.
fn sets(subject: &Subject) -> Vec<Vec<Row>> {
    let own = subject.protocols().into_iter().map(|(path, _)| Spread::randomize.below(&path));
    let tables = std::iter::once(Rows::SECTION.to_owned()).chain(own);
    let mut sets: Vec<Vec<Row>> = tables.map(|path| rows(subject, &path)).collect();
    for (path, table) in subject.terms::<Evaluation>() {
        let Some(Evaluation::ParameterSets(protocol)) = Evaluation::of_section(table) else { continue };
        let Ok(bounds) = <[f64; 2]>::try_from(protocol.scale.clone()) else { continue };
        let row = |parameter: &crate::kinds::evaluate::parameter_sets::Parameter| {
            row(&ParameterSets::scale.below(&path), parameter.word(), &Table::new(), "scale", bounds)
        };
        sets.push(protocol.parameters.iter().filter_map(row).collect());
    }
    sets.retain(|set| !set.is_empty());
    sets
}

/// The rows of a table of randomizations.
fn rows(subject: &Subject, path: &str) -> Vec<Row> {
    let Some(table) = subject.section(path) else { return Vec::new() };
    let drawn = table.sections().filter_map(|(name, section)| {
        let key = CHANGED.into_iter().find(|key| section.table().contains_key(*key))?;
        let bounds = match section.table().get(key)? {
            Value::Sampler(sampler) => sampler.bounds(),
            Value::Quantity(quantity) => [quantity.si; 2],
            Value::Count(count) => [*count as f64; 2],
            _ => return None,
        };
        row(&format!("{path}.{name}.{key}"), section.kind()?, section.table(), key, bounds)
    });
    drawn.collect()
}

fn row(path: &str, kind: &str, table: &Table, key: &'static str, bounds: [f64; 2]) -> Option<Row> {
    let known = KINDS.iter().find(|row| row.kind.name == kind)?;
    let mut table = table.clone();
    // The rows of parameter sets have only their factor: the whole robot shares it.
    if known.kind.params.iter().any(|param| param.name == PER) && !table.contains_key(PER) {
        table.insert(PER.to_owned(), Value::Text(ONE_FOR_ALL.to_owned()));
    }
    Some(Row { path: path.to_owned(), kind: known.kind.name, table, key, bounds })
}

impl Row {
    /// The robot with this row at its hard (0) or easy (1) extreme.
    fn apply(&self, draft: &mut Draft, end: usize) {
        let hard = if self.kind == WEAKENING { 0 } else { 1 };
        let value = self.bounds[if end == 0 { hard } else { 1 - hard }];
        let mut table = self.table.clone();
        table.insert(self.key.to_owned(), Value::Sampler(Sampler::Constant(value)));
        if let Some(kind) = KINDS.iter().find(|row| row.kind.name == self.kind) {
            (kind.build)(Section::new(&table)).apply(draft, &mut Stream::new("extremes"));
        }
    }
}

/// The issues of the robot with these rows at one end.
fn at(robot: &Robot, rows: &[&Row], end: usize) -> Vec<Issue> {
    let mut draft = Draft::new(robot.clone(), 1.0, 1.0);
    rows.iter().for_each(|row| row.apply(&mut draft, end));
    issues(changed(&draft.robot))
}

/// W0426 for the checks that fail at an extreme, at the row that is enough for it, or else at the first one.
fn extremes(robot: &Robot, set: &[Row], before: &BTreeSet<Identity>) -> Vec<Told> {
    let all: Vec<&Row> = set.iter().collect();
    let mut seen: BTreeSet<Identity> = before.clone();
    let mut told = Vec::new();
    for end in [0, 1] {
        for issue in at(robot, &all, end) {
            if !seen.insert(identity(&issue)) {
                continue;
            }
            let fails =
                |row: &&&Row| at(robot, &[**row], end).iter().any(|own| identity(own) == identity(&issue));
            let alone = all.iter().find(fails);
            let rows = match alone {
                Some(row) => format!("with `{}` at its extreme", row.path),
                None => "with all randomizations at their extremes".to_owned(),
            };
            told.push(Told {
                code: "W0426",
                severity: Severity::Warning,
                message: format!("{rows}, {}", issue.message),
                key: alone.or(all.first()).map(|row| row.path.clone()).unwrap_or_default(),
                remark: format!("{} of the robot in some episodes", issue.code),
                help: "narrow the range, or allow this warning with the reason".to_owned(),
            });
        }
    }
    told
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::table;
    use super::*;
    use crate::robot::{stated, tests::robot};
    use crate::spec::Marks;

    fn said(text: &str) -> Vec<(&'static str, String)> {
        let fields = table(text);
        let mut own = robot("tocabi");
        stated::state(&mut own, &fields);
        let loaded = stated::loaded(&own, &fields);
        let subject = Subject { fields: &fields, marks: &Marks::default(), robot: Some(&loaded) };
        let mut sink = Sink::default();
        robots_stay_usable(&subject, Some(&own), &mut Known::default(), &mut sink);
        sink.diagnostics.into_iter().map(|found| (found.code, found.message)).collect()
    }

    fn codes(text: &str) -> Vec<&'static str> {
        said(text).into_iter().map(|(code, _)| code).collect()
    }

    #[test]
    fn the_payload_and_the_damping_of_a_spec_are_judged_as_those_of_the_robots_file() {
        assert_eq!(codes("robot.payload = 20.0"), [""; 0]);
        assert!(codes("robot.payload = 800.0").contains(&"E0428"), "{:?}", said("robot.payload = 800.0"));
        assert_eq!(codes("robot.joint_damping = 2.0"), [""; 0]);
        assert_eq!(codes("robot.joint_damping = 400.0"), ["W0415"]);
    }

    #[test]
    fn the_extremes_of_each_randomization_are_judged() {
        let row = |kind: &str, key: &str, value: &str| {
            format!("[randomize.row]\nkind = \"{kind}\"\n{key} = {value}\n")
        };
        for (kind, key, sound, hard) in [
            ("payload", "mass", "[0.0, 20.0]", "[0.0, 2000.0]"),
            ("link_mass", "scale", "[0.6, 1.4]", "[0.6, 40.0]"),
            ("joint_damping", "scale", "[0.6, 1.4]", "[0.6, 500.0]"),
            ("joint_friction", "scale", "[0.6, 1.4]", "[0.6, 100.0]"),
            ("motor_constant", "scale", "[1.0, 1.1]", "[0.01, 1.0]"),
            ("link_com", "scale", "[0.6, 1.4]", "[0.6, 100.0]"),
        ] {
            assert_eq!(codes(&row(kind, key, sound)), [""; 0], "{kind}");
            let told = said(&row(kind, key, hard));
            assert!(!told.is_empty() && told.iter().all(|(code, _)| *code == "W0426"), "{kind}: {told:?}");
            let start = format!("with `randomize.row.{key}` at its extreme, ");
            assert!(told.iter().any(|(_, message)| message.starts_with(&start)), "{kind}: {told:?}");
        }
    }

    #[test]
    fn rows_of_evaluations_and_parameter_sets_are_judged_too() {
        let own = "[evaluate.loaded]\nkind = \"episodes\"\n[evaluate.loaded.randomize.payload]\nkind = \
            \"payload\"\nmass = 2000.0";
        assert!(codes(own).contains(&"W0426"));
        // Each is harmless alone.
        let together = "[randomize.payload]\nkind = \"payload\"\nmass = [0.0, 150.0]\n[randomize.motor_constant]\nkind \
            = \"motor_constant\"\nscale = [0.3, 1.0]";
        let [alone, other] = together
            .split_once("[randomize.motor")
            .map(|(a, b)| [a.to_owned(), format!("[randomize.motor{b}")])
            .expect("two");
        assert_eq!([codes(&alone), codes(&other)], [[""; 0], [""; 0]]);
        assert!(
            said(together).iter().any(|(_, told)| told.starts_with("with all randomizations")),
            "{:?}",
            said(together)
        );
    }
}
