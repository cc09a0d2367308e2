//! The robot and motion files of a project. Files that are missing there are taken from the copies embedded
//! in the program, so that it runs from any folder.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::reach::{Place, Reach};
use super::suggest::{listed, nearest};
use super::{Attachment, Embedded};
use crate::diag::{Diagnostic, Sink, Sources, Span};
use crate::syntax::{Files, file};

/// A type of file that specs name.
#[derive(Clone, Copy, Debug)]
pub struct Shelf<'a> {
    /// What it holds: `robot`.
    pub noun: &'static str,
    /// Its folder below the project's: `robots`.
    pub folder: &'static str,
    /// The code for a missing file.
    pub code: &'static str,
    /// The files embedded in the program.
    pub embedded: &'a [Embedded],
}

/// Whether a name is valid for a file in a spec.
fn is_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'))
}

/// A project to search for files.
#[derive(Clone, Copy)]
pub struct Project<'a> {
    /// The file system.
    pub files: &'a dyn Files,
    /// The project's folder.
    pub folder: &'a Path,
    /// What may be read outside the project.
    pub reach: &'a Reach,
}

impl Shelf<'_> {
    /// Finds a file by name; `place` is the place of the name.
    pub fn find(
        &self,
        name: &str,
        place: Span,
        project: &Project,
        sources: &mut Sources,
        sink: &mut Sink,
    ) -> Option<Attachment> {
        let Project { files, folder, reach } = *project;
        let path = self.path(folder, name);
        // A path that exists but is not a file is reported when it is read.
        if is_name(name) && files.sort(&path).is_ok() {
            if let Some(refusal) = reach.refusal(files, &path) {
                sink.emit(refusal.at(place, "named here"));
                return None;
            }
            return match file::read(files, &path) {
                Ok(text) => {
                    if self.replaces(name, &text) {
                        sink.emit(self.replaced(name, &path).at(place, "named here"));
                    }
                    let text: Arc<str> = text.into();
                    let source = match reach.place(files, &path) {
                        Place::Allowed => sources.add_private(&path, text.clone()),
                        _ => sources.add(&path, text.clone()),
                    };
                    Some(Attachment { name: name.to_owned(), source, path: Some(path), text })
                }
                Err(error) => {
                    sink.emit(error.at(place, "named here"));
                    None
                }
            };
        }
        if let Some(embedded) = self.shipped(name) {
            let shown = format!("{}/{name}.toml", self.folder);
            let text: Arc<str> = embedded.text.into();
            let source = sources.add(shown, text.clone());
            return Some(Attachment { name: name.to_owned(), source, path: None, text });
        }
        let known = self.names(files, Some(folder));
        let error = Diagnostic::error(self.code, format!("unknown {} `{name}`", self.noun));
        let error = error.at(place, format!("`{}` is missing", crate::escape::file(&path)));
        let error = match nearest(name, known.iter().map(String::as_str)) {
            Some(near) => error.help(format!("did you mean `{near}`?")).fix(place, format!("\"{near}\"")),
            None => {
                error.help(format!("the {}s are {}", self.noun, listed(known.iter().map(String::as_str))))
            }
        };
        let searched = folder.join(self.folder);
        sink.emit(error.help(format!("searched in `{}` and among the built-in ones", searched.display())));
        None
    }

    /// The path of the file of this name in a project.
    pub fn path(&self, folder: &Path, name: &str) -> PathBuf {
        folder.join(self.folder).join(format!("{name}.toml"))
    }

    /// The embedded file of this name.
    pub fn shipped(&self, name: &str) -> Option<&Embedded> {
        self.embedded.iter().find(|embedded| embedded.name == name)
    }

    /// Whether a project's file of this name and text hides a different embedded one.
    pub fn replaces(&self, name: &str, text: &str) -> bool {
        self.shipped(name).is_some_and(|embedded| embedded.text != text)
    }

    /// W0421: the project's file of this name hides the embedded one.
    pub fn replaced(&self, name: &str, path: &Path) -> Diagnostic {
        let (noun, path) = (self.noun, crate::escape::file(path));
        Diagnostic::warning("W0421", format!("`{path}` replaces the built-in {noun} `{name}`"))
            .help("rename the file, or allow the warning if the replacement is intended")
    }

    /// All names that a spec of the project can use, sorted.
    pub fn names(&self, files: &dyn Files, root: Option<&Path>) -> Vec<String> {
        let folder = root.map(|root| root.join(self.folder));
        let mut written = folder.as_deref().map(|folder| files.names(folder)).unwrap_or_default();
        // A folder or a link to nothing is none of them, whatever it is called.
        written.retain(|name| folder.as_deref().is_some_and(|folder| files.is_file(&folder.join(name))));
        let written = written.iter().filter_map(|name| name.strip_suffix(".toml").map(str::to_owned));
        let written = written.filter(|name| is_name(name));
        let mut names: Vec<String> =
            written.chain(self.embedded.iter().map(|embedded| embedded.name.to_owned())).collect();
        names.sort();
        names.dedup();
        names
    }
}
