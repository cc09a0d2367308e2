//! State for reading a description: its folder, texts and diagnostics, and typed access to values.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use super::block::Block;
use super::folder::{Folder, Place};
use super::mesh::{self, MeshError};
use super::number::{Fault, number};
use super::tree::MeshBox;
use super::xml::{self, Element};
use crate::bounded::{self, ReadError};
use crate::diag::{Diagnostic, Sink, SourceId, Sources, Span};
use crate::spec::suggest::listed;

/// Maximum number of mistakes of one kind that are reported; the rest is counted.
const TOLD: usize = 20;
/// Maximum number of remarks.
const MOST_NOTES: usize = 1000;
/// Maximum length of a name.
const LONGEST_NAME: usize = 200;
/// Maximum size of all meshes together in bytes.
const MOST_MESH_BYTES: u64 = 256 << 20;

/// Why meshes are left out, and how to fix it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Reason {
    of_one: &'static str,
    of_many: &'static str,
    cure: &'static str,
}

const MISSING: Reason = Reason {
    of_one: "is not there",
    of_many: "are not there",
    cure: "name the folder to read from with --root, or give boxes or capsules",
};

const FORMAT: Reason = Reason {
    of_one: "is neither STL, OBJ nor COLLADA",
    of_many: "are neither STL, OBJ nor COLLADA",
    cure: "convert to one of them, or give boxes or capsules",
};

/// The state of an import.
pub(super) struct Intake<'a> {
    /// The folder that may be read.
    pub folder: &'a Folder,
    /// The texts.
    pub sources: &'a mut Sources,
    /// The diagnostics.
    pub sink: &'a mut Sink,
    /// The key frame for the default pose; if absent, the first one.
    pub key: Option<String>,
    /// Remarks on what could not be imported unchanged.
    pub notes: Vec<String>,
    /// Number of elements still allowed.
    pub room: usize,
    /// Whether a file outside the folder was reported.
    outside: bool,
    /// Bytes of the meshes read so far.
    mesh_bytes: u64,
    /// Their boxes.
    meshes: BTreeMap<PathBuf, Result<Block, MeshError>>,
    /// The boxes that replace meshes.
    pub boxes: Vec<MeshBox>,
    /// Bodies and their meshes that were left out.
    left_out: BTreeMap<Reason, Vec<[String; 2]>>,
    /// Words that are not numbers, by fault, element and attribute.
    habits: BTreeMap<(Fault, String, String), Habit>,
}

/// A mistake repeated in many places.
#[derive(Debug)]
struct Habit {
    /// Index of the diagnostic for the first place.
    told: usize,
    places: BTreeSet<Span>,
}

impl<'a> Intake<'a> {
    /// Nothing read yet.
    pub fn new(folder: &'a Folder, sources: &'a mut Sources, sink: &'a mut Sink) -> Self {
        Self {
            folder,
            sources,
            sink,
            key: None,
            notes: Vec::new(),
            room: xml::MOST_ELEMENTS,
            outside: false,
            mesh_bytes: 0,
            meshes: BTreeMap::new(),
            boxes: Vec::new(),
            left_out: BTreeMap::new(),
            habits: BTreeMap::new(),
        }
    }

    /// Reports a mistake; of very many only the first.
    pub fn tell(&mut self, diagnostic: Diagnostic) {
        if !self.has_told_enough(diagnostic.code) {
            self.sink.emit(diagnostic);
        }
    }

    /// Whether further mistakes of a code are dropped.
    pub fn has_told_enough(&self, code: &str) -> bool {
        self.sink.diagnostics.iter().filter(|told| told.code == code).count() >= TOLD
    }

    /// Adds a remark for the header of the robot file.
    pub fn note(&mut self, sentence: String) {
        if self.notes.len() < MOST_NOTES {
            self.notes.push(sentence);
        }
    }

    /// Adds the number of places to mistakes reported only at the first.
    pub fn count_habits(&mut self) {
        for Habit { told, places } in std::mem::take(&mut self.habits).into_values() {
            if let (Some(diagnostic), 2..) = (self.sink.diagnostics.get_mut(told), places.len()) {
                diagnostic.message += &format!(" (and {} more like it)", places.len() - 1);
            }
        }
    }

    /// Reports a word that is not a number; a systematic mistake is reported once.
    fn unreadable(&mut self, element: &Element, key: &str, word: &str, fault: Fault) {
        let place = element.place(key);
        let habit = (fault, element.name.clone(), key.to_owned());
        if let Some(Habit { places, .. }) = self.habits.get_mut(&habit) {
            places.insert(place);
            return;
        }
        let message = format!("`{key}` of <{}> is not {}: `{}`", element.name, fault.lacks(), brief(word));
        let told = self.sink.diagnostics.len();
        self.tell(value(message, place).help(fault.help()));
        if fault.is_habit() && self.sink.diagnostics.len() > told {
            self.habits.insert(habit, Habit { told, places: BTreeSet::from([place]) });
        }
    }

