//! One hostile text in every field of every file that the program reads: no terminal, page or figure acts on
//! it.

#[path = "report/synthetic.rs"]
mod synthetic;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use specforge::diag::Sources;
use specforge::escape::is_hidden;
use specforge::report::index::{Index, Listed};
use specforge::report::model::ReportInput;
use specforge::report::sidecar::Sidecar;
use specforge::report::{Templates, render};

/// Controls (C0, DEL, C1), text that runs backwards, separators, commands to GitHub, HTML, Markdown, quotes.
const HOSTILE: &str = "\u{1b}]0;x\u{7}\u{1b}[31m\u{9b}2J\u{7f}\u{85}\u{202e}\u{2066}\u{200f}\u{61c}\u{200b}\u{2028}\u{2029}\r\n\
                       # forged\n::error::forged\n##[error]forged\n\n```\n<script>alert(1)</script><img \
                       src=x> <!-- \
                       ![i](https://evil.example/i.png) [l](https://evil.example) [l]: https://evil.example \
                       www.evil.example \
                       | a | b \\| \\ &#x202e; \"quoted\"]; ]]> \\\" ' `";

/// Nothing but line breaks and tabs acts instead of being seen.
fn assert_visible(what: &str, text: &str) {
    let acts = |letter: &char| is_hidden(*letter) && !matches!(letter, '\n' | '\t');
    assert_eq!(text.chars().find(acts), None, "{what}: {text:?}");
}

/// What the terminal or a log is given.
fn assert_harmless(what: &str, text: &str) {
    assert_visible(what, text);
    for line in text.lines().map(str::trim_start) {
        let command =
            line.strip_prefix("::").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_alphabetic()));
        assert!(!command && !line.contains("##["), "{what}: a command to GitHub: {line}");
        assert!(!line.starts_with("# forged"), "{what}: a forged line: {text}");
    }
}

/// A page without its code spans and fenced blocks, which are shown as they are.
fn prose(page: &str) -> String {
    let (mut out, mut rest) = (String::new(), page);
    while let Some(at) = rest.find(['`', '\\']) {
        out += &rest[..at];
        rest = &rest[at..];
        if rest.starts_with('\\') {
            out += rest.get(..2).unwrap_or(rest);
            rest = rest.get(2..).unwrap_or_default();
            continue;
        }
        let run = rest.len() - rest.trim_start_matches('`').len();
        let fence = &rest[..run];
        // A fenced block ends with a fence at the begin of a line.
        if run >= 3 && (out.is_empty() || out.ends_with('\n')) {
            let end = rest[run..].find(&format!("\n{fence}\n")).expect("a fenced block ends");
            rest = &rest[run + end + 1 + run..];
            continue;
        }
        let line = if run < 3 { rest.find('\n').unwrap_or(rest.len()) } else { rest.len() };
        match rest[run..line].find(fence) {
            Some(end) => rest = &rest[run + end + run..],
            None => panic!("a code span that does not end: {rest:.200}"),
        }
    }
    out + rest
}

fn headings_of(prose: &str) -> usize {
    prose.lines().filter(|line| line.starts_with('#')).count()
}

/// A page with so many headings.
fn assert_harmless_page(what: &str, page: &str, headings: usize) {
    assert_visible(what, page);
    // A figure's file is named by its arm; in the target of an image nothing is a link.
    let prose = prose(page).replace("\\]", "").replace("%20www", "");
    for (at, _) in prose.match_indices('<') {
        let rest = &prose[at..];
        let own = ["<details>", "</details>", "<summary>", "</summary>", "<br>", "<!-- Written by "]
            .iter()
            .any(|own| rest.starts_with(own));
        let text = !rest[1..].starts_with(|c: char| c.is_ascii_alphabetic() || matches!(c, '/' | '!' | '?'));
        assert!(own || text, "{what}: an element: {rest:.60}");
    }
    for mark in ["](http", "]: http", "https://", "www.evil", "&#x202e;"] {
        assert!(!prose.contains(mark), "{what}: {mark}: {prose}");
    }
    assert_eq!(headings_of(&prose), headings, "{what}: {prose}");
    let borders = |line: &str| line.replace("\\|", "").matches('|').count();
    let lines: Vec<&str> = page.lines().collect();
    for pair in lines.windows(2).filter(|pair| pair.iter().all(|line| line.starts_with('|'))) {
        assert_eq!(borders(pair[0]), borders(pair[1]), "{what}: {pair:#?}");
    }
}

