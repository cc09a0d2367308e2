//! The graph: fingerprints, sharing, states and reasons.

mod arms;

use std::collections::BTreeSet;

use arms::{Fake, arm, execute, key, plan, quantity, set, table, word};
use specforge::exec::Store;
use specforge::exec::journal::Past;
use specforge::plan::expected::Expected;
use specforge::plan::why::{State, statuses};
use specforge::plan::{Plan, PlanError, Selection, lower, render};

#[test]
fn fingerprints_ignore_the_spelling_of_units_names_and_origins() {
    let mut other = arm("another_name", "torque");
    set(&mut other, "action.delay", quantity(0.004, "0.004 s"), "--set");
    let (a, b) = (plan(&[arm("torque", "torque")]), plan(&[other]));
    for stage in
        ["robot", "motion", "env", "controller", "pretrain", "learner", "evaluate.nominal", "deploy.mujoco"]
    {
        assert_eq!(key(&a, "torque", stage), key(&b, "another_name", stage), "{stage}");
    }
}

#[test]
fn a_reward_weight_changes_the_learner_and_what_follows_but_not_pretraining() {
    let mut heavier = arm("torque", "torque");
    set(&mut heavier, "reward.contact_force.weight", quantity(0.2, "0.2"), "--set");
    let (before, after) = (plan(&[arm("torque", "torque")]), plan(&[heavier]));
    let same = |stage: &str| key(&before, "torque", stage) == key(&after, "torque", stage);
    for stage in ["robot", "motion", "controller", "pretrain"] {
        assert!(same(stage), "{stage} should not change");
    }
    for stage in ["env", "learner", "evaluate.nominal", "deploy.policy", "deploy.mujoco"] {
        assert!(!same(stage), "{stage} should change");
    }
}

#[test]
fn what_an_evaluation_says_of_its_ground_engine_and_draws_changes_nothing_else() {
    let before = plan(&[arm("torque", "torque")]);
    let push = table([("push", table([("kind", word("push")), ("impulse", quantity(50.0, "50 N*s"))]))]);
    for (key, value) in [
        ("terrain", table([("kind", word("box_obstacle"))])),
        ("engine", word("mujoco")),
        ("rate", quantity(1000.0, "1000 Hz")),
        ("randomize", push),
    ] {
        let mut own = arm("torque", "torque");
        set(&mut own, &format!("evaluate.nominal.{key}"), value, "--set");
        let after = plan(&[own]);
        let changed =
            |stage: &&str| self::key(&before, "torque", stage) != self::key(&after, "torque", stage);
        let stages = [
            "env",
            "controller",
            "pretrain",
            "learner",
            "evaluate.nominal",
            "deploy.policy",
            "deploy.mujoco",
        ];
        let changed: Vec<&str> = stages.into_iter().filter(changed).collect();
        // Both engines answer the same question: a transfer runs on the ground of the nominal evaluation.
        let expected = if key == "terrain" {
            vec!["evaluate.nominal", "deploy.mujoco"]
        } else {
            vec!["evaluate.nominal"]
        };
        assert_eq!(changed, expected, "{key}");
    }
}

#[test]
fn an_evaluation_counts_the_engine_that_it_chooses_and_no_other() {
    let identity = |arm: &specforge::plan::Arm| {
        let plan = plan(std::slice::from_ref(arm));
        plan.find("evaluate.nominal")[0].recipe.numeric.clone()
    };
    let mut own = arm("torque", "torque");
    assert!(identity(&own).is_empty());
    set(&mut own, "evaluate.nominal.engine", word("mujoco"), "--set");
    assert_eq!(identity(&own), ["mujoco 3.17.0, f64, figures in a compiled geometry"]);
}

