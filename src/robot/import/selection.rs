//! The user's choices for an import.

use regex_lite::Regex;

use super::fill::Fill;

/// Which joints to keep and which bodies are the feet.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// The joints to keep; if absent those between the base and the feet.
    pub joints: Option<Regex>,
    /// Names of the left and the right foot's body; if absent the two lowest ends of the tree.
    pub feet: Option<[String; 2]>,
    /// Whether impossible moments of inertia are replaced by their mean.
    pub balance: bool,
    /// Filled-in values; soles are examined in the default pose that they define.
    pub fills: Vec<Fill>,
}
