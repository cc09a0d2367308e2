//! Every new spec is valid, and a standalone one is the experiment that its parents describe.

use std::fs;
use std::path::Path;

use super::*;
use crate::check::Checker;
use crate::spec::LoadOptions;
use crate::spec::value::canonical_table;
use crate::syntax::Disk;

/// Every robot with every task and action.
fn wishes() -> Vec<Wish> {
    let mut wishes = Vec::new();
    for robot in robots() {
        for task in tasks() {
            for action in actions() {
                let (robot, task, action) = (robot.to_owned(), task.to_owned(), action.to_owned());
                let name = format!("{robot}_{task}_{action}");
                wishes.push(Wish { name, robot, task, action, build: None, motion: None });
            }
        }
    }
    wishes
}

/// The values of a valid spec, as text.
fn values(checker: &mut Checker, path: &Path, profile: Option<&str>) -> String {
    table(checker, path, profile).to_string()
}

/// The values of a valid spec.
fn table(checker: &mut Checker, path: &Path, profile: Option<&str>) -> serde_json::Value {
    let options = LoadOptions {
        profile: profile.map(str::to_owned),
        allow_outside: vec![concat!(env!("CARGO_MANIFEST_DIR"), "/specs").into()],
        ..LoadOptions::default()
    };
    let checked = checker.check(&Disk, path, &options);
    let found: Vec<String> =
        checked.sink.diagnostics.iter().map(|found| format!("{} {}", found.code, found.message)).collect();
    assert_eq!(found, Vec::<String>::new(), "{} {profile:?}", path.display());
    canonical_table(&checked.experiment.expect("it was read").table)
}

#[test]
fn a_spec_that_stands_alone_is_the_experiment_that_its_parents_describe() {
    let folder = tempfile::tempdir().expect("a folder");
    let base = folder.path().join("base");
    for (path, text) in parents() {
        let file = base.join(format!("{path}.toml"));
        fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
        fs::write(file, text).expect("written");
    }
    let wishes = wishes();
    assert_eq!(wishes.len(), robots().len() * 8);
    let mut checker = Checker::default();
    for wish in wishes {
        let (with_parents, without) = (folder.path().join("child.toml"), folder.path().join("alone.toml"));
        fs::write(&with_parents, child(&wish, "base", None)).expect("written");
        fs::write(&without, alone(&wish)).expect("written");
        for profile in [None, Some("quick"), Some("desk"), Some("paper")] {
            let [without, with_parents] =
                [&without, &with_parents].map(|path| values(&mut checker, path, profile));
            assert_eq!(without, with_parents, "{} {profile:?}", wish.name);
        }
    }
}

#[test]
fn new_specs_are_in_their_canonical_form() {
    use crate::format::{Order, Sort, format};
    for wish in wishes() {
        for text in [alone(&wish), child(&wish, "base", Some("schema/spec-1.json"))] {
            assert_eq!(format(&text, Sort::Spec, &Order::of_this_edition()), text);
            assert!(!text.contains(" ,"), "{text}");
        }
    }
}

#[test]
fn what_a_profile_switches_off_is_not_there_when_nothing_else_has_it() {
    let parent = "[deploy.a]\nkind = \"export\"\n[profile.desk.reward]\nb = { weight = 1, k = 2 }\n";
    let own =
        "[profile.desk.reward]\nb.enabled = false\nc.weight = 3\n[profile.desk.deploy]\na.enabled = false\n";
    let merged = super::alone::merged(&[parent], own);
    let table: toml::Table = merged.parse().expect("TOML");
    let desk = table["profile"]["desk"].as_table().expect("a profile");
    assert_eq!(desk["reward"].as_table().expect("terms").keys().collect::<Vec<_>>(), ["c"], "{merged}");
    assert_eq!(desk["deploy"]["a"]["enabled"].as_bool(), Some(false), "{merged}");
}

#[test]
fn a_spec_that_stands_alone_keeps_the_comments_and_refers_to_no_document() {
    let wish = Wish {
        name: "a".into(),
        robot: "atlas".into(),
        task: "run".into(),
        action: "torque".into(),
        build: None,
        motion: None,
    };
    let text = alone(&wish);
    assert!(text.contains("# of each joint's effort limit"), "{text}");
    assert!(!text.contains("[A") && !text.contains("docs/"), "{text}");
}

#[test]
fn a_new_spec_trains_as_the_shipped_one_for_the_same_robot_and_task() {
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs");
    let folder = tempfile::tempdir().expect("a folder");
    let sections = [
        "robot",
        "task",
        "action",
        "observe",
        "reward",
        "randomize",
        "initial",
        "pretrain",
        "learn",
        "fine_tune",
    ];
    let (mut checker, mut seen) = (Checker::default(), 0);
    for wish in wishes() {
        let shipped = specs.join(format!("{}.toml", wish.name));
        if !shipped.is_file() {
            continue;
        }
        let new = folder.path().join("new.toml");
        fs::write(&new, child(&wish, &specs.join("base").to_string_lossy(), None)).expect("written");
        for profile in [None, Some("quick"), Some("desk")] {
            let [new, shipped] = [&new, &shipped].map(|path| table(&mut checker, path, profile));
            for section in sections {
                assert_eq!(new.get(section), shipped.get(section), "{} {profile:?} {section}", wish.name);
            }
        }
        seen += 1;
    }
    assert_eq!(seen, 12);
}

#[test]
fn a_robot_of_another_height_gets_a_bound_of_its_own() {
    let (name, robot, task, action) = ("a".into(), "tocabi".into(), "squat".into(), "torque".into());
    let build = Some(Proportions {
        stands: 0.62,
        base: 0.62,
        torque: 600.0,
        stiffness: None,
        damping: None,
        own_damping: 0.0,
        effort: None,
    });
    let wish = Wish { name, robot, task, action, build, motion: None };
    for text in [alone(&wish), child(&wish, "base", None)] {
        assert!(text.contains("below = \"0.40 m\""), "{text}");
        assert_eq!(format(&text, Sort::Spec, &Order::of_this_edition()), text);
    }
}

#[test]
fn a_new_suite_over_a_new_spec_is_in_order_and_canonical() {
    use crate::format::{Order, Sort, format};
    let folder = tempfile::tempdir().expect("a folder");
    for task in tasks() {
        let (name, robot, action) = ("mine".into(), "tocabi".into(), "torque".into());
        let wish = Wish { name, robot, task: task.into(), action, build: None, motion: None };
        fs::write(folder.path().join("mine.toml"), alone(&wish)).expect("written");
        let text = suite("weights", "mine.toml", None);
        assert_eq!(format(&text, Sort::Suite, &Order::of_this_edition()), text);
        let place = folder.path().join("weights.toml");
        fs::write(&place, &text).expect("written");
        for profile in [None, Some("quick"), Some("desk"), Some("paper")] {
            let options = LoadOptions {
                profile: profile.map(str::to_owned),
                allow_outside: vec![concat!(env!("CARGO_MANIFEST_DIR"), "/specs").into()],
                ..LoadOptions::default()
            };
            let checked = crate::check::suite(&place, &options);
            assert_eq!(checked.sink.diagnostics, [], "{task} {profile:?}");
            let (suite, arms) = checked.sound().expect("it has no errors");
            assert_eq!((arms.len(), suite.claims.len()), (2, 2));
        }
    }
}
