//! The edit of a diagnostic mends the mistake: each is applied to the text, after which the mistake is gone.

use std::fs;
use std::path::Path;

use specforge::check::{Checked, checked_in};
use specforge::diag::Severity;
use specforge::spec::LoadOptions;
use specforge::syntax::{Nowhere, Overlay};

/// A mistake in a spec that extends `whole.toml`, and the text after the edit.
struct Edit {
    code: &'static str,
    wrong: &'static str,
    right: &'static str,
}

const fn edit(code: &'static str, wrong: &'static str, right: &'static str) -> Edit {
    Edit { code, wrong, right }
}

const EDITS: &[Edit] = &[
    // Distributions as other libraries write them.
    edit(
        "E0103",
        "[randomize.m]\nkind = \"link_mass\"\nscale = [0.5, 1.25]",
        "[randomize.m]\nkind = \"link_mass\"\nscale = { uniform = [0.5, 1.25] }",
    ),
    edit(
        "E0102",
        "[randomize.link_mass]\nrange = [0.5, 1.25]",
        "[randomize.link_mass]\nscale = { uniform = [0.5, 1.25] }",
    ),
    edit(
        "E0102",
        "randomize.m = { kind = \"link_mass\", range = [0.5, 1.25] }",
        "randomize.m = { kind = \"link_mass\", scale = { uniform = [0.5, 1.25] } }",
    ),
    edit(
        "E0102",
        "randomize.m = { kind = \"link_mass\", uniform = [0.6, 1.4] }",
        "randomize.m = { kind = \"link_mass\", scale = { uniform = [0.6, 1.4] } }",
    ),
    edit(
        "E0102",
        "randomize.m = { kind = \"link_mass\", scale = { min = 0.6, max = 1.4 } }",
        "randomize.m = { kind = \"link_mass\", scale = { uniform = [0.6, 1.4] } }",
    ),
    edit(
        "E0102",
        "randomize.m = { kind = \"link_mass\", scale = { std = 0.1, mean = 1.0 } }",
        "randomize.m = { kind = \"link_mass\", scale = { normal = [1.0, 0.1] } }",
    ),
    // Flags and counts as other formats write them.
    edit("E0103", "action.phase_modulation = \"yes\"", "action.phase_modulation = true"),
    edit("E0103", "action.phase_modulation = 1", "action.phase_modulation = true"),
    edit("E0103", "reward.torque.enabled = \"off\"", "reward.torque.enabled = false"),
    edit("E0103", "observe.base_orientation = true", "observe.base_orientation = {}"),
    edit("E0103", "observe.phase = false", "observe.phase = { enabled = false }"),
    edit("E0103", "learn.samples = 8e6", "learn.samples = 8000000"),
    edit("E0103", "learn.environments = 64.0", "learn.environments = 64"),
    edit("E0202", "learn.samples = \"200 K\"", "learn.samples = \"200 k\""),
    // Names.
    edit("E0107", "name = \"walk / torque\"", "name = \"walk_torque\""),
    edit(
        "E0107",
        "reward.\"a.b\" = { kind = \"torque\", weight = 0.1, k = \"0.01 /N/m\" }",
        "reward.a_b = { kind = \"torque\", weight = 0.1, k = \"0.01 /N/m\" }",
    ),
    // Numbers that follow from others.
    edit("E0507", "learn.environments = 60", "learn.environments = 32"),
    edit("E0507", "learn.minibatch = \"1 M\"", "learn.minibatch = 16384"),
    edit("W0520", "reward.torque.weight = -0.05", "reward.torque.weight = 0.05"),
    edit(
        "E0210",
        "evaluate.sets = { kind = \"parameter_sets\", sets = 8, scale = [1.3, 0.7] }",
        "evaluate.sets = { kind = \"parameter_sets\", sets = 8, scale = [0.7, 1.3] }",
    ),
    edit(
        "E0204",
        "terminate.base_tilt = { above = \"45 rad\" }",
        "terminate.base_tilt = { above = \"45 deg\" }",
    ),
];

fn check(text: &str) -> Checked {
    let whole = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/language/whole.toml");
    let mut overlay = Overlay::new(Nowhere);
    overlay.hold(Path::new("whole.toml"), fs::read_to_string(whole).expect("whole.toml is readable"));
    overlay.hold(Path::new("spec.toml"), text);
    checked_in(&overlay, Path::new("spec.toml"), &LoadOptions::default())
}

/// A spec that extends `whole.toml`.
fn child(lines: &str) -> String {
    let name = if lines.starts_with("name") { "" } else { "name = \"a\"\n" };
    format!("spec = 1\n{name}extends = \"whole.toml\"\n{lines}\n")
}

#[test]
fn every_edit_mends_its_mistake() {
    let mut wrong = Vec::new();
    for Edit { code, wrong: lines, right } in EDITS {
        let text = child(lines);
        let checked = check(&text);
        let errors = checked
            .sink
            .diagnostics
            .iter()
            .filter(|found| found.severity == Severity::Error || found.code == *code);
        let [found] = errors.collect::<Vec<_>>()[..] else {
            wrong.push(format!("{lines}: {:#?}", checked.sink.diagnostics));
            continue;
        };
        let Some(fix) = found.fix.as_ref().filter(|_| found.code == *code) else {
            wrong.push(format!("{lines}: {found:#?}"));
            continue;
        };
        let mut edited = text.clone();
        edited.replace_range(fix.span.start..fix.span.end, &fix.replacement);
        if edited != child(right) {
            wrong.push(format!("{lines} became\n{edited}"));
        }
        let left = check(&edited).sink.diagnostics;
        if left.iter().any(|found| found.severity == Severity::Error || found.code == *code) {
            wrong.push(format!("{right}: {left:#?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