#[test]
fn a_template_changes_nothing_but_the_report() {
    let arms = [arm("torque", "torque")];
    let source = |templates: &str| specforge::plan::ReportSource {
        name: "torque".into(),
        templates: templates.into(),
        suite: None,
        baselines: Vec::new(),
    };
    let keys = |plan: &Plan| {
        plan.stages().map(|stage| (stage.name().to_owned(), stage.fingerprint.clone())).collect()
    };
    let before: BTreeSet<_> = keys(&lower(&arms, Some(&source("a"))).expect("whole"));
    let after: BTreeSet<_> = keys(&lower(&arms, Some(&source("b"))).expect("whole"));
    let changed: Vec<_> = after.difference(&before).map(|(name, _)| name.as_str()).collect();
    assert_eq!(changed, ["report"]);
}

#[test]
fn stages_that_two_arms_share_are_one_node() {
    let both = plan(&[arm("torque", "torque"), arm("position", "position")]);
    let count = |name: &str| both.stages().filter(|stage| stage.name() == name).count();
    assert_eq!(
        (count("robot"), count("motion"), count("env"), count("learner"), count("report")),
        (1, 1, 2, 2, 1)
    );
    let robot = both.find("robot")[0];
    assert_eq!(robot.users.len(), 2);
    assert_eq!(both.label(robot), "robot");
    assert_eq!(both.label(both.find("position/learner")[0]), "position/learner");
}

#[test]
fn stages_in_a_circle_are_e0801() {
    let plan = plan(&[arm("torque", "torque")]);
    let mut stages: Vec<_> = plan.stages().cloned().collect();
    let learner = plan.find("learner")[0].fingerprint.clone();
    let robot = stages.iter_mut().find(|stage| stage.name() == "robot").expect("every arm has a robot");
    robot.recipe.inputs.insert("policy".into(), learner);
    let error =
        Plan::new(plan.arms.clone(), stages).expect_err("the robot takes in the learner that takes it in");
    assert_eq!(error.code(), "E0801");
}

#[test]
fn edges_carry_their_artefacts_and_join_producers_and_consumers() {
    let plan = plan(&[arm("torque", "torque")]);
    let inputs = |stage: &str| -> Vec<String> {
        let stage = plan.find(stage)[0];
        plan.inputs(stage)
            .into_iter()
            .map(|(from, edge)| format!("{}={}:{}", edge.role, from.name(), edge.artefact))
            .collect()
    };
    assert_eq!(
        inputs("learner"),
        [
            "controller=controller:control law",
            "env=env:environment blueprint",
            "pretrain=pretrain:pre-trained actor"
        ]
    );
    assert_eq!(
        inputs("deploy.mujoco"),
        ["env=env:environment blueprint", "policy=deploy.policy:policy artefact"]
    );
    assert_eq!(inputs("report").len(), 9);
}

#[test]
fn a_transfer_asks_what_the_nominal_evaluation_asks_unless_it_says_otherwise() {
    let mut changed = arm("torque", "torque");
    set(&mut changed, "evaluate.nominal.episodes", arms::quantity(8.0, "8"), "--set");
    let fields = |arm| plan(&[arm]).find("deploy.mujoco")[0].recipe.fields["deploy"]["episodes"].clone();
    assert_eq!(fields(arm("torque", "torque")), serde_json::json!(32));
    assert_eq!(fields(changed), serde_json::json!(8.0));
}

#[test]
fn a_transfer_without_an_export_has_no_producer() {
    let mut alone = arm("torque", "torque");
    alone.fields.insert("deploy".into(), table([("mujoco", table([("kind", word("transfer"))]))]));
    let error = lower(&[alone], None).expect_err("nothing is exported");
    assert!(matches!(error, PlanError::MissingProducer { .. }));
    assert_eq!(error.code(), "E0802");
    assert_eq!(
        error.to_string(),
        "torque: `deploy.mujoco` needs a stage of the kind `export`, and the spec declares none"
    );
}

