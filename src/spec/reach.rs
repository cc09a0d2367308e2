//! Which files a spec may read: those of its project and of folders allowed on the command line. Decided by
//! the resolved path, following symbolic links.

use std::path::{Path, PathBuf};

use super::folder::folder;
use crate::diag::Diagnostic;
use crate::syntax::Files;
use crate::syntax::files::{Sort, plain};

/// The files that a spec may read.
#[derive(Clone, Debug, Default)]
pub struct Reach {
    /// The project's folder, as written and resolved.
    own: Vec<PathBuf>,
    /// The folders of `--allow-outside`, likewise.
    allowed: Vec<PathBuf>,
}

/// The location of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Into the project.
    Project,
    /// Outside the project, in a folder allowed on the command line.
    Allowed,
    /// Anywhere else.
    Outside,
}

impl Reach {
    /// The project of a spec and the folders allowed in addition.
    pub fn of(files: &dyn Files, spec: &Path, allowed: &[PathBuf]) -> Self {
        let folder = folder(files, spec);
        // An empty path is the current folder, and would match every path.
        let named = |folder: &Path| {
            if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder.to_owned() }
        };
        let both = |folder: &Path| [plain(&files.absolute(&named(folder))), led(files, &named(folder))];
        Self { own: both(&folder).into(), allowed: allowed.iter().flat_map(|folder| both(folder)).collect() }
    }

    /// The location of a path.
    pub fn place(&self, files: &dyn Files, path: &Path) -> Place {
        let target = led(files, path);
        let holds = |folders: &[PathBuf]| folders.iter().any(|folder| target.starts_with(folder));
        match (holds(&self.own), holds(&self.allowed)) {
            (true, _) => Place::Project,
            (false, true) => Place::Allowed,
            (false, false) => Place::Outside,
        }
    }

    /// E0110 for a path outside, without a place in a text.
    pub fn refusal(&self, files: &dyn Files, path: &Path) -> Option<Diagnostic> {
        if self.place(files, path) != Place::Outside {
            return None;
        }
        let message = format!("`{}` is outside of the project", crate::escape::file(path));
        let error = Diagnostic::error("E0110", message);
        let target = led(files, path);
        if matches!(files.sort(&target), Ok(Sort::Folder)) {
            return Some(error.help("it is a folder: name a file of the project"));
        }
        let written = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        // The folder to allow is that of the resolved path, which for a link is not the link's own folder.
        let folder = match target.parent() {
            Some(there) if !target.starts_with(led(files, written)) => there,
            _ => written,
        };
        Some(error.help(format!(
            "move the file into the project, or allow its folder on the command line: `--allow-outside {}`",
            folder.display()
        )))
    }
}

/// The resolved path; for a file that does not exist, its folder is resolved.
fn led(files: &dyn Files, path: &Path) -> PathBuf {
    let path = plain(&files.absolute(path));
    let exists = |path: &Path| files.sort(path).is_ok();
    let Some(there) = path.ancestors().find(|path| exists(path)) else { return path };
    let rest = path.strip_prefix(there).unwrap_or(Path::new(""));
    let there = files.identity(there);
    if rest.as_os_str().is_empty() { there } else { there.join(rest) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::Disk;

    #[test]
    fn a_path_is_inside_or_outside_by_where_it_leads() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |path: &str| folder.path().join(path);
        for path in ["project/robots", "project/specs/base", "shared", "other"] {
            std::fs::create_dir_all(at(path)).expect("it can be made");
        }
        for path in ["project/specs/a.toml", "project/specs/base/b.toml", "shared/c.toml", "other/d.toml"] {
            std::fs::write(at(path), "").expect("it can be written");
        }
        std::os::unix::fs::symlink(at("other/d.toml"), at("project/specs/link.toml")).expect("a link");
        std::os::unix::fs::symlink("../../other", at("project/specs/folder")).expect("a link");
        std::os::unix::fs::symlink("base/b.toml", at("project/specs/own.toml")).expect("a link");
        let reach = Reach::of(&Disk, &at("project/specs/a.toml"), &[at("shared")]);
        let help = |path: &str| reach.refusal(&Disk, &at("project/specs").join(path)).map(|error| error.help);
        let followed = |path: &str| {
            let help = help(path).unwrap_or_default().concat();
            let folder =
                help.split("--allow-outside ").nth(1).unwrap_or_default().trim_end_matches('`').to_owned();
            let reach = Reach::of(&Disk, &at("project/specs/a.toml"), &[folder.into()]);
            reach.place(&Disk, &at("project/specs").join(path))
        };
        for path in ["link.toml", "folder/d.toml", "../../other/d.toml"] {
            assert_eq!(followed(path), Place::Allowed, "{path}");
        }
        assert!(help("../../other").is_some_and(|help| help[0].contains("is a folder")));
        let place = |path: &str| reach.place(&Disk, &at("project/specs").join(path));
        for path in ["base/b.toml", "own.toml", "base/../../robots/x.toml", "base/missing.toml"] {
            assert_eq!(place(path), Place::Project, "{path}");
        }
        assert_eq!(place("../../shared/c.toml"), Place::Allowed);
        for path in [
            "link.toml",
            "folder/d.toml",
            "folder/missing.toml",
            "../../other/d.toml",
            "../../missing",
            "/etc/passwd",
        ] {
            assert_eq!(place(path), Place::Outside, "{path}");
        }
        for spec in ["a.toml", "./a.toml", "specs/a.toml"] {
            let here = Reach::of(&Disk, Path::new(spec), &[]);
            assert_eq!(here.place(&Disk, Path::new("specs/base/walk.toml")), Place::Project, "{spec}");
            assert_eq!(here.place(&Disk, Path::new("/etc/passwd")), Place::Outside, "{spec}");
            assert_eq!(here.place(&Disk, Path::new("../x.toml")), Place::Outside, "{spec}");
        }
        let alone = Reach::of(&Disk, &at("other/d.toml"), &[]);
        assert_eq!(alone.place(&Disk, &at("other/e.toml")), Place::Project);
        assert_eq!(alone.place(&Disk, &at("shared/c.toml")), Place::Outside);
    }
}