fn assert_harmless_figure(what: &str, svg: &str) {
    assert_visible(what, svg);
    let document = roxmltree::Document::parse(svg).unwrap_or_else(|error| panic!("{what}: {error}"));
    for element in document.descendants().filter(|node| node.is_element()) {
        let name = element.tag_name().name();
        let known = ["svg", "title", "metadata", "style", "path", "circle", "text"];
        assert!(known.contains(&name), "{what}: <{name}>");
    }
}

/// The same with the hostile text behind every text, but for what names a kind, a stage, a file or a number's
/// unit.
fn infected(value: &mut Value, key: &str) {
    const NAMES: [&str; 14] = [
        "template",
        "kind",
        "stage",
        "engine",
        "fingerprint",
        "unit",
        "code",
        "tool_version",
        "commit",
        "inputs",
        "ends",
        "model",
        "end",
        "profile_kind",
    ];
    match value {
        Value::String(text) if !NAMES.contains(&key) => text.push_str(HOSTILE),
        Value::Array(items) => items.iter_mut().for_each(|item| infected(item, key)),
        Value::Object(fields) => fields.iter_mut().for_each(|(key, field)| infected(field, key)),
        _ => {}
    }
}

#[test]
fn a_report_of_hostile_results_is_plain_text() {
    let clean = synthetic::input();
    let mut value = serde_json::to_value(&clean).expect("plain data");
    let mut deviating = value["deviations"].take();
    deviating.as_array_mut().expect("a list").push("another way".into());
    value["deviations"] = deviating;
    infected(&mut value, "");
    let input: ReportInput = serde_json::from_value(value).expect("the same form");
    let input = ReportInput { name: clean.name.clone(), ..input };
    let files = render(&input, &Templates::default(), &mut Sources::default()).expect("it renders");
    let twin = ReportInput { deviations: vec!["another way".into()], ..clean };
    let twin = render(&twin, &Templates::default(), &mut Sources::default()).expect("it renders");
    let headings = headings_of(&prose(&twin[0].text));
    let mut figures = 0;
    for file in &files {
        let what = file.path.display().to_string();
        match file.path.extension().and_then(|ending| ending.to_str()) {
            Some("md") => assert_harmless_page(&what, &file.text, headings),
            Some("svg") => {
                assert_harmless_figure(&what, &file.text);
                figures += 1;
            }
            _ => {}
        }
    }
    assert!(figures > 3 && files[0].text.contains("&lt;script>"), "{}", files[0].text);

    let mut record = files
        .iter()
        .find(|file| file.path.ends_with("atlas_run_torque.json"))
        .expect("a record")
        .text
        .clone();
    record = record
        .replace("\"report\": \"atlas_run_torque\"", &format!("\"report\": {}", serde_json::json!(HOSTILE)));
    let record: Sidecar = serde_json::from_str(&record).expect("a record");
    let listed = |name: &str| Listed {
        name: name.into(),
        page: name.into(),
        summary: HOSTILE.into(),
        file: HOSTILE.into(),
        profiles: vec![HOSTILE.into()],
        claims: vec![],
    };
    let index = Index {
        suites: vec![listed(HOSTILE), listed("absent")],
        reports: [(HOSTILE.to_owned(), record)].into(),
        ..Index::default()
    };
    assert_harmless_page("README.md", &index.page(), 3);
}

/// A folder with hostile files, and the program in it.
struct World {
    folder: tempfile::TempDir,
}

