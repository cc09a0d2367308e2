//! Single steps of the batch engine against MuJoCo's, for the robot files of a folder.
//!
//! `cargo bench --bench public_robots -- FOLDER...` reads the robot files (`*.toml`) of folders, as
//! `specforge import` writes them, or single files, and prints a row for each: on the plane, a slope, a box
//! obstacle and a height field the largest difference of an acceleration, relative to the largest of its
//! step. Its figures are in docs/experiments/2026-11-26-batch-engine-fidelity.md; the files are not
//! committed.

#[path = "../tests/batch/differences.rs"]
mod differences;
#[path = "../tests/batch/lab.rs"]
mod lab;
#[path = "../tests/batch/oracle.rs"]
mod oracle;

use std::path::{Path, PathBuf};

use differences::differences;
use lab::{Drive, bar, field};
use specforge::diag::{Sink, Sources};
use specforge::robot::{self, Robot};
use specforge::sim::Terrain;

fn main() {
    let arguments = std::env::args().skip(1).filter(|argument| !argument.starts_with("--"));
    let files: Vec<PathBuf> = arguments.flat_map(|argument| files(Path::new(&argument))).collect();
    assert!(!files.is_empty(), "name robot files or folders of them");
    println!(
        "| robot | mass kg | joints | flat | slope | height field | box, 95 % of the steps | box | touching |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for file in files {
        match read(&file) {
            Some(robot) => println!("{}", row(&robot)),
            None => eprintln!("{}: no sound robot", file.display()),
        }
    }
}

/// A file, or the robot files of a folder by name.
fn files(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = path.read_dir() else { return vec![path.to_owned()] };
    let entries = entries.flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    files.sort();
    files
}

fn read(file: &Path) -> Option<Robot> {
    let name = file.file_stem()?.to_str()?;
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(file.display().to_string(), std::fs::read_to_string(file).ok()?);
    robot::load(name, &sources, source, &mut sink)
}

fn row(robot: &Robot) -> String {
    let mut worst = Vec::new();
    let (mut touching, mut steps, mut most) = (0, 0, 0.0);
    for terrain in [Terrain::Flat, Terrain::Slope { angle: 0.15 }, field(), bar()] {
        let found = [Drive::Servo, Drive::Random].map(|drive| differences(robot, &terrain, drive));
        worst.push(found.iter().map(|found| found.at(1.0)).fold(0.0, f64::max));
        most = found.iter().map(|found| found.at(0.95)).fold(0.0, f64::max);
        touching += found.iter().map(|found| found.touching).sum::<usize>();
        steps += found.iter().map(|found| found.relative.len()).sum::<usize>();
    }
    let [flat, slope, field, bar] = [0, 1, 2, 3].map(|index: usize| worst[index]);
    format!(
        "| {} | {:.1} | {} | {flat:.1e} | {slope:.1e} | {field:.1e} | {most:.1e} | {bar:.1e} | {touching} of \
         {steps} |",
        robot.name,
        robot.total_mass(),
        robot.joints()
    )
}
