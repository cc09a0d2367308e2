//! Features that every engine supports, as `specforge list engines` prints them.

/// Features that every engine supports; robots of a spec use no others.
pub const SUPPORTED: [(&str, &[&str]); 4] = [
    ("joints", &["revolute", "a floating base"]),
    ("shapes", &["box", "capsule", "sphere", "cylinder"]),
    ("terrain", &["flat", "slope", "box_obstacle", "height_field"]),
    ("self_collision", &["detected, not resolved"]),
];
