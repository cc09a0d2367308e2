//! The conditions set by the options of `evaluate`. Each option is decoded like the key of a spec that it
//! replaces, with that key's unit, range and messages.

use std::sync::Arc;

use super::Options;
use crate::check::{self, Subject};
use crate::cli::specs::Findings;
use crate::deploy::{Policy, Transfer};
use crate::diag::{Diagnostic, Sink, Sources, Span};
use crate::env::{Blueprint, BlueprintError, Randomized};
use crate::evaluate::{Condition, Protocol};
use crate::kinds::evaluate::{Setting, Spread, last_push};
use crate::kinds::task::{Task, Walk};
use crate::kinds::{deploy, randomize::push, terrain};
use crate::sim::EngineName;
use crate::spec::decode::{self, Decoder, Registry};
use crate::spec::marks::below;
use crate::spec::typed::{Declared, Keys, Typed};
use crate::spec::{Marks, Param, Quantity, Section, Table, Value};
use crate::syntax::assign::{Assigning, assignment_of};
use crate::syntax::{Item, Layer, Map, Node};

/// Physics rate in Hz in engines that the policy was not trained in, unless the user names one.
const OTHER_RATE: f64 = 2000.0;

/// The options as the table of an evaluation, `evaluate.options`.
const SECTION: &str = "evaluate";
const TABLE: &str = "options";

/// What to evaluate.
pub struct Conditions {
    /// One per engine and command.
    pub transfers: Vec<Transfer>,
    /// The protocol shared by all of them, without a command.
    pub protocol: Protocol,
    /// Time in s at which the last scheduled push of an episode begins.
    pub push: Option<f64>,
}

/// The policy on the requested ground, the conditions and what is odd about them, or all errors in the
/// options.
pub fn read(options: &Options, mut policy: Policy) -> Result<(Policy, Conditions, Findings), Box<Findings>> {
    let mut desk = Desk::default();
    if let Some(blueprint) = options.terrain.as_ref().and_then(|text| ground(text, &policy, &mut desk)) {
        policy.blueprint = blueprint;
    }
    let conditions = desk.conditions(options, &policy.blueprint);
    if let Some(conditions) = conditions.as_ref().filter(|_| !desk.sink.has_errors()) {
        desk.check(&policy.blueprint, &conditions.transfers);
    }
    let conditions = conditions.filter(|_| !desk.sink.has_errors());
    let findings = Findings::of(desk.sources, desk.sink.diagnostics);
    match conditions {
        Some(conditions) => Ok((policy, conditions, findings)),
        None => Err(Box::new(findings)),
    }
}

/// The texts of the options and the errors in them.
#[derive(Default)]
struct Desk {
    sources: Sources,
    sink: Sink,
    /// The values of the options by their keys in an evaluation's table.
    table: Table,
    /// The places of the values, by their paths in a spec.
    marks: Marks,
}

impl Desk {
    /// The decoded value of a key of a transfer's table, `engine` or `command.speed`.
    fn value(&mut self, option: &str, path: &str, text: &str) -> Option<Value> {
        let (map, span) = self.assigned(option, &format!("{path}={text}"))?;
        let key = path.split('.').next().unwrap_or(path);
        let params: &'static [Param] = deploy::Transfer::PARAMS;
        let param = params.iter().find(|param| param.name == key).expect("a transfer has the key");
        let node = Node { span, layer: Layer::Set, item: Item::Table(map) };
        let mut decoded = decode::table(&node, std::slice::from_ref(param), &mut self.sink)?;
        let value = decoded.table.remove(key)?;
        self.record(key, value.clone(), decoded.marks, "");
        Some(value)
    }

    /// Keeps a value for the checks, with its marks below a table of the evaluation's table.
    fn record(&mut self, key: &str, value: Value, marks: Marks, below: &str) {
        self.table.insert(key.to_owned(), value);
        let placed = marks.by_path.into_iter();
        self.marks
            .by_path
            .extend(placed.map(|(path, mark)| (format!("{SECTION}.{TABLE}.{below}{path}"), mark)));
    }

    /// Checks the options as the table of an evaluation in the policy's spec, for each engine.
    fn check(&mut self, blueprint: &Blueprint, transfers: &[Transfer]) {
        let mut fields = blueprint.fields.clone();
        let options = Table::from([(TABLE.to_owned(), Value::Table(self.table.clone()))]);
        fields.insert(SECTION.to_owned(), Value::Table(options));
        let subject = Subject { fields: &fields, marks: &self.marks, robot: Some(&blueprint.robot) };
        let mut found = Sink::default();
        let path = format!("{SECTION}.{TABLE}");
        check::evaluation(&subject, &path, &mut found);
        let mut engines: Vec<EngineName> =
            transfers.iter().filter_map(|transfer| EngineName::named(&transfer.engine)).collect();
        engines.dedup();
        check::evaluation_in(&subject, &path, &engines, &mut found);
        for mut diagnostic in found.diagnostics {
            diagnostic.message = with_options(&diagnostic.message);
            diagnostic.help.iter_mut().for_each(|help| *help = with_options(help));
            self.sink.emit(diagnostic);
        }
    }

    fn assigned(&mut self, option: &str, argument: &str) -> Option<(Map, Span)> {
        let assigning = Assigning { option, usage: usage(option) };
        let map = assignment_of(&assigning, argument, &mut self.sources, &mut self.sink)?;
        let span = map.entries.values().next()?.key;
        Some((map, span))
    }

