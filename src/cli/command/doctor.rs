//! `specforge doctor`: what this machine has and lacks, and how to fix each problem.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::bounded;
use crate::cli::{Exit, Format, Global, output};
use crate::sim;

/// Arguments of `doctor`.
#[derive(Debug, clap::Args)]
pub struct Options {}

/// The result of one check.
struct Finding {
    name: &'static str,
    /// The finding; `Err` is the problem and its fix.
    result: Result<String, (String, &'static str)>,
    /// Whether specforge needs it.
    needed: bool,
}

/// Runs and prints all checks; exit code 4 if something required is missing.
pub fn run(_: &Options, global: &Global) -> Exit {
    let findings = findings(global);
    if global.format == Format::Json {
        let list: Vec<serde_json::Value> = findings
            .iter()
            .map(|finding| match &finding.result {
                Ok(found) => serde_json::json!({ "name": finding.name, "ok": true, "found": found }),
                Err((wrong, cure)) => serde_json::json!({
                    "name": finding.name, "ok": false, "needed": finding.needed, "found": wrong, "cure": cure,
                }),
            })
            .collect();
        output::json(&serde_json::json!({ "checks": list }));
    } else {
        output::data(&findings.iter().map(line).collect::<String>());
    }
    let missing = findings.iter().any(|finding| finding.needed && finding.result.is_err());
    if missing { Exit::StageFailed } else { Exit::Ok }
}

fn line(finding: &Finding) -> String {
    match &finding.result {
        Ok(found) => format!("ok       {:<14} {found}\n", finding.name),
        Err((wrong, cure)) => {
            let mark = if finding.needed { "MISSING" } else { "absent" };
            format!("{mark:<8} {:<14} {wrong}\n         {:<14} cure: {cure}\n", finding.name, "")
        }
    }
}

fn findings(global: &Global) -> Vec<Finding> {
    let tool = |name, arguments: &[&str], cure| Finding {
        name,
        result: version(name, arguments, cure),
        needed: false,
    };
    vec![
        Finding {
            name: "specforge",
            result: Ok(format!("{} ({})", env!("CARGO_PKG_VERSION"), env!("SPECFORGE_COMMIT"))),
            needed: true,
        },
        tool(
            "rustc",
            &["--version"],
            "install Rust 1.95 or newer with rustup (https://rustup.rs); only building needs it",
        ),
        tool(
            "cargo",
            &["--version"],
            "install Rust 1.95 or newer with rustup (https://rustup.rs); only building needs it",
        ),
        tool("python3", &["--version"], "install Python 3; only fetching the native libraries needs it"),
        Finding {
            name: "pip",
            result: version(
                "python3",
                &["-m", "pip", "--version"],
                "install pip for python3 (package python3-pip); only fetching needs it",
            ),
            needed: false,
        },
        tool(
            "make",
            &["--version"],
            "install make (package make or build-essential); only building needs it",
        ),
        tool(
            "c++",
            &["--version"],
            "install a C++ compiler (package g++ or build-essential); only building needs it",
        ),
        Finding { name: "rapier", result: rapier(), needed: true },
        Finding { name: "mujoco", result: mujoco(), needed: true },
        Finding { name: "batch", result: batch(), needed: true },
        Finding { name: "libtorch", result: torch(), needed: false },
        Finding { name: "store", result: store(global), needed: true },
        Finding { name: "cores", result: Ok(cores()), needed: true },
    ]
}

/// The first line of a tool's version output.
fn version(tool: &str, arguments: &[&str], cure: &'static str) -> Result<String, (String, &'static str)> {
    match Command::new(tool).args(arguments).output() {
        Ok(output) if output.status.success() => {
            let text = String::from_utf8_lossy(&output.stdout);
            Ok(text.lines().next().unwrap_or_default().trim().to_owned())
        }
        Ok(output) => Err((format!("`{tool} {}` failed ({})", arguments.join(" "), output.status), cure)),
        Err(error) => Err((format!("`{tool}` cannot be started: {error}"), cure)),
    }
}

fn rapier() -> Result<String, (String, &'static str)> {
    if cfg!(feature = "rapier") {
        Ok("built in".to_owned())
    } else {
        Err(("this binary was built without it".to_owned(), "build with the feature `rapier`: `make build`"))
    }
}

/// Whether this binary includes the batch engine, and the widest instruction set available to it.
fn batch() -> Result<String, (String, &'static str)> {
    #[cfg(feature = "batch")]
    {
        let widest = crate::sim::batch::Set::available().pop();
        Ok(widest.map_or_else(String::new, |set| format!("built in, {} environments at once", set.lanes())))
    }
    #[cfg(not(feature = "batch"))]
    Err(("this binary was built without it".to_owned(), "build with the feature `batch`: `make build`"))
}

fn mujoco() -> Result<String, (String, &'static str)> {
    const CURE: &str = "run `make native` in specforge's folder, or name the library's file in the variable \
        SPECFORGE_MUJOCO";
    if cfg!(not(feature = "mujoco")) {
        return Err((
            "this binary was built without it".to_owned(),
            "build with the feature `mujoco`: `make build`",
        ));
    }
    // Opening the engine loads the library.
    let engine = sim::open("mujoco").map_err(|error| (error.to_string(), CURE))?;
    Ok(format!(
        "{}, {}",
        engine.identity(),
        loaded("libmujoco.so").unwrap_or_else(|| "linked statically".to_owned())
    ))
}

#[cfg(feature = "torch")]
fn torch() -> Result<String, (String, &'static str)> {
    let cuda = match (tch::utils::has_cudart(), tch::Cuda::device_count()) {
        (false, _) => "without CUDA".to_owned(),
        (true, 1) => "with CUDA and a device".to_owned(),
        (true, count) => format!("with CUDA and {count} devices"),
    };
    let place = loaded("libtorch_cpu.so").unwrap_or_else(|| "linked statically".to_owned());
    Ok(format!("{place}, {cuda}"))
}

#[cfg(not(feature = "torch"))]
fn torch() -> Result<String, (String, &'static str)> {
    let cure =
        "`make build FEATURES=torch`; only `learn.backend = \"torch\"` and the format `torchscript` need it";
    Err(("this binary was built without it".to_owned(), cure))
}

/// The path from which the loader actually loaded a library.
fn loaded(library: &str) -> Option<String> {
    let maps = bounded::text(Path::new("/proc/self/maps"), bounded::RECORD).unwrap_or_default();
    let mut paths = maps.lines().filter_map(|line| line.split_once('/')).map(|(_, path)| format!("/{path}"));
    paths.find(|path| path.contains(library))
}

/// Checks that the store is writable.
fn store(global: &Global) -> Result<String, (String, &'static str)> {
    const CURE: &str = "choose another place with `--store DIR`, or make this one writable";
    let place = global.store.clone().unwrap_or_else(|| PathBuf::from(".specforge"));
    if place.exists() && !place.is_dir() {
        return Err((format!("{} is a file, not a folder", place.display()), CURE));
    }
    let Some(existing) = place.ancestors().find(|folder| folder.is_dir() || folder.as_os_str().is_empty())
    else {
        return Err((format!("{} has no parent folder", place.display()), CURE));
    };
    let existing = if existing.as_os_str().is_empty() { Path::new(".") } else { existing };
    match tempfile::NamedTempFile::new_in(existing) {
        Ok(_) => Ok(format!("{} is writable", place.display())),
        Err(error) => Err((format!("{}: {error}", place.display()), CURE)),
    }
}

fn cores() -> String {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let memory = bounded::text(Path::new("/proc/meminfo"), bounded::WRITTEN).ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?.trim().to_owned();
        line.split_whitespace().next()?.parse::<f64>().ok()
    });
    match memory {
        Some(kib) => format!("{cores}, {:.1} GiB of memory free", kib / 1024.0 / 1024.0),
        None => cores.to_string(),
    }
}