    /// All remarks, once reading is done.
    pub fn notes(&mut self) -> Vec<String> {
        for (reason, left_out) in std::mem::take(&mut self.left_out) {
            let note = match left_out.as_slice() {
                [] => continue,
                [[body, mesh]] => {
                    format!("`{body}`: the mesh {mesh} {} and left out; {}", reason.of_one, reason.cure)
                }
                [[body, mesh], ..] => {
                    let mut bodies: Vec<&str> = left_out.iter().map(|[body, _]| body.as_str()).collect();
                    bodies.dedup();
                    let (count, bodies) = (left_out.len(), listed(bodies));
                    let Reason { of_many, cure, .. } = reason;
                    format!(
                        "{count} meshes {of_many} and left out, such as {mesh} of `{body}`; {cure}: {bodies}"
                    )
                }
            };
            self.note(note);
        }
        std::mem::take(&mut self.notes)
    }

    /// Records a mesh that is left out.
    fn leave_out(&mut self, reason: Reason, body: &str, mesh: &str) {
        let left_out = self.left_out.entry(reason).or_default();
        if left_out.len() < MOST_NOTES {
            left_out.push([body.to_owned(), mesh.to_owned()]);
        }
    }

    /// Reads a text into the sources under a name; `blame` is the place that refers to it.
    pub fn text(&mut self, path: &Path, shown: &Path, blame: Option<Span>) -> Option<SourceId> {
        let at = |diagnostic: Diagnostic| match blame {
            Some(span) => diagnostic.at(span, ""),
            None => diagnostic,
        };
        let place = shown.display();
        let error = match bounded::text(path, xml::LARGEST_TEXT) {
            Ok(text) => return Some(self.sources.add(shown, text)),
            Err(error) => error,
        };
        self.tell(at(match &error {
            ReadError::TooLarge { .. } => xml::too_large(format!("cannot read `{place}`: {error}")),
            ReadError::NotUtf8 { .. } => {
                Diagnostic::error("E0005", format!("`{place}` is not UTF-8")).help("save it as UTF-8")
            }
            ReadError::Special(_) => {
                let message = format!("cannot read `{place}`: {error}");
                Diagnostic::error("E0007", message).help("give a regular file")
            }
            _ if error.is_absence() => {
                let help = "name a URDF or MJCF file";
                Diagnostic::error("E0004", format!("`{place}` cannot be found: {error}")).help(help)
            }
            _ => Diagnostic::error("E0006", format!("`{place}` cannot be read: {error}"))
                .help("give a file that can be read"),
        }));
        None
    }

    /// The root element of a text.
    pub fn parse(&mut self, source: SourceId) -> Option<Element> {
        match xml::parse(self.sources, source, self.room) {
            Ok(root) => {
                self.room = self.room.saturating_sub(count(&root));
                Some(root)
            }
            Err(error) => {
                self.tell(error);
                None
            }
        }
    }

    /// The location of a file name in a description in the folder `from`; the name is at `span`. Outside is
    /// an error, reported once because one --root fixes them all.
    pub fn find(&mut self, from: &Path, named: &str, span: Span) -> Place {
        let place = self.folder.find(from, named);
        if place == Place::Outside && !std::mem::replace(&mut self.outside, true) {
            let help = "only files below that folder are read: copy the file there, or name a folder that \
                holds both with --root";
            let message = format!("`{named}` lies outside the robot's folder");
            self.tell(Diagnostic::error("E0414", message).at(span, "").help(help));
        }
        place
    }

