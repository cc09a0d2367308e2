//! Reading a claim from its keys: the grammar of each text, and the keys that exclude each other.

use std::collections::BTreeMap;

use super::{ArmPattern, Baseline, Claim, Expectation, MetricPath, Over, Paper, Relation, Term};
use super::{blank, expect, keys, pattern};
use crate::diag::{Diagnostic, Sink, Span};
use crate::spec::decode::part;
use crate::spec::marks::{Mark, Marks};
use crate::spec::{Quantity, Table, suggest};

/// Where the mistakes of a claim go.
pub(super) struct Errors<'a> {
    sink: &'a mut Sink,
    /// The place of the claim, for what has no place of its own.
    header: Span,
    /// Whether there was a mistake.
    any: bool,
}

impl<'a> Errors<'a> {
    pub(super) fn new(sink: &'a mut Sink, header: Span) -> Self {
        Self { sink, header, any: false }
    }

    fn emit(&mut self, error: Diagnostic) {
        self.sink.emit(error);
        self.any = true;
    }
}

/// The claim of these keys; `None` if anything is wrong with it, and all mistakes are then in the sink.
/// `table` holds the same keys as decoded.
pub(super) fn claim(written: keys::Claim, table: Table, marks: Marks, errors: Errors) -> Option<Claim> {
    let mut reading = Reading { written, marks, errors };
    let claim = reading.claim(table);
    claim.filter(|_| !reading.errors.any)
}

/// A claim being read: its keys and the places found so far.
struct Reading<'a> {
    written: keys::Claim,
    marks: Marks,
    errors: Errors<'a>,
}

