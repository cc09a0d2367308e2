//! The folder that an import may read, and the files that a description refers to.

use std::io::{self, ErrorKind};
use std::path::{Component, Path, PathBuf};

/// A folder; nothing outside it is opened.
#[derive(Clone, Debug)]
pub struct Folder {
    /// Its path with links resolved.
    root: PathBuf,
}

/// The location of a file name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// This path inside the folder.
    Inside(PathBuf),
    /// Outside the folder, directly or through a link.
    Outside,
    /// Does not exist.
    Missing,
}

impl Folder {
    /// Fails unless the path is an existing folder.
    pub fn new(root: &Path) -> io::Result<Self> {
        let root = root.canonicalize()?;
        if root.is_dir() { Ok(Self { root }) } else { Err(ErrorKind::NotADirectory.into()) }
    }

    /// The folder of a file: its ROS package (the nearest folder with a `package.xml`), or else the folder
    /// that contains it.
    pub fn around(file: &Path) -> io::Result<Self> {
        let parent = file.parent().filter(|parent| !parent.as_os_str().is_empty());
        let parent = Self::new(parent.unwrap_or(Path::new(".")))?;
        let package = parent.root.ancestors().find(|folder| folder.join("package.xml").is_file());
        Ok(package.map_or_else(|| parent.clone(), |package| Self { root: package.to_owned() }))
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.root
    }

    /// The file that a description in the folder `from` refers to. `package://NAME/REST` is `NAME/REST` or
    /// `REST` below this folder.
    pub fn find(&self, from: &Path, named: &str) -> Place {
        let package = named.strip_prefix("package://").or_else(|| named.strip_prefix("model://"));
        match package {
            Some(path) => {
                let path = path.trim_start_matches('/');
                let rest = path.split_once('/').map_or("", |(_, rest)| rest);
                let whole = self.place(&self.root.join(path));
                if whole == Place::Missing { self.place(&self.root.join(rest)) } else { whole }
            }
            None => self.place(&from.join(named.strip_prefix("file://").unwrap_or(named))),
        }
    }

    fn place(&self, path: &Path) -> Place {
        match path.canonicalize() {
            Ok(path) if path.starts_with(&self.root) => Place::Inside(path),
            Ok(_) => Place::Outside,
            Err(_) if plain(path).starts_with(&self.root) => Place::Missing,
            Err(_) => Place::Outside,
        }
    }
}

/// Removes `.` and `..` from a path without following links.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                plain.pop();
            }
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_into_the_folder_or_are_refused() {
        let outer = tempfile::tempdir().unwrap();
        let inner = outer.path().join("robot");
        std::fs::create_dir_all(inner.join("meshes")).unwrap();
        std::fs::write(inner.join("meshes/a.stl"), "").unwrap();
        std::fs::write(outer.path().join("secret"), "").unwrap();
        std::os::unix::fs::symlink("../secret", inner.join("link")).unwrap();
        let folder = Folder::new(&inner).unwrap();
        let inside = Place::Inside(folder.path().join("meshes/a.stl"));
        for name in [
            "meshes/a.stl",
            "./meshes/../meshes/a.stl",
            "package://walker/meshes/a.stl",
            "package:///walker/meshes/a.stl",
            "file://meshes/a.stl",
        ] {
            assert_eq!(folder.find(folder.path(), name), inside, "{name}");
        }
        for name in [
            "../secret",
            "link",
            "/etc/passwd",
            "../../../../etc/passwd",
            "../nothing",
            "package://../secret",
        ] {
            assert_eq!(folder.find(folder.path(), name), Place::Outside, "{name}");
        }
        assert_eq!(folder.find(folder.path(), "meshes/b.stl"), Place::Missing);
    }

    #[test]
    fn the_folder_of_a_file_is_its_package() {
        let package = tempfile::tempdir().unwrap();
        let [urdf, meshes] = ["urdf", "meshes"].map(|name| package.path().join(name));
        std::fs::create_dir_all(&urdf).unwrap();
        std::fs::create_dir_all(&meshes).unwrap();
        std::fs::write(meshes.join("a.stl"), "").unwrap();
        let file = urdf.join("walker.urdf");
        let alone = Folder::around(&file).unwrap();
        assert_eq!(alone.find(alone.path(), "package://walker/meshes/a.stl"), Place::Missing);
        std::fs::write(package.path().join("package.xml"), "<package/>").unwrap();
        let folder = Folder::around(&file).unwrap();
        let mesh = Place::Inside(folder.path().join("meshes/a.stl"));
        assert_eq!(folder.find(&urdf, "package://walker/meshes/a.stl"), mesh);
        assert_eq!(folder.find(&urdf.canonicalize().unwrap(), "../meshes/a.stl"), mesh);
    }
}
