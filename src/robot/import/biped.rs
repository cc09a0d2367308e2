//! Whether a tree is a biped (E0427). Not checked if the user names the feet.

use nalgebra::Vector3;

use super::remains::further_legs;
use super::tree::Tree;
use crate::diag::Diagnostic;
use crate::spec::suggest::listed;

/// Number of additional legs from which a robot is not a biped.
const FURTHER: usize = 2;
/// Words in the names of legs and of arms.
const LEG: [&str; 10] = ["leg", "hip", "knee", "ankle", "thigh", "shank", "calf", "foot", "feet", "toe"];
const ARM: [&str; 8] = ["arm", "shoulder", "elbow", "wrist", "hand", "gripper", "finger", "palm"];

/// Why a tree with these two lowest ends is not a biped. `up` is the file's up direction in the root frame.
pub(super) fn refusal(tree: &Tree, feet: [usize; 2], up: &Vector3<f64>) -> Option<Diagnostic> {
    let name = |body: usize| tree.parts[body].body.name.as_str();
    let ends = listed(feet.map(name));
    let help = "specforge trains robots that stand on two feet: name them with --feet LEFT,RIGHT, all other \
        limbs are welded";
    let further = further_legs(tree, feet, up);
    if further.len() >= FURTHER {
        let more = listed(further.iter().map(|body| name(*body)));
        let message = format!("the robot has {} legs: {ends}, and {more}", feet.len() + further.len());
        return Some(Diagnostic::error("E0427", message).help(help));
    }
    let says = |words: &[&str]| {
        let limb = |foot: usize| std::iter::successors(Some(foot), |body| tree.parts[*body].parent);
        feet.iter().all(|foot| {
            let joints = limb(*foot).filter_map(|body| Some((name(body), tree.parts[body].hinge.as_ref()?)));
            let names = joints.flat_map(|(body, hinge)| [body.to_lowercase(), hinge.name.to_lowercase()]);
            names.into_iter().any(|name| words.iter().any(|word| name.contains(word)))
        })
    };
    (says(&ARM) && !says(&LEG)).then(|| {
        Diagnostic::error(
            "E0427",
            format!("the robot has no legs: by their names {ends} are the ends of arms"),
        )
        .help(help)
    })
}
