//! The conditions set by the options of `evaluate`. Each option is decoded like the key of a spec that it
//! replaces, with that key's unit, range and messages.

use std::sync::Arc;

use super::Options;
use crate::cli::specs::Findings;
use crate::deploy::{Policy, Transfer};
use crate::diag::{Diagnostic, Sink, Sources, Span};
use crate::env::{Blueprint, BlueprintError, Randomized};
use crate::evaluate::{Condition, Protocol};
use crate::kinds::task::{Task, Walk};
use crate::kinds::{deploy, randomize::push, terrain};
use crate::spec::decode::{self, Decoder, Registry};
use crate::spec::typed::{Declared, Keys, Typed};
use crate::spec::{Param, Section, Table, Value};
use crate::syntax::assign::assignment_of;
use crate::syntax::{Item, Layer, Map, Node};

/// Physics rate in Hz in engines that the policy was not trained in, unless the user names one.
const OTHER_RATE: f64 = 2000.0;

/// What to evaluate.
pub struct Conditions {
    /// One per engine and command.
    pub transfers: Vec<Transfer>,
    /// The protocol shared by all of them, without a command.
    pub protocol: Protocol,
}

/// The policy on the requested ground and the conditions, or all errors in the options.
pub fn read(options: &Options, mut policy: Policy) -> Result<(Policy, Conditions), Box<Findings>> {
    let mut desk = Desk::default();
    if let Some(blueprint) = options.terrain.as_ref().and_then(|text| ground(text, &policy, &mut desk)) {
        policy.blueprint = blueprint;
    }
    let conditions = desk.conditions(options, &policy.blueprint);
    match conditions.filter(|_| !desk.sink.has_errors()) {
        Some(conditions) => Ok((policy, conditions)),
        None => Err(Box::new(Findings::of(desk.sources, desk.sink.diagnostics))),
    }
}

/// The texts of the options and the errors in them.
#[derive(Default)]
struct Desk {
    sources: Sources,
    sink: Sink,
}

impl Desk {
    /// The decoded value of a key of a transfer's table, `engine` or `command.speed`.
    fn value(&mut self, option: &str, path: &str, text: &str) -> Option<Value> {
        let (map, span) = self.assigned(option, &format!("{path}={text}"))?;
        let key = path.split('.').next().unwrap_or(path);
        let params: &'static [Param] = deploy::Transfer::PARAMS;
        let param = params.iter().find(|param| param.name == key).expect("a transfer has the key");
        let node = Node { span, layer: Layer::Set, item: Item::Table(map) };
        decode::table(&node, std::slice::from_ref(param), &mut self.sink)?.table.remove(key)
    }

    fn assigned(&mut self, option: &str, argument: &str) -> Option<(Map, Span)> {
        let map = assignment_of(option, argument, &mut self.sources, &mut self.sink)?;
        let span = map.entries.values().next()?.key;
        Some((map, span))
    }

    fn number(&mut self, option: &str, path: &str, text: &str) -> Option<f64> {
        match self.value(option, path, text)? {
            Value::Quantity(quantity) => Some(quantity.si),
            Value::Count(count) => Some(count as f64),
            Value::Table(table) => f64::read(table.get(path.rsplit('.').next()?)?),
            _ => None,
        }
    }

    fn count(&mut self, option: &str, path: &str, text: &str) -> Option<u64> {
        match self.value(option, path, text)? {
            Value::Count(count) => Some(count),
            _ => None,
        }
    }

    fn conditions(&mut self, options: &Options, blueprint: &Blueprint) -> Option<Conditions> {
        let rate = match &options.rate {
            Some(text) => self.number("--rate", "rate", text).map(Some),
            None => Some(None),
        };
        let episodes = self.count("--episodes", "episodes", &options.episodes);
        let seed = self.count("--seed", "seed", &options.seed);
        let time_limit = match &options.time_limit {
            Some(text) => self.number("--time-limit", "time_limit", text).map(Some),
            None => Some(None),
        };
        let engines = self.engines(options, blueprint);
        let commands = self.commands(options, blueprint);
        let randomized = match &options.push {
            Some(text) => push(text, self),
            None if options.randomize => Some(Randomized::AsTrained),
            None => Some(Randomized::Nothing),
        };
        let condition = Condition { randomized: randomized?, ..Condition::default() };
        let protocol = Protocol {
            conditions: vec![condition; usize::try_from(episodes?).ok()?],
            time_limit: time_limit?,
            noise: options.noise,
            explore: options.explore,
            seed: seed?,
            ..Protocol::default()
        };
        let (rate, commands) = (rate?, commands?);
        let transfer = |engine: &String, command: Option<f64>| {
            let own = engine == blueprint.engine();
            let usual = if own { blueprint.physics_rate() } else { OTHER_RATE };
            let rate = rate.unwrap_or(usual);
            let mut protocol = protocol.clone();
            protocol.conditions.iter_mut().for_each(|condition| condition.command = command);
            Transfer { engine: engine.clone(), rate, contact_time: None, protocol }
        };
        let engines = engines?;
        let pairs = engines.iter().flat_map(|engine| commands.iter().map(move |command| (engine, *command)));
        Some(Conditions {
            transfers: pairs.map(|(engine, command)| transfer(engine, command)).collect(),
            protocol,
        })
    }

