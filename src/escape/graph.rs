//! Labels of graphs, between double quotes, for Graphviz and Mermaid.

use super::terminal::line;

/// A label for Graphviz, which interprets `\` escapes and HTML entities.
pub fn dot(text: &str) -> String {
    line(text).replace('\\', "\\\\").replace('"', "\\\"").replace('&', "&amp;")
}

/// A label for Mermaid, which interprets HTML and sometimes Markdown; its entities have the form `#quot;`.
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
