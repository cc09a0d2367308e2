//! Low-level control laws: torque, position, delay, low-pass.