impl World {
    fn new() -> Self {
        let world = Self { folder: tempfile::tempdir().expect("a folder") };
        world.write("robots/.keep", "");
        let whole = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/language/whole.toml");
        world.write("whole.toml", &fs::read_to_string(whole).expect("it is there"));
        world
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("it can be made");
        fs::write(&path, text).expect("it can be written");
        path
    }

    fn run(&self, arguments: &[&str]) -> (Output, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
        let output =
            command.current_dir(self.folder.path()).args(arguments).output().expect("it can be started");
        let text =
            format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.code().is_some_and(|code| code != 101), "{arguments:?}: {text}");
        (output, text)
    }

    /// Runs the program and looks at both its streams; with `--format json` the data must be JSON.
    fn harmless(&self, arguments: &[&str]) -> String {
        let (output, text) = self.run(arguments);
        assert_harmless(&format!("{arguments:?}"), &text);
        if arguments.contains(&"json") && !output.stdout.is_empty() {
            serde_json::from_slice::<Value>(&output.stdout)
                .unwrap_or_else(|error| panic!("{arguments:?}: {error}: {text}"));
        }
        text
    }
}

/// A text as a TOML string.
fn toml(text: &str) -> String {
    specforge::escape::toml::string(text)
}

#[test]
fn a_hostile_spec_is_checked_shown_and_planned_as_plain_text() {
    let world = World::new();
    let hostile = toml(HOSTILE);
    let head = "spec = 1\nname = \"mine\"\nextends = \"whole.toml\"\n";
    world.write(
        "sound.toml",
        &format!(
            "{head}summary = {hostile}\n[profile.other]\nlearn.seed = 2\n[report]\ndeviations = [{hostile}]\n"
        ),
    );
    let shown = world.harmless(&["show", "sound.toml"]);
    assert!(shown.contains("\\u001b]0;x") && shown.contains("\\u202e"), "{shown}");
    for view in ["--resolved", "--origins", "--signals"] {
        for more in [&[][..], &["--format", "json"]] {
            world.harmless(&[&["show", "sound.toml", view], more].concat());
        }
    }
    world.harmless(&["show", "--diff", "sound.toml", "whole.toml"]);
    for format in ["human", "json", "dot", "mermaid"] {
        world.harmless(&["plan", "sound.toml", "--format", format]);
    }
    world.harmless(&["plan", "sound.toml", "--profile", "missing"]);
    world.harmless(&["why", "sound.toml", "learner"]);
    let painted = world.run(&["show", "sound.toml", "--origins", "--color", "always"]).1;
    assert!(painted.contains("\u{1b}[2mdefault\u{1b}[0m") && !painted.contains("\u{1b}]0;x"), "{painted}");

    let raw = "\u{9b}2J\u{202e}\u{2028}";
    let mistakes = [
        format!("name = {hostile}\n"),
        format!("[profile.{hostile}]\nlearn.seed = 2\n"),
        format!("[learn]\n{hostile} = 1\n"),
        format!("[learn]\nseed = {hostile} # {raw}\n"),
        format!("[learn]\nsamples = '{raw} ::error::x'\n"),
        format!("[robot]\nmodel = {hostile}\n"),
        format!("[task]\nmotion = {hostile}\n"),
        format!("[reward.{hostile}]\nweight = 1\n"),
        format!("[action]\nkind = {hostile}\n"),
        format!("[report]\ncompare = [{hostile}]\n"),
        format!("[report]\ntemplate = {hostile}\n"),
        format!("[evaluate.{hostile}]\nkind = \"episodes\"\n"),
        format!("[allow]\nW0501 = {hostile}\n{hostile} = \"x\"\n"),
        format!("[profile.{hostile}]\nlearn.{hostile} = 2\n"),
        format!("a = {raw}\n"),
    ];
    for (number, lines) in mistakes.iter().enumerate() {
        let text = if lines.starts_with("name") {
            head.replace("name = \"mine\"\n", lines)
        } else {
            format!("{head}{lines}")
        };
        let name = format!("mistake_{number}.toml");
        world.write(&name, &text);
        world.harmless(&["check", &name]);
        world.harmless(&["check", &name, "--format", "json"]);
        let (_, github) = world.run(&["check", &name, "--format", "github"]);
        let forged =
            github.lines().filter(|line| line.starts_with("::error::forged") || line.starts_with("# forged"));
        assert_eq!(forged.count(), 0, "{github}");
        assert!(!github.contains(|letter: char| is_hidden(letter) && letter != '\n'), "{github:?}");
    }
    let parent = world.write("h\u{1b}[2J\n::error::x.toml", &format!("{head}[learn]\nsede = 1\n"));
    world.harmless(&["check", "."]);
    world.harmless(&["fmt", "--check", &parent.to_string_lossy()]);
}

