//! What each engine is and supports, as `specforge list engines` prints it.

/// An engine as users choose it.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Its name in specs.
    pub name: &'static str,
    /// What it is, and what it is good for.
    pub summary: &'static str,
    /// Its contacts.
    pub contacts: &'static str,
}

/// What every engine supports: robots of a spec have nothing else.
pub const SUPPORTED: [(&str, &[&str]); 4] = [
    ("joints", &["revolute", "a floating base"]),
    ("shapes", &["box", "capsule", "sphere", "cylinder"]),
    ("terrain", &["flat", "slope", "box_obstacle", "height_field"]),
    ("self_collision", &["detected, not resolved"]),
];

/// The engines.
pub const CATALOGUE: [Entry; 3] = [
    Entry {
        name: "rapier",
        summary: "rapier's multibody joints: stiff contacts, pure Rust",
        contacts: "impacts end within a step; `contact_time` softens them in proportion to the mass of the foot",
    },
    Entry {
        name: "mujoco",
        summary: "the MuJoCo library: soft contacts, the paper's engine",
        contacts: "time constant of 20 ms, or `contact_time`; two physics steps if that is longer",
    },
    Entry {
        name: "batch",
        summary: "MuJoCo's model in Rust, many worlds in each instruction: the fastest for training",
        contacts: "time constant of 20 ms, or `contact_time`, of at least two physics steps (E0521)",
    },
];

#[cfg(test)]
mod tests {
    use super::CATALOGUE;
    use crate::sim::ENGINES;

    #[test]
    fn every_engine_is_in_the_catalogue() {
        assert_eq!(CATALOGUE.map(|entry| entry.name), *ENGINES);
    }
}
