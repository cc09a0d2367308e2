//! Flags, counts, numbers, quantities, ratios, texts and words.

use super::choice::{describe, example};
use super::misread::{explain, inside, not_finite, unit_missing};
use super::relative;
use crate::diag::Diagnostic;
use crate::quantity::parse::{CountError, MOST_COUNTED};
use crate::quantity::{self, Dimension, QuantityError};
use crate::spec::bounds;
use crate::spec::suggest::{listed, nearest};
use crate::spec::{Param, Presence, Quantity, Share, Ty, Value};
use crate::syntax::{Item, Node, Number, literal};

/// Decodes a scalar.
pub fn decode(ty: &Ty, node: &Node, param: &Param) -> Result<Value, Diagnostic> {
    match (ty, &node.item) {
        (Ty::Flag, Item::Flag(flag)) => Ok(Value::Flag(*flag)),
        (Ty::Count, _) => count(ty, node, param),
        (Ty::Number, Item::Number(_)) => {
            let value = bare(node, param)?;
            in_range(value.si, Dimension::NONE, node, param)?;
            Ok(Value::Quantity(value))
        }
        (Ty::Quantity(dimension), _) => {
            let value = quantity(*dimension, node, param)?;
            in_range(value.si, *dimension, node, param)?;
            Ok(Value::Quantity(value))
        }
        (Ty::Ratio(share), _) => ratio(share, node, param),
        (Ty::Text, Item::Text(text)) => Ok(Value::Text(text.clone())),
        (Ty::Choice(words), Item::Text(text)) => word(words, text, node, param),
        _ => Err(wrong_type(ty, node, param)),
    }
}

/// E0103, with an edit if the fix is obvious.
fn wrong_type(ty: &Ty, node: &Node, param: &Param) -> Diagnostic {
    let message = format!("`{}` takes {}, found {}", param.name, describe(ty), node.describe());
    let error = Diagnostic::error("E0103", message).at(node.span, "wrong type");
    let unquoted = node.text().and_then(|text| literal(text.trim())).filter(|text| match ty {
        Ty::Flag => matches!(text.as_str(), "true" | "false"),
        Ty::Number => !matches!(text.as_str(), "true" | "false"),
        _ => false,
    });
    let flag = flag_of(node).filter(|_| matches!(ty, Ty::Flag)).map(str::to_owned);
    match unquoted.or(flag) {
        Some(text) => error.help(format!("write `{} = {text}`", param.name)).fix(node.span, text),
        None => error.help(format!("write for example `{} = {}`", param.name, example_of(ty, param))),
    }
}

/// A valid value of the key: for a number its default, or one in its range.
fn example_of(ty: &Ty, param: &Param) -> String {
    match (ty, &param.presence, param.range) {
        (Ty::Count | Ty::Number, Presence::Default(default), _) => (*default).to_owned(),
        (Ty::Count | Ty::Number, _, Some((low, high))) if !(low..=high).contains(&1.0) => {
            quantity::number(if low > 1.0 { low } else { high })
        }
        _ => example(ty),
    }
}

/// `true` or `false` for a word or a number with that meaning in other formats: `yes`, `off`, `1`.
pub fn flag_of(node: &Node) -> Option<&'static str> {
    let word = match &node.item {
        Item::Text(text) => text.trim().to_ascii_lowercase(),
        Item::Number(number) => number.text.clone(),
        _ => return None,
    };
    match word.as_str() {
        "true" | "yes" | "on" | "1" => Some("true"),
        "false" | "no" | "off" | "0" => Some("false"),
        _ => None,
    }
}

/// A word of a list.
fn word(words: &[&'static str], text: &str, node: &Node, param: &Param) -> Result<Value, Diagnostic> {
    if words.contains(&text) {
        return Ok(Value::Text(text.to_owned()));
    }
    let others = others(param);
    let more: String = others.iter().map(|ty| format!(" or {}", describe(ty))).collect();
    let message = format!("`{}` takes {}{more}, found `{text}`", param.name, alternatives(words));
    let error = Diagnostic::error("E0106", message).at(node.span, "invalid choice");
    Err(match nearest(text, words.iter().copied()) {
        Some(name) => error.help(format!("did you mean `{name}`?")).fix(node.span, format!("\"{name}\"")),
        None => {
            let forms: String = others.iter().map(|ty| format!(", or write {}", example(ty))).collect();
            error.help(format!("the valid words are {}{forms}", listed(words.iter().copied())))
        }
    })
}

/// The types that a key takes besides words.
fn others(param: &Param) -> Vec<&'static Ty> {
    match param.ty {
        Ty::OneOf(types) => types.iter().filter(|ty| !matches!(ty, Ty::Choice(_))).collect(),
        _ => Vec::new(),
    }
}

