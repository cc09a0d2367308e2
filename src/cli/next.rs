//! What a run leaves to use: the exported policies, and a command that tries one.

use std::path::Path;

use super::{Format, Global, output};
use crate::deploy::policy;
use crate::escape::terminal;
use crate::exec::Store;
use crate::exec::manifest::Depth;
use crate::plan::{ArmRecord, Cached, Plan, StageKind};
use crate::report::sidecar::Sidecar;
use crate::safe_fs;

/// Runs with more arms than this, as suites have, are not listed.
const FEW: usize = 4;

/// Prints the path of each arm's policy, beside the page that was written or else in the store, and a command
/// that evaluates the first one.
pub fn tell(plan: &Plan, store: &Store, published: Option<(&Path, &Sidecar)>, global: &Global) {
    if global.format == Format::Json || plan.suite.is_some() || plan.arms.len() > FEW {
        return;
    }
    for (name, path) in policies(plan, store) {
        let path = published.and_then(|(page, record)| copy(page, record, &name)).unwrap_or(path);
        output::note(global, &terminal::line(&format!("policy of {name}: {path}")));
    }
    if let Some(command) = command(plan, store, global) {
        output::note(global, &terminal::line(&format!("try it on a slope: `{command}`")));
    }
}

/// The copy of an arm's policy beside the page.
fn copy(page: &Path, record: &Sidecar, arm: &str) -> Option<String> {
    let is_of_arm = |source: &crate::report::source::Source| source.arm == arm;
    let mut policies = record.items.iter().filter(|item| item.kind == "policy");
    let item = policies.find(|item| item.sources.iter().any(is_of_arm))?;
    Some(safe_fs::folder_of(page).join(&item.file).display().to_string())
}

/// The arms with their policies in the store.
fn policies(plan: &Plan, store: &Store) -> Vec<(String, String)> {
    let of_arm = |arm: &ArmRecord| {
        let export = arm
            .stages
            .values()
            .filter_map(|key| plan.stage(key))
            .find(|stage| stage.kind == StageKind::Export)?;
        let is_there = store.inspect(export.kind, &export.fingerprint, Depth::Quick) == Cached::Yes;
        let path = store.folder(export.kind, &export.fingerprint).join(policy::FILE);
        is_there.then(|| (arm.name.clone(), path.display().to_string()))
    };
    plan.arms.iter().filter_map(of_arm).collect()
}

/// `specforge evaluate specs/walk.toml --profile quick --terrain slope,angle=3deg`, if the first arm has a policy.
fn command(plan: &Plan, store: &Store, global: &Global) -> Option<String> {
    let first = plan.arms.first()?;
    policies(plan, store).iter().find(|(name, _)| *name == first.name)?;
    let request = &first.request;
    let mut words = vec!["specforge".to_owned()];
    words.extend(global.store.iter().flat_map(|root| ["--store".to_owned(), root.display().to_string()]));
    words.extend(["evaluate".to_owned(), request.spec.clone()]);
    words.extend(request.profile.iter().flat_map(|name| ["--profile".to_owned(), name.clone()]));
    words.extend(request.assignments.iter().flat_map(|set| ["--set".to_owned(), set.clone()]));
    words.extend(request.outside.iter().flat_map(|dir| ["--allow-outside".to_owned(), dir.clone()]));
    words.extend(["--terrain", "slope,angle=3deg"].map(String::from));
    shlex::try_join(words.iter().map(String::as_str)).ok()
}
