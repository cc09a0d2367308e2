//! Expectations: `a > b`, `a < 0.5 * b`, `a > b + 20 %`, `a < 0.2 m/s`, `a == b within 5 %`.
//!
//! Grammar: `expectation = operand relation operand [ "within" quantity ]`,
//! `operand = [ number "*" ] arm [ ( "+" | "-" ) quantity ] | quantity`,
//! `relation = ">" | ">=" | "<" | "<=" | "=="`. At least one operand is an arm; of two arms only one may have
//! a factor or an offset. `==` requires a tolerance, the other relations take none.

use std::ops::Range;

use super::pattern::trimmed;
use crate::quantity::{self, Dimension, QuantityError};
use crate::spec::Quantity;

/// What is expected of the arms of a claim.
#[derive(Clone, Debug, PartialEq)]
pub struct Expectation {
    /// Name of the arm on the left: `a` or `b`.
    pub left: String,
    /// How it relates to the right.
    pub relation: Relation,
    /// The other arm, or a number.
    pub right: Operand,
    /// Factor of the other arm; 1 if none is written.
    pub factor: f64,
    /// Offset added to the other arm, in the metric's unit.
    pub offset: Option<Quantity>,
    /// The tolerance of `==`, in the metric's unit.
    pub within: Option<Quantity>,
}

/// A relation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// `>`
    Greater,
    /// `>=`
    AtLeast,
    /// `<`
    Less,
    /// `<=`
    AtMost,
    /// `==`
    Equal,
}

/// What an arm is compared with.
#[derive(Clone, Debug, PartialEq)]
pub enum Operand {
    /// An arm of the claim.
    Arm(String),
    /// A number in the metric's unit.
    Number(Quantity),
}

impl Relation {
    /// The operator.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Greater => ">",
            Self::AtLeast => ">=",
            Self::Less => "<",
            Self::AtMost => "<=",
            Self::Equal => "==",
        }
    }

    /// The relation with its sides swapped.
    fn flipped(self) -> Self {
        match self {
            Self::Greater => Self::Less,
            Self::AtLeast => Self::AtMost,
            Self::Less => Self::Greater,
            Self::AtMost => Self::AtLeast,
            Self::Equal => Self::Equal,
        }
    }
}

impl Expectation {
    /// The key of the left side's place in the marks of a claim.
    pub const LEFT: &str = "expect.left";
    /// The key of the right side's place.
    pub const RIGHT: &str = "expect.right";
    /// The key of the offset's place.
    pub const OFFSET: &str = "expect.offset";
    /// The key of the tolerance's place.
    pub const WITHIN: &str = "expect.within";

    /// The arms named, with the keys of their places.
    pub fn names(&self) -> Vec<(&'static str, &str)> {
        let mut names = vec![(Self::LEFT, self.left.as_str())];
        if let Operand::Arm(name) = &self.right {
            names.push((Self::RIGHT, name));
        }
        names
    }

    /// The expectation as text.
    pub fn written(&self) -> String {
        let right = self.right_written(|name| name.to_owned());
        let within = self.within.as_ref().map_or(String::new(), |within| format!(" within {}", within.text));
        format!("{} {} {right}{within}", self.left, self.relation.symbol())
    }

    /// The right side as text, with a name for the arm.
    pub fn right_written(&self, named: impl Fn(&str) -> String) -> String {
        let name = match &self.right {
            Operand::Arm(name) => named(name),
            Operand::Number(number) => return number.text.clone(),
        };
        let factor = if self.factor == 1.0 { String::new() } else { format!("{} * ", self.factor) };
        let offset =
            self.offset.as_ref().map_or(String::new(), |offset| match offset.text.strip_prefix('-') {
                Some(less) => format!(" - {less}"),
                None => format!(" + {}", offset.text),
            });
        format!("{factor}{name}{offset}")
    }
}

/// An expectation and the places of its parts in the text.
#[derive(Clone, Debug, PartialEq)]
pub struct Parsed {
    /// The expectation.
    pub expectation: Expectation,
    /// By their keys in the marks of a claim.
    pub places: Vec<(&'static str, Range<usize>)>,
}

/// What is wrong with a text, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// The code of the diagnostic.
    pub code: &'static str,
    /// One sentence.
    pub message: String,
    /// The place in the text.
    pub range: Range<usize>,
    /// The remark there.
    pub label: &'static str,
    /// What to write.
    pub help: String,
}

