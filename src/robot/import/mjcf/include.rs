//! `<include>`: is replaced by the elements of another file.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::super::folder::Place;
use super::super::intake::Intake;
use super::super::xml::Element;
use crate::diag::Diagnostic;

/// A description with everything it includes. MuJoCo allows each file only once, which rules out cycles.
/// `None` if a file cannot be included: what it has is missing, and everything else that is found would only
/// follow from that.
pub(super) fn expanded(root: Element, from: &Path, intake: &mut Intake) -> Option<Element> {
    let mut inclusion = Inclusion { from, seen: BTreeSet::new(), is_whole: true };
    let expanded = inclusion.expand(root, intake);
    inclusion.is_whole.then_some(expanded)
}

struct Inclusion<'a> {
    /// The folder of the top-level file, to which all names are relative.
    from: &'a Path,
    seen: BTreeSet<PathBuf>,
    /// Whether every file was included.
    is_whole: bool,
}

impl Inclusion<'_> {
    fn expand(&mut self, mut element: Element, intake: &mut Intake) -> Element {
        let mut children = Vec::with_capacity(element.children.len());
        for child in std::mem::take(&mut element.children) {
            if child.name == "include" {
                match self.included(&child, intake) {
                    Some(included) => children.extend(included),
                    None => self.is_whole = false,
                }
            } else {
                children.push(self.expand(child, intake));
            }
        }
        element.children = children;
        element
    }

    fn included(&mut self, include: &Element, intake: &mut Intake) -> Option<Vec<Element>> {
        let named = intake.name(include, "file")?;
        let span = include.place("file");
        let path = match intake.find(self.from, &named, span) {
            Place::Inside(path) => path,
            Place::Outside => return None,
            Place::Missing => {
                intake.tell(
                    Diagnostic::error("E0414", format!("the included file `{named}` is not there"))
                        .at(span, "")
                        .help("put it beside the robot's file"),
                );
                return None;
            }
        };
        if !self.seen.insert(path.clone()) {
            intake.tell(
                Diagnostic::error("E0414", format!("`{named}` is included twice"))
                    .at(span, "")
                    .help("include each file once; a file cannot include itself"),
            );
            return None;
        }
        let source = intake.text(&path, Path::new(&named), Some(span))?;
        let root = intake.parse(source)?;
        Some(self.expand(root, intake).children)
    }
}
