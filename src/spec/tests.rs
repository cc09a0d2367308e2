//! Whole specs in their own folder, with a small vocabulary.

use std::path::PathBuf;

use proptest::prelude::*;

use super::typed::units::One;
use super::typed::{Keys, Sampled, Typed};
use super::*;
use crate::quantity::Dimension;

const RATE: Param = Param::required("rate", Ty::Quantity(Dimension::RATE));
const STD: Param = Param::default("std", Ty::Ratio(Share::of("the limit")), "\"10 %\"");

/// A number.
fn number(section: Option<Section>, key: &str) -> f64 {
    section.and_then(|section| section.get(key)).and_then(f64::read).expect("a number")
}

/// A text, if it is there.
fn text(section: Option<Section>, key: &str) -> Option<String> {
    section.and_then(|section| section.get(key)).and_then(String::read)
}

static TORQUE: Kind = Kind { name: "torque", since: Edition::ONE, doc: "", params: &[RATE, STD], needs: &[] };
static POSITION: Kind = Kind {
    name: "position",
    since: Edition::ONE,
    doc: "",
    params: &[
        RATE,
        Param::required("stiffness", Ty::Ratio(Share::of("the gain"))),
        Param::required("servo_rate", Ty::Quantity(Dimension::RATE)),
        Param::optional("noise", Ty::Sampler(Dimension::ANGLE)),
    ],
    needs: &[],
};
static EFFORT: Kind = Kind {
    name: "effort",
    since: Edition::ONE,
    doc: "",
    params: &[Param::required("k", Ty::Quantity(Dimension::PER_TORQUE))],
    needs: &[],
};
static UPRIGHT: Kind = Kind { name: "upright", since: Edition::ONE, doc: "", params: &[], needs: &[] };
static WALK: Kind = Kind {
    name: "walk",
    since: Edition::ONE,
    doc: "",
    params: &[Param::required("motion", Ty::Text)],
    needs: &[],
};

fn vocabulary() -> Vocabulary {
    let shape = |name, shape, required| SectionShape { name, noun: name, shape, required };
    let sections = vec![
        shape("robot", Shape::Plain(section::Robot::PARAMS), true),
        shape("task", Shape::Kind(vec![&WALK]), false),
        shape("action", Shape::Kind(vec![&TORQUE, &POSITION]), true),
        shape("reward", Shape::Terms(vec![&EFFORT, &UPRIGHT], section::RewardTerm::PARAMS), true),
        shape("report", Shape::Plain(section::Report::PARAMS), false),
    ];
    let robots = vec![Embedded { name: "atlas", text: "name = \"atlas\"" }];
    Vocabulary { sections, robots, motions: vec![Embedded { name: "stroll", text: "" }] }
}

/// A temporary folder with these files.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = Self::bare(files);
        std::fs::create_dir_all(folder.path("robots")).expect("made");
        folder
    }

    /// Without `robots/`.
    fn bare(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("below the folder")).expect("made");
            std::fs::write(path, text).expect("written");
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn load(&self, name: &str, profile: Option<&str>, sets: &[&str]) -> Loaded {
        let sets = sets.iter().map(|set| (*set).to_owned()).collect();
        let options = LoadOptions { profile: profile.map(str::to_owned), sets, ..LoadOptions::default() };
        load(&self.path(name), &options, &vocabulary())
    }

    /// The experiment of a valid spec.
    fn sound(&self, name: &str, profile: Option<&str>, sets: &[&str]) -> Experiment {
        let loaded = self.load(name, profile, sets);
        assert!(loaded.sink.diagnostics.is_empty(), "{:#?}", loaded.sink.diagnostics);
        loaded.experiment.expect("no mistakes")
    }

    /// Code, marked text and edit of every mistake.
    fn mistakes(
        &self,
        name: &str,
        profile: Option<&str>,
        sets: &[&str],
    ) -> Vec<(&'static str, String, Option<String>)> {
        let loaded = self.load(name, profile, sets);
        let found = loaded.sink.diagnostics.iter().map(|found| {
            let marked = found.labels.first().map(|label| {
                loaded.sources.get(label.span.source).text[label.span.start..label.span.end].to_owned()
            });
            (found.code, marked.unwrap_or_default(), found.fix.as_ref().map(|fix| fix.replacement.clone()))
        });
        found.collect()
    }
}

