//! Inputs without an end, without a size or without a bottom: each is refused with its code, and nothing
//! hangs or exhausts the memory. What is refused as a robot's description is in `hostile.rs`.

use std::fs;
use std::io::Read;
use std::os::unix::fs::symlink;
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use rustix::fs::{CWD, Mode, mkfifoat};
use specforge::bounded::ReadError;
use specforge::check::{Checked, Checker, checked_in, suite_in};
use specforge::diag::{MOST_OF_A_CODE, Sources};
use specforge::kinds::learn::Ppo;
use specforge::report::Templates;
use specforge::spec::LoadOptions;
use specforge::syntax::files::Sort;
use specforge::syntax::{Files, Nowhere, Overlay};

/// A command that takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(60);

/// Exit code and words of a command in a folder; a command that hangs is killed and has no exit code.
fn said(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.args(arguments).current_dir(folder).stdin(Stdio::null());
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it can be started");
    let (mut output, mut errors) = (child.stdout.take().expect("piped"), child.stderr.take().expect("piped"));
    let reader = std::thread::spawn(move || {
        let (mut first, mut second) = (Vec::new(), Vec::new());
        let _ = errors.read_to_end(&mut first);
        let _ = output.read_to_end(&mut second);
        String::from_utf8_lossy(&[first, second].concat()).into_owned()
    });
    let begin = Instant::now();
    let exit = loop {
        if let Some(status) = child.try_wait().expect("it is ours") {
            break status.code();
        }
        if begin.elapsed() > PATIENCE {
            let _ = child.kill();
            let _ = child.wait();
            break None;
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    (exit, reader.join().expect("reading does not fail"))
}

#[track_caller]
fn assert_refused(folder: &Path, arguments: &[&str], (exit, words): (i32, &str)) {
    let (found, text) = said(folder, arguments);
    let shown: String = text.chars().take(1500).collect();
    assert!(
        found == Some(exit) && text.contains(words),
        "{arguments:?}: exit {found:?}, wanted {exit} {words}\n{shown}"
    );
}

/// A project with a sound spec `specs/sound.toml`.
fn project() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    for name in ["specs/motions", "robots", "templates", "reports"] {
        fs::create_dir_all(path(name)).expect("a folder");
    }
    let whole = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/language/whole.toml"));
    fs::write(path("specs/whole.toml"), whole.expect("readable")).expect("written");
    fs::write(path("specs/sound.toml"), spec("")).expect("written");
    folder
}

/// A sound spec with more lines.
fn spec(more: &str) -> String {
    format!("spec = 1\nname = \"small\"\nsummary = \"x\"\nextends = \"whole.toml\"\n{more}")
}

/// The sorts of things that are in the place of a file, with what is said about them.
const SORTS: &[(&str, &str)] =
    &[("pipe", "named pipe"), ("zero", "device"), ("socket", "socket"), ("folder", "folder")];

/// Puts something that is no regular file at a path.
fn put(sort: &str, path: &Path) {
    match sort {
        "pipe" => mkfifoat(CWD, path, Mode::RUSR | Mode::WUSR).expect("a pipe"),
        "zero" => symlink("/dev/zero", path).expect("a link"),
        "socket" => drop(UnixListener::bind(path).expect("a socket")),
        _ => fs::create_dir(path).expect("a folder"),
    }
}

#[test]
fn only_regular_files_are_read_whatever_they_are_for() {
    for (sort, words) in SORTS {
        let outer = project();
        let folder = outer.path();
        let path = |name: &str| folder.join(name);
        for name in [
            "specs/it.toml",
            "robots/it.toml",
            "specs/motions/it.toml",
            "it.json",
            "it.safetensors",
            "it.urdf",
        ] {
            put(sort, &path(name));
        }
        put(sort, &path("templates/it.md.j2"));
        fs::write(path("specs/child.toml"), "spec = 1\nname = \"c\"\nextends = \"it.toml\"\n")
            .expect("written");
        fs::write(path("specs/robot.toml"), spec("[robot]\nmodel = \"it\"\n")).expect("written");
        fs::write(path("specs/motion.toml"), spec("[task]\nmotion = \"it\"\n")).expect("written");
        fs::write(path("specs/template.toml"), spec("[report]\ntemplate = \"it.md.j2\"\n")).expect("written");
        let suite = "spec = 1\nsuite = \"s\"\nextends = \"it.toml\"\n[sweep]\nseeds = 1\n";
        fs::write(path("specs/suite.toml"), suite).expect("written");
        fs::write(path("specs/compare.toml"), spec("[report]\ncompare = [\"it.toml\"]\n")).expect("written");
        for command in ["check", "plan", "show", "why", "run", "fmt"] {
            let arguments = if command == "why" {
                vec![command, "specs/it.toml", "learner"]
            } else {
                vec![command, "specs/it.toml"]
            };
            if *sort != "folder" {
                assert_refused(folder, &arguments, (3, "error[E0007]"));
            } else if !matches!(command, "check" | "fmt") {
                assert_refused(folder, &arguments, (3, words));
            }
        }
        // A device lies outside of the project, which is told before it is looked at.
        let named = if *sort == "zero" { "is outside of the project" } else { words };
        for spec in ["child", "robot", "motion", "template", "suite"] {
            assert_refused(folder, &["check", &format!("specs/{spec}.toml")], (3, named));
        }
        if *sort != "folder" {
            assert_refused(folder, &["check", "specs/compare.toml"], (3, named));
        }
        assert_refused(folder, &["plan", "it.json"], (2, words));
        assert_refused(folder, &["trace", "it.json"], (2, words));
        assert_refused(folder, &["evaluate", "it.safetensors"], (3, words));
        assert_refused(folder, &["robot", "show", "robots/it.toml"], (3, words));
        assert_refused(folder, &["robot", "import", "it.urdf"], (3, words));
    }
}

#[test]
fn a_folder_with_pipes_devices_and_loops_is_searched_and_told() {
    let outer = project();
    let folder = outer.path();
    put("pipe", &folder.join("specs/pipe.toml"));
    put("zero", &folder.join("specs/zero.toml"));
    symlink("..", folder.join("specs/up")).expect("a link");
    symlink("nothing.toml", folder.join("specs/.#lock.toml")).expect("a link");
    symlink("itself.toml", folder.join("specs/itself.toml")).expect("a link");
    let (exit, text) = said(folder, &["check", "."]);
    assert_eq!(exit, Some(3), "{text}");
    for words in ["pipe.toml`: it is a named pipe", "zero.toml`: it is a device", "itself.toml`: "] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(text.contains("5 specs: 3 errors") && !text.contains("lock"), "{text}");
}

#[test]
fn the_store_and_the_reports_may_hold_pipes() {
    let outer = project();
    let folder = outer.path();
    fs::create_dir_all(folder.join(".specforge")).expect("a folder");
    put("pipe", &folder.join(".specforge/journal.jsonl"));
    for arguments in
        [&["plan", "specs/sound.toml"][..], &["why", "specs/sound.toml", "learner"], &["cache", "gc"]]
    {
        let (exit, text) = said(folder, arguments);
        assert!(exit.is_some(), "{arguments:?} hangs: {text}");
    }
    put("pipe", &folder.join("reports/it.json"));
    let suite = "spec = 1\nsuite = \"s\"\nsummary = \"x\"\nextends = \"whole.toml\"\n[sweep]\nseeds = 1\n";
    fs::write(folder.join("specs/suite.toml"), suite).expect("written");
    assert_refused(folder, &["report", "--index", "specs/suite.toml"], (4, "named pipe"));
}

#[test]
fn what_reports_no_size_is_bounded_by_what_is_read() {
    let outer = project();
    // `/proc/self/maps` has more than a few kilobytes and reports 0; nothing of it is a spec.
    let (exit, text) = said(outer.path(), &["check", "/proc/self/maps"]);
    assert!(exit == Some(3) && text.contains("E0001"), "{text}");
    let (exit, text) = said(outer.path(), &["check", "/proc/self/mem"]);
    assert!(exit == Some(3) && text.contains("E0006"), "{text}");
    // A sparse file of a terabyte is refused by its size, and what grows while it is read by the limit.
    fs::File::create(outer.path().join("huge.toml")).unwrap().set_len(1 << 40).unwrap();
    assert_refused(outer.path(), &["check", "huge.toml"], (3, "E0006"));
    fs::File::create(outer.path().join("huge.json")).unwrap().set_len(1 << 40).unwrap();
    assert_refused(outer.path(), &["plan", "huge.json"], (2, "huge.json"));
}

#[test]
fn standard_input_is_bounded() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.args(["fmt", "-"]).stdin(fs::File::open("/dev/zero").expect("there is one"));
    let output = command.output().expect("it can be started");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(3) && text.contains("more than the 1 MiB allowed"), "{text}");
}

