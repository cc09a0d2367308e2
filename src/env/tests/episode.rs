//! The steps of a control step, on an engine without physics.

use std::sync::Arc;

use super::Recipe;
use super::engine::Still;
use crate::env::{End, Mode, RobotEnvironment, Trial};
use crate::sim::Contacts;

/// Both feet carry 500 N.
fn standing() -> Still {
    Still { contacts: Contacts { foot_force: [[0.0, 0.0, 500.0]; 2], body: false }, ..Still::default() }
}

fn environment(recipe: &Recipe, engine: &Still, mode: &Mode) -> RobotEnvironment {
    recipe.blueprint().environment(Arc::new(engine.clone()), mode).unwrap()
}

fn at_phase(phase: f64) -> Mode {
    Mode::Evaluation(Trial { phase, ..Trial::default() })
}

#[test]
fn a_torque_action_becomes_shares_of_the_effort_limits_in_every_physics_step() {
    let engine = standing();
    let mut environment = environment(&Recipe::new("tocabi", Some("walk")), &engine, &at_phase(0.0));
    environment.begin("test");
    let mut action = [0.0; 13];
    (action[3], action[6]) = (-0.5, 7.0);
    environment.step(&action);
    let torques = &engine.record.lock().unwrap().torques;
    assert_eq!(torques.len(), 4);
    assert!(torques.iter().all(|torque| torque[3] == -0.5 * 289.0 && torque[6] == 333.0 && torque[0] == 0.0));
}

#[test]
fn an_engine_that_refuses_the_robot_is_an_error_with_its_reason() {
    let engine = Still { refusal: "size must be positive", ..standing() };
    let blueprint = Recipe::new("tocabi", Some("walk")).blueprint();
    let refused =
        blueprint.environment(Arc::new(engine), &Mode::Training).err().map(|error| error.to_string());
    assert_eq!(refused.as_deref(), Some("engine `still` refused the robot model: size must be positive"));
}

#[test]
fn in_the_second_half_of_the_cycle_the_action_acts_on_the_other_side() {
    let engine = standing();
    let mut environment = environment(&Recipe::new("tocabi", Some("walk")), &engine, &at_phase(0.5));
    environment.begin("test");
    let mut action = [0.0; 13];
    (action[1], action[3]) = (0.5, -0.5);
    environment.step(&action);
    let torque = engine.record.lock().unwrap().torques[0].clone();
    assert_eq!((torque[7], torque[9]), (-0.5 * 232.0, -0.5 * 289.0));
    assert_eq!((torque[1], torque[3]), (0.0, 0.0));
}

#[test]
fn the_phase_action_at_most_doubles_the_cadence_and_never_slows_it() {
    for (action, speed) in [(-3.0, 1.0), (0.5, 1.5), (9.0, 2.0)] {
        let engine = standing();
        let mut environment = environment(&Recipe::new("tocabi", Some("walk")), &engine, &at_phase(0.0));
        environment.begin("test");
        let mut vector = [0.0; 13];
        vector[12] = action;
        environment.step(&vector);
        assert!((environment.signals().phase - speed * 0.008 / 1.8).abs() < 1e-12);
    }
}

#[test]
fn as_a_share_of_the_cycle_the_phase_action_adds_the_seconds_of_the_step() {
    let mut recipe = Recipe::new("tocabi", Some("walk"));
    recipe.action += "phase_action = \"share\"\n";
    let engine = standing();
    let mut environment = environment(&recipe, &engine, &at_phase(0.0));
    environment.begin("test");
    let mut vector = [0.0; 13];
    vector[12] = 1.0;
    environment.step(&vector);
    assert!((environment.signals().phase - (0.008 / 1.8 + 0.008)).abs() < 1e-12);
}

#[test]
fn a_delayed_command_arrives_physics_steps_later() {
    let mut recipe = Recipe::new("tocabi", Some("walk"));
    recipe.action += "delay = \"4 ms\"\n";
    let engine = standing();
    let mut environment = environment(&recipe, &engine, &at_phase(0.0));
    environment.begin("test");
    for share in [0.1, 0.2, 0.3] {
        let mut action = [0.0; 13];
        action[0] = share;
        environment.step(&action);
    }
    let record = engine.record.lock().unwrap();
    let shares: Vec<f64> =
        record.torques.iter().map(|torque| (torque[0] / 33.3 * 100.0).round() / 100.0).collect();
    // 4 physics steps per control step, 2 steps of delay; the first command also fills the line.
    assert_eq!(shares, [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 3.0, 3.0]);
}

