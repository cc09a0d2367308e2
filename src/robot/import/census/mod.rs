//! Finds what the import drops: looks up every element and attribute in the table of its format, counts those
//! that are not imported, and reports one line per group.

pub(super) mod mjcf;
mod table;
mod urdf;

use std::collections::{BTreeMap, BTreeSet};

use super::naming::some;
use super::xml::Element;
pub(super) use table::{Class, Group, Row};

/// Maximum number of elements and attributes listed in a line; of the rest only the count is shown.
const MOST_KINDS: usize = 6;

/// What was found so far.
#[derive(Debug)]
pub(super) struct Census {
    table: &'static [Row],
    left: BTreeMap<Group, Kinds>,
}

/// The findings of a group, in the order of the file.
#[derive(Debug, Default)]
struct Kinds {
    /// `stiffness` of <joint>, and the names of the owners.
    found: Vec<(String, Vec<String>)>,
    places: BTreeMap<String, usize>,
}

impl Census {
    /// A census without findings.
    pub fn new(table: &'static [Row]) -> Self {
        Self { table, left: BTreeMap::new() }
    }

    /// Counts something that is not imported, under the name of its owner.
    pub fn count(&mut self, group: Group, what: String, owner: &str) {
        let Kinds { found, places } = self.left.entry(group).or_default();
        let place = *places.entry(what.clone()).or_insert(found.len());
        if place == found.len() {
            found.push((what, Vec::new()));
        }
        found[place].1.push(owner.to_owned());
    }

    /// Whether the format has an element with this path.
    pub fn knows(&self, path: &str) -> bool {
        Row::find(self.table, path).is_some()
    }

    /// Counts an element and its attributes, except those of ignored groups; returns whether to count its
    /// children as well.
    pub fn take(&mut self, path: &str, element: &Element, owner: &str, ignored: &[Group]) -> bool {
        let Some(row) = Row::find(self.table, path) else {
            self.count(Group::Unknown, format!("<{}>", element.name), owner);
            return false;
        };
        if let Some(class) = row.whole {
            if let Class::Left(group) = class {
                self.count(group, format!("<{}>", element.name), owner);
            }
            return false;
        }
        self.attributes(row, element, owner, ignored);
        true
    }

    /// Counts the attributes of an element that are unknown to its format.
    pub fn unknown(&mut self, path: &str, element: &Element, owner: &str) {
        let Some(row) = Row::find(self.table, path).filter(|row| row.whole.is_none()) else { return };
        let unknown = element.attributes.iter().filter(|attribute| row.class(&attribute.name, "").is_none());
        for attribute in unknown {
            self.count(Group::Unknown, format!("`{}` of <{}>", attribute.name, element.name), owner);
        }
    }

    /// Counts the attributes of an element.
    pub fn attributes(&mut self, row: &Row, element: &Element, owner: &str, ignored: &[Group]) {
        for attribute in &element.attributes {
            let group = match row.class(&attribute.name, &attribute.value) {
                Some(Class::Imported | Class::Harmless) => continue,
                Some(Class::Left(group)) => group,
                None => Group::Unknown,
            };
            if !ignored.contains(&group) {
                self.count(group, format!("`{}` of <{}>", attribute.name, element.name), owner);
            }
        }
    }

    /// One line per group.
    pub fn lines(&self) -> Vec<String> {
        let line = |(group, Kinds { found, .. }): (&Group, &Kinds)| {
            let mut shown: Vec<String> =
                found.iter().take(MOST_KINDS).map(|(what, owners)| item(what, owners)).collect();
            if found.len() > MOST_KINDS {
                shown.push(format!("{} more", found.len() - MOST_KINDS));
            }
            let (title, reason) = group.text();
            format!("not imported: {title}, {}; {reason}", shown.join(", "))
        };
        self.left.iter().map(line).collect()
    }
}

/// `stiffness` of <joint> `left_knee` and `right_knee`; for unnamed owners the number.
fn item(what: &str, owners: &[String]) -> String {
    let mut known = BTreeSet::new();
    let names: Vec<&str> =
        owners.iter().map(String::as_str).filter(|name| !name.is_empty() && known.insert(*name)).collect();
    let whose = if names.is_empty() { String::new() } else { format!(" {}", some(&names)) };
    let times =
        if owners.len() > names.len().max(1) { format!(" ({} times)", owners.len()) } else { String::new() };
    format!("{what}{whose}{times}")
}

