//! Quantities relative to the robot, which some keys take in place of a share.
//!
//! The decoded value is the number in the unit of its measure. Once the robot is known, a check replaces it by
//! the share that it amounts to.

use super::misread::{explain, inside};
use crate::diag::Diagnostic;
use crate::quantity::{Dimension, Measure, QuantityError, Relative};
use crate::spec::{Param, Quantity, Share, Value};
use crate::syntax::Node;

/// Decodes the text of a quantity relative to the robot, which has been parsed.
pub fn decode(
    share: &Share,
    text: &str,
    parsed: Result<Relative, QuantityError>,
    node: &Node,
    param: &Param,
) -> Result<Value, Diagnostic> {
    let relative = match parsed {
        Ok(relative) => relative,
        Err(QuantityError::UnknownUnit { range, found, .. }) => {
            let error = Diagnostic::error("E0202", format!("unknown unit `{found}`"));
            return Err(error.at(inside(node, text, range), "not a unit").help(advice(share, param)));
        }
        Err(error) => return Err(explain(&error, text, Dimension::NONE, node, param)),
    };
    if share.measure != Some(relative.measure) {
        let expected = share.measure.map_or("a percentage", Measure::name);
        let message = format!("wrong dimension: expected {expected}, found {}", relative.measure.name());
        return Err(Diagnostic::error("E0203", message).at(node.span, "").help(advice(share, param)));
    }
    if relative.number < 0.0 {
        let error = Diagnostic::error("E0204", format!("`{}` is out of range: \"{text}\"", param.name));
        return Err(error.at(node.span, "below the range").help("it must not be negative"));
    }
    Ok(Value::Quantity(Quantity { si: relative.number, text: text.trim().to_owned() }))
}

/// What the key takes.
fn advice(share: &Share, param: &Param) -> String {
    let as_share = format!("write a percentage of {}, for example `{} = \"10 %\"`", share.of, param.name);
    match share.measure {
        Some(measure) => {
            format!("{as_share}, or {}, for example `\"{}\"`", measure.name(), measure.example())
        }
        None => as_share,
    }
}
