//! One program: it starts without its native libraries, loads MuJoCo's when a stage needs it, and says before
//! a run starts what this build or this machine lacks.

#![cfg(feature = "mujoco")]

use std::path::Path;
use std::process::{Command, Output};

fn specforge(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    command
}

fn output(command: &mut Command) -> Output {
    command.output().expect("the program can be started")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout)
}

/// A training of some seconds in MuJoCo.
fn run(store: &Path, more: &[&str]) -> Command {
    let mut command = specforge(&["--store"]);
    command.arg(store).args(["run", "specs/tocabi_walk_torque.toml", "--profile", "quick"]);
    command.args(["--set", "physics.engine=\"mujoco\"", "--until", "tocabi_walk_torque/learner"]).args(more);
    command
}

#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
#[test]
fn the_loader_does_not_load_mujoco_before_main() {
    // As `ldd` asks.
    let output = output(specforge(&["--version"]).env("LD_TRACE_LOADED_OBJECTS", "1"));
    let libraries = told(&output);
    assert!(libraries.contains("libc.so"), "{libraries}");
    assert!(!libraries.contains("mujoco"), "{libraries}");
    assert!(cfg!(feature = "torch") || !libraries.contains("torch"), "{libraries}");
}

#[test]
fn a_missing_mujoco_library_ends_a_run_before_it_starts() {
    let store = tempfile::tempdir().expect("a folder");
    let output = output(run(store.path(), &[]).env("SPECFORGE_MUJOCO", "/nowhere/libmujoco.so"));
    assert_eq!(output.status.code(), Some(4), "{}", told(&output));
    let told = told(&output);
    assert!(told.contains("[R0005]") && told.contains("/nowhere/libmujoco.so"), "{told}");
    assert!(told.contains("specforge doctor") && !told.contains("panicked"), "{told}");
    assert!(!store.path().join("robot").exists(), "a stage was worked on");
}

#[test]
fn checking_and_planning_need_no_library() {
    for command in ["check", "plan"] {
        let mut command = specforge(&[command, "specs/tocabi_walk_torque.toml"]);
        let output = output(command.env("SPECFORGE_MUJOCO", "/nowhere/libmujoco.so"));
        assert!(output.status.success(), "{}", told(&output));
    }
}

#[test]
fn the_doctor_says_which_library_is_missing_and_where_it_was_found() {
    let missing = output(specforge(&["doctor"]).env("SPECFORGE_MUJOCO", "/nowhere/libmujoco.so"));
    assert_eq!(missing.status.code(), Some(4));
    assert!(
        told(&missing).contains("MISSING  mujoco") && told(&missing).contains("make native"),
        "{}",
        told(&missing)
    );
    let found = told(&output(&mut specforge(&["doctor"])));
    assert!(found.contains("ok       mujoco") && found.contains("libmujoco.so"), "{found}");
}

#[cfg(not(feature = "torch"))]
#[test]
fn what_needs_libtorch_says_how_to_build_with_it_before_the_run_starts() {
    let store = tempfile::tempdir().expect("a folder");
    let mut export = specforge(&["--store"]);
    export.arg(store.path()).args(["run", "specs/tocabi_walk_torque.toml", "--profile", "quick"]);
    export.args([
        "--set",
        "deploy.policy.formats=[\"torchscript\"]",
        "--until",
        "tocabi_walk_torque/deploy.policy",
    ]);
    for command in [&mut run(store.path(), &["--set", "learn.backend=torch"]), &mut export] {
        let output = output(command);
        assert_eq!(output.status.code(), Some(4), "{}", told(&output));
        let told = told(&output);
        assert!(told.contains("[R0005]") && told.contains("make build FEATURES=torch"), "{told}");
        assert!(!store.path().join("robot").exists(), "a stage was worked on");
    }
}

#[cfg(feature = "torch")]
#[test]
fn a_policy_of_the_torch_backend_is_trained_and_exported_as_torchscript() {
    let store = tempfile::tempdir().expect("a folder");
    let mut command = specforge(&["--store"]);
    command.arg(store.path()).args(["run", "specs/tocabi_walk_torque.toml", "--profile", "quick"]);
    command.args(["--until", "tocabi_walk_torque/deploy.policy"]);
    for assignment in [
        "deploy.policy.formats=[\"safetensors\", \"torchscript\"]",
        "learn.backend=torch",
        "pretrain.samples=2000",
        "pretrain.epochs=1",
        "learn.samples=512",
        "learn.rollout=256",
        "learn.environments=4",
        "learn.minibatch=64",
        "learn.warm_up=1",
    ] {
        command.args(["--set", assignment]);
    }
    let output = output(&mut command);
    assert!(output.status.success(), "{}", told(&output));
    let exports: Vec<_> = std::fs::read_dir(store.path().join("export")).expect("it was exported").collect();
    let folder = exports[0].as_ref().expect("it is readable").path();
    assert!(folder.join("policy.pt").is_file() && folder.join("policy.safetensors").is_file());
    let learner =
        std::fs::read_dir(store.path().join("learner")).expect("it was trained").next().expect("one");
    let manifest = std::fs::read_to_string(learner.expect("it is readable").path().join("manifest.json"));
    assert!(manifest.expect("it has a manifest").contains("libtorch 2.13.0, f32"));
}
