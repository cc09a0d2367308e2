//! `specforge schema`: JSON Schemas for editors.

use std::path::PathBuf;

use crate::cli::{Exit, Global, output, overwrite};
use crate::safe_fs;
use crate::schema::{Schema, schemas};

/// Arguments of `schema`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// What the schema describes
    #[arg(value_name = "WHAT", default_value = "spec", value_parser = ["spec", "suite", "motion", "robot"])]
    what: String,
    /// Writes all schemas into a folder, which is made if it is not there
    #[arg(long, value_name = "DIR")]
    write: Option<PathBuf>,
}

/// Prints one schema, or writes all of them.
pub fn run(options: &Options, global: &Global) -> Exit {
    let schemas = schemas();
    let Some(folder) = &options.write else {
        schemas
            .iter()
            .filter(|schema| schema.subject == options.what)
            .for_each(|schema| output::data(&schema.text()));
        return Exit::Ok;
    };
    for schema in &schemas {
        let advice = "name another folder, or remove the file first";
        let place = folder.join(schema.file);
        if let Err(exit) = overwrite::allowed(&place, "a JSON schema", is_schema, advice, global) {
            return exit;
        }
    }
    let written = std::fs::create_dir_all(folder).and_then(|()| {
        let put = |schema: &Schema| safe_fs::replace_inside(folder, schema.file, schema.text().as_bytes());
        schemas.iter().try_for_each(put)
    });
    match written {
        Ok(()) => {
            let files: Vec<&str> = schemas.iter().map(|schema| schema.file).collect();
            output::note(global, &format!("{}: {} written", folder.display(), files.join(", ")));
            Exit::Ok
        }
        Err(error) => {
            output::complain(global, &format!("{} cannot be written: {error}", folder.display()), None);
            Exit::StageFailed
        }
    }
}

/// Whether a text is a JSON schema.
fn is_schema(text: &str) -> bool {
    let schema: Result<serde_json::Value, _> = serde_json::from_str(text);
    schema.is_ok_and(|schema| schema.get("$schema").is_some())
}