impl Mistake {
    fn grammar(message: impl Into<String>, range: Range<usize>, label: &'static str) -> Self {
        let help = "write for example `a > b`, `a > 90 %` or `a == b within 5 %`".to_owned();
        Self { code: "E0103", message: message.into(), range, label, help }
    }
}

const SYMBOLS: [Relation; 5] =
    [Relation::AtLeast, Relation::AtMost, Relation::Equal, Relation::Greater, Relation::Less];

/// Parses an expectation.
pub fn parse(text: &str) -> Result<Parsed, Mistake> {
    let (at, relation) = relation(text)?;
    let after = at + relation.symbol().len();
    let (right, within) = match text[after..].find(" within ") {
        Some(place) => (after..after + place, Some(after + place + " within ".len()..text.len())),
        None => (after..text.len(), None),
    };
    let (mut left, mut right) = (trimmed(text, 0..at), trimmed(text, right));
    let within = within.map(|range| trimmed(text, range));
    let (mut first, mut second) = (side(text, left.clone())?, side(text, right.clone())?);
    let mut relation = relation;
    if !matches!(first.operand, Operand::Arm(_)) || first.is_changed() {
        (first, second, relation) = (second, first, relation.flipped());
        (left, right) = (right, left);
    }
    let Operand::Arm(name) = first.operand.clone() else {
        return Err(Mistake::grammar(
            "an expectation names an arm",
            trimmed(text, 0..text.len()),
            "only numbers",
        ));
    };
    if first.is_changed() {
        let message = "only one side of an expectation is multiplied or added to";
        return Err(Mistake::grammar(message, left, "the other side is, too"));
    }
    if matches!(&second.operand, Operand::Arm(other) if *other == name) {
        return Err(Mistake::grammar(format!("`{name}` is compared with itself"), right, "the same arm"));
    }
    let within = tolerance(text, relation, within)?;
    let mut places = vec![(Expectation::LEFT, left), (Expectation::RIGHT, second.place)];
    let offset = second.offset.map(|(quantity, range)| {
        places.push((Expectation::OFFSET, range));
        quantity
    });
    let tolerance = within.map(|(quantity, range)| {
        places.push((Expectation::WITHIN, range));
        quantity
    });
    let expectation = Expectation {
        left: name,
        relation,
        right: second.operand,
        factor: second.factor,
        offset,
        within: tolerance,
    };
    Ok(Parsed { expectation, places })
}

/// One side of an expectation.
struct Side {
    operand: Operand,
    /// Place of the arm or the number.
    place: Range<usize>,
    factor: f64,
    offset: Option<(Quantity, Range<usize>)>,
}

impl Side {
    fn is_changed(&self) -> bool {
        self.factor != 1.0 || self.offset.is_some()
    }
}

/// Parses `[ number "*" ] arm [ ( "+" | "-" ) quantity ]` or a number.
fn side(text: &str, range: Range<usize>) -> Result<Side, Mistake> {
    let star = text[range.clone()]
        .find('*')
        .map(|at| range.start + at)
        .filter(|star| is_factor(&text[range.start..*star]));
    let start = star.map_or(range.start, |star| star + 1);
    if !text[start..range.end].trim_start().starts_with(|c: char| c.is_alphabetic() || c == '_') {
        let operand = operand(text, range.clone())?;
        return Ok(Side { operand, place: range, factor: 1.0, offset: None });
    }
    let factor = match star {
        Some(star) => factor(text, trimmed(text, range.start..star))?,
        None => 1.0,
    };
    let sign = text[start..range.end].find(['+', '-']).map(|at| start + at);
    let place = trimmed(text, start..sign.unwrap_or(range.end));
    let arm = operand(text, place.clone())?;
    let offset = match sign {
        Some(sign) => Some(offset(text, sign, range.end)?),
        None => None,
    };
    Ok(Side { operand: arm, place, factor, offset })
}

/// Whether the text before a `*` is a factor of an arm; in `5 N*m` it is part of a quantity.
fn is_factor(text: &str) -> bool {
    let is_pure = quantity::quantity(text.trim()).map_or(true, |parsed| parsed.dimension == Dimension::NONE);
    is_pure || !quantity::parse::looks_like_quantity(text)
}

/// A factor: a number above 0 without a unit, or a percentage.
fn factor(text: &str, range: Range<usize>) -> Result<f64, Mistake> {
    let word = &text[range.clone()];
    match amount(word) {
        Ok(number) if number.si > 0.0 => Ok(number.si),
        _ => {
            let mistake =
                Mistake::grammar(format!("`{word}` is not a factor"), range, "not a number above 0");
            Err(Mistake { help: "write for example `a < 0.5 * b`".to_owned(), ..mistake })
        }
    }
}

