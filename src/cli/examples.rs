//! The examples at the end of every `--help`. `tests/help.rs` parses each line like the shell and the program
//! would.

/// `check`
pub const CHECK: &str = "\
Examples:
  specforge check specs/atlas_run_torque.toml
  specforge check specs --deny warnings
  specforge check my_run.toml --format github

Exit codes: 0 no errors, 3 errors (with --deny warnings, or warnings).";

/// `show`
pub const SHOW: &str = "\
Examples:
  specforge show specs/atlas_run_torque.toml
  specforge show --origins specs/atlas_run_torque.toml --profile quick
  specforge show --resolved specs/atlas_run_torque.toml --set learn.seed=2
  specforge show --diff specs/atlas_run_torque.toml specs/atlas_run_position.toml

Exit codes: 0 shown (also when two specs differ), 3 the spec has errors.";

/// `plan`
pub const PLAN: &str = "\
Examples:
  specforge plan specs/atlas_run_torque.toml
  specforge plan specs/atlas_run_torque.toml --profile quick --format dot
  specforge plan specs/atlas_run_torque.toml --save plan.json

Exit codes: 0 planned, 3 the spec has errors.";

/// `run`
pub const RUN: &str = "\
Examples:
  specforge run specs/atlas_run_torque.toml --profile quick
  specforge run specs/tocabi_walk_torque.toml --set learn.seed=2 --jobs 2
  specforge run specs/atlas_run_torque.toml --dry-run

Exit codes: 0 done, 3 the spec has errors, 4 a stage failed, 5 a claim failed, 6 interrupted. A claim that \
fails
ends a run with 5 only in a suite with `claims = \"count\"`; otherwise it is a verdict in the report.";

/// `why`
pub const WHY: &str = "\
Examples:
  specforge why specs/atlas_run_torque.toml learner
  specforge why specs/atlas_run_torque.toml learner --set learn.seed=2

Exit codes: 0 answered, 2 unknown stage, 3 the spec has errors.";

/// `bench`
pub const BENCH: &str = "\
Examples:
  specforge bench specs/tocabi_walk_torque.toml --profile quick
  specforge bench specs/tocabi_walk_torque.toml --format json

Exit codes: 0 measured, 3 the spec has errors, 4 the measurement failed.";

/// `evaluate`
pub const EVALUATE: &str = "\
Examples:
  specforge evaluate policy.safetensors
  specforge evaluate specs/atlas_run_torque.toml --profile quick
  specforge evaluate policy.safetensors --engine rapier,mujoco --command 0.1 --command 0.3
  specforge evaluate policy.safetensors --terrain slope,angle=3deg --randomize --noise --episodes 8
  specforge evaluate policy.safetensors --push impulse=60N*s,duration=0.1s,at=6s,direction=90deg
  specforge evaluate policy.safetensors --seed 7 --format json

The same seed, command and engine give the numbers of the report: they do not depend on the threads.

Exit codes: 0 evaluated, 3 no such file or an option has an error, 4 the policy cannot be used or an engine \
is missing,
6 interrupted.";

/// `stage`
pub const STAGE: &str = "\
Examples:
  specforge plan specs/atlas_run_torque.toml --save plan.json
  specforge stage atlas_run_torque/learner --plan plan.json

Exit codes: 0 done, 2 no stage or several match, 4 the stage failed, 6 interrupted.";

/// `cache`
pub const CACHE: &str = "\
Examples:
  specforge cache list
  specforge cache verify
  specforge cache gc --dry-run

Exit codes: 0 in order, 4 an artefact is damaged or cannot be removed.";

/// `list`
pub const LIST: &str = "\
Examples:
  specforge list
  specforge list reward
  specforge list keys --format json

Exit codes: 0 listed, 2 unknown list.";

/// `explain`
pub const EXPLAIN: &str = "\
Examples:
  specforge explain E0203
  specforge explain velocity_tracking
  specforge explain learn.samples
  specforge explain rad/s

Exit codes: 0 explained, 2 unknown word.";

/// `fmt`
pub const FMT: &str = "\
Keys and sections take the order of the registries, `=` and comments are aligned; values and comments keep \
their text.
The rules are in docs/guide/editor.md.

Examples:
  specforge fmt specs robots
  specforge fmt --check specs
  specforge fmt -

Exit codes: 0 everything is in its canonical form now, 3 a file is not TOML or --check found one to rewrite.";

/// `new`
pub const NEW: &str = "\
Examples:
  specforge new my_run.toml
  specforge new specs/g1_walk.toml --robot g1 --task walk --action position
  specforge new alone.toml --standalone
  specforge new weights.toml --suite my_run.toml

Exit codes: 0 written, 2 the file exists, a name is unknown or --suite names no spec that can be varied, 3 \
the robot, the
spec of --suite or what was written has errors, 4 the file cannot be written.";

/// `schema`
pub const SCHEMA: &str = "\
Examples:
  specforge schema
  specforge schema motion
  specforge schema --write specs/schema

Exit codes: 0 printed or written, 4 the folder cannot be written.";

/// `completions`
pub const COMPLETIONS: &str = "\
Examples:
  specforge completions bash > ~/.local/share/bash-completion/completions/specforge
  specforge completions zsh > ~/.zfunc/_specforge
  specforge completions fish > ~/.config/fish/completions/specforge.fish

Exit codes: 0 printed.";

/// `robot`
pub const ROBOT: &str = "\
Examples:
  specforge robot show tocabi
  specforge robot show robots/atlas.toml --format json
  specforge robot show g1 --format urdf
  specforge robot import walker.urdf --joints 'hip|knee|ankle'

Exit codes: 0 done, 2 unknown robot, or the file to write exists, 3 its file or the robot \
has errors.";

/// `report`
pub const REPORT: &str = "\
Examples:
  specforge report specs/atlas_run_torque.toml --profile quick
  specforge report --index
  specforge report --check

Exit codes: 0 rendered, 3 the spec or template has errors, 4 a result is missing from the \
report, a page was changed or the index is out of date.";

/// `trace`
pub const TRACE: &str = "\
Examples:
  specforge trace reports/atlas_run_torque.md
  specforge trace reports/atlas_run_torque/speed.svg

Exit codes: 0 traced, 2 unknown figure or cell.";

/// `doctor`
pub const DOCTOR: &str = "\
Examples:
  specforge doctor
  specforge doctor --format json

Exit codes: 0 nothing is missing, 4 something is.";