const WALKER: &str = "spec = 1
name = \"walker\"
[robot]
model = \"atlas\"
[action]
kind = \"torque\"
rate = \"250 Hz\"
[reward.effort]
weight = 0.1
k = \"0.01 /N/m\"
[reward.upright]
weight = 0.3
[profile.quick]
action.rate = \"100 Hz\"
";

fn mistake(code: &'static str, marked: &str, fix: Option<&str>) -> (&'static str, String, Option<String>) {
    (code, marked.to_owned(), fix.map(str::to_owned))
}

fn rate(experiment: &Experiment) -> f64 {
    number(experiment.section("action"), "rate")
}

#[test]
fn a_spec_is_decoded_with_defaults_and_origins() {
    let folder = Folder::new(&[("walker.toml", WALKER)]);
    let Loaded { sources, experiment, .. } = folder.load("walker.toml", None, &[]);
    let experiment = experiment.expect("sound");
    assert_eq!((experiment.name.as_str(), rate(&experiment)), ("walker", 250.0));
    assert_eq!(number(experiment.section("action"), "std"), 0.1);
    let reward = experiment.section("reward").expect("sound");
    assert_eq!(reward.section("effort").and_then(|term| term.kind()), Some("effort"));
    assert_eq!(text(experiment.section("report"), "template").as_deref(), Some("report.md.j2"));
    let file = folder.path("walker.toml");
    let origins = experiment.origins(&sources);
    assert_eq!(origins["action.rate"].to_string(), format!("{}:7", file.display()));
    assert_eq!(origins["action.std"], Origin::Default);
    assert_eq!(experiment.robot.expect("built in").path, None);
    assert_eq!(*experiment.profiles, ["quick"]);
}

#[test]
fn the_question_of_a_parents_report_is_not_the_childs() {
    let parent = format!("{WALKER}[report]\ntemplate = \"report.md.j2\"\nquestion = \"Does it walk?\"\n");
    let child = "spec = 1\nextends = \"walker.toml\"\n";
    let folder = Folder::new(&[("walker.toml", &parent), ("child.toml", child)]);
    let question = |file: &str| {
        let experiment = folder.sound(file, None, &[]);
        text(experiment.section("report"), "question")
    };
    assert_eq!(question("walker.toml").as_deref(), Some("Does it walk?"));
    assert_eq!(question("child.toml"), None);
}

#[test]
fn precedence_is_default_parent_file_profile_set() {
    let child = "spec = 1\nextends = \"../walker.toml\"\n[action]\nstd = \"5 %\"\n";
    let folder = Folder::new(&[("walker.toml", WALKER), ("specs/child.toml", child)]);
    let action = |profile, sets: &[&str]| folder.sound("specs/child.toml", profile, sets);
    assert_eq!(rate(&action(None, &[])), 250.0);
    assert_eq!(rate(&action(Some("quick"), &[])), 100.0);
    let experiment = action(Some("quick"), &["action.rate=50 Hz"]);
    assert_eq!(rate(&experiment), 50.0);
    assert_eq!(experiment.name, "child", "a name is not inherited");
    let origin = |profile, sets: &[&str]| {
        let Loaded { sources, experiment, .. } = folder.load("specs/child.toml", profile, sets);
        experiment.expect("sound").origins(&sources)["action.rate"].to_string()
    };
    assert_eq!(origin(Some("quick"), &["action.rate=50 Hz"]), "--set action.rate=50 Hz");
    let file = folder.path("walker.toml");
    assert_eq!(origin(Some("quick"), &[]), format!("profile quick, {}:14", file.display()));
    assert_eq!(number(action(None, &[]).section("action"), "std"), 0.05);
}

