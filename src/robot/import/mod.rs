//! Robots from other programs' files: URDF and MJCF become `robots/NAME.toml`.
//!
//! A file is read into a [`Tree`] of bodies as it stands, bodies whose joints are not selected are welded to what carries
//! them, and the rest is written as a robot file. Nothing is invented: a figure that the file does not hold stands in the
//! robot file as a commented line to fill in.

mod mjcf;
mod tree;
mod urdf;
mod weld;
mod write;

use std::path::Path;

use regex::Regex;

pub use tree::{Hinge, Part, Tree};
pub use weld::{Selection, Welded, weld};
pub use write::{Origin, text};

/// Why a file cannot be imported.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// It cannot be read.
    #[error("{path}: {reason}")]
    Read {
        /// The file.
        path: String,
        /// What the system or the parser says.
        reason: String,
    },
    /// It is neither URDF nor MJCF.
    #[error("{path}: the outermost element is `{found}`, not `robot` (URDF) or `mujoco` (MJCF)")]
    Format {
        /// The file.
        path: String,
        /// The outermost element.
        found: String,
    },
    /// A selected joint is of a kind that no robot file can hold.
    #[error("joint `{joint}` is {kind}, and a robot is a tree of revolute joints; leave it out of --joints to weld it")]
    Joint {
        /// The joint.
        joint: String,
        /// Its kind.
        kind: String,
    },
    /// The regular expression selects nothing.
    #[error("--joints `{pattern}` matches no joint; the file has {names}")]
    Selector {
        /// The expression.
        pattern: String,
        /// The joints of the file.
        names: String,
    },
    /// A foot that is no moving body.
    #[error("--feet: {reason}")]
    Feet {
        /// What is wrong and which bodies there are.
        reason: String,
    },
}

/// Reads a URDF or MJCF file.
pub fn read(path: &Path) -> Result<Tree, ImportError> {
    let shown = path.display().to_string();
    let fault = |reason: String| ImportError::Read { path: shown.clone(), reason };
    let text = std::fs::read_to_string(path).map_err(|error| fault(error.to_string()))?;
    let outermost = Regex::new(r"<([A-Za-z_][\w.-]*)").expect("the expression is sound");
    // Comments and declarations may stand before the outermost element.
    let bare =
        Regex::new(r"(?s)<!--.*?-->|<\?.*?\?>|<!DOCTYPE.*?>").expect("the expression is sound").replace_all(&text, "");
    match outermost.captures(&bare).map(|found| found[1].to_owned()).as_deref() {
        Some("robot") => urdf::tree(&text).map_err(fault),
        Some("mujoco" | "mujocoinclude") => mjcf::tree(path).map_err(fault),
        found => Err(ImportError::Format { path: shown, found: found.unwrap_or("nothing").to_owned() }),
    }
}
