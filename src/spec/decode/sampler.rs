//! The sampler type: a plain value, or `{ uniform = [a, b] }`, `{ normal = [mean, std] }`, `{ log_uniform =
//! [a, b] }`, `{ choice = [...] }`.

use super::scalar;
use crate::diag::Diagnostic;
use crate::quantity::{self, Dimension};
use crate::spec::bounds::{self, Flaw};
use crate::spec::suggest::{listed, nearest};
use crate::spec::{Param, Quantity, Sampler, Value};
use crate::syntax::{Item, Map, Node};

/// Decodes a sampler of a dimension. A plain value remains a quantity with its original text.
pub fn decode(dimension: Dimension, node: &Node, param: &Param) -> Result<Value, Diagnostic> {
    if let Item::List(items) = &node.item {
        return Err(without_distribution(items, dimension, node, param));
    }
    let Item::Table(map) = &node.item else {
        let quantity = scalar::quantity(dimension, node, param)?;
        positive_scale(quantity.si, node, param)?;
        scalar::in_range(quantity.si, dimension, node, param)?;
        return Ok(Value::Quantity(quantity));
    };
    if let Some((word, entry)) = map.entries.iter().find(|(word, _)| !Sampler::WORDS.contains(&word.as_str()))
    {
        let error = Diagnostic::error("E0102", format!("unknown distribution `{word}`")).at(entry.key, "");
        if let Some(written) = in_other_words(map).filter(|_| is_inline(map, node)) {
            return Err(error.help(format!("write `{written}`")).fix(node.span, written));
        }
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

/// E0103 for a list without a distribution. Two numbers are taken as the ends of a range.
fn without_distribution(items: &[Node], dimension: Dimension, node: &Node, param: &Param) -> Diagnostic {
    let message = format!("`{}` takes {} or a distribution, found a list", param.name, dimension.name());
    let error = Diagnostic::error("E0103", message).at(node.span, "which distribution?");
    let list = node.toml();
    match items.len() {
        2 => {
            let written = format!("{{ uniform = {list} }}");
            error.help(format!("write `{} = {written}`", param.name)).fix(node.span, written)
        }
        _ => {
            error.help(format!("to draw one of these values, write `{} = {{ choice = {list} }}`", param.name))
        }
    }
}

/// The distribution that two parameters describe in other libraries: `{ min = 0.5, max = 1.25 }`.
fn in_other_words(map: &Map) -> Option<String> {
    const WORDS: [(&str, &str, &str); 6] = [
        ("min", "max", "uniform"),
        ("low", "high", "uniform"),
        ("lower", "upper", "uniform"),
        ("from", "to", "uniform"),
        ("mean", "std", "normal"),
        ("mu", "sigma", "normal"),
    ];
    let of = |(first, second, word): &(&str, &str, &str)| {
        Some(format!("{{ {word} = [{}, {}] }}", map.get(first)?.toml(), map.get(second)?.toml()))
    };
    WORDS.iter().find_map(of).filter(|_| map.entries.len() == 2)
}

/// Whether a table is inline, so that an edit can replace it.
fn is_inline(map: &Map, node: &Node) -> bool {
    let table = node.span;
    map.entries.values().all(|entry| {
        table.source == entry.key.source && table.start < entry.key.start && entry.key.end < table.end
    })
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
                "negative standard deviation",
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
                "three standard deviations around the mean reach from {low} to {high}: lower the standard \
                 deviation, or use `uniform`"
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
    Err(error.help("a scale multiplies the nominal value, so 1 has no effect"))
}
