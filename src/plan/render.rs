//! Output forms of a plan: a table for people, dot and mermaid for figures, JSON for programs.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::json;

use super::budgets;
use super::draft::TUNED_ENV;
use super::expected::Expected;
use super::fingerprint::Fingerprint;
use super::graph::{Plan, Stage};
use super::stage::StageKind;
use super::why::{Change, State, Status};
use crate::escape::graph;
use crate::escape::terminal::one_line;

/// States of the stages by key.
pub type Statuses = BTreeMap<Fingerprint, Status>;

/// The JSON of `plan --format json`.
pub fn json(plan: &Plan, statuses: &Statuses, expected: &Expected) -> serde_json::Value {
    let stages = plan.stages().map(|stage| {
        let status = &statuses[&stage.fingerprint];
        let inputs: Vec<_> = plan.inputs(stage).iter().map(|(input, _)| input.fingerprint.as_str()).collect();
        json!({
            "key": stage.fingerprint,
            "kind": stage.kind,
            "name": plan.label(stage),
            "inputs": inputs,
            "state": status.state,
            "expected_cpu_s": expected.seconds.get(&stage.fingerprint),
            "reason": reason_json(status),
            "arms": stage.users.iter().map(|user| user.arm.as_str()).collect::<Vec<_>>(),
        })
    });
    let edges = plan.stages().flat_map(|stage| {
        plan.inputs(stage).into_iter().map(|(input, edge)| {
            json!({"from": input.fingerprint, "to": stage.fingerprint,
                        "artefact": edge.artefact})
        })
    });
    json!({"stages": stages.collect::<Vec<_>>(), "edges": edges.collect::<Vec<_>>()})
}

fn reason_json(status: &Status) -> serde_json::Value {
    if status.state == State::Cached {
        return serde_json::Value::Null;
    }
    json!({"changes": status.changes, "note": status.note})
}

/// The table of `plan`: shared stages, then each arm, then the report.
pub fn text(plan: &Plan, statuses: &Statuses, expected: &Expected) -> String {
    let mut out = String::new();
    for (title, stages) in groups(plan) {
        out += &one_line(&title);
        for stage in stages {
            out.push_str(&row(plan, stage, &statuses[&stage.fingerprint], expected));
        }
        out.push('\n');
    }
    out += &budgets::text(plan);
    out += &expected.text();
    out += &one_line(&summary(plan, statuses));
    out
}

fn row(plan: &Plan, stage: &Stage, status: &Status, expected: &Expected) -> String {
    let mut roles: Vec<String> =
        plan.inputs(stage).iter().map(|(from, edge)| taken(from, &edge.role)).collect();
    if roles.len() > 6 {
        roles = vec![format!("{} artefacts", roles.len())];
    }
    let inputs = if roles.is_empty() { String::new() } else { format!("<- {}", roles.join(", ")) };
    let name = stage.name();
    let time = match expected.seconds.is_empty() {
        true => String::new(),
        false => format!("{:>13}  ", expected.time(&stage.fingerprint)),
    };
    let (state, key) = (status.state.name(), stage.fingerprint.short());
    let line = format!("  {name:<20} {state:<8} {key}  {time}{inputs}");
    let mut out = one_line(line.trim_end());
    for reason in reasons(status) {
        out += &one_line(&format!("  {:<20} {reason}", ""));
    }
    out
}

/// The name of an input: its role, or its stage's name if a fine-tuning replaces the training.
fn taken(from: &Stage, role: &str) -> String {
    let tuned = from.kind == StageKind::FineTune || from.name() == TUNED_ENV;
    if tuned { from.name().to_owned() } else { role.to_owned() }
}

