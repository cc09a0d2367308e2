//! Environments that step together give the numbers that each gives alone.

#![cfg(feature = "mujoco")]

#[path = "worlds/mod.rs"]
mod worlds;

use specforge::env::{Crew, Mode, RobotCrew, RobotEnvironment, Step};
use specforge::sim;
use specforge::stream::Stream;

/// Control steps that are compared.
const STEPS: usize = 120;

/// An action of an environment in a control step: strong enough to make the robot fall.
fn action(environment: usize, step: usize, width: usize) -> Vec<f32> {
    let mut stream = Stream::new(&format!("test/crew/{environment}/{step}"));
    (0..width).map(|_| (0.4 * stream.normal()) as f32).collect()
}

/// What is compared after a control step, bit by bit.
fn bits(step: Step, observation: &[f32]) -> (u64, bool, Vec<u32>) {
    (step.reward.to_bits(), step.end.is_some(), observation.iter().map(|value| value.to_bits()).collect())
}

fn name(environment: usize, episode: usize) -> String {
    format!("1/test/env/{environment}/episode/{episode}")
}

#[test]
fn a_crew_gives_the_numbers_of_its_members_alone_also_when_some_wait() {
    let blueprint = worlds::blueprint("walk", "torque", "");
    for engine in sim::ENGINES {
        let scene = blueprint.scene(sim::open(engine).unwrap(), &Mode::Training).unwrap();
        let mut crew = RobotCrew::new(&scene, 3);
        let sizes = crew.view(0).sizes();
        let mut observation = vec![0.0; sizes.observation];
        let (mut together, mut episodes) = (vec![Vec::new(); 3], [0; 3]);
        (0..3).for_each(|index| crew.begin(index, &name(index, 0)));
        for step in 0..STEPS {
            // The second waits in every third step.
            let acting: Vec<usize> = (0..3).filter(|index| *index != 1 || step % 3 > 0).collect();
            acting
                .iter()
                .for_each(|index| crew.act(*index, &action(*index, together[*index].len(), sizes.action)));
            crew.step();
            for index in acting {
                crew.view(index).observe(&mut observation);
                together[index].push(bits(crew.outcome(index), &observation));
                if crew.outcome(index).end.is_some() {
                    episodes[index] += 1;
                    crew.begin(index, &name(index, episodes[index]));
                }
            }
        }
        assert!(episodes.iter().any(|count| *count > 0), "{engine}: no episode ended, so none began again");
        for (index, together) in together.iter().enumerate() {
            let (mut environment, mut episode) = (RobotEnvironment::new(scene.clone()), 0);
            environment.begin(&name(index, 0));
            for (step, expected) in together.iter().enumerate() {
                let outcome = environment.step(&action(index, step, sizes.action));
                environment.view().observe(&mut observation);
                assert!(
                    bits(outcome, &observation) == *expected,
                    "{engine}: environment {index}, step {step}"
                );
                if outcome.end.is_some() {
                    episode += 1;
                    environment.begin(&name(index, episode));
                }
            }
        }
    }
}
