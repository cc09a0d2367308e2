//! What the user chooses of a description.

use regex::Regex;

use super::fill::Fill;

/// Which joints stay joints and which bodies are the feet.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// The joints that stay; without it those between the base and the feet.
    pub joints: Option<Regex>,
    /// Names of the left and the right foot's body; without it the two lowest ends of the tree.
    pub feet: Option<[String; 2]>,
    /// Whether the moments of a body that no rigid body has are replaced by their mean.
    pub balance: bool,
    /// Figures that are filled in; soles are looked at in the default pose that they give.
    pub fills: Vec<Fill>,
}
