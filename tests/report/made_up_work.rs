//! Works that put the made-up arms into a store, so that a report can be gathered from it.

use specforge::exec::{Job, Work, WorkError};
use specforge::plan::StageKind;
use specforge::report::model::{Arm, Update};

use crate::synthetic;

/// Writes what the stage would have measured.
pub struct MadeUp;

impl Work for MadeUp {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let user = &job.stage.users[0];
        let input = synthetic::input();
        let arm =
            input.arms.iter().find(|arm| arm.name == user.arm).expect("the arms have the made-up names");
        match job.stage.kind {
            // As the real work does: what is written must be the model of the recipe.
            StageKind::Robot => job.write("robot.json", &*job.stage.recipe.content),
            StageKind::Motion => job.write("motion.json", &arm.motion),
            StageKind::Pretrain => job.write("pretrain.json", &arm.pretrain),
            StageKind::Learner if user.arm.ends_with("position") => {
                Err(WorkError::coded("R0001", "the state became NaN", "lower the learning rate"))
            }
            StageKind::Learner => job.write_text("metrics.jsonl", &lines(&arm.updates)),
            StageKind::Evaluate | StageKind::Transfer => {
                job.write("evaluation.json", &evaluation(arm, &user.stage))
            }
            StageKind::Export => job.write_text("policy.safetensors", &format!("weights of {}", user.arm)),
            _ => job.write("made.json", &user.stage),
        }
    }
}

fn lines(updates: &[Update]) -> String {
    updates.iter().map(|update| serde_json::to_string(update).expect("numbers") + "\n").collect()
}

fn evaluation(arm: &Arm, stage: &str) -> specforge::evaluate::outcome::Evaluation {
    let measured = arm.evaluations.iter().find(|measured| measured.stage == stage);
    measured.expect("the made-up arm was evaluated").evaluation.clone()
}
