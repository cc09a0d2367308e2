//! Finds templates: those in the user's `templates` folder take precedence over the embedded ones.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::bounded::{self, ReadError};
use crate::diag::Diagnostic;
use crate::safe_fs;

/// The embedded templates.
static EMBEDDED: [(&str, &str); 2] = [
    ("report.md.j2", include_str!("../../templates/report.md.j2")),
    ("table.md.j2", include_str!("../../templates/table.md.j2")),
];

/// The available templates.
#[derive(Clone, Debug, Default)]
pub struct Templates {
    folder: Option<PathBuf>,
}

/// A template's text and where it was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Template {
    /// The path as a user would write it.
    pub path: PathBuf,
    /// The text.
    pub text: String,
}

impl Templates {
    /// The templates of this folder, if any, take precedence over the embedded ones.
    pub fn new(folder: Option<PathBuf>) -> Self {
        Self { folder }
    }

    /// The template with this name; `None` if missing. E0906 for an unreadable user-defined one: falling back
    /// to the embedded one would be wrong.
    pub fn get(&self, name: &str) -> Result<Option<Template>, Box<Diagnostic>> {
        if let Some(folder) = self.folder.as_ref().filter(|_| safe_fs::is_plain(name)) {
            let path = folder.join(name);
            if leads_out(folder, &path) {
                return Ok(None);
            }
            match bounded::text(&path, bounded::WRITTEN) {
                Ok(text) => return Ok(Some(Template { path, text })),
                Err(error) if is_absence(&error) => {}
                Err(error) => {
                    let message =
                        format!("cannot read the template `{}`: {error}", crate::escape::file(&path));
                    let help = "make it a text in UTF-8 that may be read, at most 1 MiB large, or remove it";
                    return Err(Box::new(Diagnostic::error("E0906", message).help(help)));
                }
            }
        }
        let shipped = EMBEDDED.iter().find(|(known, _)| *known == name);
        Ok(shipped
            .map(|(_, text)| Template { path: Path::new("templates").join(name), text: text.to_string() }))
    }

    /// Whether a report with this template reads only embedded texts.
    pub fn is_embedded(&self, name: &str) -> bool {
        let same = |(name, text): &(&str, &str)| {
            self.get(name).is_ok_and(|found| found.is_some_and(|found| found.text == *text))
        };
        EMBEDDED.iter().any(|(known, _)| *known == name) && EMBEDDED.iter().all(same)
    }

    /// The names of all templates, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries =
            self.folder.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten().flatten();
        let own = entries
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .filter(|name| name.ends_with(".j2"));
        let mut names: Vec<String> = own.chain(EMBEDDED.iter().map(|(name, _)| name.to_string())).collect();
        names.sort();
        names.dedup();
        names
    }

    /// A digest of everything that a report with this template can read. It is part of the stage's
    /// fingerprint, so that changing a template only renders reports again.
    pub fn digest(&self, name: &str) -> String {
        let mut hasher = blake3::Hasher::new();
        for name in self.names().iter().map(String::as_str).chain([name]) {
            // Unreadable templates are reported before anything is run.
            let text = self.get(name).ok().flatten().map(|template| template.text).unwrap_or_default();
            for part in [name, &text] {
                hasher.update(&(part.len() as u64).to_le_bytes());
                hasher.update(part.as_bytes());
            }
        }
        hasher.finalize().to_hex().to_string()
    }

    /// The diagnostic for an unknown name.
    pub fn not_found(&self, name: &str) -> Diagnostic {
        if self.folder.as_ref().is_some_and(|folder| leads_out(folder, &folder.join(name))) {
            let error =
                Diagnostic::error("E0110", format!("the template `{name}` is outside of the project"));
            let is_plain = safe_fs::is_plain(name);
            return error.help(match is_plain {
                true => "a link leads out of `templates/`: copy the file in its place",
                false => "copy the file into `templates/` and name it by its path there",
            });
        }
        let names = self.names();
        let nearest = names.iter().max_by(|a, b| strsim::jaro(a, name).total_cmp(&strsim::jaro(b, name)));
        let advice = match nearest.filter(|near| strsim::jaro(near, name) > 0.8) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("there are {}", names.join(", ")),
        };
        Diagnostic::error("E0901", format!("there is no template `{name}`")).help(advice)
    }
}

/// Whether the file is missing, also because `templates` is not a folder.
fn is_absence(error: &ReadError) -> bool {
    error.is_absence() || matches!(error, ReadError::Io(error) if error.kind() == ErrorKind::NotADirectory)
}

/// Whether a template is a file outside the parent folder of `templates`.
fn leads_out(folder: &Path, path: &Path) -> bool {
    let project = folder.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (project.canonicalize(), path.canonicalize()) {
        (Ok(project), Ok(path)) => !path.starts_with(project),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_template_of_the_user_goes_before_the_one_that_comes_along() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let plain = Templates::default();
        let own = Templates::new(Some(folder.path().to_path_buf()));
        assert_eq!(own.get("report.md.j2"), plain.get("report.md.j2"));
        assert_eq!(own.digest("report.md.j2"), plain.digest("report.md.j2"));
        assert!(own.is_embedded("report.md.j2") && !own.is_embedded("other.md.j2"));
        std::fs::write(folder.path().join("report.md.j2"), "{{ name }}").expect("the folder can be written");
        assert_eq!(own.get("report.md.j2").expect("readable").expect("there is one").text, "{{ name }}");
        assert_ne!(own.digest("report.md.j2"), plain.digest("report.md.j2"));
        assert!(!own.is_embedded("report.md.j2"));
        assert!(!own.is_embedded("table.md.j2"), "it may read the other one");
    }

    #[test]
    fn a_name_cannot_leave_the_folder() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::create_dir(folder.path().join("templates")).expect("the folder can be written");
        std::fs::write(folder.path().join("secret.j2"), "x").expect("the folder can be written");
        assert_eq!(Templates::new(Some(folder.path().join("templates"))).get("../secret.j2"), Ok(None));
    }

    #[test]
    fn a_link_that_leads_out_of_the_project_is_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let templates = folder.path().join("project/templates");
        std::fs::create_dir_all(&templates).expect("the folder can be written");
        std::fs::write(folder.path().join("secret"), "SECRET").expect("the folder can be written");
        std::fs::write(folder.path().join("project/shared.j2"), "{{ name }}")
            .expect("the folder can be written");
        for (name, target) in [("report.md.j2", "../../secret"), ("own.md.j2", "../shared.j2")] {
            std::os::unix::fs::symlink(target, templates.join(name)).expect("a link");
        }
        let templates = Templates::new(Some(templates));
        assert_eq!(templates.get("report.md.j2"), Ok(None));
        assert_eq!(templates.not_found("report.md.j2").code, "E0110");
        assert!(matches!(templates.get("own.md.j2"), Ok(Some(_))));
    }

    #[test]
    fn a_near_name_is_suggested() {
        let diagnostic = Templates::default().not_found("reports.md.j2");
        assert_eq!(diagnostic.code, "E0901");
        assert_eq!(diagnostic.help, ["did you mean `report.md.j2`?"]);
    }
}
