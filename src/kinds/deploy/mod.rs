//! Deployments of a trained policy. `deploy/` implements them.

pub mod export;
pub mod transfer;

pub use export::Export;
pub use transfer::Transfer;

use crate::kinds::evaluate::{self, Episodes, Evaluation};
use crate::spec::typed::prelude::*;
use crate::spec::{Section, Table};

section! {
    /// Use of a trained policy.
    pub enum Deployment in "deploy", "deployment" { export: Export, transfer: Transfer }
}

/// Number of episodes of an evaluation or a transfer (`evaluate.NAME`, `deploy.NAME`) in a decoded spec;
/// `None` if the spec lacks the stage, or if it is a training. A transfer without this key uses that of
/// `evaluate.nominal`.
pub fn episodes(fields: &Table, stage: &str) -> Option<usize> {
    let spec = Section::new(fields);
    let table = |section: &str, name: &str| spec.section(section)?.section(name);
    let (section, name) = stage.split_once('.')?;
    let own = table(section, name)?;
    let says = |table: &Section| table.holds(Episodes::episodes);
    let nominal = table(Evaluation::SECTION, evaluate::NOMINAL)
        .filter(|_| section == Deployment::SECTION && !says(&own));
    Some(evaluate::episodes(nominal.filter(says).unwrap_or(own)))
}
