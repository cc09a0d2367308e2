//! `specforge evaluate SPEC`: the policy that the spec's run exported, found in the store.

use std::path::{Path, PathBuf};

use crate::cli::specs::Variant;
use crate::cli::study::{self, Source};
use crate::cli::{Exit, Global, output};
use crate::deploy::policy;
use crate::escape::shell;
use crate::exec::Store;
use crate::exec::manifest::Depth;
use crate::plan::{Cached, Stage, StageKind};
use crate::spec::LoadOptions;
use crate::study::{Log, Study};

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
    let Some(export) = export(&study) else {
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
            match trained(spec, &study.profiles, variant, &store).as_slice() {
                [] => format!("train it first: `{again}`"),
                profiles => format!(
                    "train it: `{again}`, or name the profile that it was trained under: {}",
                    profiles.join(" or ")
                ),
            },
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

/// The stage that exports the policy of a spec. The first arm is the spec itself; the others are those that it
/// is compared with.
fn export(study: &Study) -> Option<&Stage> {
    let own = &study.plan.arms[0];
    own.stages.values().filter_map(|key| study.plan.stage(key)).find(|stage| stage.kind == StageKind::Export)
}

/// The options `--profile NAME` of the profiles under which the store has a policy of the spec.
fn trained(spec: &Path, profiles: &[String], variant: &Variant, store: &Store) -> Vec<String> {
    let is_stored = |profile: &&String| {
        let options = LoadOptions { profile: Some(profile.to_string()), ..variant.options() };
        let study = Study::read(&[spec.to_owned()], &options, &mut Log::default());
        study.is_ok_and(|study| {
            let found = export(&study).map(|own| store.inspect(own.kind, &own.fingerprint, Depth::Quick));
            matches!(found, Some(Cached::Yes))
        })
    };
    let others = profiles.iter().filter(|name| variant.profile.as_ref() != Some(*name));
    others.filter(is_stored).map(|name| format!("`--profile {}`", shell::argument(Path::new(name)))).collect()
}