fn alternatives(words: &[&str]) -> String {
    words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(" or ")
}

/// A whole number, bare or with a count suffix.
fn count(ty: &Ty, node: &Node, param: &Param) -> Result<Value, Diagnostic> {
    let whole = match &node.item {
        Item::Number(number) if !number.value.is_finite() => return Err(not_finite(node.span, param)),
        Item::Number(number) => whole(number),
        Item::Text(text) => quantity::count(text),
        _ => return Err(wrong_type(ty, node, param)),
    };
    let (code, message, written) = match whole {
        Ok(whole) => {
            in_range(whole as f64, Dimension::NONE, node, param)?;
            return Ok(Value::Count(whole));
        }
        Err(CountError::OutOfRange(value)) => return Err(uncountable(value, node, param)),
        Err(CountError::Suffix(suffix)) => {
            let known = ["k", "M", "G"].into_iter().find(|known| known.eq_ignore_ascii_case(&suffix));
            let written = known.zip(node.text()).map(|(known, text)| {
                format!("\"{} {known}\"", text.trim().trim_end_matches(suffix.as_str()).trim_end())
            });
            ("E0202", format!("unknown count suffix `{suffix}`"), written)
        }
        Err(CountError::NotWhole) => {
            let message = format!("`{}` takes a whole number, found {}", param.name, node.toml());
            ("E0103", message, without_fraction(node).filter(|_| holds_count(node, param)))
        }
    };
    let error = Diagnostic::error(code, message).at(node.span, "");
    let error = match written {
        Some(written) => {
            return Err(error.help(format!("write `{} = {written}`", param.name)).fix(node.span, written));
        }
        None => error,
    };
    Err(error.help("counts are whole numbers such as `16384`, `\"200 k\"` or `\"80 M\"`"))
}

/// A number such as `2.0` or `1e6` without point or exponent, if it is a count that a double represents
/// exactly.
fn without_fraction(node: &Node) -> Option<String> {
    let Item::Number(number) = &node.item else { return None };
    let value = number.value;
    (value.fract() == 0.0 && (0.0..9e15).contains(&value)).then(|| (value as u64).to_string())
}

fn holds_count(node: &Node, param: &Param) -> bool {
    matches!(&node.item, Item::Number(number) if bounds::holds(param, number.value))
}

/// A bare number as a count.
fn whole(number: &Number) -> Result<u64, CountError> {
    match number.whole {
        Some(whole) => u64::try_from(whole).map_err(|_| CountError::OutOfRange(number.value)),
        None if number.text.contains(['.', 'e', 'E']) => Err(CountError::NotWhole),
        None => Err(CountError::OutOfRange(number.value)),
    }
}

/// A negative or too large count (E0204).
fn uncountable(value: f64, node: &Node, param: &Param) -> Diagnostic {
    let Err(diagnostic) = in_range(value, Dimension::NONE, node, param) else {
        let message = format!("`{}` is out of range: {}", param.name, quantity::written(&node.toml()));
        let most = if matches!(node.item, Item::Text(_)) { MOST_COUNTED } else { i64::MAX as u64 };
        let (label, help) = (
            if value < 0.0 { "below the range" } else { "above the range" },
            format!("it must be between 0 and {most}"),
        );
        return Diagnostic::error("E0204", message).at(node.span, label).help(help);
    };
    diagnostic
}

/// A bare number.
fn bare(node: &Node, param: &Param) -> Result<Quantity, Diagnostic> {
    match &node.item {
        Item::Number(number) if number.value.is_finite() => {
            Ok(Quantity { si: number.value, text: number.text.clone() })
        }
        Item::Number(_) => Err(not_finite(node.span, param)),
        _ => Err(wrong_type(&Ty::Number, node, param)),
    }
}

/// A quantity of a dimension. A dimensionless number is bare or a percentage.
pub fn quantity(dimension: Dimension, node: &Node, param: &Param) -> Result<Quantity, Diagnostic> {
    if dimension == Dimension::NONE && !matches!(&node.item, Item::Text(text) if text.contains('%')) {
        return bare(node, param);
    }
    match &node.item {
        Item::Text(text) => match quantity::quantity_of(text, dimension) {
            Ok(si) => Ok(Quantity { si, text: text.trim().to_owned() }),
            Err(error) => Err(explain(&error, text, dimension, node, param)),
        },
        Item::Number(number) if !number.value.is_finite() => Err(not_finite(node.span, param)),
        Item::Number(number) => Err(unit_missing(&number.text, dimension, node, param)),
        _ => Err(wrong_type(&Ty::Quantity(dimension), node, param)),
    }
}

