//! Joints that nothing drives: springs, rods of a linkage, toes. A robot file has motors only, so on a leg the user decides
//! what becomes of them. Only MJCF says which these are: in URDF an effort limit that is missing or zero is unknown, and stays
//! to be filled in.

use regex::escape;

use super::naming::some;
use super::tree::Hinge;
use super::weld::Selection;
use crate::diag::Diagnostic;

/// The refusal of passive joints between the base and the feet (E0429), which the user neither selects nor fills.
pub(super) fn refusal(kept: &[&Hinge], selection: &Selection) -> Option<Diagnostic> {
    if selection.joints.is_some() {
        return None;
    }
    let idle: Vec<&Hinge> = passive(kept, selection).collect();
    let first = idle.first()?;
    let names: Vec<&str> = idle.iter().map(|hinge| hinge.name.as_str()).collect();
    let verb = if names.len() == 1 { "has" } else { "have" };
    let message = format!(
        "{} between the base and the feet {verb} no actuator, although the file drives other joints: a robot file has motors only",
        some(&names)
    );
    let driven = kept.iter().filter(|hinge| !hinge.passive).map(|hinge| escape(&hinge.name));
    let driven = format!("^({})$", driven.collect::<Vec<_>>().join("|"));
    let error = Diagnostic::error("E0429", message)
        .help(format!("weld them where the file has them: --joints '{driven}'"))
        .help(format!("or give them motors with --fill '{}:effort_limit=VALUE'", first.name));
    Some(match first.span {
        Some(span) => error.at(span, "nothing drives this one"),
        None => error,
    })
}

/// What is said of passive joints that the user selects.
pub(super) fn remark(kept: &[&Hinge], selection: &Selection) -> Option<String> {
    let names: Vec<&str> = passive(kept, selection).map(|hinge| hinge.name.as_str()).collect();
    let is_selected = selection.joints.is_some() && !names.is_empty();
    is_selected.then(|| format!("motors in the robot file and without an actuator in the source: {}", some(&names)))
}

fn passive<'a>(kept: &'a [&'a Hinge], selection: &'a Selection) -> impl Iterator<Item = &'a Hinge> {
    let is_filled = |hinge: &Hinge| {
        let fits = |fill: &super::Fill| fill.joints.as_ref().is_none_or(|joints| joints.is_match(&hinge.name));
        selection.fills.iter().any(|fill| fill.key == "effort_limit" && fits(fill))
    };
    kept.iter().copied().filter(move |hinge| hinge.passive && !is_filled(hinge))
}