impl Reading<'_> {
    fn claim(&mut self, fields: Table) -> Option<Claim> {
        self.check_id();
        self.texts_say_something();
        let metric = self.metric();
        let sides = self.sides();
        let expect = self.expectation(&sides);
        let margin = self.margin(expect.as_ref());
        let spread = self.spread();
        let effect = self.amount(keys::Claim::effect.name, self.written.effect.clone());
        let paper = self.written.paper.clone().map(|paper| self.paper(paper));
        let baseline = self.baseline(metric.as_ref());
        let over = self.over();
        let written = self.written.clone();
        Some(Claim {
            id: written.id,
            text: written.text,
            metric: metric?,
            sides: sides?,
            over,
            expect: expect?,
            test: written.test,
            summary: written.summary,
            alpha: written.alpha,
            margin,
            baseline,
            spread,
            effect,
            threshold: written.threshold,
            until: written.until.map(|samples| samples as f64),
            parameter: written.parameter,
            paper,
            fields,
            marks: std::mem::take(&mut self.marks),
        })
    }

    /// The place of a key's value.
    fn place(&self, path: &str) -> Span {
        self.marks.get(path).map_or(self.errors.header, |mark| mark.value)
    }

    /// The place of a key itself.
    fn place_of_key(&self, path: &str) -> Span {
        self.marks.get(path).map_or(self.errors.header, |mark| mark.key)
    }

    /// Records the place of a part of a text.
    fn mark(&mut self, path: &str, [key, value]: [Span; 2], text: &str) {
        let layer = self.marks.nearest(path).map(|mark| mark.layer).unwrap_or_default();
        self.marks.by_path.insert(path.to_owned(), Mark { key, value, layer, text: text.to_owned() });
    }

    fn check_id(&mut self) {
        let id = &self.written.id;
        let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.');
        if id.is_empty() || !id.chars().all(plain) {
            let error = Diagnostic::error("E0103", format!("`{id}` is not a name: claims are called by it"));
            let error = error.at(self.place(keys::Claim::id.name), "not a name");
            self.errors.emit(error.help("use letters, digits, `_`, `-` and `.`"));
        }
    }

    /// Reports keys with an empty text.
    fn texts_say_something(&mut self) {
        for empty in blank::of(&self.written) {
            let error = Diagnostic::error("E0103", format!("`{}` is empty", empty.path));
            let error = error.at(self.place(&empty.path), "no text");
            self.errors.emit(error.help(empty.help));
        }
    }

    /// How the arms of a pattern are combined: a word, or a table with one of its keys.
    fn over(&mut self) -> Option<Over> {
        let quantifier = match self.written.over.clone()? {
            keys::Over::All(keys::All::Each) => return Some(Over::Each),
            keys::Over::All(keys::All::Mean) => return Some(Over::Mean),
            keys::Over::Quantifier(quantifier) => quantifier,
        };
        let given = [
            quantifier.some.map(Over::Some),
            quantifier.none.map(Over::None),
            quantifier.at_least.map(Over::AtLeast),
            quantifier.at_most.map(Over::AtMost),
            quantifier.trend.map(Over::Trend),
        ];
        let place = self.place(keys::Claim::over.name);
        let mut given = given.into_iter().flatten();
        match (given.next(), given.next()) {
            (Some(over), None) => return Some(over),
            (Some(_), Some(_)) => {
                let error = Diagnostic::error(
                    "E0105",
                    "`over` has one of `some`, `none`, `at_least`, `at_most` and `trend`",
                );
                self.errors.emit(error.at(place, "several").help("remove all but one"));
            }
            (None, _) => {
                let error = Diagnostic::error("E0101", "`over` does not say over what");
                let help = "write `over = { some = \"AXIS\" }`, `over = { none = \"AXIS\" }`, `over = \
                    { at_least = N }`, `over = { trend = \"AXIS\" }`, `over = \"each\"` or `over = \"mean\"`";
                self.errors.emit(error.at(place, "an axis or a number is missing").help(help));
            }
        }
        None
    }

    /// What the metric of each run is compared with: another stage, another arm's run, or both.
    fn baseline(&mut self, metric: Option<&MetricPath>) -> Option<Baseline> {
        let keys::Claim { baseline: stage, twin, relative, .. } = self.written.clone();
        let is_relative = relative == Some(true);
        if [&stage, &twin].into_iter().flatten().any(|text| blank::is_blank(text)) {
            return None;
        }
        let twin = match twin {
            Some(text) => Some(self.pattern(keys::Claim::twin.name, &text)?),
            None => None,
        };
        match stage.or_else(|| Some(metric.filter(|_| twin.is_some())?.stage.clone())) {
            Some(stage) => Some(Baseline { stage, twin, relative: is_relative }),
            None => {
                if relative.is_some() && twin.is_none() {
                    let error = Diagnostic::error(
                        "E0105",
                        "`relative` is a key of a claim with a `baseline` or a `twin`",
                    );
                    let error = error.at(self.place(keys::Claim::relative.name), "relative to what?");
                    self.errors.emit(error.help("add `baseline = \"evaluate.NAME\"`, or remove `relative`"));
                }
                None
            }
        }
    }

    fn metric(&mut self) -> Option<MetricPath> {
        let text = self.written.metric.clone();
        let place = self.place(keys::Claim::metric.name);
        let Some((stage, name)) =
            text.rsplit_once('.').filter(|(stage, name)| !stage.is_empty() && !name.is_empty())
        else {
            let error = Diagnostic::error("E0103", format!("`{text}` is not a metric of a stage"))
                .at(place, "no stage");
            let example = if text.is_empty() { "survival" } else { text.trim_matches('.') };
            let help = format!("write the stage before it, for example `evaluate.nominal.{example}`");
            self.errors.emit(error.help(help));
            return None;
        };
        let spans = [part(place, &text, 0..stage.len()), part(place, &text, stage.len() + 1..text.len())];
        self.mark(MetricPath::STAGE, [spans[0]; 2], stage);
        self.mark(MetricPath::NAME, [spans[1]; 2], name);
        Some(MetricPath { stage: stage.to_owned(), name: name.to_owned() })
    }

    /// The patterns of `compare` or `arm`.
    fn sides(&mut self) -> Option<BTreeMap<String, ArmPattern>> {
        let sides = match (self.written.compare.clone(), self.written.arm.clone()) {
            (Some(compare), None) => vec![
                (keys::Compare::a.name, keys::Compare::a.path(), compare.a),
                (keys::Compare::b.name, keys::Compare::b.path(), compare.b),
            ],
            (None, Some(arm)) => vec![(keys::Compare::a.name, keys::Claim::arm.name.to_owned(), arm)],
            (Some(_), Some(_)) => {
                let key = self.place_of_key(keys::Claim::arm.name);
                let error = Diagnostic::error(
                    "E0105",
                    "`arm` is a key of a claim about one arm, and this compares two",
                );
                let help = "remove `arm`, or remove `compare`";
                self.errors.emit(error.at(key, "beside `compare`").help(help));
                return None;
            }
            (None, None) => {
                let error = Diagnostic::error("E0101", "a claim needs its arms: `compare` is missing");
                let help = "add `compare = { a = \"axis=point\", b = \"axis=point\" }`, or `arm = \
                    \"axis=point\"` for one arm";
                self.errors.emit(error.at(self.errors.header, "about which arms?").help(help));
                return None;
            }
        };
        sides
            .into_iter()
            .map(|(name, path, text)| Some((name.to_owned(), self.pattern(&path, &text)?)))
            .collect()
    }

    fn pattern(&mut self, path: &str, text: &str) -> Option<ArmPattern> {
        if blank::is_blank(text) {
            return None;
        }
        let place = self.place(path);
        match pattern::parse(text) {
            Ok(terms) => {
                for (index, term) in terms.iter().enumerate() {
                    let spans = [term.axis.clone(), term.point.clone()].map(|range| part(place, text, range));
                    self.mark(&format!("{path}.{index}"), spans, &text[term.axis.start..term.point.end]);
                }
                let word = |range: &std::ops::Range<usize>| text[range.clone()].to_owned();
                let term = |term: &pattern::Placed| Term { axis: word(&term.axis), point: word(&term.point) };
                Some(ArmPattern { terms: terms.iter().map(term).collect() })
            }
            Err(mistake) => {
                let error =
                    Diagnostic::error("E0103", mistake.message).at(part(place, text, mistake.range), "here");
                self.errors.emit(error.help("an arm is written `axis=point`, several axes joined by commas"));
                None
            }
        }
    }

    fn expectation(&mut self, sides: &Option<BTreeMap<String, ArmPattern>>) -> Option<Expectation> {
        let text = self.written.expect.clone();
        let place = self.place(keys::Claim::expect.name);
        let parsed = match expect::parse(&text) {
            Ok(parsed) => parsed,
            Err(mistake) => {
                let error = Diagnostic::error(mistake.code, mistake.message);
                let error = error.at(part(place, &text, mistake.range), mistake.label);
                self.errors.emit(error.help(mistake.help));
                return None;
            }
        };
        for (path, range) in &parsed.places {
            let span = part(place, &text, range.clone());
            self.mark(path, [span; 2], &text[range.clone()]);
        }
        let sides = sides.as_ref()?;
        for (path, name) in parsed.expectation.names() {
            if !sides.contains_key(name) {
                let known = suggest::listed(sides.keys().map(String::as_str));
                let error = Diagnostic::error("E0803", format!("the claim names no arm `{name}`"));
                let error = error.at(self.place(path), "not an arm of this claim");
                self.errors.emit(match sides.len() {
                    1 => error.help(format!(
                        "the only arm of this claim is {known}: compare it with a number, for example \
                         `expect = \"a > 90 %\"`, or write `compare` in place of `arm`"
                    )),
                    _ => error.help(format!("the arms of this claim are {known}")),
                });
                return None;
            }
        }
        let named = parsed.expectation.names().len();
        if sides.len() > named {
            let error = Diagnostic::error("E0103", "the expectation says nothing about `b`");
            let error = error.at(place, "compares only `a`");
            self.errors.emit(error.help("write for example `a > b`, or `arm` in place of `compare`"));
            return None;
        }
        Some(parsed.expectation)
    }

    /// A number in the metric's unit.
    fn amount(&mut self, path: &str, written: Option<keys::Amount>) -> Option<Quantity> {
        let text = match written? {
            keys::Amount::Number(number) => return Some(number),
            keys::Amount::Text(text) => text,
        };
        match expect::amount(&text) {
            Ok(quantity) => Some(quantity),
            Err(mistake) => {
                let span = part(self.place(path), &text, mistake.range);
                let error = Diagnostic::error(mistake.code, mistake.message).at(span, mistake.label);
                let help = "write it in the metric's unit, for example `\"5 %\"` or `\"0.1 m/s\"`";
                self.errors.emit(error.help(help));
                None
            }
        }
    }

    /// E0204: a margin or a spread of 0 or less.
    fn must_be_positive(&mut self, path: &str, amount: &Quantity, help: &str) {
        if amount.si <= 0.0 {
            let error = Diagnostic::error("E0204", format!("`{path}` is out of range: it must be above 0"));
            self.errors.emit(error.at(self.place(path), "below the range").help(help));
        }
    }

    fn spread(&mut self) -> Option<Quantity> {
        let path = keys::Claim::spread.name;
        let spread = self.amount(path, self.written.spread.clone())?;
        let help = "write the standard deviation between runs that you expect, or remove `spread`";
        self.must_be_positive(path, &spread, help);
        Some(spread)
    }

    fn margin(&mut self, expect: Option<&Expectation>) -> Option<Quantity> {
        let path = keys::Claim::margin.name;
        let margin = self.amount(path, self.written.margin.clone())?;
        let help = match margin.si < 0.0 {
            true => "write the distance without a sign: the relation says the direction",
            false => "remove `margin`: without one nothing has to be exceeded",
        };
        self.must_be_positive(path, &margin, help);
        if expect.is_some_and(|expect| expect.relation == Relation::Equal) {
            let error =
                Diagnostic::error("E0105", "`margin` is a key of `>`, `>=`, `<` and `<=`, not of `==`");
            let error = error.at(self.place_of_key(path), "beside `==`");
            self.errors.emit(error.help("say the tolerance in the expectation: `a == b within 5 %`"));
        }
        Some(margin)
    }

    fn paper(&mut self, written: keys::Paper) -> Paper {
        Paper {
            place: written.r#where,
            value: written.value,
            number: self.amount(&keys::Paper::number.path(), written.number),
            weaker: written.weaker == Some(true),
        }
    }
}
