//! Specs for tests: the recipe of docs/experiments/2026-11-21-small-budget.md, decoded through the
//! registries.

use std::fmt::Write;

use crate::diag::{Sink, Sources};
use crate::env::Blueprint;
use crate::kinds;
use crate::kinds::motion::clip::Clip;
use crate::kinds::motion::{self, Motion};
use crate::robot::Robot;
use crate::robot::tests::robot;
use crate::spec::decode::{Decoder, Registry};
use crate::spec::{Kind, Param, Section, Table, Ty, Value};
use crate::syntax::{Item, Node};

/// The paper's reward table, with the velocity kernel that follows commands.
const REWARD: &str = r#"
[reward]
base_orientation      = { weight = 0.3, k = "13.2 /rad" }
joint_tracking        = { weight = 0.35, k = "4 /rad^2" }
contact_schedule      = { weight = 0.2 }
velocity_tracking     = { weight = 0.3, k = "KERNEL s^2/m^2" }
joint_velocity        = { weight = 0.05, k = "0.01 s^2/rad^2" }
joint_velocity_change = { weight = 0.05, k = "20 s^2/rad^2" }
contact_force         = { weight = 0.1, k = "0.0005 /N" }
contact_force_change  = { weight = 0.1, k = "0.0005 /N" }
torque                = { weight = 0.05, k = "0.01 /N/m" }
torque_change         = { weight = 0.2, k = "0.01 /N/m" }
"#;

const OBSERVE: &str = r#"
[observe.base_orientation]
[observe.joint_position]
noise = { normal = ["0 rad", "1e-4 rad"] }
[observe.joint_velocity]
low_pass = "4 Hz"
[observe.phase]
[observe.command]
"#;

/// A spec that a test may change before decoding.
#[derive(Clone, Debug)]
pub(crate) struct Recipe {
    /// Name of the robot.
    pub robot: &'static str,
    /// Name of the motion file; `None` stands for standing.
    pub motion: Option<&'static str>,
    /// Lines of the `[action]` table other than the rate.
    pub action: String,
    /// Commanded speed as TOML.
    pub speed: &'static str,
    /// k of the velocity kernel.
    pub kernel: f64,
    /// Additional TOML.
    pub more: String,
    /// The `[initial]` table's lines.
    pub initial: String,
    /// `learn.symmetry`.
    pub symmetry: &'static str,
    /// Control rate in Hz.
    pub rate: u32,
}

impl Recipe {
    /// Torque control at 125 Hz on 500 Hz physics, without delay and randomization.
    pub fn new(robot: &'static str, motion: Option<&'static str>) -> Self {
        Self {
            robot,
            motion,
            action: "kind = \"torque\"\nstd = \"10 %\"\n".into(),
            speed: "{ uniform = [\"0.1 m/s\", \"0.3 m/s\"] }",
            kernel: 20.0,
            more: String::new(),
            initial: "kind = \"default_pose\"\nphases = [0.0, 0.5]".into(),
            symmetry: "phase_mirror",
            rate: 125,
        }
    }

    /// The decoded fields.
    pub fn fields(&self) -> Table {
        let mut text = String::from("[physics]\nengine = \"rapier\"\nrate = \"500 Hz\"\n");
        let kind = self.motion.map_or("stand", |motion| motion.split('_').next().unwrap_or(motion));
        write!(
            text,
            "[terrain]\nkind = \"flat\"\nfriction = 1.0\n[task]\nkind = \"{kind}\"\nepisode = \"16 s\"\n"
        )
        .unwrap();
        if let Some(motion) = self.motion {
            writeln!(text, "motion = \"{motion}\"").unwrap();
        }
        if !matches!(kind, "stand" | "squat") {
            writeln!(text, "command = {{ speed = {} }}", self.speed).unwrap();
        }
        write!(text, "[initial]\n{}\n[action]\nrate = \"{} Hz\"\n{}", self.initial, self.rate, self.action)
            .unwrap();
        text += OBSERVE;
        text += &REWARD.replace("KERNEL", &self.kernel.to_string());
        text += &self.more;
        let mut fields = decode(&text);
        let privileged = Table::from([("privileged".into(), Value::Flag(true))]);
        let symmetry = Value::Text(self.symmetry.into());
        let learn = Table::from([("symmetry".into(), symmetry), ("value".into(), Value::Table(privileged))]);
        fields.insert("learn".into(), Value::Table(learn));
        fields
    }

