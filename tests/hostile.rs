//! Descriptions of robots that mean harm, or that nobody has looked at: each is refused with its code, its
//! place and a cure, in bounded time and memory, and nothing is written.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Longest time that an import may take.
const PATIENCE: Duration = Duration::from_secs(20);
/// Memory in KiB that an import may have; the engine's libraries need more than that for themselves.
const MEMORY: &str = if cfg!(feature = "torch") { "unlimited" } else { "1000000" };

/// A description, what is said to it (code, line, words), and which file has the place.
#[derive(Clone)]
struct Case {
    name: &'static str,
    text: String,
    code: &'static str,
    line: Option<usize>,
    words: &'static str,
}

/// A link of URDF on a line of its own.
fn link(name: &str, inertial: &str, rest: &str) -> String {
    format!("<link name=\"{name}\">{inertial}{rest}</link>\n")
}

const SOUND: &str = "<inertial><mass value=\"2\"/><inertia \
    ixx=\"0.02\" iyy=\"0.02\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";

fn joint(name: &str, kind: &str, (parent, child): (&str, &str), rest: &str) -> String {
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
         <axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"1\" effort=\"50\" velocity=\"9\"/>{rest}</joint>\n"
    )
}

/// A robot of URDF: line 1 opens it, `body` follows from line 2 on.
fn urdf(body: &str) -> String {
    format!("<robot name=\"r\">\n{body}</robot>\n")
}

/// Base and two feet, on lines 2 to 4, their joints on lines 5 and 6; `inertial` and `rest` are those of the
/// left foot.
fn walker(inertial: &str, rest: &str) -> String {
    let links = [link("base", SOUND, ""), link("left", inertial, rest), link("right", SOUND, "")].concat();
    let joints =
        [joint("l", "revolute", ("base", "left"), ""), joint("r", "revolute", ("base", "right"), "")]
            .concat();
    urdf(&(links + &joints))
}

fn inertial(mass: &str, moments: [&str; 3]) -> String {
    let [xx, yy, zz] = moments;
    format!(
        "<inertial><mass value=\"{mass}\"/><inertia \
         ixx=\"{xx}\" iyy=\"{yy}\" izz=\"{zz}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>"
    )
}

fn mesh(file: &str) -> String {
    walker(SOUND, &format!("<collision><geometry><mesh filename=\"{file}\"/></geometry></collision>"))
}

/// So many links, each on the last one, all revolute.
fn chain(links: usize) -> String {
    let mut text = link("l0", SOUND, "");
    for index in 1..links {
        text += &link(&format!("l{index}"), SOUND, "");
        text +=
            &joint(&format!("j{index}"), "revolute", (&format!("l{}", index - 1), &format!("l{index}")), "");
    }
    urdf(&text)
}

fn mjcf(body: &str) -> String {
    format!(
        "<mujoco>\n<worldbody>\n<body name=\"base\"><freejoint/>\n{body}</body>\n</worldbody>\n</mujoco>\n"
    )
}

/// A body of MJCF with a hinge and what stands in it.
fn limb(name: &str, inside: &str) -> String {
    format!("<body name=\"{name}\"><joint name=\"{name}_joint\"/>{inside}</body>\n")
}

const WEIGHT: &str = "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"0.1 0.1 0.1\"/>";

fn case(name: &'static str, text: String, (code, line, words): (&'static str, usize, &'static str)) -> Case {
    Case { name, text, code, line: (line > 0).then_some(line), words }
}

