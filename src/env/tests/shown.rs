//! The policy's observation: layout, normalisation, mirroring.

use super::Recipe;
use crate::env::Observation;
use crate::kinds::observe::Readings;
use crate::stream::Stream;

fn layout(recipe: &Recipe) -> Observation {
    recipe.blueprint().observation()
}

fn write(observation: &Observation, readings: &Readings) -> Vec<f32> {
    let mut vector = vec![0.0; observation.len()];
    observation.write(readings, &mut vector);
    vector
}

#[test]
fn the_walking_observation_has_the_paper_s_30_numbers_in_order() {
    let observation = layout(&Recipe::new("tocabi", Some("walk")));
    let names: Vec<&str> = observation.inputs().iter().map(|input| input.name.as_str()).collect();
    assert_eq!(names.len(), 30);
    assert_eq!(names[..4], ["base_roll", "base_pitch", "base_yaw", "joint_position"]);
    assert_eq!((names[14], names[15], names[26]), ("joint_position", "joint_velocity", "joint_velocity"));
    assert_eq!(names[27..], ["phase_sin", "phase_cos", "command_speed"]);
    let robot = crate::robot::tests::robot("tocabi");
    for joint in 0..12 {
        let name = Some(robot.links[joint].joint.name.clone());
        assert_eq!(observation.inputs()[3 + joint].joint, name);
        assert_eq!(observation.inputs()[15 + joint].joint, name);
    }
}

#[test]
fn inputs_are_normalised_as_the_recipe_says() {
    let blueprint = Recipe::new("tocabi", Some("walk")).blueprint();
    let mut position = blueprint.robot.default_pose();
    position[3] += 0.3;
    let mut velocity = vec![0.0; 12];
    (velocity[9], velocity[0]) = (0.499, 99.0);
    let attitude = [0.05, -0.1, 0.1];
    let readings = Readings {
        attitude,
        position: &position,
        velocity: &velocity,
        phase: 0.25,
        command_speed: 0.25,
        mirror: None,
    };
    let vector = write(&blueprint.observation(), &readings);
    let expected = [
        (0, 0.5),
        (1, -1.0),
        (2, 0.5),
        (5, 0.0),
        (6, 2.0),
        (15, 8.0),
        (24, 0.5),
        (27, 1.0 / 0.7),
        (28, 0.0),
        (29, 0.5),
    ];
    for (index, expected) in expected {
        assert!((vector[index] - expected).abs() < 1e-6, "{index}: {vector:?}");
    }
}

#[test]
fn the_second_half_of_the_cycle_is_the_first_in_the_mirror() {
    let observation = layout(&Recipe::new("tocabi", Some("walk")));
    let mirror = crate::robot::tests::robot("tocabi").mirror;
    let mut stream = Stream::new("test");
    let mut draw = || (0..12).map(|_| 0.2 * stream.normal()).collect::<Vec<f64>>();
    let (position, velocity) = (draw(), draw());
    let image =
        |vector: &[f64]| mirror.iter().map(|&(joint, sign)| sign * vector[joint]).collect::<Vec<f64>>();
    let (other_position, other_velocity) = (image(&position), image(&velocity));
    let first = Readings {
        attitude: [0.01, 0.02, 0.03],
        position: &position,
        velocity: &velocity,
        phase: 0.2,
        command_speed: 0.2,
        mirror: None,
    };
    let second = Readings {
        attitude: [-0.01, 0.02, -0.03],
        position: &other_position,
        velocity: &other_velocity,
        phase: 0.7,
        ..first
    };
    let (first, second) = (write(&observation, &first), write(&observation, &second));
    for (a, b) in first.iter().zip(&second) {
        assert!((a - b).abs() < 1e-5);
    }
    assert!(!observation.reflects(0.49) && observation.reflects(0.5));
}

#[test]
fn reflecting_an_action_twice_gives_it_back_and_swaps_the_legs() {
    let observation = layout(&Recipe::new("atlas", Some("walk")));
    let original: Vec<f32> = (0..13).map(|index| 0.1 * index as f32 - 0.3).collect();
    let mut action = original.clone();
    observation.reflect(&mut action);
    // Yaw and roll change sign and side, pitch joints only the side; the phase action stays.
    assert_eq!((action[0], action[1], action[2]), (-original[6], -original[7], original[8]));
    assert_eq!((action[9], action[12]), (original[3], original[12]));
    observation.reflect(&mut action);
    assert_eq!(action, original);
}

#[test]
fn without_symmetry_nothing_is_mirrored_and_a_squat_must_be_without() {
    let mut recipe = Recipe::new("tocabi", Some("squat"));
    let refused = crate::env::Blueprint::new(
        recipe.fields(),
        crate::robot::tests::robot("tocabi"),
        Some(super::recipe::motion("squat", &crate::robot::tests::robot("tocabi"))),
    );
    assert!(refused.is_err_and(|error| error.to_string().contains("mirror image")));
    recipe.symmetry = "none";
    assert!(!layout(&recipe).reflects(0.9));
}
