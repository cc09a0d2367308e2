//! What every engine supports, as `specforge list engines` prints it.

/// What every engine supports: robots of a spec have nothing else.
pub const SUPPORTED: [(&str, &[&str]); 4] = [
    ("joints", &["revolute", "a floating base"]),
    ("shapes", &["box", "capsule", "sphere", "cylinder"]),
    ("terrain", &["flat", "slope", "box_obstacle", "height_field"]),
    ("self_collision", &["detected, not resolved"]),
];