/// The codes of the mistakes of a template, and what is said.
fn preflight(text: &[u8]) -> Vec<(&'static str, String)> {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("own.md.j2"), text).expect("written");
    fs::write(folder.path().join("latin.md.j2"), b"\xe9").expect("written");
    fs::write(folder.path().join("deep.md.j2"), "{% include 'none.md.j2' %}").expect("written");
    let templates = Templates::new(Some(folder.path().to_owned()));
    let found = specforge::report::check("own.md.j2", &templates, &mut Sources::default());
    found.into_iter().map(|found| (found.code, found.message)).collect()
}

#[test]
fn templates_that_are_nested_without_end_are_refused_before_they_are_parsed() {
    let around = |open: &str, inside: &str, close: &str| {
        let [open, close] = [open, close].map(|piece| format!("{piece}\n").repeat(70_000));
        format!("{{{{ {open}{inside}{close} }}}}")
    };
    let cases = [
        ("not", around("not ", "1", "")),
        ("minus", around("-", "1", "")),
        ("brackets", around("[", "", "]")),
        ("parentheses", around("(", "1", ")")),
        ("braces", around("{'a':", "1", "}")),
        ("sums", around("1 + ", "1", "")),
        ("powers", around("2 ** ", "1", "")),
        ("concatenations", around("'a' ~ ", "'a'", "")),
        ("attributes", around("", "name", ".x")),
        ("calls", around("", "name", "()")),
        ("items", around("", "name", "[0]")),
        ("filters", around("", "1", "|string")),
        ("tests", around("", "1", " is odd")),
        ("conditions", around("1 if 1 else ", "1", "")),
        ("comparisons", around("", "1", " < 2")),
        ("and", around("1 and ", "1", "")),
        ("branches", format!("{{% if 1 %}}{}{{% endif %}}", "{% elif 1 %}\n".repeat(70_000))),
        ("hidden", format!("{{{{ '}}}}' ~ {} 1 }}}}", "not \n".repeat(100_000))),
        ("statement", format!("{{% set x = {}1 %}}", "not \n".repeat(100_000))),
    ];
    for (name, text) in cases {
        let found = preflight(text.as_bytes());
        assert!(found.first().is_some_and(|(code, _)| *code == "E0905"), "{name}: {found:?}");
    }
    // Of these, the parser itself knows the limit.
    for (name, open, close) in
        [("if", "{% if 1 %}", "{% endif %}"), ("for", "{% for x in [] %}", "{% endfor %}")]
    {
        let found = preflight(
            format!("{}{}", format!("{open}\n").repeat(20_000), format!("{close}\n").repeat(20_000))
                .as_bytes(),
        );
        assert!(found.iter().any(|(code, _)| *code == "E0905"), "{name}: {found:?}");
    }
    let long = format!("{{{{ [{}]|length }}}}", vec!["1"; 20_000].join(",\n"));
    assert_eq!(preflight(long.as_bytes()), [], "a long list is not deep");
    // What does not end in one line would have a column beyond the engine's numbers.
    for text in ["{#".repeat(400_000), format!("{{{{ '{}", "a".repeat(900_000)), "{% raw %}".repeat(100_000)]
    {
        assert_eq!(preflight(text.as_bytes())[0].0, "E0905");
    }
}