    /// Adds an assignment to a table that lacks its key; the place of the key.
    fn add(&mut self, table: &mut Map, option: &str, argument: &str) -> Option<Span> {
        let (map, span) = self.assigned(option, argument)?;
        for (key, entry) in map.entries {
            if let Some(first) = table.entries.get(&key) {
                let twice = Diagnostic::error("E0104", format!("`{key}` is written twice"))
                    .at(entry.key, "again here");
                self.sink.emit(twice.note(first.key, "first written here").help("keep one of the two"));
                return None;
            }
            table.entries.insert(key, entry);
        }
        Some(span)
    }

    /// Replaces the advice on missing keys, which is about the lines of a spec, in the diagnostics of an
    /// option, the last ones.
    fn advise(&mut self, option: &str, earlier: usize) {
        let own = self.sink.diagnostics[earlier..].iter_mut();
        own.filter(|found| found.code == "E0101")
            .for_each(|missing| missing.help = vec![usage(option).to_owned()]);
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
            None if options.randomize => {
                self.record(Spread::randomize.name, Value::Flag(true), Marks::default(), "");
                Some(Randomized::AsTrained)
            }
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
            push: last_push(Section::new(&blueprint.fields), Section::new(&self.table)),
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
        let commands = commands?;
        // What the fastest reaches is reached.
        if let Some(si) = commands.iter().copied().reduce(f64::max) {
            let speed = Value::Quantity(Quantity { si, text: String::new() });
            let command = Value::Table(Table::from([("speed".to_owned(), speed)]));
            self.record("command", command, Marks::default(), "");
        }
        let commands: Vec<Option<f64>> = commands.into_iter().map(Some).collect();
        Some(if commands.is_empty() { vec![None] } else { commands })
    }
}

/// A speed as in a spec; a number without a unit is in m/s.
fn with_unit(speed: &str) -> String {
    if speed.parse::<f64>().is_ok() { format!("{speed} m/s") } else { speed.to_owned() }
}

/// A message about the table of the options, with the options in place of the keys.
fn with_options(message: &str) -> String {
    let prefix = format!("`{SECTION}.{TABLE}.");
    let mut parts = message.split(&prefix);
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (path, rest) = part.split_once('`').unwrap_or((part, ""));
        let push = below(Spread::randomize.name, push::Pushes::KIND.name);
        let tables = [(push.as_str(), "--push"), (Setting::terrain.name, "--terrain")];
        let key = |table: &str| path.strip_prefix(table).map(|key| key.trim_start_matches('.'));
        let option = tables.into_iter().find_map(|(table, option)| Some((key(table)?, option)));
        text += &match option {
            Some(("", option)) => format!("`{option}`"),
            Some((key, option)) => format!("`{key}` of `{option}`"),
            None => format!("`--{}`", path.replace('_', "-")),
        };
        text += rest;
    }
    text
}

/// How to write an option with assignments; empty for others, which have no invalid ones.
fn usage(option: &str) -> &'static str {
    match option {
        "--push" => "write `--push key=value,...`, for example `--push 'impulse=60 N*s,duration=0.1 s'`",
        "--terrain" => "write `--terrain kind,key=value,...`, for example `--terrain 'slope,angle=3 deg'`",
        _ => "",
    }
}

/// A push in every episode: `impulse=60 N*s,duration=0.1 s,at=6 s`.
fn push(text: &str, desk: &mut Desk) -> Option<Randomized> {
    let (mut map, mut first) = (Map::default(), None);
    for part in text.split(',') {
        let span = desk.add(&mut map, "--push", part.trim())?;
        first.get_or_insert(span);
    }
    let span = first?;
    let node = Node { span, layer: Layer::Set, item: Item::Table(map) };
    let registry =
        Registry { noun: "randomization", kinds: &[push::Pushes::KIND], extra: &[], reserved: &[] };
    let earlier = desk.sink.diagnostics.len();
    let mut decoder = Decoder::new(&mut desk.sink);
    let row = decoder.of_kind(&node, &registry, "push", Some(("push", span)));
    let marks = decoder.marks;
    desk.advise("--push", earlier);
    let row = row?;
    let rows = Table::from([("push".to_owned(), Value::Table(row))]);
    let randomize = Spread::randomize.name;
    desk.record(randomize, Value::Table(rows.clone()), marks, &format!("{randomize}."));
    Some(Randomized::By(Arc::new(rows)))
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
        desk.add(&mut table, "--terrain", part)?;
    }
    if !table.entries.contains_key("friction") {
        let own = policy.blueprint.part::<terrain::Ground>().friction();
        desk.add(&mut table, "--terrain", &format!("friction={own:?}"))?;
    }
    let node = Node { span, layer: Layer::Set, item: Item::Table(table) };
    let registry = Registry { noun: "terrain", kinds: terrain::KINDS, extra: &[], reserved: &["kind"] };
    let earlier = desk.sink.diagnostics.len();
    let mut decoder = Decoder::new(&mut desk.sink);
    let decoded: Option<Table> = decoder.of_kind(&node, &registry, Setting::terrain.name, None);
    let marks = decoder.marks;
    desk.advise("--terrain", earlier);
    let decoded = decoded?;
    desk.record(Setting::terrain.name, Value::Table(decoded.clone()), marks, "");
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
