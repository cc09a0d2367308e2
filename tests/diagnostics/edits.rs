//! The mistakes of `docs/reference/diagnostics.md`.

/// A mistake and what must be said to it.
pub struct Edit {
    /// What was done, in a few words.
    pub title: &'static str,
    /// Why someone does it.
    pub why: &'static str,
    /// The changes by file: what stood there (nothing: added at the end) and what stands there now.
    pub changes: &'static [(&'static str, &'static [(&'static str, &'static str)])],
    /// The arguments of `specforge`.
    pub command: &'static str,
    /// The codes, one for each error.
    pub codes: &'static [&'static str],
}

const SPEC: &str = "specs/tocabi_walk_torque.toml";
const CHECK: &str = "check specs/tocabi_walk_torque.toml";
const GRAVITY: &str = "specs/paper/paper_pretraining.toml";
const CHECK_GRAVITY: &str = "check specs/paper/paper_pretraining.toml";
const GAINS: &str = "specs/paper/paper_exp1.toml";
const CHECK_GAINS: &str = "check specs/paper/paper_exp1.toml";
const SQUATS: &str = "specs/studies/squatting.toml";
const CHECK_SQUATS: &str = "check specs/studies/squatting.toml";
const MOTORS: &str = "specs/studies/motor_speed.toml";
const CHECK_MOTORS: &str = "check specs/studies/motor_speed.toml";

