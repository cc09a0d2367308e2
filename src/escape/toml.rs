//! Text in TOML files that the program writes: strings, and comments quoted from other files.

use super::hidden::is_hidden;
use super::terminal;

/// A text as a TOML string on one line, with escaped hidden characters.
pub fn string(text: &str) -> String {
    if !text.contains(is_hidden) {
        return toml::Value::String(text.to_owned()).to_string();
    }
    let mut out = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => out.extend(['\\', letter]),
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            _ if is_hidden(letter) => out += &format!("\\U{:08X}", u32::from(letter)),
            _ => out.push(letter),
        }
    }
    out.push('"');
    out
}

/// A text in a comment, on one line.
pub fn comment(text: &str) -> String {
    terminal::line(text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_string_stands_on_one_line_and_reads_as_it_was() {
        for text in [
            "plain",
            "it's",
            "a\"b\\c",
            "a\nb\tc\r",
            "\u{1b}[31m\u{9b}\u{202e}\u{2028}\u{e0041}\"\\",
            "'''\n\"\"\"",
        ] {
            let written = string(text);
            assert!(!written.contains(is_hidden), "{written}");
            let read: toml::Table = toml::from_str(&format!("a = {written}")).expect("TOML");
            assert_eq!(read["a"].as_str(), Some(text));
        }
    }

    #[test]
    fn a_comment_does_not_leave_its_line() {
        assert_eq!(comment("walker\nmass = 1"), "walker\\u000amass = 1");
    }
}