/// The lines for a URDF file.
pub(super) fn urdf(root: &Element) -> Vec<String> {
    let mut census = Census::new(urdf::TABLE);
    elements(&mut census, root, "robot", "", &root.space);
    census.lines()
}

/// Counts a URDF element and its contents.
fn elements(census: &mut Census, element: &Element, path: &str, owner: &str, space: &str) {
    if element.space != *space {
        census.count(Group::Extensions, format!("<{}>", element.name), owner);
        return;
    }
    let named = element.text("name").filter(|_| path != "robot").unwrap_or(owner);
    if !census.take(path, element, named, &[]) {
        return;
    }
    for (index, child) in element.children.iter().enumerate() {
        let earlier = &element.children[..index];
        let again = urdf::SINGLE.contains(&child.name.as_str())
            && earlier.iter().any(|other| other.name == child.name);
        // A geometry has only one shape.
        if again || (element.name == "geometry" && index > 0) {
            census.count(Group::Second, format!("<{}>", child.name), named);
        } else {
            elements(census, child, &format!("{path}/{}", child.name), named, space);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::xml::{self, MOST_ELEMENTS};
    use super::*;
    use crate::diag::Sources;

    fn said(text: &str) -> Vec<String> {
        let mut sources = Sources::default();
        let source = sources.add("robot.urdf", text);
        urdf(&xml::parse(&sources, source, MOST_ELEMENTS).expect("it is XML"))
    }

    #[test]
    fn what_urdf_says_beside_the_robot_is_one_line_for_each_kind() {
        let limit = "<limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"1\" acceleration=\"3\"/>";
        let joint = |name: &str| {
            format!(
                "<joint name=\"{name}\" type=\"revolute\">{limit}<dynamics \
                 damping=\"1\" spring_stiffness=\"4\"/>\
                 <axis xyz=\"1 0 0\"/><axis xyz=\"0 1 0\"/></joint>"
            )
        };
        let joints: String = ["a", "b", "c", "d", "e"].map(joint).concat();
        let lines = said(&format!(
            "<robot name=\"r\" xmlns:drake=\"http://drake.mit.edu\">{joints}<link \
             name=\"l\" colour=\"red\"><visual><glow/></visual>\
             <collision><geometry><box size=\"1 1 1\"/><sphere radius=\"1\"/></geometry></collision></link>\
             <gazebo reference=\"l\"/><drake:joint/></robot>"
        ));
        let all = "`a`, `b`, `c` and 2 others";
        let expected = [
            format!("springs, `spring_stiffness` of <dynamics> {all};"),
            format!("`acceleration` of <limit> {all};"),
            "simulators and controllers, <gazebo>;".to_owned(),
            "other programs, <joint>;".to_owned(),
            format!("second elements where one counts, <axis> {all}, <sphere> `l`;"),
            "unknown elements and attributes, `colour` of <link> `l`;".to_owned(),
        ];
        assert_eq!(lines.len(), expected.len(), "{lines:#?}");
        for (line, expected) in lines.iter().zip(&expected) {
            assert!(line.starts_with("not imported: ") && line.contains(expected), "{line}\n{expected}");
        }
    }

    #[test]
    fn a_plain_file_says_nothing() {
        let text = "<robot name=\"r\" version=\"1.0\"><link name=\"l\"><collision><origin xyz=\"0 0 \
            0\"/><geometry>\
            <box size=\"1 1 1\"/></geometry></collision></link><material name=\"m\"><color rgba=\"1 1 1 \
            1\"/></material></robot>";
        assert_eq!(said(text), Vec::<String>::new());
    }

    #[test]
    fn very_many_kinds_are_counted() {
        let attributes: String = (0..60).map(|index| format!(" a{index}=\"\"")).collect();
        let lines = said(&format!("<robot name=\"r\"><link name=\"l\"{attributes}/></robot>"));
        assert!(lines.len() == 1 && lines[0].contains("`a5` of <link> `l`, 54 more;"), "{lines:?}");
    }
}