/// The delay in ms of the command of the second control step, from the deficit in its torque: 10 % of 333 N m
/// and then 20 %.
fn measured_delay(environment: &mut RobotEnvironment, engine: &Still, stream: &str) -> f64 {
    engine.record.lock().unwrap().torques.clear();
    environment.begin(stream);
    for share in [0.1, 0.2, 0.2] {
        let mut action = [0.0; 13];
        action[0] = share;
        environment.step(&action);
    }
    let record = engine.record.lock().unwrap();
    let (before, after) = (record.torques[0][0], record.torques[record.torques.len() - 1][0]);
    // Four physics steps of 2 ms per control step; the command changes before the fifth.
    record.torques[4..].iter().map(|torque| 2.0 * (after - torque[0]) / (after - before)).sum()
}

#[test]
fn a_delay_of_any_time_is_the_time_by_which_the_torque_comes_late() {
    for delay in [0.0, 0.3, 1.0, 2.0, 3.1, 4.0, 5.95] {
        let mut recipe = Recipe::new("tocabi", Some("walk"));
        recipe.action += &format!("delay = \"{delay} ms\"\n");
        let engine = standing();
        let mut environment = environment(&recipe, &engine, &at_phase(0.0));
        let measured = measured_delay(&mut environment, &engine, "test");
        assert!((measured - delay).abs() < 1e-5, "{delay} ms: {measured}");
    }
}

#[test]
fn drawn_delays_are_uniform_between_their_bounds_and_not_whole_physics_steps() {
    let mut recipe = Recipe::new("tocabi", Some("walk"));
    recipe.action += "delay = \"4 ms\"\n";
    recipe.more = "[randomize.action_delay]\nscale = { uniform = [0.7, 1.3] }\n".into();
    recipe.initial = "kind = \"default_pose\"\nphases = [0.0]".into();
    let engine = standing();
    let mut environment = environment(&recipe, &engine, &Mode::Training);
    let draw =
        |episode: usize| (measured_delay(&mut environment, &engine, &format!("test/{episode}")) - 2.8) / 2.4;
    let mut shares: Vec<f64> = (0..1000).map(draw).collect();
    shares.sort_by(f64::total_cmp);
    assert!(shares[0] > -1e-6 && shares[999] < 1.0 + 1e-6, "{} to {}", shares[0], shares[999]);
    // Kolmogorov-Smirnov test: 1.63 / sqrt(n) at a level of 1 %.
    let gap =
        |(index, share): (usize, &f64)| (share - index as f64 / 1e3).max((index + 1) as f64 / 1e3 - share);
    let largest = shares.iter().enumerate().map(gap).fold(0.0, f64::max);
    assert!(largest < 1.63 / libm::sqrt(1e3), "{largest}");
}

/// The torques in N m of the servo of each joint in 4000 physics steps of a robot that is held still, with
/// the encoders' noise of 1e-4 rad.
fn held_still(feedback: &str) -> Vec<Vec<f64>> {
    let mut recipe = Recipe::new("tocabi", Some("walk"));
    recipe.action = format!(
        "kind = \"position\"\nstd = \"1 %\"\nservo_rate = \"500 Hz\"\nstiffness = \"25 %\"\n{feedback}"
    );
    let engine = standing();
    let mut environment = environment(&recipe, &engine, &Mode::Training);
    environment.begin("test");
    for _ in 0..1000 {
        environment.step(&[0.0; 13]);
    }
    let record = engine.record.lock().unwrap();
    record.torques.clone()
}

#[test]
fn a_servo_that_reads_its_encoders_has_their_noise_in_its_torque() {
    let robot = Recipe::new("tocabi", Some("walk")).blueprint().robot;
    let [silent, plain, measured] =
        ["", "feedback = \"true\"\n", "feedback = \"measured\"\n"].map(held_still);
    assert_eq!(silent, plain, "the default");
    assert!(silent.iter().all(|torques| *torques == silent[0]), "nothing moves");
    for (joint, link) in robot.links.iter().enumerate() {
        let noise = |torques: &Vec<f64>| torques[joint] - silent[0][joint];
        let variance =
            measured.iter().map(|torques| noise(torques).powi(2)).sum::<f64>() / measured.len() as f64;
        // -K_p n_k - K_d (n_k - n_(k-1)) / dt, n white with 1e-4 rad; K_d by the root of the stiffness.
        let (stiffness, damping) = (0.25 * link.joint.stiffness_gain, 0.5 * link.joint.damping_gain / 0.002);
        let due = 1e-8 * ((stiffness + damping).powi(2) + damping.powi(2));
        assert!((variance / due - 1.0).abs() < 0.12, "{}: {variance} of {due}", link.joint.name);
    }
}