/// Stages under the titles of the text form, in the plan's order.
fn groups(plan: &Plan) -> Vec<(String, Vec<&Stage>)> {
    /// Largest number of arms that a title names.
    const NAMED: usize = 6;
    let mut groups: Vec<(String, Vec<&Stage>)> = Vec::new();
    let mut places: BTreeMap<Vec<&str>, usize> = BTreeMap::new();
    for stage in plan.stages() {
        let mut arms: Vec<&str> = stage.users.iter().map(|user| user.arm.as_str()).collect();
        arms.dedup();
        let title = match arms.as_slice() {
            [arm] => (*arm).to_owned(),
            [first, .., last] if arms.len() > NAMED => {
                format!("shared by {} from {first} to {last}", arms.len())
            }
            several => format!("shared by {}", several.join(", ")),
        };
        // The arms of a report are its name, which may be that of an arm.
        let key = if stage.kind == StageKind::Report { Vec::new() } else { arms.clone() };
        let title = if stage.kind == StageKind::Report { format!("report {title}") } else { title };
        if let Some(place) = places.get(&key) {
            groups[*place].1.push(stage);
            continue;
        }
        places.insert(key, groups.len());
        let is_taken = groups.iter().any(|(other, _)| *other == title);
        let title = if is_taken { format!("shared by {}", arms.join(", ")) } else { title };
        groups.push((title, vec![stage]));
    }
    groups
}

/// All stages by state, in one line.
pub fn summary(plan: &Plan, statuses: &Statuses) -> String {
    let count = |state| statuses.values().filter(|status| status.state == state).count();
    let all = plan.stages().len();
    let (cached, changed, missing) = (count(State::Cached), count(State::Changed), count(State::Missing));
    format!("{all} stages: {cached} cached, {changed} changed, {missing} missing")
}

/// The reasons of a state, one line each; at most four.
pub fn reasons(status: &Status) -> Vec<String> {
    const SHOWN: usize = 4;
    let mut lines: Vec<String> = status.changes.iter().take(SHOWN).map(change).collect();
    if status.changes.len() > SHOWN {
        lines.push(format!("and {} more; see `specforge why`", status.changes.len() - SHOWN));
    }
    lines.extend(status.note.iter().filter(|_| status.state != State::Cached).cloned());
    lines
}

/// A change in one line.
pub fn change(change: &Change) -> String {
    let value = |value: &Option<String>| value.clone().unwrap_or_else(|| "(absent)".into());
    let through = if change.through.is_empty() {
        String::new()
    } else {
        format!(", through {}", change.through.join(" <- "))
    };
    format!("{}: {} -> {}{through}", change.field, value(&change.from), value(&change.to))
}

/// The graph in Graphviz' dot language.
pub fn dot(plan: &Plan, statuses: &Statuses) -> String {
    let mut out = String::from(
        "digraph plan {\n  rankdir=LR;\n  node [shape=box, style=\"rounded,filled\", \
         fontname=\"sans-serif\"];\n",
    );
    for stage in plan.stages() {
        let state = statuses[&stage.fingerprint].state;
        let color = match state {
            State::Cached => "#d5e8d4",
            State::Changed => "#ffe6a8",
            State::Missing => "#f5f5f5",
        };
        let (key, label) = (stage.fingerprint.short(), graph::dot(&plan.label(stage)));
        let _ = writeln!(out, "  \"{key}\" [label=\"{label}\\n{}\", fillcolor=\"{color}\"];", state.name());
    }
    for stage in plan.stages() {
        for (input, edge) in plan.inputs(stage) {
            let (from, to) = (input.fingerprint.short(), stage.fingerprint.short());
            let _ = writeln!(out, "  \"{from}\" -> \"{to}\" [label=\"{}\"];", graph::dot(&edge.artefact));
        }
    }
    out.push_str("}\n");
    out
}

/// The graph in Mermaid's language, which GitHub renders in Markdown.
pub fn mermaid(plan: &Plan, statuses: &Statuses) -> String {
    let mut out = String::from("flowchart LR\n");
    for stage in plan.stages() {
        let state = statuses[&stage.fingerprint].state.name();
        let (key, label) = (stage.fingerprint.short(), graph::mermaid(&plan.label(stage)));
        let _ = writeln!(out, "  s{key}[\"{label}<br/>{state}\"]:::{state}");
    }
    for stage in plan.stages() {
        for (input, edge) in plan.inputs(stage) {
            let (from, to) = (input.fingerprint.short(), stage.fingerprint.short());
            let _ = writeln!(out, "  s{from} -->|{}| s{to}", graph::mermaid(&edge.artefact));
        }
    }
    out.push_str("  classDef cached fill:#d5e8d4,stroke:#82b366,color:#000\n");
    out.push_str("  classDef changed fill:#ffe6a8,stroke:#d79b00,color:#000\n");
    out.push_str("  classDef missing fill:#f5f5f5,stroke:#888,color:#000\n");
    out
}
