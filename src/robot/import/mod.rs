//! Imports robots from other formats: converts URDF and MJCF to `robots/NAME.toml`.
//!
//! A file is read into a [`Tree`] of bodies without changes, bodies with unselected joints are welded to
//! their parents, and the rest is written as a robot file. No values are invented: one that is missing in the
//! file becomes a commented line to fill in. Only the [`Folder`] is read, and the size of every text, mesh
//! and tree is limited; mistakes are diagnostics at their places (E0402 to E0429). Frames that violate the
//! convention of robot files are rewritten.

mod biped;
mod block;
mod census;
mod collada;
mod ends;
mod feet;
mod fill;
mod folder;
mod frames;
mod intake;
mod judged;
mod mesh;
mod mjcf;
mod naming;
mod number;
mod origin;
mod passive;
mod physical;
mod remains;
mod round;
mod selection;
mod tree;
mod urdf;
mod weld;
mod welded;
mod write;
mod xacro;
mod xml;

use std::path::Path;

pub use block::Block;
pub use fill::{Fill, fillable};
pub use folder::{Folder, Place};
pub use judged::{Draft, issues};
pub use selection::Selection;
pub use tree::{Hinge, MeshBox, Part, Shapes, Tie, Tree, Weight};
pub use weld::weld;
pub use welded::{Moving, Welded};
pub use write::{Origin, Written, idle, text};

use crate::diag::{Diagnostic, Sink, Sources};
use intake::Intake;

/// Reads a URDF or MJCF file and adds its texts to the sources. `None` if anything is wrong; the diagnostics
/// are then in the sink.
pub fn read(path: &Path, folder: &Folder, sources: &mut Sources, sink: &mut Sink) -> Option<Tree> {
    read_with_key(path, None, folder, sources, sink)
}

/// The same with the name of the key frame for the default pose; if absent, the first one.
pub fn read_with_key(
    path: &Path,
    key: Option<&str>,
    folder: &Folder,
    sources: &mut Sources,
    sink: &mut Sink,
) -> Option<Tree> {
    let mut intake = Intake::new(folder, sources, sink);
    intake.key = key.map(str::to_owned);
    let source = intake.text(path, path, None)?;
    let root = intake.parse(source)?;
    xacro::refuse(&root, &mut intake)?;
    let from = path.canonicalize().ok()?.parent()?.to_owned();
    let tree = match root.name.as_str() {
        "robot" if key.is_some() => {
            intake.tell(intake::no_key(key.unwrap_or_default(), &[]));
            None
        }
        "robot" => urdf::tree(&root, &from, &mut intake),
        "mujoco" | "mujocoinclude" => mjcf::tree(root, &from, &mut intake),
        found => {
            let message =
                format!("the outermost element is `{found}`, not `robot` (URDF) or `mujoco` (MJCF)");
            let help = match found {
                "sdf" => "convert it from SDF to URDF or MJCF first",
                _ => "give a URDF or MJCF file",
            };
            intake.tell(Diagnostic::error("E0410", message).at(root.span, "").help(help));
            None
        }
    };
    intake.count_habits();
    let notes = intake.notes();
    let meshes = std::mem::take(&mut intake.boxes);
    let mut tree = tree?;
    tree.notes.extend(notes);
    tree.meshes = meshes;
    (!sink.has_errors()).then_some(tree)
}
