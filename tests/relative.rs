//! Quantities relative to the robot: a spec with them is the spec with the shares that they amount to.

use std::path::{Path, PathBuf};

use specforge::spec::LoadOptions;
use specforge::study::{Log, Study};

/// A spec that extends one of the shipped ones.
fn write(folder: &Path, name: &str, robot: &str, own: &str) -> PathBuf {
    let root = env!("CARGO_MANIFEST_DIR");
    let path = folder.join(format!("{name}.toml"));
    let text = format!(
        "spec = 1\nname = \"same\"\nextends = \"{root}/specs/{robot}_walk_torque.toml\"\n[report]\ncompare = []\n{own}"
    );
    std::fs::write(&path, text).expect("written");
    path
}

fn study(path: &Path) -> Study {
    let options = LoadOptions {
        allow_outside: vec![env!("CARGO_MANIFEST_DIR").into()],
        profile: Some("desk".to_owned()),
        ..LoadOptions::default()
    };
    let mut log = Log::default();
    Study::read(&[path.to_owned()], &options, &mut log)
        .unwrap_or_else(|refusal| panic!("{refusal}: {:?}", log.findings))
}

fn fingerprints(study: &Study) -> Vec<String> {
    study.plan.stages().map(|stage| stage.fingerprint.to_string()).collect()
}

const RELATIVE: &str = "[profile.desk]\naction.std = \"1.72 % mgh\"\nfine_tune.std = \"0.87 % mgh\"\n\
    pretrain.stiffness = \"0.16 mgh/rad\"\npretrain.damping = \"0.023 mgh*sqrt(h/g)/rad\"\n";

#[test]
fn stages_are_those_of_the_shares_of_each_robot() {
    let folder = tempfile::tempdir().expect("a folder");
    for (robot, [std, last, stiffness, damping]) in [
        ("tocabi", ["6.597 %", "3.337 %", "4.437 %", "18.81 %"]),
        ("g1", ["4.828 %", "2.442 %", "48.36 %", "67.79 %"]),
    ] {
        let shares = format!(
            "[profile.desk]\naction.std = \"{std}\"\nfine_tune.std = \"{last}\"\n\
             pretrain.stiffness = \"{stiffness}\"\npretrain.damping = \"{damping}\"\n"
        );
        let relative = study(&write(folder.path(), "relative", robot, RELATIVE));
        let plain = study(&write(folder.path(), "plain", robot, &shares));
        assert_eq!(fingerprints(&relative), fingerprints(&plain), "{robot}");
    }
}

#[test]
fn a_saved_plan_keeps_both_forms() {
    let folder = tempfile::tempdir().expect("a folder");
    let relative = study(&write(folder.path(), "relative", "tocabi", RELATIVE));
    let saved = folder.path().join("plan.json");
    std::fs::write(&saved, serde_json::to_string(&relative.plan).expect("JSON")).expect("written");
    let text = std::fs::read_to_string(&saved).expect("read");
    assert!(text.contains("0.16 mgh/rad = 4.437 %"), "both forms are in the plan");
    let mut log = Log::default();
    let read = Study::read(&[saved], &LoadOptions::default(), &mut log)
        .unwrap_or_else(|refusal| panic!("{refusal}: {:?}", log.findings));
    assert_eq!(fingerprints(&read), fingerprints(&relative));
}
