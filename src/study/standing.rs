//! Checks whether a report matches the runs that its own command would make today.

use std::collections::BTreeSet;
use std::path::PathBuf;

use super::{Log, Refusal, Study};
use crate::plan::{Plan, Stage, StageKind};
use crate::report::index::Standing;
use crate::report::sidecar::Sidecar;
use crate::report::wording::command_of;
use crate::spec::LoadOptions;

/// The content of a record's command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recorded {
    /// The specs.
    pub files: Vec<PathBuf>,
    /// Their variant. A record is untrusted: it cannot permit folders outside the project.
    pub options: LoadOptions,
    /// The folders outside the project that its run was permitted to read.
    pub outside: Vec<String>,
}

impl Recorded {
    /// A command with the same specs and options.
    pub fn command(&self, verb: &str) -> String {
        let files: Vec<String> = self.files.iter().map(|file| file.display().to_string()).collect();
        let files: Vec<&str> = files.iter().map(String::as_str).collect();
        command_of(verb, &files, self.options.profile.as_deref(), &self.options.sets, &self.outside)
    }
}

/// Plans a report's command and compares the stages. `None`: the record has no command of this program.
pub fn of(report: &Sidecar, log: &mut Log) -> Result<Option<Standing>, Refusal> {
    let Some(Recorded { files, options, .. }) = recorded(report) else { return Ok(None) };
    if files.iter().any(|file| !file.is_file()) {
        return Ok(Some(Standing::WithoutSpecs));
    }
    let study = Study::read(&files, &options, log)?;
    Ok(Some(compared(report, &study.plan)))
}

/// The specs and variant in a record's command (`report::wording::command_of`); `None` unless it is a `run`
/// of this program with only these options.
pub fn recorded(report: &Sidecar) -> Option<Recorded> {
    let mut words = shlex::split(&report.command)?.into_iter();
    if words.next()? != "specforge" || words.next()? != "run" {
        return None;
    }
    let mut recorded = Recorded { files: Vec::new(), options: LoadOptions::default(), outside: Vec::new() };
    while let Some(word) = words.next() {
        match word.as_str() {
            "--profile" => recorded.options.profile = Some(words.next()?),
            "--set" => recorded.options.sets.push(words.next()?),
            "--allow-outside" => recorded.outside.push(words.next()?),
            option if option.starts_with('-') => return None,
            file => recorded.files.push(PathBuf::from(file)),
        }
    }
    (!recorded.files.is_empty()).then_some(recorded)
}

/// Compares the report's stages with those of a plan. The report stage is excluded, as it depends on the
/// program that renders.
pub(super) fn compared(report: &Sidecar, plan: &Plan) -> Standing {
    let made: BTreeSet<&str> =
        report.arms.iter().flat_map(|arm| &arm.stages).map(|stage| stage.fingerprint.as_str()).collect();
    let today: Vec<_> = plan.stages().filter(|stage| stage.kind != StageKind::Report).collect();
    let lacks = |stage: &&&Stage| !made.contains(stage.fingerprint.to_string().as_str());
    let lacking: Vec<_> = today.iter().filter(lacks).collect();
    let mut kinds: Vec<String> = Vec::new();
    for stage in &lacking {
        let kind = stage.kind.facts().name;
        if !kinds.iter().any(|known| known == kind) {
            kinds.push(kind.to_owned());
        }
    }
    let (stages, lacking) = (today.len(), lacking.len());
    match (lacking, made.len() + lacking - stages) {
        (0, 0) => Standing::Current,
        (lacking, gone) => Standing::Earlier { kinds, lacking, stages, gone },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(command: &str) -> Option<Recorded> {
        recorded(&Sidecar { command: command.to_owned(), ..Sidecar::default() })
    }

    #[test]
    fn the_command_that_a_record_has_is_read_again() {
        let sets = ["a.b=\"5 %\"".to_owned(), "c = 2".to_owned()];
        let command = command_of(
            "run",
            &["specs/a.toml", "b c.toml"],
            Some("quick"),
            &sets,
            &["/elsewhere".to_owned()],
        );
        let whole = read(&command).expect("a command of this program");
        assert_eq!(whole.command("run"), command);
        let Recorded { files, options, .. } = whole;
        assert_eq!(files, [PathBuf::from("specs/a.toml"), PathBuf::from("b c.toml")]);
        assert_eq!((options.profile.as_deref(), &options.sets[..]), (Some("quick"), &sets[..]));
        assert!(options.allow_outside.is_empty(), "a record permits nothing");
        for other in ["", "rm -rf x", "specforge check a.toml", "specforge run", "specforge run a --jobs 2"] {
            assert_eq!(read(other), None, "{other}");
        }
    }
}
