//! All works of a run: those of `exec`, and the report's, which depends on them.

use super::Study;
use crate::control::words::law;
use crate::exec::{Works, works};
use crate::plan::StageKind;
use crate::report::{ReportWork, Templates};

/// The works by kind.
pub fn works(study: &Study) -> Works {
    let mut works = works::works();
    let templates = Templates::new(Some(study.project.join("templates")));
    works.insert(StageKind::Report, Box::new(ReportWork::new(templates, law)));
    works
}
