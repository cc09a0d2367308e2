//! Text in XML (figures, URDF, MJCF): escapes markup and characters that XML does not allow.

use super::terminal::line;

/// The text of an element.
pub fn text(text: &str) -> String {
    line(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// The value of an attribute in double quotes.
pub fn attribute(value: &str) -> String {
    text(value).replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_text_makes_a_well_formed_document_without_elements_of_its_own() {
        let letters: String = (0..0x3000).chain(0xfff0..=0xffff).filter_map(char::from_u32).collect();
        for hostile in
            [letters.as_str(), "</text><script>alert(1)</script>", "]]>", "\"/><a b=\"", "&lt;&#27;"]
        {
            let document = format!("<a b=\"{}\">{}</a>", attribute(hostile), text(hostile));
            let parsed = roxmltree::Document::parse(&document).expect("well formed");
            assert!(parsed.root_element().children().all(|child| child.is_text()));
            assert_eq!(parsed.root_element().attributes().len(), 1);
        }
    }
}