#[test]
fn a_plan_survives_the_way_through_a_file_and_an_edited_file_is_refused() {
    let plan = plan(&[arm("torque", "torque"), arm("position", "position")]);
    let text = serde_json::to_string(&plan).expect("a plan is plain data");
    let again: Plan = serde_json::from_str(&text).expect("just written");
    assert_eq!(serde_json::to_string(&again).expect("a plan is plain data"), text);
    let edited = text.replacen("\"samples\":2000000", "\"samples\":3000000", 1);
    assert_ne!(edited, text);
    let error = serde_json::from_str::<Plan>(&edited).expect_err("the recipe no longer has its fingerprint");
    assert!(error.to_string().contains("is not the fingerprint of its recipe"), "{error}");
}

#[test]
fn selections_intersect() {
    let plan = plan(&[arm("torque", "torque"), arm("position", "position")]);
    let names = |selection: Selection| -> Vec<String> {
        let selected = selection.apply(&plan).expect("the words are stages");
        plan.stages()
            .filter(|stage| selected.contains(&stage.fingerprint))
            .map(|stage| plan.label(stage))
            .collect()
    };
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
    let only = Selection { only: words(&["torque/learner"]), ..Selection::default() };
    assert_eq!(names(only), ["torque/learner"]);
    let between = Selection {
        from: words(&["torque/pretrain"]),
        until: words(&["deploy.policy"]),
        ..Selection::default()
    };
    assert_eq!(names(between), ["torque/pretrain", "torque/learner", "torque/deploy.policy"]);
    let unknown = Selection { only: words(&["lerner"]), ..Selection::default() }.apply(&plan);
    assert_eq!(unknown.expect_err("a slip").word, "lerner");
}

#[test]
fn why_names_the_field_both_values_and_both_origins() {
    let store = tempfile::tempdir().expect("a folder");
    let before = plan(&[arm("torque", "torque")]);
    execute(&before, store.path(), &Fake::default(), 2).outcome.expect("the store works");
    let mut heavier = arm("torque", "torque");
    set(&mut heavier, "reward.contact_force.weight", quantity(0.2, "0.2"), "--set");
    let after = plan(&[heavier]);
    let store = Store::at(store.path());
    let statuses = statuses(&after, &Past::of(&store, &after));
    let status = |name: &str| &statuses[&after.find(name)[0].fingerprint];
    assert_eq!(status("pretrain").state, State::Cached);
    assert_eq!(status("evaluate.nominal").state, State::Changed);
    let [change] = status("learner").changes.as_slice() else {
        panic!("one cause: {:?}", status("learner").changes)
    };
    assert_eq!(change.field, "reward.contact_force.weight");
    assert_eq!((change.from.as_deref(), change.to.as_deref()), (Some("0.1"), Some("0.2")));
    assert_eq!(change.from_origin.as_deref(), Some("specs/base/task/run.toml:40"));
    assert_eq!(change.to_origin.as_deref(), Some("--set"));
    assert_eq!(change.through, ["env"]);
    assert_eq!(render::change(change), "reward.contact_force.weight: 0.1 -> 0.2, through env");
    // Every later stage has the same single cause, through however many inputs.
    assert_eq!(status("deploy.mujoco").changes.len(), 1);
}

#[test]
fn why_names_the_number_in_the_robot_file() {
    let store = tempfile::tempdir().expect("a folder");
    execute(&plan(&[arm("torque", "torque")]), store.path(), &Fake::default(), 2)
        .outcome
        .expect("the store works");
    let mut heavier = arm("torque", "torque");
    heavier.robot["links"][1]["body"]["mass"] = 2.5.into();
    let after = plan(&[heavier]);
    let store = Store::at(store.path());
    let statuses = statuses(&after, &Past::of(&store, &after));
    let change = &statuses[&after.find("learner")[0].fingerprint].changes[0];
    assert_eq!(change.field, "robot file: links.1.body.mass");
    assert_eq!(change.to.as_deref(), Some("2.5"));
}

