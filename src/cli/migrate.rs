//! `specforge migrate FILE...`: brings specs to the newest edition of the language.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::specs::{self, Findings};
use super::{Exit, Format, Global, output, rewrite};
use crate::diag::{Sink, Sources};
use crate::migrate::{Migrated, STEPS, migrate};
use crate::safe_fs;
use crate::syntax::{Disk, file};

/// Arguments of `migrate`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// Specs, or folders of specs
    #[arg(value_name = "FILE|DIR", required = true)]
    files: Vec<PathBuf>,
    /// Changes nothing; prints what would change and ends with 3 if anything would
    #[arg(long)]
    check: bool,
}

/// Migrates every file.
pub fn run(options: &Options, global: &Global) -> Exit {
    let files = match specs::files(&options.files, global) {
        Ok(files) => files,
        Err(exit) => return exit,
    };
    if files.is_empty() {
        output::complain(global, "there is no spec in the folders named", Some("`specforge migrate specs`"));
        return Exit::Usage;
    }
    let (mut broken, mut done) = (Vec::new(), Vec::new());
    for path in &files {
        match read(path) {
            Err(findings) => broken.push(findings),
            Ok((before, migrated)) => {
                let changed = migrated.text != before;
                if changed && options.check {
                    if global.format != Format::Json {
                        output::data(&rewrite::difference(path, &before, &migrated.text));
                    }
                } else if changed && let Err(error) = safe_fs::replace(path, migrated.text.as_bytes()) {
                    output::complain(global, &format!("{} cannot be written: {error}", path.display()), None);
                    return Exit::StageFailed;
                }
                tell(path, &migrated, global);
                done.push((path, migrated));
            }
        }
    }
    specs::print(&broken, global);
    if global.format == Format::Json {
        let mut document = specs::json(&broken);
        document["files"] = done.iter().map(|(path, migrated)| json_of(path, migrated)).collect();
        output::json(&document);
    }
    let outdated = done.iter().any(|(_, migrated)| migrated.from != migrated.to);
    if broken.is_empty() && !(options.check && outdated) { Exit::Ok } else { Exit::Invalid }
}

/// The text of a file, and what becomes of it.
fn read(path: &Path) -> Result<(String, Migrated), Findings> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let result = file::read(&Disk, path).map_err(|error| sink.emit(error)).ok().and_then(|text| {
        let source = sources.add(path, text.as_str());
        migrate(&sources, source, STEPS, &mut sink).map(|migrated| (text, migrated))
    });
    result.ok_or(Findings::of(sources, sink.diagnostics).in_file(path))
}

fn tell(path: &Path, migrated: &Migrated, global: &Global) {
    let Migrated { from, to, .. } = migrated;
    if global.format == Format::Json {
        return;
    }
    if from == to {
        output::note(global, &format!("{}: already edition {}", output::shown(path), to.0));
        return;
    }
    output::note(global, &format!("{}: edition {} to {}", output::shown(path), from.0, to.0));
    for change in &migrated.changes {
        output::note(global, &format!("  `{}` {}", change.path, change.what));
    }
}

fn json_of(path: &Path, migrated: &Migrated) -> serde_json::Value {
    json!({ "file": path, "from": migrated.from.0, "to": migrated.to.0, "changes": migrated.changes })
}
