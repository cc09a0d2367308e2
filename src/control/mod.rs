//! Low-level control: from the policy's actions to joint torques.
//!
//! Each physics step, without allocation, the law computes torques from actions, the delay line holds them
//! back, and the motor limits them. Depends on robots, but not on engines or rewards.

pub mod delay;
pub mod law;
pub mod low_pass;
pub mod motor;
pub mod words;

pub use delay::Delay;
pub use law::Law;
pub use low_pass::LowPass;
