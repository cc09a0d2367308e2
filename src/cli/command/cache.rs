//! `specforge cache`: what the store holds, whether it is whole, and cleaning it.

use std::path::{Path, PathBuf};
use std::time::Duration;

use serde_json::json;

use crate::cli::{Exit, Format, Global, faults, output, records};
use crate::escape::terminal::one_line;
use crate::exec::journal::Journal;
use crate::exec::line_file::Health;
use crate::exec::lock::Wait;
use crate::exec::manifest::Depth;
use crate::exec::marker::{self, Identity};
use crate::exec::{Store, StoreError, gc};
use crate::plan::{Cached, StageKind};

/// Arguments of `cache`.
#[derive(Debug, clap::Args)]
pub struct Options {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Lists the artefacts
    List,
    /// Checks every file against its digest, and copied values against their source
    Verify,
    /// Removes damaged artefacts, and those that provably no stage uses any more
    Gc {
        /// Keeps artefacts that are younger
        #[arg(long, value_name = "DAYS", default_value = "14", value_parser = days,
                allow_negative_numbers = true)]
        older_than: Duration,
        /// Also removes the checkpoints of stages that were not finished
        #[arg(long)]
        scratch: bool,
        /// Trusts a damaged or missing journal: artefacts that it does not name count as unused
        #[arg(long)]
        force: bool,
        /// Prints what would be removed, and removes nothing
        #[arg(long)]
        dry_run: bool,
    },
    /// Writes a record of each finished run of a plan: a JSON file with everything that its report needs
    Export(records::Export),
    /// Puts the runs of records into the store, so that a report needs no new training
    Import(records::Import),
}

/// Runs the action.
pub fn run(options: &Options, global: &Global) -> Exit {
    let store = Store::at(global.store.clone().unwrap_or_else(default_store));
    if store.root().exists() && !store.root().is_dir() {
        let message = format!("{} is a file, not a store", store.root().display());
        output::complain(global, &message, Some("name the store's folder: `--store DIR`"));
        return Exit::Usage;
    }
    match &options.action {
        Action::Export(options) => records::export(options, global),
        Action::Import(options) => records::import(options, &store, global),
        Action::List => match listable(&store, global) {
            Ok(()) => list(&store, global),
            Err(error) => faults::store(global, &error),
        },
        Action::Verify => verify(&store, global),
        Action::Gc { older_than, scratch, force, dry_run } => {
            let rules = gc::Rules { age: *older_than, scratch: *scratch, force: *force };
            let root = store.root().display();
            let tell = |who: &str| {
                output::note(global, &format!("{who} has locked the store {root}; waiting for it"))
            };
            let wait = Wait { tell: Some(&tell), ..Wait::default() };
            match listable(&store, global).and_then(|()| gc::waste(&store, &rules, &wait)) {
                Ok(cleaning) => collect(&store, &cleaning, (!dry_run).then_some(&wait), global),
                Err(error) => faults::store(global, &error),
            }
        }
    }
}

/// Parses a number of days; too large numbers become the longest duration.
fn days(text: &str) -> Result<Duration, String> {
    match text.parse::<f64>() {
        Ok(days) if days >= 0.0 => Ok(Duration::try_from_secs_f64(days * 86_400.0).unwrap_or(Duration::MAX)),
        _ => Err("a number of days from 0 on".into()),
    }
}

/// `.specforge` in the nearest parent folder (or this one) that contains it or a Cargo.toml.
fn default_store() -> PathBuf {
    let here = std::env::current_dir().unwrap_or_default();
    let is_project =
        |folder: &&Path| folder.join(".specforge").is_dir() || folder.join("Cargo.toml").is_file();
    here.ancestors().find(is_project).unwrap_or(&here).join(".specforge")
}