fn figures() -> Vec<Case> {
    let sound = ["0.02", "0.02", "0.01"];
    vec![
        case("zero mass", walker(&inertial("0", sound), ""), ("E0405", 3, "0 kg")),
        case("negative mass", walker(&inertial("-1", sound), ""), ("E0405", 3, "-1 kg")),
        case(
            "negative inertia",
            walker(&inertial("1", ["-0.02", "0.02", "0.01"]), ""),
            ("E0405", 3, "negative principal"),
        ),
        case(
            "triangle",
            walker(&inertial("1", ["0.05", "0.02", "0.01"]), ""),
            ("E0405", 3, "triangle inequality"),
        ),
        case("not a number", walker(&inertial("nan", sound), ""), ("E0411", 3, "not a finite number")),
        case("infinite", walker(&inertial("inf", sound), ""), ("E0411", 3, "not a finite number")),
        case("too large a number", walker(&inertial("1e400", sound), ""), ("E0411", 3, "`1e400`")),
        case("no number", walker(&inertial("heavy", sound), ""), ("E0411", 3, "`heavy`")),
        case("empty number", walker(&inertial("", sound), ""), ("E0411", 3, "needs one number, found 0")),
        case(
            "two numbers of three",
            walker(SOUND, "<collision><geometry><box size=\"1 1\"/></geometry></collision>"),
            ("E0411", 3, "needs 3 numbers, found 2"),
        ),
        case(
            "negative box",
            walker(SOUND, "<collision><geometry><box size=\"1 -1 1\"/></geometry></collision>"),
            ("E0405", 3, "not positive"),
        ),
        case(
            "limits the wrong way round",
            walker(SOUND, "").replacen("lower=\"-1\" upper=\"1\"", "lower=\"1\" upper=\"-1\"", 1),
            ("E0405", 5, "not an interval"),
        ),
        case(
            "axis without length",
            walker(SOUND, "").replacen("0 1 0", "0 0 0", 1),
            ("E0411", 5, "has no length"),
        ),
        case(
            "line break in a name",
            walker(SOUND, "").replace("\"left\"", "\"le&#10;ft\""),
            ("E0411", 3, "not a name"),
        ),
    ]
}

/// So many default classes.
fn classes(count: usize) -> String {
    (0..count).map(|index| format!("<default class=\"c{index}\"/>")).collect()
}

fn trees() -> Vec<Case> {
    let two = link("a", SOUND, "") + &link("b", SOUND, "");
    let circle = joint("ab", "revolute", ("a", "b"), "") + &joint("ba", "revolute", ("b", "a"), "");
    let three = two.clone() + &link("c", SOUND, "");
    let loose = joint("bc", "revolute", ("b", "c"), "") + &joint("cb", "revolute", ("c", "b"), "");
    vec![
        case("circle", urdf(&(two.clone() + &circle)), ("E0412", 4, "circle")),
        case("circle beside the tree", urdf(&(three.clone() + &loose)), ("E0412", 5, "circle")),
        case(
            "link on itself",
            urdf(&(link("a", SOUND, "") + &joint("aa", "revolute", ("a", "a"), ""))),
            ("E0412", 3, "circle"),
        ),
        case("two roots", urdf(&two), ("E0412", 2, "hang on nothing")),
        case("no links", urdf(""), ("E0412", 1, "no link")),
        case(
            "two parents",
            urdf(&(three + &joint("ac", "fixed", ("a", "c"), "") + &joint("bc", "fixed", ("b", "c"), ""))),
            ("E0412", 6, "two joints"),
        ),
        case(
            "unknown link",
            urdf(&(two.clone() + &joint("ax", "fixed", ("a", "x"), ""))),
            ("E0412", 4, "there is no link `x`"),
        ),
        case("one name twice", urdf(&(two.clone() + &link("a", SOUND, ""))), ("E0412", 4, "two links")),
        case(
            "unknown type",
            urdf(&(two + &joint("ab", "elastic", ("a", "b"), ""))),
            ("E0411", 4, "unknown type `elastic`"),
        ),
        case("forty-one joints", chain(42), ("E0407", 84, "41 joints")),
        case("a thousand links", chain(1001), ("E0415", 1, "1001 links")),
        case(
            "two bases",
            "<mujoco><worldbody><body><freejoint/></body>\n<body><freejoint/></body></worldbody></mujoco>"
                .into(),
            ("E0412", 2, "base is not clear"),
        ),
        case("empty world", "<mujoco><worldbody/></mujoco>".into(), ("E0412", 1, "no body")),
        case("a thousand bodies", mjcf(&limb("b", WEIGHT).repeat(1000)), ("E0415", 0, "500 bodies")),
        case(
            "classes that multiply",
            format!(
                "<mujoco><default>\n<geom user=\"{}\" size=\"{}\"/></default></mujoco>",
                "1 ".repeat(1_000_000),
                "1 ".repeat(1_000_000)
            ),
            ("E0415", 2, "more than 400 letters"),
        ),
        case(
            "classes without end",
            format!("<mujoco><default>{}</default></mujoco>", classes(10_000)),
            ("E0415", 0, "200 default classes"),
        ),
        case(
            "replicated",
            mjcf("<replicate count=\"1000000\"><body/></replicate>\n"),
            ("E0413", 4, "<replicate>"),
        ),
        case(
            "nested deeper than a stack",
            format!(
                "<mujoco><worldbody>{}{}</worldbody></mujoco>",
                "<body>".repeat(15_000),
                "</body>".repeat(15_000)
            ),
            ("E0415", 1, "deep"),
        ),
        case(
            "attributes without end",
            format!(
                "<robot>\n<link {}/></robot>",
                (0..1_000_000).map(|index| format!("a{index}=\"\" ")).collect::<String>()
            ),
            ("E0415", 2, "attributes"),
        ),
        case(
            "elements without end",
            format!("<robot>{}</robot>", "<link name=\"a\"/>".repeat(900_000)),
            ("E0415", 1, "elements"),
        ),
    ]
}