/// The mistakes.
pub const EDITS: &[Edit] = &[
    Edit {
        title: "A number without a unit",
        why: "Most configuration files take bare numbers, so a delay is written as in them.",
        changes: &[(SPEC, &[("", "\n[action]\ndelay = 0.004\n")])],
        command: CHECK,
        codes: &["E0201"],
    },
    Edit {
        title: "A unit of something else",
        why: "The base shall not tilt, and a limit on the tilting speed is written for it.",
        changes: &[(SPEC, &[("", "\n[terminate.base_tilt]\nabove = \"1 rad/s\"\n")])],
        command: CHECK,
        codes: &["E0203"],
    },
    Edit {
        title: "Degrees for radians",
        why: "The number was thought of in degrees.",
        changes: &[(SPEC, &[("", "\n[terminate.base_tilt]\nabove = \"57 rad\"\n")])],
        command: CHECK,
        codes: &["E0204"],
    },
    Edit {
        title: "A percentage without its sign",
        why: "An exploration of 10 %, written as a plain 10.",
        changes: &[(SPEC, &[("", "\n[action]\nstd = 10\n")])],
        command: CHECK,
        codes: &["E0201"],
    },
    Edit {
        title: "A string without quotes",
        why: "YAML does not ask for them.",
        changes: &[(SPEC, &[("", "\n[action]\ndelay = 4 ms\n")])],
        command: CHECK,
        codes: &["E0001"],
    },
    Edit {
        title: "A key twice",
        why: "Two trials were left in the file.",
        changes: &[(SPEC, &[("", "\n[learn]\nseed = 1\nepochs = 4\nseed = 2\n")])],
        command: CHECK,
        codes: &["E0104"],
    },
    Edit {
        title: "The wrong type",
        why: "Switches of other tools are `on` and `off`.",
        changes: &[(SPEC, &[("", "\n[action]\nphase_modulation = \"off\"\n")])],
        command: CHECK,
        codes: &["E0103"],
    },
    Edit {
        title: "A misspelt key",
        why: "A typing error.",
        changes: &[(SPEC, &[("", "\n[learn]\nlearning_rtae = 1e-4\n")])],
        command: CHECK,
        codes: &["E0102"],
    },
    Edit {
        title: "A misspelt joint in a selector",
        why: "The names of joints are long.",
        changes: &[(
            SPEC,
            &[(
                "",
                "\n[randomize.joint_offset]\noffset = { uniform = [\"-1 deg\", \"1 deg\"] }\njoints = \
                 [\"L_Kne_Joint\"]\n",
            )],
        )],
        command: CHECK,
        codes: &["E0402"],
    },
    Edit {
        title: "A key of another reward",
        why: "Most rewards have a sharpness `k`; the contact schedule is either met or not.",
        changes: &[(SPEC, &[("", "\n[reward.contact_schedule]\nk = \"4 /rad^2\"\n")])],
        command: CHECK,
        codes: &["E0105"],
    },
    Edit {
        title: "A rate that does not divide",
        why: "A round number for the policy's rate.",
        changes: &[(SPEC, &[("", "\n[action]\nrate = \"300 Hz\"\n")])],
        command: CHECK,
        codes: &["E0501"],
    },
    Edit {
        title: "Gains in a torque spec",
        why: "A PD controller's gain was tuned before and is kept.",
        changes: &[(SPEC, &[("", "\n[action]\nstiffness = \"50 %\"\n")])],
        command: CHECK,
        codes: &["E0503"],
    },
    Edit {
        title: "From torque to position by one word",
        why: "The kind was changed, and what the new kind needs was not written.",
        changes: &[(SPEC, &[("", "\n[action]\nkind = \"position\"\n")])],
        command: CHECK,
        codes: &["E0504"],
    },
    Edit {
        title: "A delay longer than the history",
        why: "80 ms are below the 100 ms that are kept, but the delay is randomized.",
        changes: &[(SPEC, &[("", "\n[action]\ndelay = \"80 ms\"\n")])],
        command: CHECK,
        codes: &["E0505"],
    },
    Edit {
        title: "A scale that goes negative",
        why: "A range of plus and minus was written where a factor is meant.",
        changes: &[(SPEC, &[("", "\n[randomize.link_mass]\nscale = { uniform = [-0.4, 0.4] }\n")])],
        command: CHECK,
        codes: &["E0211"],
    },
    Edit {
        title: "An unknown robot",
        why: "A typing error.",
        changes: &[(SPEC, &[("\"tocabi\"", "\"tocabbi\"")])],
        command: CHECK,
        codes: &["E0401"],
    },
    Edit {
        title: "An engine in capitals",
        why: "The project writes its name so.",
        changes: &[(SPEC, &[("", "\n[physics]\nengine = \"MuJoCo\"\n")])],
        command: CHECK,
        codes: &["E0106"],
    },
    Edit {
        title: "A term switched off by the wrong name",
        why: "The reward is called `torque`.",
        changes: &[(SPEC, &[("", "\n[reward.torques]\nenabled = false\n")])],
        command: CHECK,
        codes: &["E0605"],
    },
    Edit {
        title: "A missing parent",
        why: "The file was renamed.",
        changes: &[(SPEC, &[("base/action/torque.toml", "base/torques.toml")])],
        command: CHECK,
        codes: &["E0601"],
    },
    Edit {
        title: "Parents in a circle",
        why: "The common parent was made to extend one of its children.",
        changes: &[(
            "specs/base/biped.toml",
            &[("\"budget/small.toml\"", "[\"budget/small.toml\", \"task/walk.toml\"]")],
        )],
        command: CHECK,
        codes: &["E0602"],
    },
    Edit {
        title: "A misspelt profile",
        why: "A typing error.",
        changes: &[],
        command: "check specs/tocabi_walk_torque.toml --profile quikc",
        codes: &["E0706"],
    },
    Edit {
        title: "A profile's rate against the file's",
        why: "The profile `quick` lowers the rate of the physics; the spec now asks for more.",
        changes: &[(SPEC, &[("", "\n[profile.quick]\naction.rate = \"200 Hz\"\n")])],
        command: "check specs/tocabi_walk_torque.toml --profile quick",
        codes: &["E0501"],
    },
    Edit {
        title: "An assignment to nothing",
        why: "A letter is missing on the command line.",
        changes: &[],
        command: "check specs/tocabi_walk_torque.toml --set \"learn.sample=2 M\"",
        codes: &["E0604"],
    },
    Edit {
        title: "A parent that is run",
        why: "It looks like a spec.",
        changes: &[],
        command: "run specs/base/task/walk.toml --dry-run",
        codes: &["E0606"],
    },
    Edit {
        title: "A template with an undefined variable",
        why: "The report's template was copied and changed.",
        changes: &[
            (SPEC, &[("[report]\n", "[report]\ntemplate = \"short.md.j2\"\n")]),
            ("templates/short.md.j2", &[("", "# {{ nmae }}\n\n{{ summary }}\n")]),
        ],
        command: CHECK,
        codes: &["E0902"],
    },
    Edit {
        title: "An excluded point that is no longer there",
        why: "The point `1 %` was dropped from the axis, and the `exclude` that names it was forgotten.",
        changes: &[(
            GAINS,
            &[
                (
                    "values = [\"1 %\", \"0.5 %\", \"0.25 %\", \"0.125 %\"]\n",
                    "values = [\"0.5 %\", \"0.25 %\", \"0.125 %\"]\n\n[[sweep.exclude]]\nstiffness = \"12.5 \
                     %\"\nstd       = [\"1 %\", \"0.5 %\"]\n",
                ),
                ("\"stiffness=50 %,std=1 %\"", "\"stiffness=50 %,std=0.5 %\""),
            ],
        )],
        command: CHECK_GAINS,
        codes: &["E0702"],
    },
    Edit {
        title: "A claim on an arm that was renamed",
        why: "The point got a shorter name; one claim was changed with it, the others were not.",
        changes: &[(
            GRAVITY,
            &[
                ("torque_pretrained   = {", "pretrained          = {"),
                (
                    "compare   = { a = \"control=torque_pretrained\"",
                    "compare   = { a = \"control=pretrained\"",
                ),
            ],
        )],
        command: CHECK_GRAVITY,
        codes: &["E0803", "E0803"],
    },
    Edit {
        title: "A claim over a metric that no stage produces",
        why: "The error of the joints is measured by an evaluation, not by the learning.",
        changes: &[(SQUATS, &[("\"deploy.mujoco.joint_error\"", "\"learn.joint_error\"")])],
        command: CHECK_SQUATS,
        codes: &["E0804"],
    },
    Edit {
        title: "Too few seeds for the test",
        why: "Three seeds are enough for the test that a claim has by default, not for one by ranks.",
        changes: &[(
            MOTORS,
            &[("expect  = \"a < b\"\n", "expect  = \"a < b\"\ntest    = \"mann_whitney\"\n")],
        )],
        command: CHECK_MOTORS,
        codes: &["E0805"],
    },
    Edit {
        title: "Two axes that set one path",
        why: "One exploration was to belong to each stiffness, and the axis of explorations stayed.",
        changes: &[(
            GAINS,
            &[
                (
                    "path   = \"action.stiffness\"\nvalues = [\"100 %\", \"50 %\", \"25 %\", \"12.5 %\"]\n",
                    "\"100 %\" = { action.stiffness = \"100 %\", action.std = \"1 %\" }\n\"50 %\"  = \
                     { action.stiffness = \"50 %\", action.std = \"0.5 %\" }\n",
                ),
                (
                    "stiffness = [\"25 %\", \"12.5 %\"]\nseeds     = [2, 3]\n",
                    "stiffness = \"50 %\"\nseeds     = 3\n",
                ),
            ],
        )],
        command: CHECK_GAINS,
        codes: &["E0704"],
    },
];