/// Whether a folder can be listed: it is a store, or the default one, which the first run creates.
fn listable(store: &Store, global: &Global) -> Result<(), StoreError> {
    let nothing = |reason: String| Err(StoreError::NotAStore { path: store.root().to_owned(), reason });
    match marker::identity(store.root())? {
        Identity::Absent if global.store.is_some() => nothing("it does not exist".into()),
        Identity::Other { reason, vacant: false } => nothing(reason),
        Identity::Absent | Identity::Other { .. } | Identity::Marked | Identity::Unmarked => Ok(()),
    }
}

fn list(store: &Store, global: &Global) -> Exit {
    let mut entries = Vec::new();
    for kind in StageKind::ALL {
        for key in store.keys(kind) {
            let Ok(Some(manifest)) = store.manifest(kind, &key) else { continue };
            let users = manifest.stage.users.iter().map(|user| format!("{}/{}", user.arm, user.stage));
            let size: u64 = manifest.files.iter().map(|file| file.size).sum();
            entries.push(json!({
                "kind": kind.name(), "key": key, "users": users.collect::<Vec<_>>(), "size": size,
                "provenance": manifest.provenance,
            }));
        }
    }
    if global.format == Format::Json {
        output::json(&json!({ "store": store.root(), "artefacts": entries }));
        return Exit::Ok;
    }
    let mut text = String::new();
    for entry in &entries {
        let short = entry["key"].as_str().unwrap_or_default().get(..12).unwrap_or_default();
        let users = entry["users"].as_array().into_iter().flatten().filter_map(|user| user.as_str());
        let (kind, size) =
            (entry["kind"].as_str().unwrap_or_default(), entry["size"].as_u64().unwrap_or_default());
        let made = entry["provenance"]["finished"].as_str().unwrap_or_default();
        let users = users.collect::<Vec<_>>().join(", ");
        text += &one_line(&format!("{kind:<10} {short}  {made}  {:>9}  {users}", bytes(size)));
    }
    output::data_if_any(&text);
    output::note(global, &format!("{}: {} artefacts", store.root().display(), entries.len()));
    Exit::Ok
}

/// Files in an artefact's folder that are not part of it.
struct Strays {
    what: String,
    files: Vec<String>,
}

/// Something wrong in a store.
struct Fault {
    code: &'static str,
    what: String,
    reason: String,
    help: &'static str,
}

fn verify(store: &Store, global: &Global) -> Exit {
    let found = artefacts(store).and_then(|Verified { whole, mut faults, strays }| {
        faults.extend(checkpoints(store));
        faults.extend(journal(store, whole + faults.len())?);
        Ok(Verified { whole, faults, strays })
    });
    let Verified { whole, faults, strays } = match found {
        Ok(found) => found,
        Err(error) => return faults::store(global, &error),
    };
    if global.format == Format::Json {
        let damaged = faults
            .iter()
            .map(|fault| json!({ "code": fault.code, "what": fault.what, "reason": fault.reason }));
        let strays = strays.iter().map(|strays| json!({ "what": strays.what, "files": strays.files }));
        output::json(&json!({
            "whole": whole, "damaged": damaged.collect::<Vec<_>>(), "strays": strays.collect::<Vec<_>>(),
        }));
    } else {
        for Fault { code, what, reason, help } in &faults {
            output::fault(global, Some(*code), &format!("{what}: {reason}"), Some(*help));
        }
        for Strays { what, files } in &strays {
            let files = files.join(", ");
            output::note(global, &format!("{what}: not part of the artefact, and ignored: {files}"));
        }
        let journals = faults.iter().filter(|fault| fault.what == JOURNAL).count();
        let (damaged, journal) =
            (faults.len() - journals, if journals > 0 { "; the journal is damaged" } else { "" });
        output::note(global, &format!("{whole} artefacts are whole, {damaged} are damaged{journal}"));
    }
    if faults.is_empty() { Exit::Ok } else { Exit::StageFailed }
}

/// What a check of every artefact finds.
struct Verified {
    whole: usize,
    faults: Vec<Fault>,
    strays: Vec<Strays>,
}