#[test]
fn a_hostile_suite_is_listed_and_planned_as_plain_text() {
    let world = World::new();
    let hostile = toml(HOSTILE);
    let claim = format!(
        "[[claim]]\nid = \"a\"\ntext = {hostile}\nmetric = \"evaluate.nominal.survival\"\narm = \"std=10 \
         %\"\nexpect = \"a > 0.5\"\npaper = {{ where = {hostile}, value = {hostile} }}\n"
    );
    let suite = format!(
        "spec = 1\nsuite = \"mine\"\nsummary = {hostile}\nextends = \"whole.toml\"\n[sweep]\nseeds = \
         3\n[sweep.std]\npath = \"action.std\"\nvalues = [\"10 %\", \"5 %\"]\n{claim}"
    );
    world.write("suite.toml", &suite);
    for arguments in [&["check", "suite.toml"][..], &["show", "suite.toml"], &["plan", "suite.toml"]] {
        world.harmless(arguments);
        world.harmless(&[arguments, &["--format", "json"]].concat());
    }
    for (from, to) in
        [("\"a\"", &*hostile), ("\"10 %\"", &hostile), ("sweep.std", &format!("sweep.{hostile}"))]
    {
        world.write("wrong.toml", &suite.replacen(from, to, 2));
        world.harmless(&["check", "wrong.toml"]);
    }
    let told = world.harmless(&["report", "--index", "suite.toml", "--reports", "reports"]);
    let page = fs::read_to_string(world.folder.path().join("reports/README.md"));
    let page = page.unwrap_or_else(|error| panic!("{error}: {told}"));
    assert_harmless_page("README.md", &page, 3);
}

#[test]
fn hostile_records_plans_stores_and_policies_are_told_as_plain_text() {
    let world = World::new();
    let mut plan = world.folder.path().join("plan.json");
    world.run(&["plan", "whole.toml", "--save", &plan.to_string_lossy()]);
    let mut value: Value = serde_json::from_slice(&fs::read(&plan).expect("a plan")).expect("JSON");
    infected(&mut value, "");
    plan = world.write("hostile.json", &value.to_string());
    for command in ["plan", "why", "run"] {
        let more: &[&str] = match command {
            "why" => &["learner"],
            "run" => &["--dry-run"],
            _ => &[],
        };
        world.harmless(&[&[command, &plan.to_string_lossy()], more].concat());
    }

    let files =
        render(&synthetic::input(), &Templates::default(), &mut Sources::default()).expect("it renders");
    let record = files.iter().find(|file| file.path.ends_with("atlas_run_torque.json")).expect("a record");
    let mut value: Value = serde_json::from_str(&record.text).expect("JSON");
    infected(&mut value, "");
    world.write("reports/page.json", &value.to_string());
    let items: Vec<String> = value["items"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|item| item["id"].as_str().unwrap_or_default().to_owned())
        .collect();
    world.harmless(&["trace", "reports/page.md"]);
    world.harmless(&["trace", "reports/page.md#nothing"]);
    for id in &items {
        world.harmless(&["trace", &format!("reports/page.md#{id}"), "--verbose"]);
        world.harmless(&["trace", &format!("reports/page.md#{id}"), "--format", "json"]);
    }
    world.harmless(&["report", "--index", "--reports", "reports", "whole.toml"]);

    let key = "0".repeat(64);
    for name in ["manifest.json", "journal.jsonl"] {
        world.write(&format!("store/learner/{key}/{name}"), HOSTILE);
        world.write(&format!("store/{name}"), HOSTILE);
    }
    for action in ["list", "verify"] {
        world.harmless(&["cache", action, "--store", "store"]);
    }

    let header = serde_json::json!({ HOSTILE: { "dtype": "F64", "shape": [1], "data_offsets": [0, 8] },
            "__metadata__": { "contract": HOSTILE, "format": HOSTILE } })
    .to_string();
    let bytes = [&(header.len() as u64).to_le_bytes()[..], header.as_bytes(), &[0; 8]].concat();
    fs::write(world.folder.path().join("policy.safetensors"), bytes).expect("it can be written");
    world.harmless(&["evaluate", "policy.safetensors"]);
}

