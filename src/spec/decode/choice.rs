//! Values of one of several types: the first type that matches the TOML value.

use crate::diag::Diagnostic;
use crate::quantity::parse::looks_like_quantity;
use crate::quantity::relative;
use crate::spec::{Param, Presence, Sampler, Ty};
use crate::syntax::{Item, Node};

/// The type to decode a value as: the first strict match, else a table with one of its keys, else the first
/// loose match.
pub fn pick<'t>(types: &'t [Ty], node: &Node) -> Option<&'t Ty> {
    let first = |fits: &dyn Fn(&Ty) -> bool| types.iter().find(|ty| fits(ty));
    first(&|ty| fits(ty, node, true))
        .or_else(|| first(&|ty| knows(ty, node)))
        .or_else(|| first(&|ty| fits(ty, node, false)))
}

/// Whether a type is a table with one of the keys present.
fn knows(ty: &Ty, node: &Node) -> bool {
    match (ty, node.table()) {
        (Ty::Table(params), Some(map)) => params.iter().any(|param| map.get(param.name).is_some()),
        _ => false,
    }
}

/// Whether a value has the shape of a type: strictly, or only the same sort of TOML value.
fn fits(ty: &Ty, node: &Node, strictly: bool) -> bool {
    match (ty, &node.item) {
        (Ty::Flag, Item::Flag(_)) | (Ty::Number, Item::Number(_)) => true,
        (Ty::Count, Item::Number(number)) => !strictly || number.whole.is_some(),
        (Ty::Quantity(_) | Ty::Ratio(_), Item::Number(_)) => !strictly,
        (Ty::Sampler(dimension), Item::Number(_)) => !strictly || dimension.unit().is_empty(),
        (Ty::Ratio(share), Item::Text(text)) => {
            let has_its_unit = text.contains('%') || share.measure.is_some() && text.contains(relative::WORD);
            looks_like_quantity(text) && (!strictly || has_its_unit)
        }
        (Ty::Quantity(_) | Ty::Sampler(_) | Ty::Count, Item::Text(text)) => looks_like_quantity(text),
        (Ty::Choice(words), Item::Text(text)) => !strictly || words.contains(&text.as_str()),
        (Ty::Text, Item::Text(_)) => true,
        (Ty::Sampler(_), Item::Table(map)) => Sampler::WORDS.iter().any(|word| map.get(word).is_some()),
        (Ty::Table(params), Item::Table(map)) => {
            let required = |param: &&Param| matches!(param.presence, Presence::Required);
            let mut known = params.iter().map(|param| param.name);
            !strictly
                || (params.iter().filter(required).all(|param| map.get(param.name).is_some())
                    && (map.entries.is_empty() || known.any(|name| map.get(name).is_some())))
        }
        (Ty::Named(_) | Ty::Kind(_) | Ty::Terms(_), Item::Table(_)) => true,
        (Ty::List(ty), Item::List(items)) => !strictly || items.iter().all(|item| fits(ty, item, true)),
        (Ty::OneOf(types), _) => types.iter().any(|ty| fits(ty, node, strictly)),
        _ => false,
    }
}

/// E0103 for a value that fits none of the types.
pub fn mismatch(types: &[Ty], node: &Node, key: &str) -> Diagnostic {
    let expected = types.iter().map(describe).collect::<Vec<_>>().join(" or ");
    let message = format!("`{key}` takes {expected}, found {}", node.describe());
    let error = Diagnostic::error("E0103", message).at(node.span, "wrong type");
    match types {
        [] => error,
        [first, ..] => error.help(format!("write for example `{key} = {}`", example(first))),
    }
}

/// What a type accepts, with an article.
pub fn describe(ty: &Ty) -> String {
    match ty {
        Ty::Flag => "`true` or `false`".to_owned(),
        Ty::Count => "a whole number".to_owned(),
        Ty::Number => "a number".to_owned(),
        Ty::Quantity(dimension) => dimension.name(),
        Ty::Ratio(_) => "a percentage".to_owned(),
        Ty::Text => "a string".to_owned(),
        Ty::Choice(words) => {
            words.iter().map(|word| format!("`\"{word}\"`")).collect::<Vec<_>>().join(" or ")
        }
        Ty::Sampler(dimension) => format!("{} or a distribution", dimension.name()),
        Ty::List(item) => format!("a list ({} each)", describe(item)),
        Ty::Table(params) => {
            let keys = params.iter().filter(|param| matches!(param.presence, Presence::Required));
            let keys: Vec<String> = keys.map(|param| format!("{} = ...", param.name)).collect();
            format!("a table `{{ {} }}`", keys.join(", "))
        }
        Ty::Named(_) => "a table".to_owned(),
        Ty::Kind(_) => "a table `{ kind = ... }`".to_owned(),
        Ty::Terms(kinds) => format!("a table of {}s", kinds.noun),
        Ty::OneOf(types) => types.iter().map(describe).collect::<Vec<_>>().join(" or "),
    }
}

/// The form of a value of a type, for lines to fill in. It is not a valid value, so that a pasted line is a mistake
/// and not a robot or an experiment that nobody meant.
pub fn blank(ty: &Ty) -> String {
    match ty {
        Ty::Flag => "<true or false>".to_owned(),
        Ty::Count | Ty::Number => "<number>".to_owned(),
        Ty::Quantity(dimension) | Ty::Sampler(dimension) if dimension.unit().is_empty() => {
            "<number>".to_owned()
        }
        Ty::Quantity(dimension) | Ty::Sampler(dimension) => format!("\"<number> {}\"", dimension.unit()),
        Ty::Ratio(_) => "\"<number> %\"".to_owned(),
        Ty::Text => "<\"name\">".to_owned(),
        Ty::Choice(words) => format!("\"<{}>\"", words.join(" | ")),
        Ty::List(Ty::Quantity(dimension)) if *dimension == crate::quantity::Dimension::LENGTH => {
            r#"["<x> m", "<y> m", "<z> m"]"#.to_owned()
        }
        Ty::List(item) => format!("[{}, ...]", blank(item)),
        Ty::Table(_) | Ty::Named(_) | Ty::Terms(_) => "{ ... }".to_owned(),
        Ty::Kind(_) => "{ kind = \"<kind>\" }".to_owned(),
        Ty::OneOf(types) => types.first().map_or_else(String::new, blank),
    }
}

/// A value of a type, as TOML, for advice.
pub fn example(ty: &Ty) -> String {
    match ty {
        Ty::Flag => "true".to_owned(),
        Ty::Count | Ty::Number => "1".to_owned(),
        Ty::Quantity(dimension) | Ty::Sampler(dimension) if dimension.unit().is_empty() => "1.0".to_owned(),
        Ty::Quantity(dimension) | Ty::Sampler(dimension) => format!("\"1 {}\"", dimension.unit()),
        Ty::Ratio(_) => "\"10 %\"".to_owned(),
        Ty::Text => "\"...\"".to_owned(),
        Ty::Choice(words) => format!("\"{}\"", words.first().copied().unwrap_or("...")),
        // Every list of lengths is a point or the size of a box.
        Ty::List(Ty::Quantity(dimension)) if *dimension == crate::quantity::Dimension::LENGTH => {
            r#"["0.1 m", "0.05 m", "0.02 m"]"#.to_owned()
        }
        Ty::List(item) => format!("[{}]", example(item)),
        Ty::Table(_) | Ty::Named(_) | Ty::Terms(_) => "{ ... }".to_owned(),
        Ty::Kind(_) => "{ kind = \"...\" }".to_owned(),
        Ty::OneOf(types) => types.first().map_or_else(String::new, example),
    }
}
