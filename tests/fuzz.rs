//! Damaged specs: whatever stands in a file, the checker ends soon, takes little memory and says where the
//! mistake is.
//!
//! `cargo test` tries some thousand inputs; `SPECFORGE_FUZZ_INPUTS=5000000 cargo test --release --test fuzz`
//! as many as one likes. Input N is made by the stream `fuzz/N`, so
//! `SPECFORGE_FUZZ_FIRST=N SPECFORGE_FUZZ_INPUTS=1` tries one again.

#[path = "fuzz/mutate.rs"]
mod mutate;

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use specforge::check::{Checked, checked_in};
use specforge::diag::codes::page;
use specforge::diag::render::{Look, github, human, json};
use specforge::spec::LoadOptions;
use specforge::spec::value::canonical_table;
use specforge::stream::Stream;
use specforge::syntax::{Nowhere, Overlay};

/// No input may take longer than this, even on a busy machine and without optimisation.
const PATIENCE: Duration = Duration::from_secs(20);
/// Memory of the whole test, in KiB.
const MEMORY: u64 = 1 << 20;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn number(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

/// The files that are damaged: specs with their parents, a robot, a motion.
const FILES: &[&str] = &[
    "specs/spec.toml",
    "specs/whole.toml",
    "specs/tocabi_walk_torque.toml",
    "specs/atlas_run_position.toml",
    "specs/base/biped.toml",
    "specs/base/task/walk.toml",
    "specs/base/task/run.toml",
    "specs/base/action/torque.toml",
    "specs/base/action/position.toml",
    "specs/motions/walk.toml",
    "robots/tocabi.toml",
];

/// The specs that are checked.
const SPECS: &[&str] = &[
    "specs/spec.toml",
    "specs/whole.toml",
    "specs/tocabi_walk_torque.toml",
    "specs/atlas_run_position.toml",
];

const SMALL: &str = "spec = 1\nname = \"small\"\nextends = \"whole.toml\"\n\n[action]\nkind = \
    \"position\"\nrate = \"250 Hz\"\n\
delay = \"4 ms\"\nservo_rate = \"500 Hz\"\nstiffness = \"25 %\"\nstd = \"1 %\"\n\n[terrain]\nkind = \
\"slope\"\nfriction = 1.0\n\
angle = \"5 deg\"\n\n[randomize.joint_offset]\noffset = { normal = [\"0 rad\", \"1e-3 rad\"] }\njoints = \
[\"*_Knee_Joint\"]\n\n\
[profile.quick]\nlearn.seed = 2\n\n[allow]\nW0501 = \"watched\"\n";

fn text(name: &str) -> String {
    match name {
        "specs/spec.toml" => SMALL.to_owned(),
        "specs/whole.toml" => fs::read_to_string(root().join("tests/language/whole.toml")).expect("readable"),
        name => fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}")),
    }
}

/// One damaged world and what is asked of it.
struct Input {
    files: Overlay<Nowhere>,
    spec: &'static str,
    options: LoadOptions,
    damaged: (&'static str, String),
}

fn input(number: u64, texts: &[(&'static str, String)]) -> Input {
    let mut stream = Stream::new(&format!("fuzz/{number}"));
    let mut files = Overlay::new(Nowhere);
    texts.iter().for_each(|(name, text)| files.hold(Path::new(name), text.as_str()));
    let spec = SPECS[stream.below(SPECS.len())];
    // Most damage is done to the spec itself, where all of it is seen.
    let victim = if stream.below(3) > 0 { spec } else { FILES[stream.below(FILES.len())] };
    let original = &texts.iter().find(|(name, _)| *name == victim).expect("a known file").1;
    let damaged = mutate::damaged(original, &mut stream);
    files.hold(Path::new(victim), damaged.as_str());
    let profile = (stream.below(4) == 0).then(|| ["quick", "desk", "quik"][stream.below(3)].to_owned());
    let sets = (0..stream.below(6) / 4).map(|_| mutate::assignment(original, &mut stream)).collect();
    let options =
        LoadOptions { profile, sets, deny_warnings: stream.below(8) == 0, ..LoadOptions::default() };
    Input { files, spec, options, damaged: (victim, damaged) }
}

/// What holds of every result.
fn hold(checked: &Checked, thoroughly: bool) {
    for diagnostic in &checked.sink.diagnostics {
        assert!(page(diagnostic.code).is_some(), "{} has a page", diagnostic.code);
        assert!(!diagnostic.message.is_empty());
        for span in
            diagnostic.labels.iter().map(|label| label.span).chain(diagnostic.fix.iter().map(|fix| fix.span))
        {
            let text = &checked.sources.get(span.source).text;
            assert!(text.get(span.start..span.end).is_some(), "{diagnostic:?} lies in its text");
        }
    }
    if checked.sink.has_errors() {
        assert!(checked.sound().is_none());
    } else {
        let (experiment, _) = checked.sound().expect("without errors there is an experiment and its robot");
        let canonical = canonical_table(&experiment.table);
        assert!(!canonical.to_string().contains("null"), "every number is finite: {canonical}");
    }
    if thoroughly {
        human(&checked.sources, &checked.sink.diagnostics, Look::default());
        github(&checked.sources, &checked.sink.diagnostics);
        json(&checked.sources, &checked.sink.diagnostics);
    }
}

/// Peak memory of this process in KiB, where the system tells it.
fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?
        .trim()
        .strip_suffix("kB")?
        .trim()
        .parse()
        .ok()
}

#[test]
fn whatever_is_damaged_the_checker_ends_soon_and_says_where() {
    let texts: Vec<(&'static str, String)> = FILES.iter().map(|name| (*name, text(name))).collect();
    let (first, inputs) = (number("SPECFORGE_FUZZ_FIRST", 0), number("SPECFORGE_FUZZ_INPUTS", 2000));
    let (mut slowest, mut wrong, start) = ((Duration::ZERO, first), 0, Instant::now());
    for number in first..first + inputs {
        let input = input(number, &texts);
        let begin = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            let checked = checked_in(&input.files, Path::new(input.spec), &input.options);
            hold(&checked, number % 8 == 0);
            checked.sink.has_errors()
        }));
        let Ok(failed) = outcome else {
            panic!(
                "input {number}: {} {:?}\n{}\n{}",
                input.spec, input.options, input.damaged.0, input.damaged.1
            )
        };
        wrong += u64::from(failed);
        slowest = slowest.max((begin.elapsed(), number));
        assert!(begin.elapsed() < PATIENCE, "input {number} takes {:?}", begin.elapsed());
    }
    let (elapsed, memory) = (start.elapsed(), peak_memory());
    println!(
        "{inputs} inputs, {wrong} with errors, in {elapsed:.1?}; slowest {slowest:?}; peak memory {memory:?} \
         KiB"
    );
    assert!(memory.is_none_or(|memory| memory < MEMORY), "{memory:?} KiB");
    assert!(inputs < 100 || (wrong > inputs / 4 && wrong < inputs), "{wrong} of {inputs} have errors");
}