#[test]
fn of_very_many_mistakes_of_a_template_the_first_are_listed() {
    let filters = "{{ name|nope }}\n".repeat(50_000);
    let variables: String = (0..50_000).map(|number| format!("{{{{ v{number} }}}}\n")).collect();
    for (text, code) in [(filters, "E0903"), (variables, "E0902")] {
        let found = preflight(text.as_bytes());
        assert!(
            found.len() == MOST_OF_A_CODE + 1 && found.iter().all(|(found, _)| *found == code),
            "{}",
            found.len()
        );
    }
}

#[test]
fn missing_includes_and_wrong_encodings_are_found_before_anything_runs() {
    let codes = |text: &str| preflight(text.as_bytes()).into_iter().map(|(code, _)| code).collect::<Vec<_>>();
    assert_eq!(codes("{% include 'none.md.j2' %}"), ["E0901"]);
    assert_eq!(codes("{% from 'none.md.j2' import f %}"), ["E0901"]);
    assert_eq!(codes("{% extends 'none.md.j2' %}"), ["E0901"]);
    assert_eq!(codes("{% include 'deep.md.j2' %}"), ["E0901"], "in a template that is included");
    assert_eq!(codes("{% include 'latin.md.j2' %}"), ["E0906"]);
    assert_eq!(
        codes("{% include 'none.md.j2' ignore missing %}{% include ['none.md.j2', 'report.md.j2'] %}"),
        [""; 0]
    );
    assert_eq!(preflight(b"caf\xe9")[0].0, "E0906");
    assert_eq!(preflight(&vec![b'a'; (1 << 20) + 1])[0].0, "E0906");
}

