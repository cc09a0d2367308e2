//! Writes the places of the native libraries into the binary, so that it runs from any folder.

use std::path::Path;

/// What goes into the binary.
const PARTS: &[&str] =
    &["build.rs", "Cargo.toml", "Cargo.lock", "src", "templates", "specs/base", "specs/motions", "robots"];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=LIBTORCH");
    println!("cargo:rerun-if-env-changed=MUJOCO_DYNAMIC_LINK_DIR");
    let root = std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR");
    let absolute = |place: String| {
        let path = Path::new(&place);
        if path.is_absolute() { place } else { Path::new(&root).join(path).display().to_string() }
    };
    let has = |feature: &str| std::env::var_os(format!("CARGO_FEATURE_{feature}")).is_some();
    if has("TORCH") {
        let folder = std::env::var("LIBTORCH").unwrap_or_else(|_| "third_party/libtorch".into());
        let libraries = Path::new(&absolute(folder)).join("lib");
        println!("cargo:rustc-link-arg=-Wl,-rpath,{}", libraries.display());
        // Nothing names a symbol of it, so the linker would leave it out, and libtorch would find no device.
        let cuda = libraries.join("libtorch_cuda.so");
        if cuda.exists() {
            println!("cargo:rustc-link-arg=-Wl,--no-as-needed,{},--as-needed", cuda.display());
        }
    }
    if has("MUJOCO") {
        // Where `sim::mujoco` finds the library when an engine is opened.
        let folder =
            std::env::var("MUJOCO_DYNAMIC_LINK_DIR").unwrap_or_else(|_| "third_party/mujoco/lib".into());
        println!("cargo:rustc-link-arg=-Wl,-rpath,{}", absolute(folder));
    }
    let git = |arguments: &[&str]| {
        let output = std::process::Command::new("git").args(arguments).current_dir(&root).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // The log of HEAD changes with every commit, checkout and pull.
    for place in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--path-format=absolute", "--git-path", place])
            .filter(|path| Path::new(path).exists())
        {
            println!("cargo:rerun-if-changed={path}");
        }
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_else(|| "unknown".into());
    // What is built of changed sources does not pass for the commit.
    PARTS.iter().for_each(|part| println!("cargo:rerun-if-changed={part}"));
    let changes = git(&[&["status", "--porcelain", "--"], PARTS].concat()).unwrap_or_default();
    let mark = if changes.is_empty() { "" } else { "-modified" };
    println!("cargo:rustc-env=SPECFORGE_COMMIT={commit}{mark}");
}
