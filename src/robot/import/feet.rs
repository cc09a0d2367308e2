//! The feet of a welded tree: their bodies and their soles.

use nalgebra::Vector3;

use super::block::{Block, along_axes, around};
use super::ends::{Feet, Joints};
use super::round;
use super::welded::{Owner, Welded};
use crate::diag::Diagnostic;
use crate::robot::{Collision, Shape};

/// Shapes whose lowest points are within this distance in m of the lowest of all form the sole.
pub(super) const SOLE_DEPTH: f64 = 5e-3;

/// The feet by body name; `owner` maps a body of the file to its welded body.
pub(super) fn named(
    names: &[String; 2],
    owner: impl Fn(&str) -> Option<Owner>,
    welded: &Welded,
) -> Result<[usize; 2], Diagnostic> {
    let mut feet = [0; 2];
    for (foot, name) in feet.iter_mut().zip(names) {
        let message = match owner(name) {
            Some(Some(link)) => {
                *foot = link;
                continue;
            }
            Some(None) => format!("--feet: `{name}` is welded to the base"),
            None => format!("--feet: there is no body `{name}`"),
        };
        let links: Vec<&str> = welded.links.iter().map(|link| link.body.name.as_str()).collect();
        return Err(
            Diagnostic::error("E0404", message).help(format!("the moving bodies are {}", links.join(", ")))
        );
    }
    if feet[0] == feet[1] {
        let message = format!("--feet: `{}` and `{}` are one moving body", names[0], names[1]);
        return Err(Diagnostic::error("E0404", message).help("name the left and the right foot's body"));
    }
    Ok(feet)
}

/// The two ends of a welded tree that reach lowest with all joints at zero; `up` is the file's up direction.
pub(super) fn lowest_ends(welded: &Welded, up: &Vector3<f64>) -> Result<[usize; 2], Diagnostic> {
    match Joints::of_welded(welded).feet(up) {
        Feet::Pair(feet) => Ok(feet),
        Feet::Fewer(_) => Err(Diagnostic::error(
            "E0404",
            "the selected joints have fewer than two ends, and a robot has two feet",
        )
        .help("select both legs with --joints")),
        Feet::Unclear => Err(unclear(&welded.base.name)),
    }
}

/// E0416: the feet cannot be determined.
pub(super) fn unclear(base: &str) -> Diagnostic {
    let message =
        format!("which bodies are the feet is unclear: the z axis of `{base}` is not up along the legs");
    Diagnostic::error("E0416", message).help(format!(
        "name the left and the right foot with --feet LEFT,RIGHT, or turn the frame of `{base}` so that x \
         points forward, y to the left \
         and z up"
    ))
}

/// The box around the lowest shapes of a foot; its other shapes are dropped, because only the sole touches
/// the ground.
pub(super) fn sole(welded: &mut Welded, link: usize) -> Option<Block> {
    let body = &mut welded.links[link].body;
    let blocks: Vec<Block> = body.collisions.iter().map(around).collect();
    let low = |block: &Block| block.centre.z - block.half.z;
    let lowest = blocks.iter().map(low).min_by(f64::total_cmp)?;
    let (soles, others): (Vec<&Block>, Vec<&Block>) =
        blocks.iter().partition(|block| low(block) - lowest < SOLE_DEPTH);
    let corner = |sign: f64| {
        let corners = soles.iter().map(|block| block.centre + sign * block.half);
        corners.reduce(|a, b| if sign < 0.0 { a.inf(&b) } else { a.sup(&b) })
    };
    let (from, to) = (corner(-1.0)?, corner(1.0)?);
    // Round shapes that touch in a point or a line have a note of their own.
    let is_changed = |collision: &Collision| match collision.shape {
        Shape::Box(_) => !along_axes(collision),
        Shape::Cylinder(..) => true,
        Shape::Capsule(..) | Shape::Sphere(_) => false,
    };
    if soles.len() > 1 || !others.is_empty() || body.collisions.iter().any(is_changed) {
        let shapes = if soles.len() == 1 {
            "lowest shape".to_owned()
        } else {
            format!("{} lowest shapes", soles.len())
        };
        let rest = match others.len() {
            0 => String::new(),
            1 => "; another is left out".to_owned(),
            count => format!("; {count} others are left out"),
        };
        welded.notes.push(format!("`{}`: the sole is the box around its {shapes}{rest}", body.name));
    }
    let lowest = body.collisions.iter().zip(&blocks).filter(|(_, block)| low(block) - lowest < SOLE_DEPTH);
    let touching: Vec<&Collision> = lowest.map(|(collision, _)| collision).collect();
    if let Some(touch) = round::touch(&touching, &(to - from)) {
        let name = &body.name;
        welded.notes.push(format!(
            "`{name}`: {touch}; a sole is a flat box, and the one around it stands for it: the real foot \
             does not stand as steadily"
        ));
    }
    body.collisions.clear();
    Some(Block { centre: 0.5 * (from + to), half: 0.5 * (to - from) })
}