#[test]
fn a_template_that_asks_for_more_memory_than_there_is_is_refused_and_ends_no_process() {
    let project = project();
    let folder = project.path();
    fs::write(folder.join("specs/sound.toml"), spec("[report]\ntemplate = \"mine.md.j2\"\n"))
        .expect("written");
    let doubled = format!("{{% set a = 'aaaaaaaa' %}}{}{{{{ a|length }}}}", "{% set a = a ~ a %}".repeat(60));
    for template in [
        "{{ 'a'|indent(1000000000000000) }}",
        "{{ 'a\nb'|indent(18446744073709551615) }}",
        "{{ ('x' * 90000000)|replace('x', 'y' * 90000000)|length }}",
        "{{ range(100000)|join('x' * 90000000)|length }}",
        "{{ [1]|batch(1000000000000000, 'x')|list|length }}",
        "{{ [1]|slice(1000000000000000)|list|length }}",
        "{{ '%1000000000000000d'|format(1) }}",
        doubled.as_str(),
    ] {
        fs::write(folder.join("templates/mine.md.j2"), template).expect("written");
        let (exit, text) = said(folder, &["check", "specs/sound.toml"]);
        assert!(exit == Some(3) && text.contains("error[E090"), "{template}: {exit:?} {text}");
        assert!(!text.contains("panicked") && !text.contains("R0010"), "{template}: {text}");
    }
}

#[test]
fn ten_thousand_parents_are_an_error_and_no_stack_overflow() {
    let outer = project();
    let path = |number: usize| outer.path().join(format!("specs/p{number}.toml"));
    for number in 0..10_000 {
        let text = format!("spec = 1\nname = \"p\"\nextends = \"p{}.toml\"\n", number + 1);
        fs::write(path(number), text).expect("written");
    }
    fs::write(path(10_000), "spec = 1\nname = \"p\"\nextends = \"whole.toml\"\n").expect("written");
    for command in ["check", "plan"] {
        assert_refused(outer.path(), &[command, "specs/p0.toml"], (3, "error[E0109]"));
    }
    let (exit, text) = said(outer.path(), &["check", "specs/p9975.toml"]);
    assert!(exit == Some(0), "{text}");
    // Wide, not deep: so many parents that nobody can follow them.
    let names: Vec<String> = (0..600).map(|number| format!("\"w{number}.toml\"")).collect();
    (0..600).for_each(|number| {
        fs::write(outer.path().join(format!("specs/w{number}.toml")), "spec = 1\n").expect("written")
    });
    let wide = format!("spec = 1\nname = \"w\"\nextends = [\"whole.toml\", {}]\n", names.join(", "));
    fs::write(outer.path().join("specs/wide.toml"), wide).expect("written");
    assert_refused(outer.path(), &["check", "specs/wide.toml"], (3, "error[E0109]"));
}