    /// The blueprint.
    pub fn blueprint(&self) -> Blueprint {
        let robot = robot(self.robot);
        let motion = self.motion.map(|name| motion(name, &robot));
        Blueprint::new(self.fields(), robot, motion).unwrap()
    }
}

/// A motion included with specforge, for a robot.
pub(crate) fn motion(name: &str, robot: &Robot) -> Motion {
    let text = motion::embedded(&format!("{name}.toml")).unwrap();
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("motion", text);
    let node = crate::syntax::parse(&sources, source, &mut sink).unwrap();
    let file = crate::spec::decode::kind(&node, &motion::kinds(), &mut sink).unwrap().table;
    let clip = Section::new(&file).value(Clip::file).as_deref().and_then(motion::embedded);
    motion::build(name, Section::new(&file), robot, clip).unwrap()
}

static PHYSICS: [Param; 2] = [
    Param::required("engine", Ty::Text),
    Param::required("rate", Ty::Quantity(crate::quantity::Dimension::RATE)),
];
static WEIGHT: [Param; 1] = [Param::required("weight", Ty::Number)];

/// Decodes the sections of an environment.
fn decode(text: &str) -> Table {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("spec", text);
    let root = crate::syntax::parse(&sources, source, &mut sink).unwrap();
    let Item::Table(map) = &root.item else { unreachable!("a document is a table") };
    let mut fields = Table::new();
    let mut decoder = Decoder::new(&mut sink);
    for (name, entry) in &map.entries {
        let node = &entry.node;
        let table = match name.as_str() {
            "physics" => decoder.plain(node, &PHYSICS, name),
            "terrain" => one(&mut decoder, node, &kinds::terrain::kinds()),
            "task" => one(&mut decoder, node, &kinds::task::kinds()),
            "initial" => one(&mut decoder, node, &kinds::initial::kinds()),
            "action" => one(&mut decoder, node, &kinds::action::kinds()),
            "observe" => terms(&mut decoder, node, &kinds::observe::kinds(), &[]),
            "reward" => terms(&mut decoder, node, &kinds::reward::kinds(), &WEIGHT),
            "terminate" => terms(&mut decoder, node, &kinds::terminate::kinds(), &[]),
            "randomize" => terms(&mut decoder, node, &kinds::randomize::kinds(), &[]),
            other => unreachable!("no section {other}"),
        };
        let table = table.unwrap_or_else(|| panic!("[{name}]: {:?}", decoder.sink));
        fields.insert(name.clone(), Value::Table(table));
    }
    fields
}

fn one(decoder: &mut Decoder, node: &Node, kinds: &[&'static Kind]) -> Option<Table> {
    decoder.of_kind(
        node,
        &Registry { noun: "kind", kinds, extra: &[], reserved: &["kind", "enabled"] },
        "",
        None,
    )
}

fn terms(
    decoder: &mut Decoder,
    node: &Node,
    kinds: &[&'static Kind],
    extra: &'static [Param],
) -> Option<Table> {
    let Item::Table(map) = &node.item else { return None };
    let registry = Registry { noun: "term", kinds, extra, reserved: &["kind", "enabled"] };
    let term = |(name, entry): (&String, &crate::syntax::Entry)| {
        let table = decoder.of_kind(&entry.node, &registry, "", Some((name, entry.key)))?;
        Some((name.clone(), Value::Table(table)))
    };
    map.entries.iter().map(term).collect()
}