#[test]
fn a_hostile_robot_is_imported_and_shown_as_plain_text() {
    let world = World::new();
    let name = |base: &str| {
        let xml: String =
            HOSTILE.chars().filter(|c| !c.is_control() || matches!(c, '\n' | '\u{80}'..='\u{9f}')).collect();
        let escaped =
            format!("{base}{xml}").replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        escaped.replace('\n', "&#10;")
    };
    let leg = |side: &str, y: f64| {
        let (link, joint) = (name(&format!("{side}_foot")), name(&format!("{side}_knee")));
        format!(
            "<link name=\"{link}\"><inertial><mass value=\"1\"/><inertia \
             ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial>\
             <collision><geometry><box size=\"0.2 0.1 0.02\"/></geometry></collision></link>\
             <joint name=\"{joint}\" type=\"revolute\"><parent link=\"{}\"/><child link=\"{link}\"/><origin \
             xyz=\"0 {y} -0.5\"/><axis xyz=\"0 1 0\"/>\
             <limit lower=\"-1\" upper=\"1\" effort=\"10\" velocity=\"5\"/></joint>",
            name("base")
        )
    };
    let urdf = format!(
        "<robot name=\"{0}\"><link name=\"{0}\"><inertial><mass value=\"5\"/><inertia \
         ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/></inertial></link>{1}{2}</robot>",
        name("base"),
        leg("left", 0.1),
        leg("right", -0.1)
    );
    world.write("hostile.urdf", &urdf);
    world.harmless(&["robot", "import", "hostile.urdf"]);
    if let Ok(text) = fs::read_to_string(world.folder.path().join("robots/hostile.toml")) {
        assert_harmless("the robot's file", &text);
        assert!(text.parse::<toml_edit::DocumentMut>().is_ok(), "{text}");
    }
    let mut robot = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/tocabi.toml"))
        .expect("it is there");
    let name = "\u{9b}2J\u{202e}\u{1b}[31m<b> \"q\" & \u{2028}\n::error::x";
    for joint in ["L_AnkleRoll_Joint", "L_AnkleRoll_Link", "L_Foot_Link"] {
        robot = robot.replace(&format!("\"{joint}\""), &toml(&format!("L_{name}")));
        robot = robot.replace(&format!("\"{}\"", joint.replacen('L', "R", 1)), &toml(&format!("R_{name}")));
    }
    world.write("robots/evil.toml", &robot);
    for format in ["human", "json", "mjcf", "urdf"] {
        world.harmless(&["robot", "show", "robots/evil.toml", "--format", format]);
    }
    world.write(
        "spec.toml",
        "spec = 1\nname = \"mine\"\nextends = \"whole.toml\"\n[robot]\nmodel = \"evil\"\n",
    );
    world.harmless(&["check", "spec.toml"]);
    world.harmless(&["show", "spec.toml", "--signals"]);
}

