//! Labels of graphs, between double quotes: in the language of Graphviz and in that of Mermaid.

use super::terminal::line;

/// A label for Graphviz. It knows `\` as an escape and HTML's entities.
pub fn dot(text: &str) -> String {
    line(text).replace('\\', "\\\\").replace('"', "\\\"").replace('&', "&amp;")
}

/// A label for Mermaid, which is HTML and may be Markdown; its own entities are `#quot;` and the like.
pub fn mermaid(text: &str) -> String {
    let mut out = String::new();
    for letter in line(text).chars() {
        match letter {
            '"' | '#' | '&' | '<' | '>' | '`' | '|' | ';' | '[' | ']' | '{' | '}' | '\\' => {
                out += &format!("#{};", u32::from(letter));
            }
            _ => out.push(letter),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_cannot_end_before_its_quote() {
        assert_eq!(dot("a\"]; b \\"), "a\\\"]; b \\\\");
        assert_eq!(dot("a\n\x1b"), "a\\\\u000a\\\\u001b");
        assert_eq!(mermaid("stiffness=100 %"), "stiffness=100 %");
        assert_eq!(mermaid("\"]<b>"), "#34;#93;#60;b#62;");
    }
}
