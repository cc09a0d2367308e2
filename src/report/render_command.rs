//! The command that renders a published page again, for advice.

use std::path::{Path, PathBuf};

use super::paths::page_folder;
use super::sidecar::Sidecar;

/// The advice for a page whose record is missing or was edited, so that its command is unknown.
pub const UNKNOWN: &str = "`specforge report SPEC` with the `--profile` and `--set` of its run";

/// `specforge report FILES` with the options of the page's run. The page is in the folder `below`, which is
/// named if the command would not write there. `None` if the record has no command of this program.
pub fn render_command(record: &Sidecar, below: &Path) -> Option<String> {
    let mut words = shlex::split(&record.command)?;
    match words.as_mut_slice() {
        [program, verb, _, ..] if program == "specforge" && verb == "run" => *verb = "report".to_owned(),
        _ => return None,
    }
    // Records of earlier versions have the spec's place only in the command.
    let place = record.specs.first().unwrap_or(&words[2]);
    if real(below) != real(&Path::new("reports").join(page_folder(place))) {
        words.extend(["--reports".to_owned(), below.display().to_string()]);
    }
    shlex::try_join(words.iter().map(String::as_str)).ok()
}

fn real(folder: &Path) -> PathBuf {
    folder.canonicalize().unwrap_or_else(|_| folder.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_has_the_options_of_the_run_and_the_folder_of_the_page() {
        let record = |command: &str, specs: &[&str]| Sidecar {
            command: command.to_owned(),
            specs: specs.iter().map(|spec| (*spec).to_owned()).collect(),
            ..Sidecar::default()
        };
        let run = "specforge run specs/a/b.toml --profile desk --set 'x.y=\"5 %\"'";
        let own = record(run, &["specs/a/b.toml"]);
        let report = "specforge report specs/a/b.toml --profile desk --set 'x.y=\"5 %\"'";
        assert_eq!(render_command(&own, Path::new("reports/a")).as_deref(), Some(report));
        assert_eq!(render_command(&record(run, &[]), Path::new("reports/a")).as_deref(), Some(report));
        let elsewhere = format!("{report} --reports 'my pages'");
        assert_eq!(render_command(&own, Path::new("my pages")), Some(elsewhere));
        for other in ["", "specforge run", "specforge check a.toml", "rm -rf x; specforge run a", "a 'b"] {
            assert_eq!(render_command(&record(other, &[]), Path::new("reports")), None, "{other}");
        }
    }
}