#[test]
fn a_parent_outside_of_the_project_is_not_read_without_permission_and_never_quoted() {
    let world = World::new();
    let other = tempfile::tempdir().expect("a folder");
    let secret = other.path().join("secret.toml");
    fs::write(&secret, "spec = 1\nabstract = true\n[lern]\ntoken = \"SECRET\"\n").expect("it can be written");
    let plain = other.path().join("plain");
    fs::write(&plain, "SECRET = SECRET\n").expect("it can be written");
    std::os::unix::fs::symlink(&secret, world.folder.path().join("link.toml")).expect("a link");
    std::os::unix::fs::symlink(&secret, world.folder.path().join("robots/link.toml")).expect("a link");
    let [secret, plain, allowed] =
        [&secret, &plain, &other.path().to_owned()].map(|path| path.display().to_string());
    let specs = [
        format!("extends = {secret:?}"),
        format!("extends = {plain:?}"),
        "extends = \"link.toml\"".to_owned(),
        "extends = \"../../../../../../../../etc/passwd\"".to_owned(),
        "extends = \"whole.toml\"\n[robot]\nmodel = \"link\"".to_owned(),
        format!("extends = \"whole.toml\"\n[report]\ncompare = [{secret:?}]"),
    ];
    let text = world.harmless(&["check", "."]);
    assert!(!text.contains("SECRET") && !text.contains("lern"), "{text}");
    for lines in specs {
        world.write("spec.toml", &format!("spec = 1\nname = \"mine\"\n{lines}\n"));
        let text = world.harmless(&["check", "spec.toml"]);
        assert!(text.contains("error[E0110]") && text.contains("--allow-outside"), "{text}");
        assert!(!text.contains("SECRET") && !text.contains("root:"), "{text}");
        if lines.contains("secret.toml") || lines.contains("plain") || lines.contains("link") {
            let text = world.harmless(&["check", "spec.toml", "--allow-outside", &allowed]);
            assert!(!text.contains("E0110") && !text.contains("SECRET"), "{text}");
        }
    }
}

#[test]
fn a_file_whose_name_has_backquotes_ends_no_code_in_a_page_or_a_message() {
    let name = "specs/a`**b** [c](d.md)`e.toml";
    let mut input = synthetic::input();
    input.request.files = vec![name.into()];
    input.arms.iter_mut().for_each(|arm| arm.spec = name.into());
    let files = render(&input, &Templates::default(), &mut Sources::default()).expect("it renders");
    let page = &files[0].text;
    assert!(page.contains(&format!("\nspecforge run '{name}'")), "{page}");
    assert!(page.contains(&format!("| `` {name} ``")), "{page}");
    assert!(!prose(page).contains("**b**"), "{page}");
    let suite = Listed { name: "mine".into(), page: "mine".into(), file: name.into(), ..Listed::default() };
    let index = Index { suites: vec![suite], ..Index::default() }.page();
    assert!(index.contains(&format!("`` specforge run '{name}' ``")), "{index}");

    let world = World::new();
    let file = "a`$(x)`b.toml";
    let missing = world.harmless(&["check", file]);
    assert!(missing.contains("file not found: `a\\u0060$(x)\\u0060b.toml`"), "{missing}");
    world.write("base.toml", "spec = 1\nname = \"base\"\nextends = \"whole.toml\"\n");
    world.write(file, "spec = 1\nname = \"mine\"\nlearn.nope = 1\nextends = \"whole.toml\"\n");
    world.write(
        "own.toml",
        &format!("spec = 1\nname = \"own\"\nextends = \"whole.toml\"\n[report]\nbaseline = '{file}'\n"),
    );
    let wrong = world.harmless(&["check", "own.toml"]);
    assert!(
        wrong.contains("the baseline `./a\\u0060$(x)\\u0060b.toml` has errors")
            || wrong.contains("`a\\u0060$(x)\\u0060b.toml` has errors"),
        "{wrong}"
    );
    assert!(
        wrong.contains(&format!("specforge check '{file}'"))
            || wrong.contains(&format!("specforge check './{file}'")),
        "{wrong}"
    );
}
