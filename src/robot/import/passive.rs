//! Joints without a drive: springs, rods of a linkage, toes. A robot file has only motors, so on a leg the
//! user decides how to treat them. Only MJCF identifies them: in URDF an effort limit that is missing or zero
//! is unknown, and has to be filled in.

use regex_lite::escape;

use super::fill::{Fill, LIMIT, gives};
use super::naming::some;
use super::selection::Selection;
use super::tree::{Hinge, Tie, Tree};
use crate::diag::Diagnostic;

/// Maximum number of constraints listed.
const TOLD: usize = 4;

/// The error for passive joints between the base and the feet (E0429) that the user neither selects nor fills
/// in.
pub(super) fn refusal(kept: &[&Hinge], tree: &Tree, selection: &Selection) -> Option<Diagnostic> {
    if selection.joints.is_some() {
        return None;
    }
    let idle: Vec<&Hinge> = passive(kept, selection).collect();
    let first = idle.first()?;
    let names: Vec<&str> = idle.iter().map(|hinge| hinge.name.as_str()).collect();
    let verb = if names.len() == 1 { "has" } else { "have" };
    let message = format!(
        "{} between the base and the feet {verb} no actuator, although the file drives other joints: a robot \
         file has motors only",
        some(&names)
    );
    let driven = kept.iter().filter(|hinge| !hinge.passive).map(|hinge| escape(&hinge.name));
    let driven = format!("^({})$", driven.collect::<Vec<_>>().join("|"));
    let outside: Vec<&str> =
        idle.iter().filter(|hinge| hinge.is_welded_outside()).map(|hinge| hinge.name.as_str()).collect();
    let pose = if outside.is_empty() {
        String::new()
    } else {
        format!(
            "; {} would be outside of the range there, so give the file a key frame first in which the leg \
             is put together, and \
             name it with --key",
            some(&outside)
        )
    };
    let mut error = Diagnostic::error("E0429", message)
        .help(format!("weld them where the file has them: --joints '{driven}'{pose}"))
        .help(format!("or give them motors with --fill '{}:effort_limit=VALUE'", first.name));
    if let Some(fill) =
        selection.fills.iter().find(|fill| idle.iter().any(|hinge| fill.fits(LIMIT, &hinge.name)))
    {
        error = error.help(format!(
            "--fill '{fill}' fits driven joints, too, and gives those that nothing drives no motors"
        ));
    }
    error = [loops(tree), followers(&names, tree)].into_iter().flatten().fold(error, Diagnostic::help);
    Some(match first.span {
        Some(span) => error.at(span, "nothing drives this one"),
        None => error,
    })
}

/// Reports closed loops: they move such joints in the file, but not in the robot.
fn loops(tree: &Tree) -> Option<String> {
    let closed = tree.ties.iter().filter_map(|tie| match tie {
        Tie::Bodies { ends: [one, other], by } => Some(format!("`{one}` to `{other}` ({by})")),
        Tie::Joints { .. } => None,
    });
    let closed: Vec<String> = closed.collect();
    let more = closed.len().saturating_sub(TOLD);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let first = closed.iter().take(TOLD).map(String::as_str).collect::<Vec<_>>().join(", ");
    (!closed.is_empty()).then(|| {
        format!(
            "the file closes loops that a tree of joints does not have, and nothing moves a joint \
            through them: {first}{more}"
        )
    })
}

/// Reports passive joints coupled to a driven one, which may be driven by its motor.
fn followers(idle: &[&str], tree: &Tree) -> Option<String> {
    let led = tree.ties.iter().filter_map(|tie| match tie {
        Tie::Joints { follower, leader } if idle.contains(&follower.as_str()) => {
            Some(format!("`{follower}` follows `{leader}`"))
        }
        _ => None,
    });
    let led: Vec<String> = led.take(TOLD).collect();
    (!led.is_empty()).then(|| {
        let led = led.join(", ");
        format!(
            "{led}: where that joint's motor drives the leg through gears or a linkage, give its figures to \
             the one that \
             follows"
        )
    })
}

/// The remark on passive joints that the user selects.
pub(super) fn remark(kept: &[&Hinge], selection: &Selection) -> Option<String> {
    let names: Vec<&str> = passive(kept, selection).map(|hinge| hinge.name.as_str()).collect();
    let is_selected = selection.joints.is_some() && !names.is_empty();
    is_selected.then(|| {
        let meant = |fill: &&Fill| names.iter().any(|name| fill.fits(LIMIT, name));
        let unfilled = match selection.fills.iter().find(meant) {
            Some(fill) => format!(
                "; --fill '{fill}' is for the joints that the source drives, and --fill '{}:{LIMIT}=VALUE' \
                 makes a motor of one \
                 that it does not",
                names[0]
            ),
            None => String::new(),
        };
        format!("motors in the robot file and without an actuator in the source: {}{unfilled}", some(&names))
    })
}

fn passive<'a>(kept: &'a [&'a Hinge], selection: &'a Selection) -> impl Iterator<Item = &'a Hinge> {
    let is_filled =
        |hinge: &Hinge| selection.fills.iter().any(|fill| gives(fill, LIMIT, hinge, kept.iter().copied()));
    kept.iter().copied().filter(move |hinge| hinge.passive && !is_filled(hinge))
}
