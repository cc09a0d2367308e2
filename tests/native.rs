//! The native libraries: what is on the disk is held against the pinned digests, not against a version that a
//! file claims.

use std::fs;
use std::path::Path;
use std::process::Command;

/// Fetches a small library of its own, from a wheel that is made on the spot.
const SCRIPT: &str = r#"
import importlib.util, pathlib, sys, zipfile
spec = importlib.util.spec_from_file_location("fetch_native", "tools/fetch_native.py")
fetch = importlib.util.module_from_spec(spec)
spec.loader.exec_module(fetch)
fetch.TARGET = pathlib.Path(sys.argv[1])

def download(wheels, folder):
    with zipfile.ZipFile(folder / "tiny.whl", "w") as wheel:
        wheel.writestr("tiny/lib/libtiny.so.1", sys.argv[2])
        wheel.writestr("tiny/include/tiny.h", "int tiny(void);")
    return [folder / "tiny.whl"]

fetch.download = download
place = lambda member: member.removeprefix("tiny/")
finish = lambda folder: (folder / "lib/libtiny.so").symlink_to("libtiny.so.1")
import hashlib
sha = lambda text: hashlib.sha256(text.encode()).hexdigest()
pinned = {
    "lib/libtiny.so.1": sha("library"),
    "lib/libtiny.so": "link to libtiny.so.1",
    "include/": sha("include/tiny.h " + sha("int tiny(void);") + "\n"),
}
fetch.install("tiny", "1.0", [("tiny", "1.0", "")], pinned, place, finish)
"#;

/// Fetches from a wheel with this library; says whether it succeeded and what was told.
fn fetch(target: &Path, library: &str) -> (bool, String) {
    let mut command = Command::new("python3");
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env("PYTHONDONTWRITEBYTECODE", "1").args(["-c", SCRIPT]);
    let output = command.arg(target).arg(library).output().expect("Python is installed");
    (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_library_that_is_not_as_pinned_is_fetched_again() {
    let target = tempfile::tempdir().expect("a folder");
    let tiny = target.path().join("tiny");
    let fetched = |told: &str| told.contains("downloading");
    let (well, told) = fetch(target.path(), "library");
    assert!(well && fetched(&told), "{told}");
    let (well, told) = fetch(target.path(), "library");
    assert!(well && told.is_empty(), "nothing is to be done: {told}");
    let changes: [(&str, &dyn Fn()); 6] = [
        ("lib/libtiny.so.1 differs", &|| {
            fs::write(tiny.join("lib/libtiny.so.1"), "l1brary").expect("written")
        }),
        ("lib/libtiny.so.1 is missing", &|| fs::remove_file(tiny.join("lib/libtiny.so.1")).expect("removed")),
        ("include/ differs", &|| {
            fs::write(tiny.join("include/tiny.h"), "long tiny(void);").expect("written")
        }),
        ("lib/libm.so.6 does not belong there", &|| {
            fs::write(tiny.join("lib/libm.so.6"), "").expect("written")
        }),
        ("build-version differs", &|| fs::write(tiny.join("build-version"), "2.0\n").expect("written")),
        ("lib/libtiny.so differs", &|| {
            fs::remove_file(tiny.join("lib/libtiny.so")).expect("removed");
            fs::write(tiny.join("lib/libtiny.so"), "library").expect("written");
        }),
    ];
    for (what, change) in changes {
        change();
        let (well, told) = fetch(target.path(), "library");
        assert!(well && told.contains(what) && fetched(&told), "{what}: {told}");
        assert!(fetch(target.path(), "library").1.is_empty(), "{what}");
    }
}

#[test]
fn a_wheel_that_is_not_as_pinned_replaces_nothing() {
    let target = tempfile::tempdir().expect("a folder");
    assert!(fetch(target.path(), "library").0);
    let library = target.path().join("tiny/lib/libtiny.so.1");
    fs::write(&library, "edited").expect("written");
    let (well, told) = fetch(target.path(), "another library");
    assert!(!well && told.contains("are not as pinned: lib/libtiny.so.1 differs"), "{told}");
    assert_eq!(fs::read_to_string(&library).expect("it is there"), "edited");
}