/// The offset; negative after a `-`.
fn offset(text: &str, sign: usize, end: usize) -> Result<(Quantity, Range<usize>), Mistake> {
    let range = trimmed(text, sign + 1..end);
    match operand(text, range.clone())? {
        Operand::Number(number) if text[sign..].starts_with('-') => {
            let quantity = Quantity { si: -number.si, text: format!("-{}", number.text) };
            Ok((quantity, range))
        }
        Operand::Number(number) => Ok((number, range)),
        Operand::Arm(_) => {
            let mistake = Mistake::grammar("an arm is compared, not added", range, "not a number");
            Err(Mistake { help: "write for example `a > b + 20 %`".to_owned(), ..mistake })
        }
    }
}

/// The relation and its place.
fn relation(text: &str) -> Result<(usize, Relation), Mistake> {
    let whole = trimmed(text, 0..text.len());
    let Some(at) = text.find(['<', '>', '=']) else {
        return Err(Mistake::grammar(
            "an expectation needs a relation",
            whole,
            "no `>`, `>=`, `<`, `<=` or `==`",
        ));
    };
    match SYMBOLS.into_iter().find(|relation| text[at..].starts_with(relation.symbol())) {
        Some(relation) => Ok((at, relation)),
        None => {
            let mistake = Mistake::grammar("`=` is not a relation", at..at + 1, "not a relation");
            Err(Mistake { help: "equality is written `a == b within 5 %`".to_owned(), ..mistake })
        }
    }
}

/// An arm's name or a number.
fn operand(text: &str, range: Range<usize>) -> Result<Operand, Mistake> {
    let word = &text[range.clone()];
    if word.is_empty() {
        return Err(Mistake::grammar(
            "an expectation has two sides",
            trimmed(text, 0..text.len()),
            "one side is missing",
        ));
    }
    if quantity::parse::looks_like_quantity(word) {
        let shifted = |mistake: Mistake| Mistake {
            range: range.start + mistake.range.start..range.start + mistake.range.end,
            ..mistake
        };
        return amount(word).map(Operand::Number).map_err(shifted);
    }
    if word.chars().all(|c| c.is_alphanumeric() || c == '_') {
        return Ok(Operand::Arm(word.to_owned()));
    }
    Err(Mistake::grammar(format!("`{word}` is neither an arm nor a number"), range, "not an arm"))
}

/// The tolerance: required by `==`, not allowed otherwise.
fn tolerance(
    text: &str,
    relation: Relation,
    range: Option<Range<usize>>,
) -> Result<Option<(Quantity, Range<usize>)>, Mistake> {
    match (relation, range) {
        (Relation::Equal, None) => {
            let whole = trimmed(text, 0..text.len());
            Err(Mistake::grammar("`==` needs a tolerance: no two samples are equal", whole, "within what?"))
        }
        (Relation::Equal, Some(range)) => match operand(text, range.clone())? {
            Operand::Number(quantity) if quantity.si > 0.0 => Ok(Some((quantity, range))),
            _ => Err(Mistake::grammar("a tolerance is a number above 0", range, "not a tolerance")),
        },
        (_, Some(range)) => {
            let mistake =
                Mistake::grammar(format!("`{}` takes no tolerance", relation.symbol()), range, "not here");
            Err(Mistake {
                help: "a distance to exceed or to fall short by is the key `margin`".to_owned(),
                ..mistake
            })
        }
        (_, None) => Ok(None),
    }
}

