//! The committed JSON Schemas are up to date, and every committed file names its own.
//!
//! `SPECFORGE_BLESS=1 cargo test --test schema` rewrites them.

use std::fs;
use std::path::{Path, PathBuf};

use specforge::schema::schemas;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn toml_files(folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join(folder)).expect("the folder is there").flatten();
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .collect();
    files.sort();
    files
}

#[test]
fn the_committed_schemas_are_what_the_descriptors_say() {
    for schema in schemas() {
        let path = root().join("specs/schema").join(schema.file);
        if std::env::var_os("SPECFORGE_BLESS").is_some() {
            fs::create_dir_all(root().join("specs/schema")).expect("the folder can be made");
            fs::write(&path, schema.text()).expect("the schema can be written");
        }
        let written = fs::read_to_string(&path).unwrap_or_default();
        assert!(
            written == schema.text(),
            "{} is stale: SPECFORGE_BLESS=1 cargo test --test schema",
            schema.file
        );
    }
}

#[test]
fn every_committed_file_names_its_schema() {
    let mut count = 0;
    for (folder, schema) in [
        ("specs", "spec-1.json"),
        ("specs/base", "spec-1.json"),
        ("specs/paper", "-1.json"), // suites, and the baselines that their pages compare with
        ("specs/studies", "suite-1.json"),
        ("specs/motions", "motion-1.json"),
        ("robots", "robot-1.json"),
    ] {
        for path in toml_files(folder) {
            let text = fs::read_to_string(&path).expect("the file is readable");
            let first = text.lines().next().unwrap_or_default();
            let named = first.strip_prefix("#:schema ").expect("the first line names the schema");
            let place = path.parent().expect("a folder").join(named);
            assert!(place.is_file() && named.ends_with(schema), "{}: {first}", path.display());
            count += 1;
        }
    }
    assert!(count >= 25, "{count} files");
}
