//! Fine-tuning: trainings that go on from the policy of `[learn]` in a changed world. What they do stands in `learn/`.

pub mod ppo;

use crate::spec::{Kind, Param, Ty};

/// All fine-tunings, sorted by name.
pub static KINDS: &[&Kind] = &[&ppo::PPO];

/// The descriptors of all fine-tunings.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}

/// Which of a spec's policies an evaluation or a deployment is about.
pub const POLICY: Param = Param::optional("policy", Ty::Choice(&["fine_tune", "learner"])).doc(
    "Which policy: that of `[learn]` (`learner`) or that of `[fine_tune]`, each in the world that it was trained in. \
     Without it the last one.",
);
