//! Single mistakes: what is written over `tests/language/whole.toml`, and the code that it must give.

/// A mistake, as one or several assignments that belong together.
pub struct Mistake {
    /// The assignments: a dotted path and a TOML value.
    pub lines: &'static [(&'static str, &'static str)],
    /// The code where it stands in a file, in a parent or in a profile.
    pub code: &'static str,
    /// The code where it is made with `--set`.
    pub set: &'static str,
}

const fn one(line: &'static [(&'static str, &'static str)], code: &'static str) -> Mistake {
    Mistake { lines: line, code, set: code }
}

/// A path that does not exist is E0102 or E0301 in a file and E0604 on the command line.
const fn path(line: &'static [(&'static str, &'static str)], code: &'static str) -> Mistake {
    Mistake { lines: line, code, set: "E0604" }
}

/// One mistake each.
pub const MISTAKES: &[Mistake] = &[
    // Files.
    one(&[("report.compare", "[\"wohle.toml\"]")], "E0004"),
    // Keys and types.
    one(&[("terrain.kind", "\"slope\"")], "E0101"),
    one(&[("terminate.base_tilt", "{}")], "E0101"),
    one(&[("reward.speed", "{ kind = \"velocity_tracking\" }")], "E0101"),
    one(&[("deploy.mujoco", "{ kind = \"transfer\" }")], "E0101"),
    one(&[("task.kind", "\"stand\"")], "E0101"),
    path(&[("action.delai", "\"4 ms\"")], "E0102"),
    path(&[("obsrve.phase.enabled", "true")], "E0102"),
    path(&[("learn.policy.hiden", "[64, 64]")], "E0102"),
    path(&[("task.command.evry", "\"4 s\"")], "E0102"),
    one(&[("randomize.link_mass.scale", "{ unifrom = [0.6, 1.4] }")], "E0102"),
    one(&[("action.phase_modulation", "\"yes\"")], "E0103"),
    one(&[("learn.epochs", "2.5")], "E0103"),
    one(&[("learn.seed", "2026-01-01")], "E0103"),
    one(&[("learn.samples", "\"1.23456789 M\"")], "E0103"),
    one(&[("learn.learning_rate", "{ linear = [] }")], "E0103"),
    one(&[("learn.learning_rate", "{ linear = [5e-5, 1e-5, 1e-6] }")], "E0103"),
    one(&[("pretrain", "{ kind = \"gravity_compensation\", tilt_noise = [] }")], "E0103"),
    one(&[("pretrain", "{ kind = \"tracking\", tilt_noise = [\"1 deg\"] }")], "E0103"),
    one(&[("pretrain", "{ kind = \"tracking\", learning_rate = [1e-3] }")], "E0103"),
    one(&[("observe.base_orientation.scale", "[]")], "E0103"),
    one(&[("observe.base_orientation.scale", "[\"0.1 rad\", \"0.1 rad\"]")], "E0103"),
    one(&[("observe.joint_position.scale", "[]")], "E0103"),
    one(&[("observe.joint_velocity.scale", "[\"1 rad/s\", \"2 rad/s\"]")], "E0103"),
    one(&[("evaluate.grid", "{ kind = \"speeds\", speeds = [] }")], "E0103"),
    one(&[("evaluate.sets", "{ kind = \"parameter_sets\", sets = 8, scale = [0.9] }")], "E0103"),
    one(&[("initial.phases", "0.5")], "E0103"),
    one(&[("initial.phases", "[0.0, \"half\"]")], "E0103"),
    one(&[("learn.policy.hidden", "[256, \"many\"]")], "E0103"),
    one(&[("randomize.link_mass.scale", "{ uniform = [0.6, 1.0, 1.4] }")], "E0103"),
    one(&[("randomize.link_mass.scale", "{ uniform = 0.6 }")], "E0103"),
    one(&[("randomize.link_mass.scale", "{ uniform = [0.6, 1.4], choice = [1.0] }")], "E0103"),
    one(&[("observe.joint_position.enabled", "\"no\"")], "E0103"),
    one(&[("observe.phase", "true")], "E0103"),
    one(&[("observe", "[\"phase\"]")], "E0103"),
    one(&[("task", "\"walk\"")], "E0103"),
    one(&[("task.command", "\"0.2 m/s\"")], "E0103"),
    one(&[("action.delay", "{ uniform = [\"2 ms\", \"6 ms\"] }")], "E0103"),
    one(&[("action.delay", "\"four ms\"")], "E0103"),
    one(&[("report.compare", "\"whole.toml\"")], "E0103"),
    one(&[("terrain.kind", "1")], "E0103"),
    one(&[("terrain.amplitude", "\"2 cm\"")], "E0105"),
    one(&[("physics.engine", "\"rapir\"")], "E0106"),
    one(&[("randomize.link_mass.per", "\"links\"")], "E0106"),
    one(&[("learn.policy.activation", "\"relo\"")], "E0106"),
    one(&[("allow.W0501", "\"\"")], "E0108"),
    one(&[("observe.fast", "{ kind = \"joint_velocity\" }")], "E0104"),
    one(&[("evaluate", "{ \"a.b\" = { kind = \"episodes\" } }")], "E0107"),
    one(&[("reward", "{ \"\" = { kind = \"torque\", weight = 0.1, k = \"0.01 /N/m\" } }")], "E0107"),
    // Quantities.
    one(&[("action.delay", "0.004")], "E0201"),
    one(&[("action.delay", "\"0.004\"")], "E0201"),
    one(&[("action.std", "0.1")], "E0201"),
    one(&[("action.std", "\"NaN %\"")], "E0103"),
    one(&[("task.command.speed", "{ uniform = [0.0, 0.5] }")], "E0201"),
    one(&[("action.delay", "\"4 sec\"")], "E0202"),
    one(&[("robot.payload", "\"3 lb\"")], "E0202"),
    one(&[("robot.joint_damping", "0.22")], "E0201"),
    one(&[("robot.joint_damping", "\"0.22 N*m\"")], "E0203"),
    one(&[("robot.joint_damping", "\"-1 N*m*s/rad\"")], "E0204"),
    one(&[("reward.torque.k", "\"0.01 /N m\"")], "E0202"),
    one(&[("learn.samples", "\"2 X\"")], "E0202"),
    one(&[("action.delay", "\"4 m\"")], "E0203"),
    one(&[("action.std", "\"10 N\"")], "E0203"),
    one(&[("terminate.base_tilt.above", "\"0.8 rad/s\"")], "E0203"),
    one(&[("observe.joint_velocity.low_pass", "\"4 rad/s\"")], "E0203"),
    one(&[("evaluate.nominal.command.speed", "\"0.2 m\"")], "E0203"),
    one(&[("physics.rate", "\"-500 Hz\"")], "E0204"),
    one(&[("learn.gamma", "1.5")], "E0204"),
    one(&[("learn.learning_rate", "-1e-4")], "E0204"),
    one(&[("learn.learning_rate", "1e9")], "E0204"),
    one(&[("learn.samples", "\"-1 M\"")], "E0204"),
    one(&[("learn.samples", "\"99999999999 M\"")], "E0204"),
    one(&[("learn.seed", "18446744073709551615")], "E0204"),
    one(&[("action.std", "\"0 %\"")], "E0204"),
    one(&[("observe.joint_position.scale", "[\"0 rad\"]")], "E0204"),
    one(&[("pretrain", "{ kind = \"tracking\", tilt_noise = [\"0 rad\", \"0 rad\", \"-1 deg\"] }")], "E0204"),
    one(&[("randomize.payload.mass", "{ normal = [\"3 kg\", \"2 kg\"] }")], "E0204"),
    one(&[("learn.samples", "-5")], "E0204"),
    one(&[("evaluate.nominal.episodes", "0")], "E0204"),
    one(&[("reward.torque.weight", "inf")], "E0205"),
    one(&[("reward.torque.weight", "nan")], "E0205"),
    one(&[("action.delay", "\"1e999 s\"")], "E0205"),
    one(&[("task.command.speed", "{ uniform = [\"0.5 m/s\", \"0 m/s\"] }")], "E0210"),
    one(&[("task.command.speed", "{ choice = [] }")], "E0210"),
    one(&[("observe.joint_position.noise", "{ normal = [\"0 rad\", \"-1e-4 rad\"] }")], "E0210"),
    one(&[("randomize.link_mass.scale", "{ uniform = [-0.4, 1.4] }")], "E0211"),
    one(&[("randomize.link_mass.scale", "{ log_uniform = [0.0, 1.4] }")], "E0211"),
    one(&[("randomize.link_mass.scale", "{ normal = [1.0, 0.5] }")], "E0211"),
    one(&[("evaluate.sets", "{ kind = \"parameter_sets\", sets = 8, scale = [1.0, 1.0] }")], "E0210"),
    // Kinds and signals.
    one(&[("action.kind", "\"torqe\"")], "E0301"),
    one(&[("terrain.kind", "\"stairs\"")], "E0301"),
    one(&[("initial.kind", "\"referense\"")], "E0301"),
    path(&[("reward.torqe.weight", "0.05")], "E0301"),
    path(&[("terminate.fell", "{}")], "E0301"),
    one(&[("task", "{ kind = \"stand\", motion = \"walk\", episode = \"16 s\" }")], "E0303"),
    one(&[("task.motion", "\"wakl\"")], "E0304"),
    // Robots.
    one(&[("robot.model", "\"atlass\"")], "E0401"),
    one(
        &[
            ("randomize.joint_offset.offset", "\"0.01 rad\""),
            ("randomize.joint_offset.joints", "[\"L_Kne_Joint\"]"),
        ],
        "E0402",
    ),
    // Rates and control.
    one(&[("action.rate", "\"300 Hz\"")], "E0501"),
    one(&[("action.rate", "\"1000 Hz\"")], "E0501"),
    one(&[("physics.rate", "\"400 Hz\"")], "E0501"),
    one(
        &[
            ("deploy.mujoco.kind", "\"transfer\""),
            ("deploy.mujoco.engine", "\"mujoco\""),
            ("deploy.mujoco.rate", "\"600 Hz\""),
            ("deploy.mujoco.episodes", "8"),
            ("deploy.policy.kind", "\"export\""),
        ],
        "E0501",
    ),
    one(
        &[
            ("deploy.mujoco.kind", "\"transfer\""),
            ("deploy.mujoco.engine", "\"mujoco\""),
            ("deploy.mujoco.rate", "\"500 Hz\""),
        ],
        "E0802",
    ),
    one(&[("action.stiffness", "\"50 %\"")], "E0503"),
    one(&[("action.kind", "\"position\"")], "E0504"),
    one(&[("action.delay", "\"120 ms\"")], "E0204"),
    one(
        &[("action.delay", "\"80 ms\""), ("randomize.action_delay", "{ scale = { uniform = [0.5, 1.5] } }")],
        "E0505",
    ),
    one(&[("task.episode", "\"16.001 s\"")], "E0506"),
    one(&[("task.episode", "\"16.001 s\"")], "E0506"),
    one(&[("task.command.every", "\"4.001 s\"")], "E0506"),
    one(
        &[("evaluate.grid", "{ kind = \"speeds\", from = \"0 m/s\", to = \"1 m/s\", step = \"0.3 m/s\" }")],
        "E0508",
    ),
    one(&[("learn.environments", "60")], "E0507"),
    one(&[("learn.minibatch", "\"20 k\"")], "E0507"),
    // Overrides.
    one(&[("robot.mass", "\"3 kg\"")], "E0603"),
    one(&[("learn.updates", "100")], "E0603"),
    one(&[("reward.torques.enabled", "false")], "E0605"),
];