/// A number with or without a unit: `0.9`, `90 %`, `0.2 m/s`, `500 k`. The metric checks the unit.
pub fn amount(text: &str) -> Result<Quantity, Mistake> {
    let text = text.trim();
    let whole = 0..text.len();
    if let Ok(si) = text.replace('_', "").parse::<f64>() {
        let finite = si.is_finite().then(|| Quantity { si, text: text.to_owned() });
        return finite.ok_or_else(|| Mistake {
            code: "E0205",
            ..Mistake::grammar("a number is not finite", whole, "")
        });
    }
    if let Some(si) = quantity::counted(text) {
        return Ok(Quantity { si, text: text.to_owned() });
    }
    let mistake = |code, message: String, range| Mistake { code, ..Mistake::grammar(message, range, "") };
    match quantity::quantity(text) {
        Ok(parsed) => Ok(Quantity { si: parsed.si, text: text.to_owned() }),
        Err(QuantityError::UnknownUnit { range, found, suggestion }) => {
            let help = suggestion.map_or_else(
                || "units are joined by `*` and `/`, powers by `^`".to_owned(),
                |unit| format!("did you mean `{unit}`?"),
            );
            Err(Mistake { help, ..mistake("E0202", format!("unknown unit `{found}`"), range) })
        }
        Err(QuantityError::NotFinite { number }) => {
            Err(mistake("E0205", "a number is not finite".to_owned(), number))
        }
        Err(error) => Err(mistake("E0103", error.to_string(), whole)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Expectation {
        parse(text).unwrap_or_else(|mistake| panic!("{text}: {mistake:?}")).expectation
    }

    fn wrong(text: &str) -> (&'static str, &str) {
        let mistake = parse(text).expect_err("a mistake");
        (mistake.code, &text[mistake.range])
    }

    #[test]
    fn every_relation_between_two_arms_is_read_and_written_again() {
        let plain = [
            "a > b",
            "a >= b",
            "b < a",
            "a <= b",
            "a == b within 5 %",
            "a > 90 %",
            "a <= 0.2 m/s",
            "a < 5 N*m",
        ];
        let changed = ["a < 0.5 * b", "a > b + 20 %", "a == 0.8 * b - 3 N*m within 5 N*m"];
        for text in plain.into_iter().chain(changed) {
            assert_eq!(read(text).written(), text);
        }
        assert_eq!(read("a>b"), read("a > b"));
    }

    #[test]
    fn a_number_on_the_left_turns_the_relation_round() {
        assert_eq!(read("0.9 < a").written(), "a > 0.9");
        assert_eq!(read("90 % <= a").written(), "a >= 90 %");
    }

    #[test]
    fn one_arm_is_multiplied_and_added_to() {
        let half = read("50 % * b >= a");
        assert_eq!((half.written().as_str(), half.factor), ("a <= 0.5 * b", 0.5));
        let less = read("a > b - 20 %");
        assert!(less.offset.is_some_and(|offset| (offset.si + 0.2).abs() < 1e-12));
        assert_eq!(wrong("2 * a > 3 * b"), ("E0103", "3 * b"));
        assert_eq!(wrong("a > 0 * b"), ("E0103", "0"));
        assert_eq!(wrong("a > x * b"), ("E0103", "x"));
        assert_eq!(wrong("a > b + c"), ("E0103", "c"));
        assert_eq!(wrong("a > 2 * a"), ("E0103", "2 * a"));
    }

    #[test]
    fn numbers_are_si() {
        let Operand::Number(number) = read("a > 90 %").right else { panic!("a number") };
        assert!((number.si - 0.9).abs() < 1e-12);
        let Some(within) = read("a == b within 5 ms").within else { panic!("a tolerance") };
        assert!((within.si - 0.005).abs() < 1e-12);
        let Operand::Number(number) = read("a < 2 M").right else { panic!("a number") };
        assert_eq!(number.si, 2e6);
        assert_eq!(read("a < b - 500 k").offset.map(|offset| offset.si), Some(-5e5));
        assert_eq!(read("a == b within 1.5 k").within.map(|within| within.si), Some(1500.0));
        assert_eq!(read("a < b - 500 k").written(), "a < b - 500 k");
        assert_eq!(wrong("a < 2 K"), ("E0202", "K"));
        assert_eq!(read("a > b + 200_000").offset.map(|offset| offset.si), Some(2e5));
    }

    #[test]
    fn places_are_those_of_the_parts() {
        let text = "a ==  b within 5 %";
        let words: Vec<_> =
            parse(text).expect("sound").places.into_iter().map(|(key, range)| (key, &text[range])).collect();
        assert_eq!(words, [("expect.left", "a"), ("expect.right", "b"), ("expect.within", "5 %")]);
    }

    #[test]
    fn mistakes_are_pointed_at() {
        assert_eq!(wrong("a b"), ("E0103", "a b"));
        assert_eq!(wrong("a = b"), ("E0103", "="));
        assert_eq!(wrong("a == b"), ("E0103", "a == b"));
        assert_eq!(wrong("a > b within 5 %"), ("E0103", "5 %"));
        assert_eq!(wrong("a > a"), ("E0103", "a"));
        assert_eq!(wrong("1 > 2"), ("E0103", "1 > 2"));
        assert_eq!(wrong("a > 2 parsec"), ("E0202", "parsec"));
        assert_eq!(wrong("a >"), ("E0103", "a >"));
        assert_eq!(wrong("a > b.c"), ("E0103", "b.c"));
    }
}
