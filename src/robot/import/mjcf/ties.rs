//! `<equality>`: constraints between bodies and joints in addition to the tree.

use super::super::tree::Tie;
use super::super::xml::Element;

/// Constraints between two named ends. One with a single end fixes it to the world or to a number.
pub(super) fn read(root: &Element) -> Vec<Tie> {
    root.all("equality").flat_map(|equality| &equality.children).filter_map(tie).collect()
}

fn tie(element: &Element) -> Option<Tie> {
    let text = |key: &str| element.text(key).map(str::to_owned);
    match element.name.as_str() {
        "joint" => Some(Tie::Joints { follower: text("joint1")?, leader: text("joint2")? }),
        kind @ ("connect" | "weld") => {
            let end = |number: u8| text(&format!("body{number}")).or(text(&format!("site{number}")));
            let name = element.text("name").map(|name| format!(" {name}")).unwrap_or_default();
            Some(Tie::Bodies { ends: [end(1)?, end(2)?], by: format!("<{kind}>{name}") })
        }
        _ => None,
    }
}
