//! Xacro, the macro language of URDF: all its remains in a file are reported as one mistake.

use super::intake::Intake;
use super::xml::{Element, unexpanded};
use crate::diag::Span;

/// Reports elements or expressions of xacro; then returns `None`.
pub(super) fn refuse(root: &Element, intake: &mut Intake) -> Option<()> {
    let mut places = Vec::new();
    gather(root, &mut places);
    let Some(&first) = places.first() else { return Some(()) };
    intake.tell(unexpanded(first, places.len()));
    None
}

/// The places of xacro in an element, in the order of the text.
fn gather(element: &Element, places: &mut Vec<Span>) {
    if element.space.contains("xacro") {
        // The contents of a macro are not reported separately.
        places.push(element.span);
        return;
    }
    let expression = |value: &str| value.contains("${") || value.contains("$(");
    let expressions = element.attributes.iter().filter(|attribute| expression(&attribute.value));
    places.extend(expressions.map(|attribute| attribute.span));
    element.children.iter().for_each(|child| gather(child, places));
}

#[cfg(test)]
mod tests {
    use super::super::folder::Folder;
    use crate::diag::{Diagnostic, Sink, Sources};

    fn told(text: &str) -> Vec<(String, usize)> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.urdf");
        std::fs::write(&path, text).unwrap();
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        super::super::read(&path, &Folder::around(&path).unwrap(), &mut sources, &mut sink);
        let line =
            |diagnostic: &Diagnostic| text[..diagnostic.labels[0].span.start].matches('\n').count() + 1;
        sink.diagnostics.iter().map(|told| (format!("{}: {}", told.code, told.message), line(told))).collect()
    }

    #[test]
    fn left_over_xacro_is_one_mistake_wherever_it_stands() {
        const SAID: &str = "E0410: this is a xacro file, from which URDF is made";
        let head = "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n";
        let link = "<link name=\"l\"><inertial><mass value=\"1\"/><inertia \
            ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial></link>";
        let deep = format!("{head}<link name=\"l\">\n<xacro:box_inertia m=\"${{m}}\"/></link></robot>");
        assert_eq!(told(&deep), [(SAID.to_owned(), 3)]);
        let effort =
            "<joint name=\"j\" type=\"fixed\"><limit effort=\"${effort}\" velocity=\"${2*pi}\"/></joint>\n";
        let values = format!("{head}{link}{}</robot>", effort.repeat(20));
        assert_eq!(told(&values), [(format!("{SAID} (and 39 more places)"), 2)]);
        let found = format!(
            "{head}\n<link name=\"l\"><visual><mesh filename=\"$(find arm)/a.stl\"/></visual></link></robot>"
        );
        assert_eq!(told(&found), [(SAID.to_owned(), 3)]);
        // Without its namespace declaration the file is not valid XML either.
        let bare = told("<robot name=\"r\">\n<xacro:arm/>\n<xacro:leg/></robot>");
        assert_eq!(bare, [(SAID.to_owned(), 2)]);
        // The output of xacro declares the namespace but does not use it.
        assert_eq!(told(&format!("{head}{link}</robot>")), []);
    }
}