/// The codes of the errors of a spec that lies in memory beside `whole.toml`, each once.
fn codes(text: &str) -> Vec<&'static str> {
    let mut codes: Vec<&str> =
        checked(&files(text)).sink.diagnostics.iter().map(|found| found.code).collect();
    codes.sort();
    codes.dedup();
    codes
}

/// Files in memory: `spec.toml` and `whole.toml`.
fn files(text: &str) -> Counted {
    let whole = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/language/whole.toml");
    let mut overlay = Overlay::new(Nowhere);
    overlay.hold(Path::new("whole.toml"), fs::read_to_string(whole).expect("readable"));
    overlay.hold(Path::new("spec.toml"), text);
    Counted { files: overlay, reads: AtomicUsize::new(0) }
}

fn checked(files: &Counted) -> Checked {
    checked_in(files, Path::new("spec.toml"), &LoadOptions::default())
}

/// Files that count how often one is read.
struct Counted {
    files: Overlay<Nowhere>,
    reads: AtomicUsize,
}

impl Files for Counted {
    fn sort(&self, path: &Path) -> std::io::Result<Sort> {
        self.files.sort(path)
    }

    fn bytes(&self, path: &Path, limit: u64) -> Result<Vec<u8>, ReadError> {
        self.reads.fetch_add(1, Ordering::Relaxed);
        self.files.bytes(path, limit)
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        self.files.names(folder)
    }

    fn absolute(&self, path: &Path) -> PathBuf {
        self.files.absolute(path)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        self.files.identity(path)
    }
}

fn profiles(count: usize) -> String {
    spec(
        &(0..count).map(|number| format!("[profile.p{number}]\nlearn.seed = {number}\n")).collect::<String>(),
    )
}

#[test]
fn a_spec_is_read_once_however_many_profiles_it_is_checked_under() {
    let files = files(&profiles(1000));
    let mut checker = Checker::default();
    checker.remember_specs();
    for number in 0..1000 {
        let options = LoadOptions { profile: Some(format!("p{number}")), ..LoadOptions::default() };
        let checked = checker.check(&files, Path::new("spec.toml"), &options);
        assert_eq!(checked.sink.diagnostics, []);
        let seed = checked
            .experiment
            .expect("it was read")
            .section("learn")
            .and_then(|learn| learn.value(Ppo::seed));
        assert_eq!(seed, Some(number));
    }
    // The spec and its parent; the robot and the motion are those of the program.
    assert_eq!(files.reads.load(Ordering::Relaxed), 2);
}

#[test]
fn a_thousand_profiles_are_checked_and_planned() {
    let outer = project();
    fs::write(outer.path().join("specs/many.toml"), profiles(1000)).expect("written");
    for command in ["check", "plan"] {
        let (exit, text) = said(outer.path(), &[command, "specs/many.toml"]);
        assert_eq!(exit, Some(0), "{text}");
    }
}

