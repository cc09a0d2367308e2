//! What a report was asked for: the files and options of its command.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use shlex::Quoter;

use crate::spec::LoadOptions;

/// The files and options of a command. The page prints the command, its record stores this.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// The specs as the user named them.
    pub files: Vec<String>,
    /// Their paths in the project.
    pub specs: Vec<String>,
    /// The profile, if one was chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<String>,
    /// Assignments given with `--set`, as written.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// Folders outside the project that the specs may refer to, given with `--allow-outside`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub allow_outside: Vec<String>,
}

impl Request {
    /// The request for one spec or suite, by its path in the project.
    pub fn for_spec(file: &str, profile: Option<&str>) -> Self {
        let (files, specs) = (vec![file.to_owned()], vec![file.to_owned()]);
        Self { files, specs, profile: profile.map(str::to_owned), ..Self::default() }
    }

    /// Whether there is nothing to run: the record says no file.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// The command of this verb (`run`, `report`, `check`), for a shell.
    pub fn command(&self, verb: &str) -> String {
        let mut words = vec!["specforge", verb];
        words.extend(self.files.iter().map(String::as_str));
        words.extend(self.profile.iter().flat_map(|profile| ["--profile", profile]));
        words.extend(self.set.iter().flat_map(|assignment| ["--set", assignment]));
        words.extend(self.allow_outside.iter().flat_map(|folder| ["--allow-outside", folder]));
        // A record may have been written by anyone, even with a zero byte, which no shell takes.
        Quoter::new().allow_nul(true).join(words).unwrap_or_default()
    }

    /// The paths of the files.
    pub fn paths(&self) -> Vec<PathBuf> {
        self.files.iter().map(PathBuf::from).collect()
    }

    /// The options for loading the files, without the folders outside the project: a record may have been
    /// written by anyone, so it permits nothing.
    pub fn options(&self) -> LoadOptions {
        LoadOptions { profile: self.profile.clone(), sets: self.set.clone(), ..LoadOptions::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_repeats_profile_assignments_and_folders_outside() {
        let whole = Request {
            files: vec!["specs/x.toml".into(), "b c.toml".into()],
            profile: Some("quick".into()),
            set: vec!["learn.seed = 2".into()],
            allow_outside: vec!["../shared parents".into()],
            ..Request::default()
        };
        assert_eq!(
            whole.command("run"),
            "specforge run specs/x.toml 'b c.toml' --profile quick --set 'learn.seed = 2' --allow-outside \
             '../shared parents'"
        );
        assert_eq!(Request::for_spec("x.toml", None).command("report"), "specforge report x.toml");
        assert!(whole.options().allow_outside.is_empty(), "a record permits nothing");
    }

    #[test]
    fn a_zero_byte_in_a_record_is_no_panic() {
        assert!(Request::for_spec("a\0b", None).command("run").starts_with("specforge run "));
    }
}