/// Whole files with one mistake that is no assignment.
pub const TEXTS: &[(&str, &str)] = &[
    ("spec = 1\nname = \"a\nextends = \"whole.toml\"\n", "E0001"),
    ("spec = 1\nextends = \"whole.toml\"\n[action\nrate = \"1 Hz\"\n", "E0001"),
    ("spec = 1\nextends = \"whole.toml\"\n[learn]\nseed = \n", "E0001"),
    ("extends = \"whole.toml\"\n", "E0002"),
    ("spec = 2\nextends = \"whole.toml\"\nnonsense = 1\n", "E0003"),
    ("spec = \"1\"\nextends = \"whole.toml\"\n", "E0003"),
    ("spec = 1\nextends = \"whole.toml\"\n[learn]\nseed = 1\nseed = 2\n", "E0104"),
    ("spec = 1\nextends = \"whole.toml\"\n[learn]\nseed = 1\n[learn]\nepochs = 2\nseed = 2\n", "E0104"),
    ("spec = 1\nname = \"a b\"\nextends = \"whole.toml\"\n", "E0107"),
    ("spec = 1\nname = \"\"\nextends = \"whole.toml\"\n", "E0107"),
    ("spec = 1\nname = 3\nextends = \"whole.toml\"\n", "E0103"),
    ("spec = 1\nsummary = [\"a\"]\nextends = \"whole.toml\"\n", "E0103"),
    ("spec = 1\nabstract = \"yes\"\nextends = \"whole.toml\"\n", "E0103"),
    ("spec = 1\nextends = 3\n", "E0103"),
    ("spec = 1\nprofile = 3\nextends = \"whole.toml\"\n", "E0103"),
    ("spec = 1\nextends = \"whole.toml\"\n[profile]\nfast = 3\n", "E0103"),
    ("spec = 1\nextends = \"whole.toml\"\n[profile.fast]\nname = \"other\"\n", "E0102"),
    ("spec = 1\nextends = \"whole.toml\"\n[allow]\nE0101 = \"no\"\n", "E0102"),
    ("spec = 1\nextends = \"whole.toml\"\nallow = 3\n", "E0103"),
    ("spec = 1\nextends = \"whoel.toml\"\n", "E0601"),
    ("spec = 1\nextends = \"whoel.toml\"\n[action]\nkind = \"position\"\n", "E0601"),
    ("spec = 1\nextends = \".\"\n", "E0006"),
    ("spec = 1\nextends = \"spec.toml\"\n", "E0602"),
];