fn texts() -> Vec<Case> {
    let laughs = (1..10).fold("<!ENTITY l0 \"lol\">".to_owned(), |mut text, depth| {
        let _ = write!(text, "<!ENTITY l{depth} \"{}\">", format!("&l{};", depth - 1).repeat(10));
        text
    });
    vec![
        case(
            "billion laughs",
            format!("<!DOCTYPE r [{laughs}]>\n<robot name=\"&l9;\"/>"),
            ("E0410", 1, "DOCTYPE"),
        ),
        case(
            "external entity",
            "<!DOCTYPE r [<!ENTITY x SYSTEM \"file:///etc/passwd\">]>\n<robot name=\"&x;\"/>".into(),
            ("E0410", 1, "DOCTYPE"),
        ),
        case(
            "external subset",
            "<!DOCTYPE r SYSTEM \"http://127.0.0.1:9/r.dtd\">\n<robot/>".into(),
            ("E0410", 1, "DOCTYPE"),
        ),
        case("unknown entity", "<robot name=\"&x;\"/>".into(), ("E0410", 1, "well-formed")),
        case("not closed", "<robot>\n<link>\n".into(), ("E0410", 1, "never closed")),
        case("empty", String::new(), ("E0410", 1, "well-formed")),
        case("a web page", "<html/>".into(), ("E0410", 1, "`html`")),
        case("sdf", "<sdf/>".into(), ("E0410", 1, "SDF")),
        case(
            "xacro",
            "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n<xacro:macro name=\"m\"/></robot>".into(),
            ("E0410", 2, "xacro"),
        ),
        case("zero bytes", "\0\0\0".into(), ("E0410", 1, "well-formed")),
    ]
}

fn files() -> Vec<Case> {
    let include = |file: &str| format!("<mujoco>\n<include file=\"{file}\"/>\n</mujoco>");
    vec![
        case("mesh above", mesh("../../../../etc/passwd"), ("E0414", 3, "outside the robot's folder")),
        case("mesh at the root", mesh("/etc/passwd"), ("E0414", 3, "outside the robot's folder")),
        case(
            "mesh of a package above",
            mesh("package://../../secret.stl"),
            ("E0414", 3, "outside the robot's folder"),
        ),
        case("mesh through a link", mesh("link.stl"), ("E0414", 3, "outside the robot's folder")),
        case("mesh of a gigabyte", mesh("huge.stl"), ("E0415", 3, "1024 MiB")),
        case("mesh of nonsense", mesh("nonsense.stl"), ("E0414", 3, "cannot be read")),
        case("mesh without end", mesh("endless.stl"), ("E0414", 3, "outside the robot's folder")),
        case("mesh that is a folder", mesh("folder.stl"), ("E0414", 3, "it is a folder")),
        case("include above", include("../../../../etc/passwd"), ("E0414", 2, "outside the robot's folder")),
        case("include of nothing", include("nothing.xml"), ("E0414", 2, "not there")),
        case("include of itself", include("self.xml"), ("E0414", 2, "twice")),
        case("include of a gigabyte", include("huge.stl"), ("E0415", 2, "1024 MiB")),
        case("include of nonsense", include("nonsense.stl"), ("E0410", 1, "well-formed")),
        case("huge itself", "huge".into(), ("E0415", 0, "1024 MiB")),
    ]
}

