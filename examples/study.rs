//! specforge as a library: checks a spec, trains and evaluates its policies, and writes the report.
//!
//! `cargo run --release --example study specs/tocabi_squat_torque.toml`

use std::error::Error;
use std::path::{Path, PathBuf};

use specforge::exec::{Interrupt, events::Silence};
use specforge::spec::LoadOptions;
use specforge::study::{Log, Study};

/// The page of the report; none when a stage failed.
pub fn report(spec: &Path, options: &LoadOptions) -> Result<Option<PathBuf>, Box<dyn Error>> {
    let mut log = Log::default();
    let study = Study::read(&[spec.to_owned()], options, &mut log);
    for found in log.findings.iter().flat_map(|findings| &findings.diagnostics) {
        eprintln!("{}: {}", found.code, found.message);
    }
    let study = study?;
    println!("{} stages", study.plan.stages().len());
    let store = study.store(None)?;
    Ok(study.run(&store, 1, &Silence, &Interrupt::default())?)
}

#[allow(dead_code, reason = "the test calls `report`")]
fn main() -> Result<(), Box<dyn Error>> {
    let spec = std::env::args().nth(1).ok_or("name a spec")?;
    let options = LoadOptions { profile: Some("quick".to_owned()), ..LoadOptions::default() };
    match report(Path::new(&spec), &options)? {
        Some(page) => println!("{}", page.display()),
        None => println!("a stage failed"),
    }
    Ok(())
}