    /// The box around a mesh, scaled; `None` with a remark or an error if it has none.
    pub fn mesh(
        &mut self,
        body: &str,
        from: &Path,
        named: &str,
        span: Span,
        scale: [f64; 3],
    ) -> Option<Block> {
        let path = match self.find(from, named, span) {
            Place::Inside(path) => path,
            Place::Outside => return None,
            Place::Missing => {
                self.leave_out(MISSING, body, named);
                return None;
            }
        };
        let found = match self.meshes.get(&path) {
            Some(found) => found.clone(),
            None => {
                let found = mesh::bounds(&path, &mut self.mesh_bytes);
                if self.mesh_bytes > MOST_MESH_BYTES {
                    let message = format!("the meshes have more than {} MiB together", MOST_MESH_BYTES >> 20);
                    self.tell(xml::too_large(message).at(span, ""));
                    return None;
                }
                self.meshes.insert(path.clone(), found.clone());
                found
            }
        };
        let block = match found {
            Ok(block) => block,
            Err(MeshError::Format) => {
                self.leave_out(FORMAT, body, named);
                return None;
            }
            Err(MeshError::TooLarge(reason)) => {
                let message = format!("cannot read the mesh `{named}`: {reason}");
                self.tell(
                    Diagnostic::error("E0415", message)
                        .at(span, "")
                        .help("give the body a box or a coarser mesh"),
                );
                return None;
            }
            Err(MeshError::Broken(reason)) => {
                let message = format!("the mesh `{named}` cannot be read: {reason}");
                let help = "export it again as STL or OBJ, or give the body a box";
                self.tell(Diagnostic::error("E0414", message).at(span, "").help(help));
                return None;
            }
        };
        let factors = Vector3::from(scale);
        let block = Block {
            centre: block.centre.component_mul(&factors),
            half: block.half.component_mul(&factors).abs(),
        };
        if block.half.min() <= 0.0 {
            self.note(format!("`{body}`: the mesh {named} is flat and left out; give the body a box"));
            return None;
        }
        let size = (2.0 * block.half).iter().map(|side| format!("{side:.3}")).collect::<Vec<_>>().join(" x ");
        self.note(format!("`{body}`: the mesh {named} became the box around it, {size} m"));
        self.boxes.push(MeshBox { body: body.to_owned(), block, path, scale });
        Some(block)
    }

    /// The number in an attribute; `None` if it is absent, or invalid, which is reported.
    pub fn number(&mut self, element: &Element, key: &str) -> Option<f64> {
        self.vector::<1>(element, key).map(|[number]| number)
    }

    /// A fixed number of numbers in an attribute.
    pub fn vector<const N: usize>(&mut self, element: &Element, key: &str) -> Option<[f64; N]> {
        let numbers = self.numbers(element, key)?;
        let found = numbers.len();
        let exact = numbers.try_into().ok();
        if exact.is_none() {
            let wanted = if N == 1 { "one number".to_owned() } else { format!("{N} numbers") };
            let message = format!("`{key}` of <{}> needs {wanted}, found {found}", element.name);
            self.tell(value(message, element.place(key)).help("separate numbers by spaces"));
        }
        exact
    }

    /// All numbers in an attribute.
    pub fn numbers(&mut self, element: &Element, key: &str) -> Option<Vec<f64>> {
        let text = element.text(key)?;
        let mut numbers = Vec::new();
        for word in text.split_whitespace() {
            match number(word) {
                Ok(number) => numbers.push(number),
                Err(fault) => {
                    self.unreadable(element, key, word, fault);
                    return None;
                }
            }
        }
        Some(numbers)
    }

    /// The numbers in a required attribute.
    pub fn needed<const N: usize>(&mut self, element: &Element, key: &str) -> Option<[f64; N]> {
        if element.attribute(key).is_none() {
            self.lacks(element, key);
        }
        self.vector(element, key)
    }

    /// The text of a required attribute, valid as a name.
    pub fn name(&mut self, element: &Element, key: &str) -> Option<String> {
        let Some(name) = element.text(key) else {
            self.lacks(element, key);
            return None;
        };
        if name.is_empty() || name.len() > LONGEST_NAME || name.chars().any(char::is_control) {
            let message = format!("`{key}` of <{}> is not a name", element.name);
            self.tell(value(message, element.place(key)).help("write at most 200 letters and digits"));
            return None;
        }
        Some(name.to_owned())
    }

    fn lacks(&mut self, element: &Element, key: &str) {
        let message = format!("<{}> has no `{key}`", element.name);
        self.tell(value(message, element.span).help(format!("add {key}=\"...\"")));
    }
}

/// E0411: an invalid value.
pub(super) fn value(message: String, span: Span) -> Diagnostic {
    Diagnostic::error("E0411", message).at(span, "")
}

/// E0412: bodies and joints do not form a tree.
pub(super) fn not_a_tree(message: String, span: Span) -> Diagnostic {
    Diagnostic::error("E0412", message).at(span, "")
}

/// The first letters of a word.
fn brief(word: &str) -> String {
    if word.chars().count() <= 40 {
        word.to_owned()
    } else {
        word.chars().take(40).chain("...".chars()).collect()
    }
}

fn count(element: &Element) -> usize {
    1 + element.children.iter().map(count).sum::<usize>()
}

/// E0402: an unknown key frame.
pub(super) fn no_key(wanted: &str, keys: &[&str]) -> Diagnostic {
    let help = if keys.is_empty() {
        "leave --key out: the file has no key frame with positions".to_owned()
    } else {
        format!("the key frames with positions are {}", listed(keys.iter().copied()))
    };
    Diagnostic::error("E0402", format!("--key: the file has no key frame `{wanted}`")).help(help)
}