/// A folder with everything that the descriptions name.
fn folder() -> tempfile::TempDir {
    let outer = tempfile::tempdir().unwrap();
    let inner = outer.path().join("robot");
    fs::create_dir_all(inner.join("folder.stl")).unwrap();
    fs::write(outer.path().join("secret.stl"), "solid").unwrap();
    fs::write(inner.join("nonsense.stl"), "nonsense").unwrap();
    fs::write(inner.join("self.xml"), "<mujoco>\n<include file=\"self.xml\"/>\n</mujoco>").unwrap();
    // Sparse: a gigabyte of zeros that takes no room on the disk.
    fs::File::create(inner.join("huge.stl")).unwrap().set_len(1 << 30).unwrap();
    std::os::unix::fs::symlink("../secret.stl", inner.join("link.stl")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", inner.join("endless.stl")).unwrap();
    outer
}

/// What an import of a file in a folder says, and with which exit code.
fn import(folder: &Path, file: &str) -> (Option<i32>, String) {
    let command = format!("ulimit -v {MEMORY}; exec \"$0\" robot import \"$1\" --name mine");
    let mut shell = Command::new("sh");
    shell.args(["-c", &command, env!("CARGO_BIN_EXE_specforge"), file]).current_dir(folder);
    let output = shell.output().expect("the shell can be started");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn hostile_descriptions_are_refused_with_code_place_and_cure_and_nothing_is_written() {
    let outer = folder();
    let inner = outer.path().join("robot");
    let mut wrong = String::new();
    for Case { name, text, code, line, words } in [figures(), trees(), texts(), files()].concat() {
        let file = if text == "huge" { "huge.stl" } else { "robot.xml" };
        fs::write(inner.join("robot.xml"), &text).unwrap();
        let begin = Instant::now();
        let (exit, said) = import(&inner, file);
        let spent = begin.elapsed();
        let placed = line.is_none_or(|line| said.contains(&format!(":{line}:")));
        let cured = said.contains("help: ");
        let first = said.starts_with(&format!("error[{code}]: "));
        if exit != Some(3) || !first || !placed || !cured || !said.contains(words) || spent > PATIENCE {
            let shown: String = said.chars().take(600).collect();
            let _ = writeln!(
                wrong,
                "{name}: exit {exit:?} after {spent:?}, wanted {code} {line:?} {words}\n{shown}"
            );
        }
        assert!(!inner.join("robots").exists(), "{name} has written something");
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn the_same_descriptions_without_the_harm_are_taken() {
    let outer = folder();
    let inner = outer.path().join("robot");
    let sole = "<collision><geometry><box size=\"0.2 0.1 0.02\"/></geometry></collision>";
    let mesh = mesh("missing.stl");
    for (name, text) in
        [("urdf", walker(SOUND, sole)), ("forty", chain(40).replace("l0", "base")), ("mesh", mesh)]
    {
        fs::write(inner.join("robot.xml"), &text).unwrap();
        let (exit, said) = import(&inner, "robot.xml");
        // A chain has one end, and a robot has two feet: it is refused for that alone.
        let wanted = if name == "forty" { Some(3) } else { Some(0) };
        assert!(exit == wanted && !said.contains("E0407"), "{name}: {said}");
        let _ = fs::remove_dir_all(inner.join("robots"));
    }
}

#[test]
fn another_root_opens_the_folder_above_and_no_more() {
    let outer = folder();
    let inner = outer.path().join("robot");
    fs::write(inner.join("robot.xml"), mesh("../box.obj")).unwrap();
    fs::write(outer.path().join("box.obj"), "v 0 0 0\nv 0.2 0 0\nv 0 0.1 0\nv 0 0 0.04\nf 1 2 3\nf 1 2 4\n")
        .unwrap();
    let run = |root: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
        command.args(["robot", "import", "robot.xml", "--name", "mine", "--root", root]).current_dir(&inner);
        command.output().unwrap()
    };
    assert_eq!(run(".").status.code(), Some(3));
    let output = run("..");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(inner.join("robots/mine.toml")).unwrap();
    assert!(text.contains("the mesh ../box.obj became the box around it, 0.200 x 0.100 x 0.040 m"), "{text}");
    assert!(text.contains("half_extents = [\"0.1 m\", \"0.05 m\", \"0.02 m\"]"), "{text}");
}

#[test]
fn very_many_mistakes_are_not_all_told() {
    let outer = folder();
    let inner = outer.path().join("robot");
    fs::write(inner.join("robot.xml"), chain(400).replace("value=\"2\"", "value=\"x\"")).unwrap();
    let (exit, said) = import(&inner, "robot.xml");
    assert_eq!(exit, Some(3));
    assert_eq!(said.matches("error[E0411]").count(), 20, "{said}");
}

/// A robot file that is TOML already: G1 with one text replaced, or a thousand links.
#[test]
fn hostile_robot_files_are_refused_with_code_and_place() {
    let folder = tempfile::tempdir().unwrap();
    let g1 = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/g1.toml")).unwrap();
    let first = g1.find("[[links]]").unwrap();
    let feet = g1.find("[feet.left]").unwrap();
    let thousand = format!("{}{}{}", &g1[..first], g1[first..feet].repeat(84), &g1[feet..]);
    let edit = |from: &str, to: &str| {
        assert!(g1.contains(from), "{from}");
        g1.replacen(from, to, 1)
    };
    let cases = [
        ("zero mass", edit("mass = \"1.35 kg\"", "mass = \"0 kg\""), "E0405"),
        ("negative inertia", edit("ixx = \"0.001811004868 kg*m^2\"", "ixx = \"-1 kg*m^2\""), "E0405"),
        ("triangle", edit("ixx = \"0.001811004868 kg*m^2\"", "ixx = \"1 kg*m^2\""), "E0405"),
        ("not a number", edit("mass = \"1.35 kg\"", "mass = \"nan kg\""), "E0205"),
        ("too large a number", edit("mass = \"1.35 kg\"", "mass = \"1e400 kg\""), "E0205"),
        ("bare nan", edit("axis = [0.0, 1.0, 0.0]", "axis = [nan, 1.0, 0.0]"), "E0205"),
        ("circle", edit("parent = \"pelvis\"", "parent = \"left_knee_link\""), "E0404"),
        ("link on itself", edit("parent = \"pelvis\"", "parent = \"left_hip_pitch_link\""), "E0404"),
        ("a thousand links", thousand, "E0407"),
        ("flat cylinder", cylinder(&g1, "[\"0 m\", \"0 m\", \"0 m\"]"), "E0405"),
        ("huge", format!("# {}\n{g1}", "x".repeat(2 << 20)), "E0006"),
    ];
    for (name, text, code) in cases {
        fs::write(folder.path().join("bad.toml"), text).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
        let begin = Instant::now();
        let output = command.args(["robot", "show", "bad.toml"]).current_dir(folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let refused = output.status.code() == Some(3) && said.contains(&format!("error[{code}]"));
        let shown: String = said.chars().take(600).collect();
        assert!(refused && output.stdout.is_empty() && begin.elapsed() < PATIENCE, "{name}: {shown}");
    }
}

/// G1 with a cylinder from the origin to a point.
fn cylinder(g1: &str, to: &str) -> String {
    let old = "{ shape = \"box\", half_extents = [\"0.08 m\", \"0.11 m\", \"0.19 m\"], \
               centre = [\"0 m\", \"0 m\", \"0.17 m\"] }";
    assert!(g1.contains(old));
    let shape = format!(
        "{{ shape = \"cylinder\", from = [\"0 m\", \"0 m\", \"0 m\"], to = {to}, radius = \"0.1 m\" }}"
    );
    g1.replacen(old, &shape, 1)
}