    /// The engines without duplicates; by default that of the training.
    fn engines(&mut self, options: &Options, blueprint: &Blueprint) -> Option<Vec<String>> {
        let mut engines: Vec<String> = Vec::new();
        for name in &options.engine {
            match self.value("--engine", "engine", name.trim())? {
                Value::Text(engine) if !engines.contains(&engine) => engines.push(engine),
                _ => {}
            }
        }
        if engines.is_empty() {
            engines.push(blueprint.engine().to_owned());
        }
        Some(engines)
    }

    /// The commands in m/s; by default the task's own.
    fn commands(&mut self, options: &Options, blueprint: &Blueprint) -> Option<Vec<Option<f64>>> {
        let task = Section::new(&blueprint.fields).within::<Task>().filter(|task| !task.holds(Walk::command));
        if let (Some(task), false) = (task, options.command.is_empty()) {
            let task = task.kind().unwrap_or_default();
            let message =
                format!("--command asks for a speed, and this policy, which is to {task}, follows none");
            self.sink.emit(Diagnostic::error("E0303", message).help("leave the option out"));
            return None;
        }
        let number = |speed: &String| self.number("--command", "command.speed", &with_unit(speed.trim()));
        let commands: Option<Vec<f64>> = options.command.iter().map(number).collect();
        let commands: Vec<Option<f64>> = commands?.into_iter().map(Some).collect();
        Some(if commands.is_empty() { vec![None] } else { commands })
    }
}

/// A speed as in a spec; a number without a unit is in m/s.
fn with_unit(speed: &str) -> String {
    if speed.parse::<f64>().is_ok() { format!("{speed} m/s") } else { speed.to_owned() }
}

/// A push in every episode: `impulse=60 N*s,duration=0.1 s,at=6 s`.
fn push(text: &str, desk: &mut Desk) -> Option<Randomized> {
    let mut row: Option<(Map, Span)> = None;
    for part in text.split(',') {
        let (map, span) = desk.assigned("--push", part.trim())?;
        row.get_or_insert((Map::default(), span)).0.entries.extend(map.entries);
    }
    let (map, span) = row?;
    let node = Node { span, layer: Layer::Set, item: Item::Table(map) };
    let registry =
        Registry { noun: "randomization", kinds: &[push::Pushes::KIND], extra: &[], reserved: &[] };
    let row = Decoder::new(&mut desk.sink).of_kind(&node, &registry, "push", Some(("push", span)))?;
    Some(Randomized::By(Arc::new(Table::from([("push".to_owned(), Value::Table(row))]))))
}

/// The environment of a policy on another ground, `slope,angle=3 deg`; the policy's friction is used unless
/// given.
fn ground(text: &str, policy: &Policy, desk: &mut Desk) -> Option<Blueprint> {
    let mut parts = text.split(',').map(str::trim);
    let kind = parts.next().filter(|kind| !kind.contains('=')).unwrap_or_default();
    let (mut table, span) = desk.assigned("--terrain", &format!("kind={kind}"))?;
    if kind.is_empty() {
        let message = format!("`{text}` does not begin with a kind of terrain");
        let kinds =
            terrain::KINDS.iter().map(|kind| format!("`{}`", kind.name)).collect::<Vec<_>>().join(", ");
        desk.sink
            .emit(Diagnostic::error("E0301", message).at(span, "").help(format!("the kinds are {kinds}")));
        return None;
    }
    for part in parts {
        table.entries.extend(desk.assigned("--terrain", part)?.0.entries);
    }
    if !table.entries.contains_key("friction") {
        let own = policy.blueprint.part::<terrain::Ground>().friction();
        table.entries.extend(desk.assigned("--terrain", &format!("friction={own:?}"))?.0.entries);
    }
    let node = Node { span, layer: Layer::Set, item: Item::Table(table) };
    let registry = Registry { noun: "terrain", kinds: terrain::KINDS, extra: &[], reserved: &["kind"] };
    let decoded: Table = Decoder::new(&mut desk.sink).of_kind(&node, &registry, "terrain", None)?;
    match policy.blueprint.with_terrain(decoded) {
        Ok(blueprint) => Some(blueprint),
        Err(error) => {
            let diagnostic = match &error {
                BlueprintError::Field(size) => Diagnostic::error("E0204", error.to_string()).help(size.help),
                _ => Diagnostic::error("R0002", error.to_string()),
            };
            desk.sink.emit(diagnostic.at(span, ""));
            None
        }
    }
}
