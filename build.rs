//! Writes the places of the native libraries into the binary, so that it runs from any folder.

use std::path::Path;

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
        println!("cargo:rustc-link-arg=-Wl,-rpath,{}/lib", absolute(folder));
    }
    if has("MUJOCO") {
        let folder = std::env::var("MUJOCO_DYNAMIC_LINK_DIR").unwrap_or_else(|_| "third_party/mujoco/lib".into());
        println!("cargo:rustc-link-arg=-Wl,-rpath,{}", absolute(folder));
    }
    let commit = std::process::Command::new("git")
        .args(["rev-parse", "--short=12", "HEAD"])
        .current_dir(&root)
        .output()
        .ok()
        .filter(|output| output.status.success())
        .map_or_else(|| "unknown".into(), |output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    println!("cargo:rustc-env=SPECFORGE_COMMIT={commit}");
}
