//! The modules stand in `src/lib.rs` in the order of the pipeline and import only from those above them;
//! inside a folder no modules use each other in a cycle.

#[path = "layering/cycles.rs"]
mod cycles;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The modules in the order of `src/lib.rs`.
fn modules() -> Vec<String> {
    let text = fs::read_to_string(source().join("lib.rs")).expect("src/lib.rs is readable");
    text.lines()
        .filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'))
        .map(str::to_owned)
        .collect()
}

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The Rust files of a module.
fn files(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let entries = fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.path());
    entries
        .filter(|path| path.is_dir() || path.extension().is_some_and(|end| end == "rs"))
        .flat_map(|p| files(&p))
        .collect()
}

/// The modules of the crate that a text names: in `crate::name` and in `crate::{name, other::thing}`.
/// Comments may name anything.
fn imported(text: &str) -> Vec<String> {
    let code: String =
        text.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned() + "\n").collect();
    let mut names = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        if code[..at].ends_with(|before: char| before.is_alphanumeric() || before == '_' || before == '$') {
            continue;
        }
        let rest = &code[at + "crate::".len()..];
        match rest.strip_prefix('{') {
            None => names.push(word(rest)),
            Some(group) => names.extend(heads(group)),
        }
    }
    names
}

/// The first word of every item of a brace group that has just been opened.
fn heads(group: &str) -> Vec<String> {
    let (mut depth, mut item, mut names) = (0, String::new(), Vec::new());
    for letter in group.chars() {
        match letter {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => names.push(word(&std::mem::take(&mut item))),
            _ if depth == 0 => item.push(letter),
            _ => {}
        }
    }
    names.push(word(&item));
    names
}

fn word(text: &str) -> String {
    text.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

#[test]
fn imports_are_found_alone_and_in_groups() {
    let text = "use crate::diag::Span;\nuse crate::{sim, env::{A, B}, kinds};\n// crate::report\nlet x = \
        crate::quantity::parse();";
    assert_eq!(imported(text), ["diag", "sim", "env", "kinds", "quantity"]);
}

#[test]
fn no_module_imports_from_one_below_it() {
    let modules = modules();
    assert!(modules.len() > 10, "src/lib.rs lists the modules: {modules:?}");
    let mut upward = Vec::new();
    for (rank, module) in modules.iter().enumerate() {
        let folder = source().join(module);
        let path = if folder.is_dir() { folder } else { source().join(format!("{module}.rs")) };
        for file in files(&path) {
            let text = fs::read_to_string(&file).expect("sources are readable");
            let below = |name: &String| {
                modules.iter().position(|other| other == name).is_some_and(|other| other > rank)
            };
            for name in imported(&text).into_iter().filter(below) {
                upward.push(format!(
                    "{} imports {name}",
                    file.strip_prefix(source()).unwrap_or(&file).display()
                ));
            }
        }
    }
    assert!(upward.is_empty(), "a module may import only from those above it in src/lib.rs: {upward:#?}");
}

/// The path of a file's module below `src/`; `None` for tests, which may use anything.
fn module_of(file: &Path) -> Option<cycles::Module> {
    let path = file.strip_prefix(source()).expect("it is below").with_extension("");
    let mut module: Vec<String> = path.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    if module.iter().any(|name| name == "tests") {
        return None;
    }
    if module.last().is_some_and(|last| last == "mod") || matches!(module.as_slice(), [only] if only == "lib")
    {
        module.pop();
    }
    (module != ["main"]).then_some(module)
}

#[test]
fn inside_a_folder_no_modules_use_each_other_in_a_cycle() {
    let read =
        |file: PathBuf| Some((module_of(&file)?, fs::read_to_string(&file).expect("sources are readable")));
    let found = cycles::Crate::new(files(&source()).into_iter().filter_map(read)).cycles();
    assert_eq!(found, BTreeMap::new(), "move what both modules need into a module below them");
}

#[test]
fn only_the_bounded_reader_reads_whole_files() {
    let unbounded = ["fs::read(", "fs::read_to_string(", ".and_then(fs::read)", "stdin().lock().read"];
    let mut found = Vec::new();
    for file in files(&source()) {
        let text = fs::read_to_string(&file).expect("sources are readable");
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        let code = code.split("#[cfg(all(test").next().unwrap_or_default();
        let name = file.strip_prefix(source()).expect("it is below").display().to_string();
        let exempt = name.ends_with("tests.rs") || name.contains("/tests/");
        if !exempt && unbounded.iter().any(|call| code.contains(call)) {
            found.push(name);
        }
    }
    assert!(found.is_empty(), "read with `bounded::bytes` or `bounded::text`: {found:?}");
}

/// The files below `src` that name a crate, by their path there.
fn naming(krate: &str) -> Vec<String> {
    let head = format!("{krate}::");
    let names = |text: &str| {
        let code = text.lines().map(|line| line.split("//").next().unwrap_or_default());
        code.into_iter().any(|line| {
            let own = |at: usize| !line[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
            line.match_indices(&head).any(|(at, _)| own(at))
        })
    };
    let files = files(&source()).into_iter();
    let naming = files.filter(|file| names(&fs::read_to_string(file).expect("sources are readable")));
    naming.map(|file| file.strip_prefix(source()).expect("it is below").display().to_string()).collect()
}

#[test]
fn libtorch_and_the_engines_are_named_only_where_they_live() {
    // The doctor says what libtorch there is, and whether it finds a device; tests compare with its autograd.
    let torch =
        ["cli/command/doctor.rs", "learn/backend/tests.rs", "learn/ppo/tests/autograd.rs", "learn/tests.rs"];
    for (krate, home, beside) in
        [("tch", "learn/backend/torch/", &torch[..]), ("rapier3d", "sim/", &[]), ("mujoco_rs", "sim/", &[])]
    {
        let mut naming = naming(krate);
        naming.sort();
        let (inside, outside): (Vec<_>, Vec<_>) = naming.into_iter().partition(|file| file.starts_with(home));
        assert!(!inside.is_empty(), "{krate} is named nowhere in {home}");
        assert_eq!(outside, beside, "{krate} belongs to {home}");
    }
}
