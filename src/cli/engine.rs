//! The two binaries of an installation. `specforge` is linked without the native libraries, so that it
//! starts in milliseconds and can say what is missing; `specforge-engine`, beside it, is the same
//! program with the learner and the engines. Commands that need those go on in the engine.
//!
//! A `specforge` that was built with all features needs no engine and works by itself.

use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{Exit, Global, output};
use crate::plan::StageKind;

/// Whether this binary has the learner and the engines.
pub const COMPLETE: bool = cfg!(all(feature = "torch", feature = "rapier", feature = "mujoco", feature = "batch"));

/// Tells the engine that the warnings of specs have been told: by the process that it goes on as.
const TOLD: &str = "SPECFORGE_TOLD_BY";

/// Whether this process goes on as an engine, and the warnings of specs have been told before.
pub fn has_told() -> bool {
    std::env::var(TOLD).is_ok_and(|process| process == std::process::id().to_string())
}

/// Whether the work of a stage needs what only the engine has.
pub fn needs_engine(kind: StageKind) -> bool {
    use StageKind::{Evaluate, FineTune, Learner, Pretrain, Transfer};
    matches!(kind, Pretrain | Learner | FineTune | Evaluate | Transfer)
}

/// Goes on as the engine, with the same arguments; comes back only with what is wrong.
pub fn hand_over(global: &Global) -> Exit {
    let fault = match usable() {
        Ok(engine) => {
            let mut command = Command::new(engine);
            command.args(std::env::args_os().skip(1)).env(TOLD, std::process::id().to_string());
            format!("it cannot be started: {}", command.exec())
        }
        Err(fault) => fault,
    };
    let advice = "`make build` fetches the native libraries and builds it; `specforge doctor` says what is missing";
    let message = format!("the engine `specforge-engine` cannot be used: {fault}");
    output::fault(global, Some("R0005"), &message, Some(advice));
    Exit::StageFailed
}

/// The engine beside this binary, when it starts; otherwise what the system says.
pub fn usable() -> Result<PathBuf, String> {
    let here = std::env::current_exe().map_err(|error| error.to_string())?;
    let engine = here.with_file_name("specforge-engine");
    starts(&engine).map(|()| engine)
}

/// Whether an engine can be loaded with its libraries; otherwise what the system says.
fn starts(engine: &Path) -> Result<(), String> {
    if !engine.is_file() {
        return Err(format!("there is no {}", engine.display()));
    }
    match Command::new(engine).arg("--version").output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            let reason = text.split_once(": ").map_or(text.clone(), |(_, reason)| reason.to_owned());
            Err(if reason.is_empty() { output.status.to_string() } else { reason })
        }
        Err(error) => Err(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_missing_engine_is_named_with_its_place() {
        // The tests' own binary has no engine beside it.
        let fault = usable().expect_err("there is no engine among the tests' binaries");
        assert!(fault.starts_with("there is no /") && fault.ends_with("specforge-engine"), "{fault}");
    }

    /// Compiles with the C compiler that building specforge needs anyway.
    fn compile(folder: &Path, source: &str, arguments: &[&str]) {
        fs::write(folder.join("source.c"), source).expect("a source can be written");
        let status = Command::new("cc").current_dir(folder).arg("source.c").args(arguments).status();
        assert!(status.expect("there is a C compiler").success());
    }

    #[test]
    fn a_missing_native_library_is_named_as_the_loader_names_it() {
        for library in ["libtorch_cpu.so.0", "libmujoco.so.0.0.0"] {
            // Releases that no machine has, wherever its LD_LIBRARY_PATH leads.
            let folder = tempfile::tempdir().expect("a temporary folder");
            let folder = folder.path();
            compile(folder, "int native(void) { return 0; }", &["-shared", "-fPIC", "-o", library]);
            let needs = "int native(void); int main(void) { return native(); }";
            compile(folder, needs, &["-o", "engine", &format!("-L{}", folder.display()), &format!("-l:{library}")]);
            let soname = folder.join(library);
            let engine = folder.join("engine");
            // Found nowhere: the folder is not among those that the loader searches.
            fs::remove_file(soname).expect("the library can be removed");
            let fault = starts(&engine).expect_err("it cannot be loaded");
            assert!(fault.contains(library) && fault.contains("cannot open shared object file"), "{fault}");
        }
    }
}
