//! The one sampler type: a plain value, or `{ uniform = [a, b] }`, `{ normal = [mean, std] }`,
//! `{ log_uniform = [a, b] }`, `{ choice = [...] }`.

use super::scalar;
use crate::diag::Diagnostic;
use crate::quantity::{self, Dimension};
use crate::spec::bounds::{self, Flaw};
use crate::spec::suggest::{listed, nearest};
use crate::spec::{Param, Quantity, Sampler, Value};
use crate::syntax::{Item, Node};

/// Decodes a sampler of a dimension. A plain value stays a quantity, with its author's text.
pub fn decode(dimension: Dimension, node: &Node, param: &Param) -> Result<Value, Diagnostic> {
    let Item::Table(map) = &node.item else {
        let quantity = scalar::quantity(dimension, node, param)?;
        positive_scale(quantity.si, node, param)?;
        scalar::in_range(quantity.si, dimension, node, param)?;
        return Ok(Value::Quantity(quantity));
    };
    if let Some((word, entry)) = map.entries.iter().find(|(word, _)| !Sampler::WORDS.contains(&word.as_str()))
    {
        let error = Diagnostic::error("E0102", format!("unknown distribution `{word}`")).at(entry.key, "");
        return Err(match nearest(word, Sampler::WORDS.iter().copied()) {
            Some(name) => error.help(format!("did you mean `{name}`?")).fix(entry.key, name),
            None => error.help(format!("the distributions are {}", listed(Sampler::WORDS.iter().copied()))),
        });
    }
    let (word, entry) = match map.entries.iter().collect::<Vec<_>>().as_slice() {
        [(word, entry)] => (word.as_str(), *entry),
        entries => {
            let error = Diagnostic::error("E0103", format!("`{}` takes one distribution", param.name));
            let help = "write for example `{ uniform = [low, high] }`";
            return Err(error.at(node.span, format!("{} of them here", entries.len())).help(help));
        }
    };
    let values = numbers(word, dimension, &entry.node, param)?;
    let pair = |values: &[f64]| [values[0], values[1]];
    let sampler = match word {
        "uniform" => Sampler::Uniform(pair(&values)),
        "normal" => Sampler::Normal(pair(&values)),
        "log_uniform" => Sampler::LogUniform(pair(&values)),
        _ => Sampler::Choice(values),
    };
    check(&sampler, dimension, &entry.node, param)?;
    Ok(Value::Sampler(sampler))
}

/// The numbers of a distribution: two, or any number for a choice.
fn numbers(word: &str, dimension: Dimension, node: &Node, param: &Param) -> Result<Vec<f64>, Diagnostic> {
    let form = match word {
        "normal" => "[mean, standard deviation]",
        "choice" => "[a, b, ...]",
        _ => "[low, high]",
    };
    let items = match &node.item {
        Item::List(items) if word == "choice" || items.len() == 2 => items,
        Item::List(items) => {
            let error =
                Diagnostic::error("E0103", format!("`{word}` takes two numbers, found {}", items.len()));
            return Err(error.at(node.span, "").help(format!("write `{word} = {form}`")));
        }
        _ => {
            let error =
                Diagnostic::error("E0103", format!("`{word}` takes a list, found {}", node.describe()));
            return Err(error.at(node.span, "not a list").help(format!("write `{word} = {form}`")));
        }
    };
    items.iter().map(|item| scalar::quantity(dimension, item, param).map(|Quantity { si, .. }| si)).collect()
}

/// The checks on a distribution: not empty (E0210), a scale positive (E0211), in range (E0204).
fn check(sampler: &Sampler, dimension: Dimension, node: &Node, param: &Param) -> Result<(), Diagnostic> {
    let empty = |message: String, label: &str, help: &str| {
        Err(Diagnostic::error("E0210", message).at(node.span, label).help(help))
    };
    match bounds::flaw(sampler) {
        None => {}
        Some(Flaw::Swapped) => {
            let swapped = match &node.item {
                Item::List(items) => format!("[{}, {}]", items[1].toml(), items[0].toml()),
                _ => node.toml(),
            };
            let error = Diagnostic::error("E0210", format!("the range of `{}` is empty", param.name));
            let error =
                error.at(node.span, "the lower end is above the upper").fix(node.span, swapped.clone());
            return Err(error.help(format!("swap the ends: `{swapped}`")));
        }
        Some(Flaw::NegativeDeviation) => {
            return empty(
                format!("the standard deviation of `{}` is negative", param.name),
                "the second number",
                "write zero or more",
            );
        }
        Some(Flaw::NoChoice) => {
            return empty(
                format!("the choice of `{}` is empty", param.name),
                "no values to choose from",
                "write at least one value",
            );
        }
        Some(Flaw::NotPositive) => {
            let error = Diagnostic::error("E0211", "a log-uniform range must be positive");
            return Err(error
                .at(node.span, "the lower end is not above zero")
                .help("use `uniform`, or raise the end"));
        }
    }
    let is_normal = matches!(sampler, Sampler::Normal(_));
    let bounds = bounds::reach(sampler);
    let inside = positive_scale(bounds[0], node, param);
    let inside =
        inside.and_then(|()| bounds.iter().try_for_each(|si| scalar::in_range(*si, dimension, node, param)));
    inside.map_err(|error| match is_normal {
        true => {
            let [low, high] = bounds.map(|bound| quantity::print(bound, dimension));
            error.help(format!(
                "3 standard deviations about the mean reach from {low} to {high}: write a smaller one, or \
                 `uniform`"
            ))
        }
        false => error,
    })
}

/// A scale multiplies a physical quantity and must be positive (E0211).
fn positive_scale(low: f64, node: &Node, param: &Param) -> Result<(), Diagnostic> {
    if !bounds::is_scale(param) || low > 0.0 {
        return Ok(());
    }
    let error = Diagnostic::error("E0211", "a scale must be positive")
        .at(node.span, format!("{} is not above zero", quantity::number(low)));
    Err(error.help("a scale multiplies the nominal value: 1 leaves it as it is"))
}
