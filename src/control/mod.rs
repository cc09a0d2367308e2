//! Low-level control: what happens to an action between the policy and the joints.
//!
//! Per physics step and without allocation: the law makes torques of actions, the delay holds them back, the
//! motor bounds them. Knows robots, no engines and no rewards.

pub mod delay;
pub mod law;
pub mod low_pass;
pub mod motor;
pub mod words;

pub use delay::Delay;
pub use law::Law;
pub use low_pass::LowPass;
