//! An interruption before the work of a command begins: while it reads, checks and plans.

#![cfg(all(feature = "batch", feature = "rapier", feature = "mujoco", target_os = "linux"))]

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};

const SPEC: &str = "specs/tocabi_walk_torque.toml";
const POLICY: &str = "reports/policies/tocabi_walk_torque.safetensors";

/// Begins a command in the folder of the project.
fn begin(words: &[&str], store: &Path) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env("OMP_NUM_THREADS", "1").env("TMPDIR", store);
    command.arg("--store").arg(store.join("store")).args(words);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Whether a process has a handler of its own for a signal, as the kernel says.
fn hears(child: &Child, signal: Signal) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or_default();
    u64::from_str_radix(caught.trim(), 16).is_ok_and(|caught| caught >> (signal.as_raw() - 1) & 1 == 1)
}

/// Interrupts a command as soon as it hears the signal, and says how it ended and what it said. On a busy
/// machine a quick command may be done before it is looked at; it is begun again then.
fn interrupted(words: &[&str], signal: Signal, store: &Path) -> (Option<i32>, String) {
    for _ in 0..50 {
        let mut child = begin(words, store);
        while !hears(&child, signal) && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        // An error means that it is done.
        let _ = kill_process(Pid::from_child(&child), signal);
        let output = child.wait_with_output().unwrap();
        if output.status.code() != Some(0) {
            return (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned());
        }
    }
    panic!("{words:?} was always done before {signal:?} came, or never listened to it");
}

#[test]
fn a_command_that_is_interrupted_before_its_work_says_so_and_has_the_exit_code_of_an_interruption() {
    let folder = tempfile::tempdir().unwrap();
    let commands: [&[&str]; 4] = [
        &["run", SPEC, "--profile", "quick", "--dry-run"],
        &["run", "specs/paper/paper_exp2.toml", "--profile", "quick", "--dry-run"],
        &["bench", SPEC, "--profile", "quick"],
        &["evaluate", POLICY, "--episodes", "1"],
    ];
    for words in commands {
        for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
            let (code, said) = interrupted(words, signal, folder.path());
            assert_eq!(code, Some(6), "{words:?} {signal:?}: {said}");
            assert!(said.lines().any(|line| line == "interrupted"), "{words:?} {signal:?}: {said}");
        }
    }
    let left: Vec<_> =
        std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(
        left.iter().all(|name| name == "store"),
        "nothing is left in the folder of temporary files: {left:?}"
    );
}

/// A thousand arms are planned for longer than anybody waits; the plan ends where it is.
#[test]
fn a_long_plan_ends_with_the_first_signal() {
    let folder = tempfile::tempdir().unwrap();
    let spec = Path::new(env!("CARGO_MANIFEST_DIR")).join(SPEC);
    let suite = folder.path().join("large.toml");
    let text = format!(
        "spec = 1\nsuite = \"large\"\nsummary = \"Many runs\"\nextends = \"{}\"\n[sweep]\nseeds = 100\n\
         [sweep.weight]\npath = \"reward.torque.weight\"\nvalues = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, \
         0.9, 1.0]\n",
        spec.display()
    );
    std::fs::write(&suite, text).unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).display().to_string();
    let words = ["run", suite.to_str().unwrap(), "--profile", "quick", "--dry-run", "--allow-outside", &root];
    let (code, said) = interrupted(&words, Signal::INT, folder.path());
    assert_eq!((code, said.as_str()), (Some(6), "interrupted\n"));
    assert!(!folder.path().join("store").exists());
}