/// A percentage.
fn ratio(share: &Share, node: &Node, param: &Param) -> Result<Value, Diagnostic> {
    let reference = share.of;
    if let Some((text, read)) = node.text().and_then(|text| Some((text, quantity::relative(text)?))) {
        return relative::decode(share, text, read, node, param);
    }
    let share = |si: f64, text: &str| {
        in_range(si, Dimension::NONE, node, param)?;
        Ok(Value::Quantity(Quantity { si, text: text.trim().to_owned() }))
    };
    let missing = |number: &str, value: f64| {
        let factor = quantity::print_ratio(value);
        // Up to 1 it was probably a factor, above 1 a percentage.
        let (written, other) = if value.abs() <= 1.0 {
            (factor, String::new())
        } else {
            (format!("{number} %"), format!("; as a factor, {number} is \"{factor}\""))
        };
        let error = Diagnostic::error("E0201", "missing percent sign").at(node.span, "no `%`");
        let help = format!("write \"{written}\" (of {reference}){other}");
        error.help(help).fix(node.span, format!("\"{written}\""))
    };
    let as_share = format!("write a percentage of {reference}, for example \"10 %\"");
    match &node.item {
        Item::Text(text) => match quantity::quantity_of(text, Dimension::NONE) {
            Ok(si) => share(si, text),
            Err(QuantityError::UnitMissing { .. }) => {
                Err(missing(text.trim(), text.trim().parse().unwrap_or(1.0)))
            }
            Err(QuantityError::Mismatch { range, found, .. }) => {
                let message = format!("wrong dimension: expected a percentage, found {}", found.name());
                let error =
                    Diagnostic::error("E0203", message).at(inside(node, text, range), "not a percentage");
                Err(error.help(as_share))
            }
            Err(QuantityError::UnknownUnit { range, found, suggestion: None }) => {
                let error = Diagnostic::error("E0202", format!("unknown unit `{found}`"));
                Err(error.at(inside(node, text, range), "not a percentage").help(as_share))
            }
            Err(QuantityError::NoNumber { .. }) => {
                let message = format!("`{}` takes a percentage, found `{text}`", param.name);
                Err(Diagnostic::error("E0103", message).at(node.span, "no number").help(as_share))
            }
            Err(error) => Err(explain(&error, text, Dimension::NONE, node, param)),
        },
        Item::Number(number) if !number.value.is_finite() => Err(not_finite(node.span, param)),
        Item::Number(number) => Err(missing(&number.text, number.value)),
        _ => Err(wrong_type(&param.ty, node, param)),
    }
}

/// Checks the bounds of a key (E0204).
pub fn in_range(si: f64, dimension: Dimension, node: &Node, param: &Param) -> Result<(), Diagnostic> {
    let Some((low, high)) = param.range.filter(|_| !bounds::holds(param, si)) else { return Ok(()) };
    let (written, side) = (node.toml(), if si < low { "below" } else { "above" });
    let error = Diagnostic::error(
        "E0204",
        format!("`{}` is out of range: {}", param.name, quantity::written(&written)),
    );
    let is_in_degrees =
        dimension == Dimension::ANGLE && node.text().is_some_and(|text| text.ends_with("deg"));
    // Rounded towards zero, so that the bounds shown are within the range.
    let shown = |bound: f64| quantity::number((bound.to_degrees() * 10.0).trunc() / 10.0);
    let too = match is_in_degrees {
        true => format!(" ({} deg and {} deg)", shown(low), shown(high)),
        false => String::new(),
    };
    let help = format!("it must be {}{too}", bounds::in_words(param, dimension));
    let error = error.at(node.span, format!("{side} the range")).help(help);
    let degrees = si.to_radians();
    let meant = node.text().filter(|_| dimension == Dimension::ANGLE && low <= degrees && degrees <= high);
    Err(
        match meant
            .and_then(|text| Some(text.strip_suffix("rad")?.trim_end()))
            .filter(|number| number.parse::<f64>().is_ok())
        {
            Some(number) => {
                let written = format!("\"{number} deg\"");
                error.help(format!("for degrees, write `{written}`")).fix(node.span, written)
            }
            None => error,
        },
    )
}