#[test]
fn an_episode_ends_at_its_time_limit_with_its_last_reward() {
    let mode = Mode::Evaluation(Trial { time_limit: Some(0.4), ..Trial::default() });
    let mut environment = environment(&Recipe::new("tocabi", Some("walk")), &standing(), &mode);
    environment.begin("test");
    let mut steps = 0;
    let last = loop {
        steps += 1;
        let step = environment.step(&[0.0; 13]);
        if step.end.is_some() {
            break step;
        }
    };
    assert_eq!((steps, last.end), (50, Some(End::TimeOut)));
    assert!(last.reward > 0.5);
    assert!((last.reward - environment.view().term_values().iter().sum::<f64>()).abs() < 1e-12);
}

#[test]
fn a_terminated_step_earns_nothing_and_names_its_cause() {
    let mut recipe = Recipe::new("tocabi", Some("walk"));
    recipe.more = "[terminate.ground_contact]\n[terminate.base_height]\nbelow = \"0.6 m\"\n".into();
    let mut engine = standing();
    engine.contacts.body = true;
    let mut environment = environment(&recipe, &engine, &Mode::Training);
    environment.begin("test");
    let step = environment.step(&[0.0; 13]);
    let Some(End::Terminated(cause)) = step.end else { unreachable!("the body touches the ground") };
    assert_eq!((environment.view().causes()[cause].as_str(), step.reward), ("ground_contact", 0.0));
}

#[test]
fn links_inside_each_other_end_the_episode_where_a_term_says_so() {
    let ends = |drift: f64, more: &str| {
        let mut recipe = Recipe::new("tocabi", Some("walk"));
        recipe.more = more.into();
        let engine = Still { drift, ..standing() };
        let mut environment = environment(&recipe, &engine, &Mode::Training);
        environment.begin("test");
        let last = (0..50).find_map(|_| environment.step(&[0.0; 13]).end);
        last.map(|end| match end {
            End::Terminated(cause) => environment.view().causes()[cause].clone(),
            other => format!("{other:?}"),
        })
    };
    // 0.6 rad per second on every joint: the soles rotate into each other.
    assert_eq!(ends(0.01, "[terminate.self_collision]\n"), Some("self_collision".into()));
    assert_eq!(ends(0.01, ""), None);
    assert_eq!(ends(0.0, "[terminate.self_collision]\n"), None);
}

#[test]
fn a_trial_looks_at_links_inside_each_other_where_no_term_does() {
    let looks = |mode: &Mode| {
        let engine = Still { drift: 0.01, ..standing() };
        let mut environment = environment(&Recipe::new("tocabi", Some("walk")), &engine, mode);
        environment.begin("test");
        let mut seen = (0..50).map(|_| {
            let end = environment.step(&[0.0; 13]).end;
            (environment.signals().self_collision, end)
        });
        seen.any(|(inside, _)| inside)
    };
    assert_eq!((looks(&at_phase(0.0)), looks(&Mode::Training)), (true, false));
}

#[test]
fn an_exploded_state_ends_the_episode_and_shows_finite_numbers() {
    let engine = Still { insane: 6, ..standing() };
    let mut environment = environment(&Recipe::new("tocabi", Some("walk")), &engine, &Mode::Training);
    environment.begin("test");
    assert_eq!(environment.step(&[0.0; 13]).end, None);
    assert_eq!(environment.step(&[0.0; 13]).end, Some(End::Exploded));
    let mut privileged = [f32::NAN; 42];
    environment.view().observe_privileged(&mut privileged);
    assert!(privileged.iter().all(|number| number.is_finite()));
    environment.begin("again");
    assert_eq!(environment.step(&[f32::NAN; 13]).end, None);
}

#[test]
fn standing_through_the_swing_window_violates_the_schedule_in_training_only() {
    let mut recipe = Recipe::new("tocabi", Some("walk"));
    recipe.more = "[terminate.contact_schedule]\ntolerance = \"15 %\"\n".into();
    let mut training = environment(&recipe, &standing(), &Mode::Training);
    training.begin("test");
    let steps = (1..).find(|_| training.step(&[0.0; 13]).end.is_some()).unwrap();
    // Single support begins 0.15 s after phase 0 or one half; 0.27 s of it are tolerated.
    assert!((52..=54).contains(&steps), "{steps}");
    let mut evaluation = environment(&recipe, &standing(), &at_phase(0.0));
    evaluation.begin("test");
    assert!((0..1999).all(|_| evaluation.step(&[0.0; 13]).end.is_none()));
}