#[test]
fn why_names_the_line_of_the_motion_file() {
    let store = tempfile::tempdir().expect("a folder");
    execute(&plan(&[arm("torque", "torque")]), store.path(), &Fake::default(), 2)
        .outcome
        .expect("the store works");
    let mut slower = arm("torque", "torque");
    slower.motion.as_mut().expect("a motion").insert("period".into(), quantity(0.7, "700 ms"));
    slower.origins.insert("motion.period".into(), "specs/motions/run_gait.toml:3".into());
    let after = plan(&[slower]);
    let store = Store::at(store.path());
    let statuses = statuses(&after, &Past::of(&store, &after));
    let change = &statuses[&after.find("evaluate.nominal")[0].fingerprint].changes[0];
    assert_eq!(change.field, "motion file: period");
    assert_eq!((change.from.as_deref(), change.to.as_deref()), (Some("0.66 s"), Some("700 ms")));
    assert_eq!(change.to_origin.as_deref(), Some("specs/motions/run_gait.toml:3"));
}

#[test]
fn the_times_of_a_plan_are_those_of_like_stages_in_the_store_or_the_projects_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let store = Store::at(folder.path().join("store"));
    let of_seed = |seed| {
        let mut arm = arm("torque", "torque");
        set(&mut arm, "learn.seed", specforge::spec::Value::Count(seed), "--set");
        set(&mut arm, "learn.rollout", specforge::spec::Value::Count(2000), "--set");
        set(&mut arm, "action.rate", quantity(125.0, "125 Hz"), "--set");
        ["evaluate.nominal", "deploy.mujoco"].iter().for_each(|stage| {
            set(&mut arm, &format!("{stage}.time_limit"), quantity(8.0, "8 s"), "--set");
        });
        set(&mut arm, "deploy.mujoco.rate", quantity(2000.0, "2 kHz"), "--set");
        plan(&[arm])
    };
    let (first, second) = (of_seed(1), of_seed(2));
    let told = |plan: &Plan| {
        let statuses = statuses(plan, &Past::of(&store, plan));
        let expected = specforge::exec::forecast::expected(&store, plan, &statuses);
        render::text(plan, &statuses, &expected)
    };
    let before = told(&second);
    assert!(before.contains("us per sample in rapier (not measured in this store)"), "{before}");
    // 2 M samples of 29 us and four physics steps of 55.5 us each.
    assert!(before.contains("8 min 2"), "{before}");
    assert!(before.contains("docs/experiments/2026-11-26-batch-engine-speed.md"), "{before}");
    execute(&first, store.root(), &Fake::default(), 2).outcome.expect("the store works");
    let after = told(&second);
    assert!(after.contains(" us per sample in rapier on "), "{after}");
    assert!(after.contains("(1 finished in this store)") && !after.contains("not measured"), "{after}");
    assert!(!told(&first).contains("core-hours"), "nothing is left to do");
}

#[test]
fn a_new_plan_is_missing_and_every_form_of_it_can_be_written() {
    let plan = plan(&[arm("torque", "torque"), arm("position", "position")]);
    let folder = tempfile::tempdir().expect("a folder");
    let store = Store::at(folder.path().join("none"));
    let statuses = statuses(&plan, &Past::of(&store, &plan));
    assert!(!store.root().exists(), "looking at a store creates nothing");
    assert!(statuses.values().all(|status| status.state == State::Missing));
    let text = render::text(&plan, &statuses, &Expected::default());
    assert!(text.contains("shared by torque, position\n  robot "), "{text}");
    assert!(text.ends_with("17 stages: 0 cached, 0 changed, 17 missing\n"), "{text}");
    let json = render::json(&plan, &statuses, &Expected::default());
    assert_eq!(json["stages"].as_array().map(Vec::len), Some(17));
    assert_eq!(json["edges"][0]["artefact"], "robot model");
    assert!(render::dot(&plan, &statuses).contains("[label=\"pre-trained actor\"]"));
    assert!(render::mermaid(&plan, &statuses).starts_with("flowchart LR\n"));
}