#[test]
fn later_parents_win_and_a_diamond_counts_its_top_once() {
    let left = "spec = 1\nextends = \"walker.toml\"\nabstract = true\naction.rate = \"10 Hz\"\n";
    let right = "spec = 1\nextends = \"walker.toml\"\nabstract = true\nreward.upright.weight = 0.5\n";
    let child = "spec = 1\nextends = [\"left.toml\", \"right.toml\"]\n";
    let files = [("walker.toml", WALKER), ("left.toml", left), ("right.toml", right), ("child.toml", child)];
    let experiment = Folder::new(&files).sound("child.toml", None, &[]);
    assert_eq!(rate(&experiment), 10.0, "the right parent's own parent does not undo the left one");
    let reward = experiment.section("reward").expect("sound");
    assert_eq!(number(reward.section("upright"), "weight"), 0.5);
    assert!(!experiment.is_abstract);
}

#[test]
fn a_changed_kind_replaces_the_section_and_a_disabled_term_goes() {
    let child = "spec = 1\nextends = \"walker.toml\"
[action]\nkind = \"position\"\nrate = \"10 Hz\"\nstiffness = \"25 %\"\nservo_rate = \"1 kHz\"
[reward.upright]\nenabled = false\n[profile.quick]\naction.noise = { normal = [\"0 rad\", \"1 rad\"] }
";
    let folder = Folder::new(&[("walker.toml", WALKER), ("child.toml", child)]);
    let experiment = folder.sound("child.toml", None, &["action.noise={ uniform = [\"0 rad\", \"1 rad\"] }"]);
    assert!(experiment.section("action").expect("sound").get("std").is_none());
    assert!(experiment.section("reward").expect("sound").section("upright").is_none());
    let both =
        folder.sound("child.toml", Some("quick"), &["action.noise={ uniform = [\"0 rad\", \"1 rad\"] }"]);
    let noise = both
        .section("action")
        .expect("sound")
        .get("noise")
        .and_then(Sampled::<One>::read)
        .expect("a distribution");
    assert_eq!(noise, Sampler::Uniform([0.0, 1.0]), "another distribution replaces");
}

#[test]
fn parents_that_are_missing_or_go_in_a_circle_are_one_error() {
    let a = "spec = 1\nextends = \"b.toml\"\n";
    let b = "spec = 1\nextends = \"a.toml\"\n";
    let lost = "spec = 1\nextends = \"wlaker.toml\"\n";
    let folder = Folder::new(&[("a.toml", a), ("b.toml", b), ("lost.toml", lost), ("walker.toml", WALKER)]);
    assert_eq!(folder.mistakes("a.toml", None, &[]), [mistake("E0602", "\"a.toml\"", None)]);
    let shown = |name: &str| folder.path(name).display().to_string();
    let chain = [shown("a.toml"), shown("b.toml"), shown("a.toml")].join(" -> ");
    assert_eq!(
        folder.load("a.toml", None, &[]).sink.diagnostics[0].message,
        format!("a cycle of parents: {chain}")
    );
    assert_eq!(folder.mistakes("lost.toml", None, &[]), [mistake("E0601", "\"wlaker.toml\"", None)]);
}

#[test]
fn files_without_an_edition_or_of_another_stop_at_that() {
    let folder = Folder::new(&[
        ("none.toml", "nmae = 1"),
        ("two.toml", "spec = 2\nnmae = 1"),
        ("text.toml", "spec = ["),
    ]);
    assert_eq!(folder.mistakes("none.toml", None, &[]), [mistake("E0002", "", Some("spec = 1\n"))]);
    assert_eq!(folder.mistakes("two.toml", None, &[]), [mistake("E0003", "2", Some("1"))]);
    assert!(folder.mistakes("text.toml", None, &[]).iter().all(|(code, ..)| *code == "E0001"));
    assert_eq!(folder.mistakes("absent.toml", None, &[])[0].0, "E0004");
    assert!(folder.load("two.toml", None, &[]).experiment.is_none());
}

#[test]
fn all_mistakes_of_a_spec_are_found_at_once_and_each_once() {
    let text = WALKER.replace("rate = \"250 Hz\"", "rate = \"250 rad/s\"\nstiffness = \"3 %\"")
        + "[reward.uprihgt]\nweight = 1\n[reward.effort2]\nkind = \"effort\"\nweight = 1\nk = 3\n[rewrad]\nx \
            = 1\n";
    let text = text.replace("model = \"atlas\"", "model = \"atals\"");
    let folder = Folder::new(&[("walker.toml", &text)]);
    let expected = [
        mistake("E0401", "\"atals\"", Some("\"atlas\"")),
        mistake("E0203", "rad/s", None),
        mistake("E0503", "stiffness", None),
        mistake("E0301", "uprihgt", Some("upright")),
        mistake("E0201", "3", Some("\"3 /N/m\"")),
        mistake("E0102", "rewrad", Some("reward")),
    ];
    assert_eq!(folder.mistakes("walker.toml", None, &[]), expected);
}

#[test]
fn a_section_that_is_written_inside_another_is_recognised() {
    let folder = Folder::new(&[("walker.toml", &(WALKER.to_owned() + "[action.reward]\nx = 1\n"))]);
    let found = folder.load("walker.toml", None, &[]).sink.diagnostics;
    assert_eq!(found[0].help, ["it is a section of its own: write `reward`, not `action.reward`"]);
    let folder = Folder::new(&[("walker.toml", &(WALKER.to_owned() + "[env.reward]\nx = 1\n"))]);
    let found = folder.load("walker.toml", None, &[]).sink.diagnostics;
    assert_eq!(found[0].help, ["`reward` is a section of its own: write `reward`, not `env.reward`"]);
}

#[test]
fn a_failed_section_is_absent_and_the_others_are_there() {
    let folder = Folder::new(&[("walker.toml", &WALKER.replace("250 Hz", "fast"))]);
    let experiment = folder.load("walker.toml", None, &[]).experiment.expect("understood in part");
    assert!(experiment.section("action").is_none());
    assert_eq!(experiment.poisoned, ["action"]);
    assert!(experiment.section("reward").is_some());
}

#[test]
fn a_position_action_without_gains_and_missing_sections_are_told() {
    let text = "spec = 1\n[action]\nkind = \"position\"\nrate = \"1 Hz\"\nservo_rate = \"2 Hz\"\n[reward]\n";
    let folder = Folder::new(&[("bare.toml", text)]);
    let expected = [mistake("E0101", "spec", None), mistake("E0504", "[action]", None)];
    assert_eq!(folder.mistakes("bare.toml", None, &[]), expected);
}

#[test]
fn a_section_of_terms_has_no_switch_and_the_advice_names_the_terms() {
    let child = "spec = 1\nextends = \"walker.toml\"\n[reward]\nenabled = false\n";
    let folder = Folder::new(&[("walker.toml", WALKER), ("child.toml", child)]);
    assert_eq!(folder.mistakes("child.toml", None, &[]), [mistake("E0103", "enabled", None)]);
    let found = folder.load("child.toml", None, &[]).sink.diagnostics;
    assert!(found[0].help[0].contains("`reward.NAME.enabled = false`"), "{found:#?}");
}

#[test]
fn terms_are_switched_off_only_where_they_were_on() {
    let child = "spec = 1\nextends = \"walker.toml\"\n[reward.uprigth]\nenabled = false\n";
    let folder = Folder::new(&[("walker.toml", WALKER), ("child.toml", child)]);
    assert_eq!(folder.mistakes("child.toml", None, &[]), [mistake("E0605", "uprigth", Some("upright"))]);
}

#[test]
fn what_is_written_below_a_switch_that_is_off_is_checked_all_the_same() {
    let folder = |own: &str| {
        let child = format!("spec = 1\nextends = \"walker.toml\"\n[reward.upright]\nenabled = false\n{own}");
        Folder::new(&[("walker.toml", WALKER), ("child.toml", &child)])
    };
    assert_eq!(folder("weight = 2.0\n").mistakes("child.toml", None, &[]), [], "sound, and off");
    assert_eq!(
        folder("weihgt = 2.0\n").mistakes("child.toml", None, &[]),
        [mistake("E0102", "weihgt", Some("weight"))]
    );
    assert_eq!(folder("weight = nan\n").mistakes("child.toml", None, &[]), [mistake("E0205", "nan", None)]);
    assert_eq!(folder("weight = \"1 m\"\n").mistakes("child.toml", None, &[])[0].0, "E0103");
    assert_eq!(folder("kind = \"uprigth\"\n").mistakes("child.toml", None, &[])[0].0, "E0301");
    for (set, code) in [("weight=nan", "E0205"), ("wieght=1", "E0604"), ("weight=true", "E0103")] {
        let found = folder("").mistakes("child.toml", None, &[&format!("reward.upright.{set}")]);
        assert_eq!(found[0].0, code, "{set}");
    }
}

#[test]
fn profiles_are_known_and_those_not_chosen_are_checked_too() {
    let text = WALKER.to_owned() + "[profile.slow]\naction.rate = \"1 s\"\n";
    let folder = Folder::new(&[("walker.toml", WALKER), ("slow.toml", &text)]);
    assert_eq!(folder.mistakes("walker.toml", Some("qiuck"), &[]), [mistake("E0706", "", None)]);
    assert_eq!(folder.mistakes("slow.toml", None, &[]), [mistake("E0203", "s", None)]);
    assert_eq!(folder.mistakes("slow.toml", Some("slow"), &[]), [mistake("E0203", "s", None)]);
}

#[test]
fn a_profile_has_no_name() {
    let folder = Folder::new(&[("walker.toml", &(WALKER.to_owned() + "name = \"other\"\n"))]);
    assert_eq!(folder.mistakes("walker.toml", None, &[]), [mistake("E0102", "name", None)]);
}

#[test]
fn assignments_are_checked_like_any_other_value() {
    let folder = Folder::new(&[("walker.toml", WALKER)]);
    let found = |set: &str| {
        let mut found = folder.mistakes("walker.toml", None, &[set]);
        assert_eq!(found.len(), 1, "{found:?}");
        found.remove(0)
    };
    assert_eq!(found("action.raet=1 Hz"), mistake("E0604", "raet", Some("rate")));
    assert_eq!(found("acton.rate=1 Hz"), mistake("E0604", "acton", Some("action")));
    assert_eq!(found("reward.efort.weight=1"), mistake("E0604", "efort", Some("effort")));
    assert_eq!(found("action.rate=1 rad"), mistake("E0203", "rad", None));
    assert_eq!(found("spec=2"), mistake("E0603", "spec", None));
    assert_eq!(found("name=other"), mistake("E0603", "name", None));
    assert_eq!(found("profile.quick.action.rate=1 Hz"), mistake("E0603", "profile", None));
    assert_eq!(found("robot.mass=3 kg"), mistake("E0603", "mass", None));
    assert_eq!(found("action.kind=torqe"), mistake("E0301", "torqe", Some("\"torque\"")));
}

#[test]
fn an_assignment_to_a_disabled_table_is_told_unless_it_disables_it() {
    let text = WALKER.to_owned() + "[profile.calm]\nreward.upright.enabled = false\n";
    let folder = Folder::new(&[("walker.toml", &text)]);
    let found = |profile, sets: &[&str]| folder.mistakes("walker.toml", profile, sets);
    assert_eq!(found(Some("calm"), &["reward.upright.weight=2"]), [mistake("W0524", "2", None)]);
    assert_eq!(found(None, &["reward.upright.weight=2"]), []);
    assert_eq!(found(Some("calm"), &["reward.upright.weight=2", "reward.upright.enabled=true"]), []);
    assert_eq!(found(None, &["reward.upright.weight=2", "reward.upright.enabled=false"]), []);
}

/// The last one won before.
#[test]
fn a_path_is_assigned_once() {
    let folder = Folder::new(&[("walker.toml", WALKER)]);
    let found = |sets: &[&str]| folder.mistakes("walker.toml", None, sets);
    let twice = |place| [mistake("E0104", place, None)];
    assert_eq!(found(&["action.rate=1 Hz", "action.rate=2 Hz"]), twice("action.rate"));
    assert_eq!(found(&["action={ rate = \"1 Hz\" }", "action.rate=2 Hz"]), twice("action.rate"));
    folder.sound("walker.toml", None, &["action.rate=2 Hz", "reward.effort.weight=1"]);
}

#[test]
fn an_abstract_parent_may_be_incomplete_but_not_wrong() {
    let text = "spec = 1\nabstract = true\n[action]\nrate = \"1 Hz\"\n[reward.upright]\n";
    let folder = Folder::new(&[("base.toml", text), ("wrong.toml", &text.replace("upright", "uprigt"))]);
    assert!(folder.sound("base.toml", None, &[]).is_abstract);
    assert_eq!(folder.mistakes("wrong.toml", None, &[]), [mistake("E0301", "uprigt", Some("upright"))]);
}

#[test]
fn files_of_the_project_come_before_those_of_the_program() {
    let text = WALKER.to_owned()
        + "[task]\nkind = \"walk\"\nmotion = \"strol\"\n[report]\ncompare = [\"../b.toml\"]\n";
    let folder = Folder::new(&[("specs/walker.toml", &text), ("robots/atlas.toml", "name = \"mine\"")]);
    let expected = [mistake("W0421", "\"atlas\"", None), mistake("E0304", "\"strol\"", Some("\"stroll\""))];
    assert_eq!(folder.mistakes("specs/walker.toml", None, &[]), expected);
    let experiment = folder.load("specs/walker.toml", None, &[]).experiment.expect("understood in part");
    let robot = experiment.robot.expect("found");
    assert_eq!((&*robot.text, robot.path), ("name = \"mine\"", Some(folder.path("robots/atlas.toml"))));
    assert_eq!(experiment.compare, [folder.path("b.toml")]);
}

#[test]
fn a_motion_is_found_beside_robots_beside_the_parents_and_beside_the_spec() {
    let text = WALKER.to_owned() + "[task]\nkind = \"walk\"\nmotion = \"mine\"\n";
    let own = "kind = \"stroll\"\n";
    let beside_robots =
        [("specs/walker.toml", text.as_str()), ("robots/x.toml", ""), ("specs/motions/mine.toml", own)];
    let beside_parents =
        [("specs/walker.toml", &*text), ("specs/base/x.toml", ""), ("specs/motions/mine.toml", own)];
    let beside_the_spec = [("walker.toml", &*text), ("specs/motions/mine.toml", own)];
    for files in [&beside_robots[..], &beside_parents[..], &beside_the_spec[..]] {
        let folder = Folder::bare(files);
        let loaded = folder.load(files[0].0, None, &[]);
        let motion = loaded.experiment.expect("understood in part").motion.expect("found");
        assert_eq!(motion.path, Some(folder.path("specs/motions/mine.toml")), "{}", files[0].0);
    }
    // If the file is missing, the message names the folder that was searched.
    let folder = Folder::bare(&[("walker.toml", text.as_str()), ("motions/mine.toml", own)]);
    let told = folder.load("walker.toml", None, &[]).sink.diagnostics;
    let help = &told.iter().find(|found| found.code == "E0304").expect("it is not there").help;
    let searched = format!("searched in `{}`", folder.path("specs/motions").display());
    assert!(help.iter().any(|line| line.starts_with(&searched)), "{help:?}");
}

#[test]
fn names_that_do_not_fit_into_a_file_s_name_are_e0107() {
    let long = "a".repeat(121);
    let named = |name: &str| WALKER.replace("name = \"walker\"", &format!("name = \"{name}\""));
    let codes = |file: &str, text: &str| {
        let folder = Folder::new(&[(file, text)]);
        let told = folder.load(file, None, &[]).sink.diagnostics;
        told.into_iter().map(|found| found.code).filter(|code| *code == "E0107").count()
    };
    assert_eq!(codes("walker.toml", &named(&long)), 1);
    assert_eq!(codes("walker.toml", &named(&long[1..])), 0);
    // A spec without `name` is named after its file.
    assert_eq!(codes(&format!("{long}.toml"), &WALKER.replace("name = \"walker\"\n", "")), 1);
    assert_eq!(codes(&format!("{long}.toml"), &named("short")), 0);
}

#[test]
fn warnings_are_allowed_with_a_reason() {
    let text = WALKER.to_owned() + "[allow]\nW0501 = \"an ablation\"\nE0101 = \"no\"\nW0502 = \"\"\n";
    let folder = Folder::new(&[("walker.toml", &text)]);
    assert_eq!(
        folder.mistakes("walker.toml", None, &[]),
        [mistake("E0102", "E0101", None), mistake("E0108", "\"\"", None)]
    );
    let experiment = folder.load("walker.toml", None, &[]).experiment.expect("understood in part");
    assert_eq!(experiment.allow["W0501"], "an ablation");
}

/// A spec with parts removed and inserted at random.
fn damaged() -> impl Strategy<Value = String> {
    let piece = prop::sample::select(vec![
        "[",
        "]",
        "=",
        "\"",
        "{",
        "\n",
        ".",
        "µ",
        "-",
        "1e400",
        "enabled = false\n",
        "\0",
        "kind",
    ]);
    let edit = (0..WALKER.len(), 0..8usize, piece);
    prop::collection::vec(edit, 1..5).prop_map(|edits| {
        edits.into_iter().fold(WALKER.to_owned(), |text, (at, cut, piece)| {
            let kept = |index: &usize| *index < at || *index >= at + cut;
            let chars: Vec<char> =
                text.chars().enumerate().filter(|(index, _)| kept(index)).map(|(_, c)| c).collect();
            let (left, right) = chars.split_at(at.min(chars.len()));
            left.iter().chain(&piece.chars().collect::<Vec<_>>()).chain(right).collect()
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_damaged_spec_gives_diagnostics_that_lie_in_its_text(text in damaged()) {
        let folder = Folder::new(&[("walker.toml", &text)]);
        let loaded = folder.load("walker.toml", Some("quick"), &[]);
        for label in loaded.sink.diagnostics.iter().flat_map(|found| &found.labels) {
            let text = &loaded.sources.get(label.span.source).text;
            prop_assert!(text.get(label.span.start..label.span.end).is_some(), "{:?} in {}", label, text);
        }
    }
}

#[test]
fn deep_nesting_is_an_error_and_no_crash() {
    let deep = format!("spec = 1\nx = {}1{}\n", "[".repeat(20_000), "]".repeat(20_000));
    let dotted = format!("spec = 1\nx{} = 1\n", ".x".repeat(20_000));
    for text in [deep, dotted] {
        let folder = Folder::new(&[("deep.toml", &text)]);
        assert!(folder.load("deep.toml", None, &[]).sink.has_errors());
    }
}