#[test]
fn the_first_step_is_not_punished_for_changes() {
    let mut environment = environment(&Recipe::new("tocabi", Some("walk")), &standing(), &at_phase(0.0));
    environment.begin("test");
    environment.step(&[0.3; 13]);
    let signals = environment.signals();
    assert_eq!(signals.torque, signals.previous_torque);
    environment.step(&[0.1; 13]);
    assert_ne!(environment.signals().torque, environment.signals().previous_torque);
}

#[test]
fn measured_velocities_lag_behind_as_the_filter_says() {
    let engine = Still { drift: 0.001, ..standing() };
    let mut environment = environment(&Recipe::new("tocabi", Some("walk")), &engine, &at_phase(0.0));
    environment.begin("test");
    for _ in 0..5 {
        environment.step(&[0.0; 13]);
    }
    let mut observation = [0.0f32; 30];
    environment.view().observe(&mut observation);
    // 20 physics steps at 0.5 rad/s through y += a (x - y).
    let share = 0.002 / (1.0 / (std::f64::consts::TAU * 4.0) + 0.002);
    let expected = 0.5 * (1.0 - (1.0 - share).powi(20)) / 0.998;
    assert!((f64::from(observation[18]) - expected).abs() < 1e-6);
    assert!((f64::from(observation[6]) - 0.02 / 0.15).abs() < 1e-6);
}

#[test]
fn the_mean_velocity_forgets_within_half_a_cycle_and_every_episode_begins_anew() {
    let engine = Still { speed: 0.5, ..standing() };
    let mut environment = environment(&Recipe::new("tocabi", Some("walk")), &engine, &at_phase(0.0));
    let half = 0.5 * environment.scene().motion().period;
    let share = environment.scene().step() / (half + environment.scene().step());
    for _ in 0..2 {
        environment.begin("test");
        assert_eq!(environment.signals().mean_velocity, [0.0; 3]);
        for _ in 0..5 {
            environment.step(&[0.0; 13]);
        }
        let signals = environment.signals();
        assert_eq!(signals.base_velocity, [0.5, 0.0, 0.0]);
        assert!((signals.mean_velocity[0] - 0.5 * (1.0 - (1.0 - share).powi(5))).abs() < 1e-12);
        assert_eq!(signals.mean_velocity[1..], [0.0; 2]);
    }
}

#[test]
fn randomized_episodes_differ_by_stream_and_repeat_with_it() {
    let mut recipe = Recipe::new("tocabi", Some("walk"));
    recipe.action += "delay = \"4 ms\"\n";
    recipe.more = "[randomize.link_mass]\nscale = { uniform = [0.6, 1.4] }\n[randomize.ground_friction]\n\
                   scale = { uniform = [0.5, 1.0] }\n[randomize.leg_length]\nscale = \
                   { uniform = [0.9, 1.1] }\n"
        .into();
    let engine = standing();
    let mut environment = environment(&recipe, &engine, &Mode::Training);
    ["a", "b", "a"].into_iter().for_each(|stream| environment.begin(stream));
    let record = engine.record.lock().unwrap();
    // The first world shows that the engine takes the nominal robot.
    assert_eq!((&record.robots[1], record.frictions[1]), (&record.robots[3], record.frictions[3]));
    assert_ne!(record.robots[1], record.robots[2]);
    assert_ne!(record.frictions[1], record.frictions[2]);
}

#[test]
fn a_push_acts_for_its_duration_and_ends() {
    let mut recipe = Recipe::new("tocabi", Some("walk"));
    recipe.more = "[randomize.push]\nimpulse = \"60 m*kg/s\"\nduration = \"0.2 s\"\nevery = \"1 s\"\n".into();
    let engine = standing();
    let mut environment = environment(&recipe, &engine, &Mode::Training);
    environment.begin("test");
    for _ in 0..300 {
        environment.step(&[0.0; 13]);
    }
    let pushes = &engine.record.lock().unwrap().pushes;
    assert!(pushes.len() >= 4);
    let force = |push: &[f64; 3]| push[0].hypot(push[1]);
    let first: Vec<f64> = pushes.iter().map(force).take_while(|force| *force > 0.0).collect();
    // Partial in the steps in which it begins and ends, full in between; then it is over.
    assert!(first.len() <= 3 && pushes[first.len()] == [0.0; 3], "{first:?}");
    assert_eq!(first.iter().filter(|force| (**force - 300.0).abs() < 1e-9).count(), 1, "{first:?}");
    assert!(first.iter().all(|force| *force < 300.0 + 1e-9), "{first:?}");
}
