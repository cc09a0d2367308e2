//! `specforge list [REGISTRY]`: the registries, or the kinds of one.

use serde_json::json;

use super::{Exit, Format, Global, output};
use crate::kinds::reference::{Registry, registries, summary};

/// Arguments of `list`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// A registry such as `reward`; without it, all of them
    #[arg(value_name = "REGISTRY")]
    registry: Option<String>,
}

/// Prints one line per kind.
pub fn run(options: &Options, global: &Global) -> Exit {
    let mut shown = registries();
    if let Some(wanted) = &options.registry {
        let names: Vec<&str> = shown.iter().map(|registry| registry.name).collect();
        if !names.contains(&wanted.as_str()) {
            let advice = format!("the registries are {}", names.join(", "));
            output::complain(global, &format!("there is no registry `{wanted}`"), Some(&advice));
            return Exit::Usage;
        }
        shown.retain(|registry| registry.name == wanted);
    }
    match global.format {
        Format::Json => output::json(&json!(shown.iter().map(json_of).collect::<Vec<_>>())),
        _ => output::data(&shown.iter().map(text_of).collect::<Vec<_>>().join("\n")),
    }
    Exit::Ok
}

fn text_of(registry: &Registry) -> String {
    let mut text = format!("{} {}: {}\n", registry.name, registry.place, registry.summary);
    for kind in &registry.kinds {
        text += &format!("  {:<24} {}\n", kind.name, summary(kind));
    }
    text
}

fn json_of(registry: &Registry) -> serde_json::Value {
    let kinds: Vec<_> = registry
        .kinds
        .iter()
        .map(|kind| {
            let keys: Vec<&str> = kind.params.iter().map(|param| param.name).collect();
            json!({ "name": kind.name, "since": kind.since.0, "summary": summary(kind), "keys": keys })
        })
        .collect();
    json!({ "registry": registry.name, "place": registry.place, "summary": registry.summary, "kinds": kinds })
}
