//! Paths as printed in a report: relative to the project, else to the current folder, else the bare file
//! name. A page may be published, so it must not reveal the folders of the machine that rendered it.

use std::path::{Component, Path, PathBuf};

use crate::spec::folder;
use crate::syntax::files::{Disk, Files, plain};

/// The base folders of printed paths.
#[derive(Clone, Debug, Default)]
pub struct Paths {
    /// Without `.` and `..`; the first that contains a path counts.
    folders: Vec<PathBuf>,
    home: Option<PathBuf>,
}

impl Paths {
    /// For a spec and its related files.
    pub fn of(spec: &Path) -> Self {
        let project = folder::root(&Disk, spec).map(|folder| plain(&Disk.absolute(&folder)));
        let folders = project.into_iter().chain(std::env::current_dir().ok()).collect();
        Self { folders, home: std::env::home_dir().filter(|home| home.components().count() > 1) }
    }

    /// Prints a path. One that leads down from the current folder is left unchanged.
    pub fn shown(&self, path: &str) -> String {
        let given = Path::new(path);
        if given.is_relative() && !given.starts_with("..") {
            return path.to_owned();
        }
        let whole = plain(&Disk.absolute(given));
        let inside = self.folders.iter().find_map(|folder| whole.strip_prefix(folder).ok());
        let name = || whole.file_name().map(Path::new).unwrap_or(Path::new(""));
        inside.unwrap_or_else(name).display().to_string()
    }

    /// Prints the origin of a value: `profile desk, FILE:12`.
    pub fn origin(&self, origin: &str) -> String {
        let (layer, place) = origin
            .rsplit_once(", ")
            .map_or(("", origin), |(_, place)| (&origin[..origin.len() - place.len()], place));
        match place.rsplit_once(':') {
            Some((file, line))
                if line.bytes().all(|byte| byte.is_ascii_digit()) && !place.starts_with("--set ") =>
            {
                format!("{layer}{}:{line}", self.shown(file))
            }
            _ => origin.to_owned(),
        }
    }

    /// Prints a message that contains paths.
    pub fn message(&self, message: &str) -> String {
        let within = |text: String, folder: &PathBuf| text.replace(&format!("{}/", folder.display()), "");
        let text = self
            .folders
            .iter()
            .filter(|folder| folder.components().count() > 1)
            .fold(message.to_owned(), within);
        match &self.home {
            Some(home) => text.replace(&home.display().to_string(), "~"),
            None => text,
        }
    }
}

/// The subfolder of a spec's page in the folder of reports, which mirrors `specs/`: `paper` for
/// `specs/paper/walk.toml` in the project. Empty for specs at the top of `specs/` or elsewhere.
pub fn page_folder(place: &str) -> PathBuf {
    let inside = Path::new(place).parent().and_then(|folder| folder.strip_prefix("specs").ok());
    let is_plain = |folder: &&Path| folder.components().all(|part| matches!(part, Component::Normal(_)));
    inside.filter(is_plain).map(Path::to_owned).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_lies_below_the_reports_as_its_spec_does_below_the_specs() {
        let expected = [
            ("specs/paper/walk.toml", "paper"),
            ("specs/a/b/walk.toml", "a/b"),
            ("specs/walk.toml", ""),
            ("walk.toml", ""),
            ("mine/paper/walk.toml", ""),
            ("specs/../../walk.toml", ""),
            ("/specs/paper/walk.toml", ""),
            ("", ""),
        ];
        for (place, folder) in expected {
            assert_eq!(page_folder(place), Path::new(folder), "{place}");
        }
    }

    #[test]
    fn a_path_begins_at_the_project_or_is_a_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let project = folder.path().join("home/me/project");
        std::fs::create_dir_all(project.join("robots")).expect("it can be made");
        let spec = project.join("specs/a.toml");
        let paths = Paths { home: Some(folder.path().join("home/me")), ..Paths::of(&spec) };
        let at = |path: &str| project.join(path).display().to_string();
        assert_eq!(paths.shown(&at("specs/a.toml")), "specs/a.toml");
        assert_eq!(paths.shown(&at("specs/../base/b.toml")), "base/b.toml");
        assert_eq!(paths.shown(&at("../other/c.toml")), "c.toml");
        assert_eq!(paths.shown("specs/a.toml"), "specs/a.toml");
        let here = std::env::current_dir().expect("a folder");
        assert_eq!(paths.shown(&here.join("x/y.toml").display().to_string()), "x/y.toml");
        assert_eq!(paths.origin(&format!("{}:12", at("specs/a.toml"))), "specs/a.toml:12");
        assert_eq!(paths.origin(&format!("profile desk, {}:3", at("b.toml"))), "profile desk, b.toml:3");
        assert_eq!(paths.origin("--set learn.seed=2"), "--set learn.seed=2");
        assert_eq!(paths.origin("default"), "default");
        let message = format!("{} and {} are full", at(".specforge/x"), at("../y"));
        assert_eq!(paths.message(&message), ".specforge/x and ../y are full");
    }
}
