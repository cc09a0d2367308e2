//! Mistakes in the text of a quantity.

use std::ops::Range;

use super::choice::example;
use crate::diag::{Diagnostic, Span};
use crate::quantity::{self, Dimension, QuantityError};
use crate::spec::{Param, Ty, bounds};
use crate::syntax::Node;

/// E0201 with the edit.
pub fn unit_missing(number: &str, dimension: Dimension, node: &Node, param: &Param) -> Diagnostic {
    let error =
        Diagnostic::error("E0201", format!("{} needs a unit", dimension.name())).at(node.span, "no unit");
    // Angles are often given in degrees. A unit that puts the value out of its range is not suggested.
    let units = [Some(dimension.unit()), (dimension == Dimension::ANGLE).then(|| "deg".to_owned())];
    let fits = |unit: &String| {
        let si = quantity::quantity_of(&format!("{number} {unit}"), dimension);
        si.is_ok_and(|si| bounds::holds(param, si))
    };
    match units.into_iter().flatten().find(fits) {
        Some(unit) => {
            let written = format!("\"{number} {unit}\"");
            error.help(format!("did you mean `{written}`?")).fix(node.span, written)
        }
        None => {
            error.help(format!("write it in `{}`, within the range of `{}`", dimension.unit(), param.name))
        }
    }
}

/// A quantity's error as a diagnostic.
pub fn explain(
    error: &QuantityError,
    text: &str,
    dimension: Dimension,
    node: &Node,
    param: &Param,
) -> Diagnostic {
    match error {
        QuantityError::NoNumber { .. } => {
            let message = format!("`{}` takes {}, found `{text}`", param.name, dimension.name());
            let example = example(&Ty::Quantity(dimension));
            Diagnostic::error("E0103", message)
                .at(node.span, "no number")
                .help(format!("write for example `{example}`"))
        }
        QuantityError::UnitMissing { number } => unit_missing(&text[number.clone()], dimension, node, param),
        QuantityError::UnknownUnit { range, found, suggestion } => {
            let place = inside(node, text, range.clone());
            let error = Diagnostic::error("E0202", format!("unknown unit `{found}`")).at(place, "not a unit");
            match suggestion {
                Some(unit) => error.help(format!("did you mean `{unit}`?")).fix(place, unit.clone()),
                None => error.help(format!(
                    "{} is written with {}; units are joined by `*` and `/`, powers by `^`",
                    dimension.name(),
                    if dimension.unit().is_empty() {
                        "`%`".to_owned()
                    } else {
                        format!("`{}`", dimension.unit())
                    },
                )),
            }
        }
        QuantityError::Mismatch { range, found, expected } => {
            let unit = &text[range.clone()];
            let message = format!("wrong dimension: expected {}, found {}", expected.name(), found.name());
            let error = Diagnostic::error("E0203", message);
            let error = error.at(inside(node, text, range.clone()), format!("`{unit}` is {}", found.name()));
            let number = text[..range.start].trim();
            let example = format!("`\"{number} {}\"`", expected.unit());
            error.help(format!("write `{}` as {}, for example {example}", param.name, expected.name()))
        }
        QuantityError::NotFinite { number } => not_finite(inside(node, text, number.clone()), param),
    }
}

/// The place of a part of a string value. For strings with escapes, and for defaults, that of the whole.
pub fn inside(node: &Node, text: &str, range: Range<usize>) -> Span {
    part(node.span, text, range)
}

/// The place of a part of a string value whose place is `span`.
pub fn part(span: Span, text: &str, range: Range<usize>) -> Span {
    let quote = match (span.end - span.start).checked_sub(text.len()) {
        Some(0) => 0,
        Some(2) => 1,
        _ => return span,
    };
    let start = span.start + quote;
    Span { start: start + range.start, end: start + range.end, ..span }
}

/// A number that is not finite (E0205).
pub fn not_finite(span: Span, param: &Param) -> Diagnostic {
    Diagnostic::error("E0205", format!("`{}` is not finite", param.name))
        .at(span, "infinite, too large or not a number")
        .help("write a finite number")
}