#[test]
fn specs_with_too_many_entries_say_so_and_list_the_first_mistakes() {
    let many = |count: usize, line: &dyn Fn(usize) -> String| spec(&(0..count).map(line).collect::<String>());
    let terms = many(16_000, &|number| format!("[reward.xx{number}]\nweight = 1\n"));
    assert_eq!(codes(&terms), ["E0009", "E0301"]);
    let found = checked(&files(&terms)).sink.diagnostics;
    assert_eq!(
        found.len(),
        MOST_OF_A_CODE + 2,
        "as many as can be read, that there are more, and that they are too many"
    );
    let terms =
        many(900, &|number| format!("[reward.xx{number}]\nkind = \"velocity_tracking\"\nenabled = false\n"));
    assert_eq!(codes(&terms), ["E0605"]);
    assert_eq!(codes(&profiles(2001)), ["E0009"]);
    assert_eq!(codes(&spec(&format!("[learn]\nx = [{}]\n", "1,".repeat(200_000)))), ["E0009"]);
    assert_eq!(codes(&many(40_000, &|number| format!("k{number} = 1\n"))), ["E0102"]);
    assert_eq!(codes(&format!("spec = 1\n[learn]\n{}", "x = 1\n".repeat(100_000))), ["E0104"]);
    assert_eq!(codes(&"x\n".repeat(500_000)), ["E0001"]);
    for nested in [
        format!("a = {}{}", "[".repeat(400_000), "]".repeat(400_000)),
        format!("a{} = 1", ".a".repeat(400_000)),
    ] {
        assert_eq!(codes(&nested), ["E0001"]);
    }
}

#[test]
fn a_word_as_long_as_its_file_gives_a_short_message() {
    let long = "a".repeat(900_000);
    for text in [format!("[reward.{long}]\nweight = 1\n"), format!("[learn]\n{long} = 1\n")] {
        let found = checked(&files(&spec(&text))).sink.diagnostics;
        assert!(!found.is_empty() && found.iter().all(|found| found.message.len() < 5000), "{}", found.len());
    }
    let stars = format!(
        "[randomize.joint_offset]\noffset = {{ normal = [\"0 rad\", \"1e-3 rad\"] }}\njoints = [\"{}\"]\n",
        "*a".repeat(400_000)
    );
    assert_eq!(codes(&spec(&stars)), ["E0402"]);
}

/// The codes of the mistakes of a suite, each once.
fn suite_codes(sweep: &str) -> Vec<&'static str> {
    let text =
        format!("spec = 1\nsuite = \"s\"\nsummary = \"x\"\nextends = \"whole.toml\"\n[sweep]\n{sweep}");
    let found = suite_in(&files(&text), Path::new("spec.toml"), &LoadOptions::default());
    // What exceeds a limit is left out: at most the points of the one sound axis remain.
    assert!(!found.sink.has_errors() || found.arms.len() <= 2, "{} arms", found.arms.len());
    let mut codes: Vec<&str> = found.sink.diagnostics.iter().map(|found| found.code).collect();
    codes.dedup();
    codes
}

#[test]
fn runs_are_counted_before_they_are_made() {
    let list = |count: usize| (0..count).map(|number| format!("{}, ", 8192 + number)).collect::<String>();
    let axis = |name: &str, path: &str, count: usize| {
        format!("[sweep.{name}]\npath = \"{path}\"\nvalues = [{}]\n", list(count))
    };
    assert_eq!(suite_codes(&format!("seeds = 1000\n{}", axis("a", "learn.rollout", 200))), ["E0204"]);
    assert_eq!(suite_codes("seeds = 1000000000000\n"), ["E0204"]);
    assert_eq!(suite_codes(&format!("seeds = [{}]\n", list(40_000))), ["E0204"]);
    assert_eq!(suite_codes(&axis("a", "learn.rollout", 40_000)), ["E0204"]);
    // The product of all axes does not fit into 64 bits.
    let axes: String =
        (0..30).map(|number| axis(&format!("a{number}"), &format!("learn.x{number}"), 900)).collect();
    assert_eq!(suite_codes(&format!("seeds = 1000\n{axes}")), ["E0204"]);
    let axes: String =
        (0..9000).map(|number| axis(&format!("a{number}"), &format!("learn.x{number}"), 1)).collect();
    assert_eq!(suite_codes(&axes), ["E0009"]);
    let patterns = "[[sweep.include]]\na = \"8192\"\n".repeat(20_000);
    assert_eq!(suite_codes(&format!("{}{patterns}", axis("a", "learn.rollout", 1))), ["E0009"]);
    let same: String = (0..900).map(|number| format!("[sweep.a.p{number}]\nlearn.seed = 1\n")).collect();
    assert_eq!(suite_codes(&same), ["E0104"]);
}
