//! Arm patterns: `control=position,stiffness=100 %` selects the arms at these points of these axes.
//!
//! Grammar: `pattern = term { "," term }`, `term = axis "=" point { "|" point }`. A point that ends with `*`
//! matches every point with that prefix, `*` alone every point of the axis.
//! A comma inside brackets, braces or quotes belongs to the point. Blanks around axes and points are ignored.

use std::ops::Range;

/// Selects arms: those whose points agree with every term.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ArmPattern {
    /// The terms, in the order in which they are written; at least one.
    pub terms: Vec<Term>,
}

/// One axis and its point, or several of its points.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Term {
    /// Name of the axis.
    pub axis: String,
    /// Name of the point; several separated by `|`, or a prefix followed by `*`.
    pub point: String,
}

impl Term {
    /// The alternatives between the bars: points, or prefixes followed by `*`.
    pub fn points(&self) -> Vec<&str> {
        self.point.split('|').map(str::trim).collect()
    }

    fn takes(&self, point: &str) -> bool {
        self.points().into_iter().any(|written| is_meant(written, point))
    }
}

/// Whether an alternative of a term matches a point: it is equal, or a prefix of it.
pub fn is_meant(written: &str, point: &str) -> bool {
    written == point || written.strip_suffix('*').is_some_and(|beginning| point.starts_with(beginning))
}

impl ArmPattern {
    /// Whether an arm matches, given its point on each axis.
    pub fn matches<'a>(&self, point: impl Fn(&str) -> Option<&'a str>) -> bool {
        self.terms.iter().all(|term| point(&term.axis).is_some_and(|point| term.takes(point)))
    }

    /// Whether the pattern selects one point of this axis; of several, each is a separate arm.
    pub fn fixes(&self, axis: &str) -> bool {
        let one = |term: &Term| matches!(term.points().as_slice(), [point] if !point.ends_with('*'));
        self.terms.iter().any(|term| term.axis == axis && one(term))
    }

    /// The pattern as text: `control=position,stiffness=100 %`.
    pub fn written(&self) -> String {
        self.terms.iter().map(|term| format!("{}={}", term.axis, term.point)).collect::<Vec<_>>().join(",")
    }
}

/// The places of a term in the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Placed {
    /// The axis.
    pub axis: Range<usize>,
    /// The point.
    pub point: Range<usize>,
}

/// What is wrong with a pattern, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// One sentence.
    pub message: String,
    /// The place in the text.
    pub range: Range<usize>,
}

/// Parses a pattern.
pub fn parse(text: &str) -> Result<Vec<Placed>, Mistake> {
    let mut terms: Vec<Placed> = Vec::new();
    for range in split(text) {
        let piece = &text[range.clone()];
        let Some(equals) = piece.find('=') else {
            let message = match piece.trim() {
                "" => "an arm has no term here".to_owned(),
                word => format!("`{word}` names no axis"),
            };
            return Err(Mistake { message, range: trimmed(text, range) });
        };
        let axis = trimmed(text, range.start..range.start + equals);
        let point = trimmed(text, range.start + equals + 1..range.end);
        if axis.is_empty() || point.is_empty() {
            let lacking = if axis.is_empty() { "an axis" } else { "a point" };
            return Err(Mistake {
                message: format!("`{}` lacks {lacking}", piece.trim()),
                range: trimmed(text, range),
            });
        }
        if let Some(earlier) = terms.iter().find(|term| text[term.axis.clone()] == text[axis.clone()]) {
            let message = format!("the axis `{}` stands twice", &text[earlier.axis.clone()]);
            return Err(Mistake { message, range: axis });
        }
        terms.push(Placed { axis, point });
    }
    Ok(terms)
}

/// Splits at commas outside brackets and quotes.
fn split(text: &str) -> Vec<Range<usize>> {
    let (mut depth, mut quoted, mut start, mut pieces) = (0usize, false, 0, Vec::new());
    for (at, letter) in text.char_indices() {
        match letter {
            '"' => quoted = !quoted,
            '[' | '{' | '(' if !quoted => depth += 1,
            ']' | '}' | ')' if !quoted => depth = depth.saturating_sub(1),
            ',' if !quoted && depth == 0 => {
                pieces.push(start..at);
                start = at + 1;
            }
            _ => {}
        }
    }
    pieces.push(start..text.len());
    pieces
}

/// A range without leading and trailing blanks.
pub fn trimmed(text: &str, range: Range<usize>) -> Range<usize> {
    let piece = &text[range.clone()];
    let start = range.start + (piece.len() - piece.trim_start().len());
    start..start + piece.trim().len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<(&str, &str)> {
        let terms = parse(text).expect("a pattern");
        terms.into_iter().map(|term| (&text[term.axis], &text[term.point])).collect()
    }

    #[test]
    fn terms_are_axes_and_points() {
        assert_eq!(words("control=torque"), [("control", "torque")]);
        assert_eq!(
            words("control = position , stiffness=12.5 %"),
            [("control", "position"), ("stiffness", "12.5 %")]
        );
        assert_eq!(words("layers=[256, 256],std=1 %"), [("layers", "[256, 256]"), ("std", "1 %")]);
    }

    #[test]
    fn what_is_no_term_is_pointed_at() {
        let range = |text: &str| parse(text).expect_err("no pattern").range;
        assert_eq!(range("torque"), 0..6);
        assert_eq!(range("control=torque,"), 15..15);
        assert_eq!(range("control=torque, =x"), 16..18);
        assert_eq!(range("a=1,a=2"), 4..5);
    }

    #[test]
    fn a_pattern_matches_arms_that_agree_with_every_term() {
        let term = |axis: &str, point: &str| Term { axis: axis.into(), point: point.into() };
        let pattern = ArmPattern { terms: vec![term("control", "torque"), term("std", "1 %")] };
        let arm = |std: &'static str| {
            move |axis: &str| {
                [("control", "torque"), ("std", std)]
                    .iter()
                    .find(|(name, _)| *name == axis)
                    .map(|(_, point)| *point)
            }
        };
        assert!(pattern.matches(arm("1 %")) && !pattern.matches(arm("2 %")) && !pattern.matches(|_| None));
        assert!(pattern.fixes("std") && !pattern.fixes("robot"));
        let several = ArmPattern { terms: vec![term("std", "1 % | 3 %")] };
        assert!(several.matches(arm("1 %")) && several.matches(arm("3 %")) && !several.matches(arm("2 %")));
        let every = ArmPattern { terms: vec![term("std", "*")] };
        assert!(every.matches(arm("2 %")) && !every.matches(|_| None));
        assert!(!several.fixes("std") && !every.fixes("std"));
        let family = ArmPattern { terms: vec![term("setting", "position_k8*|torque")] };
        let meant = |point: &'static str| family.matches(|axis| (axis == "setting").then_some(point));
        assert!(meant("position_k8_s100") && meant("position_k8") && meant("torque"));
        assert!(!meant("position_k4") && !meant("torque_5") && !family.fixes("setting"));
        let one = ArmPattern { terms: vec![term("setting", "position_*")] };
        assert!(!one.fixes("setting"), "it may mean several");
        assert_eq!(pattern.written(), "control=torque,std=1 %");
    }
}
