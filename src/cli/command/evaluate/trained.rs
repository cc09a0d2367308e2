//! `specforge evaluate SPEC`: the policy that the spec's run exported, found in the store.

use std::path::{Path, PathBuf};

use crate::cli::specs::Variant;
use crate::cli::study::{self, Source};
use crate::cli::{Exit, Global, output};
use crate::deploy::policy;
use crate::escape::shell;
use crate::exec::manifest::Depth;
use crate::plan::{Cached, Stage, StageKind};

/// Whether a path names a spec and not a policy.
pub fn is_spec(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "toml")
}

/// The policy of a spec under a profile and assignments. Reports errors: an invalid spec, a suite, a spec that
/// exports no policy or is not trained yet. `Err` is the exit code.
pub fn policy(spec: &Path, variant: &Variant, global: &Global) -> Result<PathBuf, Exit> {
    let source = Source { files: vec![spec.to_owned()], variant: variant.clone() };
    let study = study::read(&source, global)?;
    let shown = shell::argument(spec);
    if study.plan.suite.is_some() {
        let message = format!("{} is a suite, which trains many policies", spec.display());
        let advice = "name one policy: `specforge cache list` shows the exports in the store";
        output::complain(global, &message, Some(advice));
        return Err(Exit::Usage);
    }
    // The first arm is the spec itself; the others are those that it is compared with.
    let own = &study.plan.arms[0];
    let exports = own.stages.values().filter_map(|key| study.plan.stage(key));
    let Some(export) = exports.into_iter().find(|stage| stage.kind == StageKind::Export) else {
        let message = format!("{} exports no policy", spec.display());
        let advice = "add `[deploy.policy]` with `kind = \"export\"` to the spec, and run it";
        output::complain(global, &message, Some(advice));
        return Err(Exit::Usage);
    };
    let store = study::store(&study, global)?;
    let again = format!("specforge run {shown}{}", arguments(variant));
    let (message, advice) = match store.inspect(export.kind, &export.fingerprint, Depth::Quick) {
        Cached::Yes => return Ok(store.folder(export.kind, &export.fingerprint).join(policy::FILE)),
        Cached::No => (
            format!(
                "{} has no trained policy in {}{}",
                spec.display(),
                store.root().display(),
                under(variant)
            ),
            format!("train it first: `{again}`{}", other_profiles(&study.profiles, variant)),
        ),
        Cached::Damaged(reason) => (
            format!("the policy of {} is damaged: {reason}", spec.display()),
            format!("`{again}` makes it again: {}", label(export)),
        ),
    };
    output::complain(global, &message, Some(&advice));
    Err(Exit::Usage)
}

fn label(stage: &Stage) -> String {
    format!("{} {}", stage.name(), stage.fingerprint.short())
}

fn under(variant: &Variant) -> String {
    variant
        .profile
        .as_ref()
        .map_or_else(|| " without a profile".to_owned(), |name| format!(" under the profile {name}"))
}

/// The options that select the variant, as they are given on the command line.
fn arguments(variant: &Variant) -> String {
    let profile =
        variant.profile.iter().map(|name| format!(" --profile {}", shell::argument(Path::new(name))));
    let sets = variant.sets.iter().map(|set| format!(" --set {}", shell::argument(Path::new(set))));
    profile.chain(sets).collect()
}

fn other_profiles(profiles: &[String], variant: &Variant) -> String {
    if variant.profile.is_some() || profiles.is_empty() {
        return String::new();
    }
    format!(", or name the profile it was trained under: `--profile {}`", profiles.join("` or `--profile "))
}
