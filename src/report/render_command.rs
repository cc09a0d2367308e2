//! The command that renders a published page again, for advice.

use std::path::{Path, PathBuf};

use shlex::Quoter;

use super::paths::page_folder;
use super::sidecar::Sidecar;

/// The advice for a page whose record is missing or was edited, so that its command is unknown.
pub const UNKNOWN: &str = "`specforge report SPEC` with the `--profile` and `--set` of its run";

/// `specforge report FILES` with the options of the page's run. The page is in the folder `below`, which is
/// named if the command would not write there. `None` if the record names no files.
pub fn render_command(record: &Sidecar, below: &Path) -> Option<String> {
    let request = &record.request;
    let place = request.specs.first()?;
    let command = request.command("report");
    if real(below) == real(&Path::new("reports").join(page_folder(place))) {
        return Some(command);
    }
    let below = below.display().to_string();
    let folder = Quoter::new().allow_nul(true).quote(&below).ok()?;
    Some(format!("{command} --reports {folder}"))
}

fn real(folder: &Path) -> PathBuf {
    folder.canonicalize().unwrap_or_else(|_| folder.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::request::Request;

    #[test]
    fn the_command_has_the_options_of_the_run_and_the_folder_of_the_page() {
        let request = Request {
            set: vec!["x.y=\"5 %\"".to_owned()],
            ..Request::for_spec("specs/a/b.toml", Some("desk"))
        };
        let record = |request| Sidecar { request, ..Sidecar::default() };
        let report = "specforge report specs/a/b.toml --profile desk --set 'x.y=\"5 %\"'";
        let own = record(request);
        assert_eq!(render_command(&own, Path::new("reports/a")).as_deref(), Some(report));
        let elsewhere = format!("{report} --reports 'my pages'");
        assert_eq!(render_command(&own, Path::new("my pages")), Some(elsewhere));
        assert_eq!(render_command(&record(Request::default()), Path::new("reports")), None);
    }
}