/// Checks every artefact. Fails for a folder that is not a store.
fn artefacts(store: &Store) -> Result<Verified, StoreError> {
    let nothing = |reason: String| StoreError::NotAStore { path: store.root().to_owned(), reason };
    match marker::identity(store.root())? {
        Identity::Marked | Identity::Unmarked => {}
        Identity::Absent => return Err(nothing("it does not exist".into())),
        Identity::Other { reason, .. } => return Err(nothing(reason)),
    }
    let (mut whole, mut faults, mut strays) = (0, Vec::new(), Vec::new());
    for kind in StageKind::ALL {
        for key in store.entries(kind)? {
            let what = format!("{} {key}", kind.name());
            let files = store.strays(kind, &key);
            if !files.is_empty() {
                strays.push(Strays { what: what.clone(), files });
            }
            match store.inspect(kind, &key, Depth::Full) {
                Cached::Damaged(reason) => faults.push(Fault {
                    code: "R0003",
                    what,
                    reason,
                    help: "run the spec again: the artefact is moved aside and made anew",
                }),
                _ => whole += 1,
            }
        }
    }
    Ok(Verified { whole, faults, strays })
}

/// Damaged checkpoints, from which no training would continue.
fn checkpoints(store: &Store) -> Vec<Fault> {
    let fault = |(key, reason)| Fault {
        code: "R0003",
        what: format!("checkpoint {key}"),
        reason,
        help: "delete it in the store's folder `scratch`: its training begins again",
    };
    store.damaged_checkpoints().into_iter().map(fault).collect()
}

/// What a fault of the journal is about.
const JOURNAL: &str = "journal";

/// What is wrong with the journal of a store that has this many artefacts.
fn journal(store: &Store, artefacts: usize) -> Result<Option<Fault>, StoreError> {
    let reason = match Journal::open(store)?.health() {
        Health::Damaged(reason) => reason.clone(),
        Health::Absent if artefacts > 0 => "it is missing".into(),
        Health::Absent | Health::Whole => return Ok(None),
    };
    let help = "runs go on; `cache gc` removes nothing until `cache gc --force` has written it again";
    Ok(Some(Fault { code: "E0814", what: JOURNAL.to_owned(), reason, help }))
}

/// Removes the waste and reports it; without `removal` it is only reported.
fn collect(store: &Store, cleaning: &gc::Cleaning, removal: Option<&Wait>, global: &Global) -> Exit {
    if let Some(Err(error)) = removal.map(|wait| gc::remove(store, cleaning, wait)) {
        return faults::store(global, &error);
    }
    let dry_run = removal.is_none();
    let gc::Cleaning { waste, unnamed, leased, .. } = cleaning;
    let size: u64 = waste.iter().map(|entry| entry.size).sum();
    if global.format == Format::Json {
        let list =
            waste.iter().map(|entry| json!({ "what": entry.what, "path": entry.path, "size": entry.size }));
        let entries: Vec<_> = list.collect();
        output::json(&json!({
            "removed": !dry_run, "entries": entries, "size": size, "unnamed": unnamed, "in_use": leased,
        }));
        return Exit::Ok;
    }
    let lines = waste.iter().map(|entry| one_line(&format!("{:<32} {:>9}", entry.what, bytes(entry.size))));
    output::data_if_any(&lines.collect::<String>());
    let verb = if dry_run { "would be removed" } else { "were removed" };
    let count = waste.len();
    output::note(global, &format!("{}: {count} entries of {} {verb}", store.root().display(), bytes(size)));
    if *leased > 0 {
        output::note(global, &format!("{leased} more are kept: a running process uses them"));
    }
    if *unnamed > 0 {
        let message = format!("{unnamed} more are kept: the journal does not name them, so they may be used");
        output::note(global, &format!("{message}; `--force` removes them too"));
    }
    Exit::Ok
}

/// A size for people.
fn bytes(size: u64) -> String {
    match size {
        0..1_000 => format!("{size} B"),
        1_000..1_000_000 => format!("{:.1} kB", size as f64 / 1e3),
        _ => format!("{:.1} MB", size as f64 / 1e6),
    }
}
