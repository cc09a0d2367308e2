//! Characters that have an effect but no glyph: controls, bidirectional formatting, separators and invisible
//! letters.

/// Characters other than controls (`char::is_control`: C0, DEL and C1) that have no glyph: Unicode categories
/// Cf, Zl and Zp, and letters defined as invisible. Variation selectors are not included: they only choose a
/// glyph.
const INVISIBLE: [(char, char); 17] = [
    ('\u{ad}', '\u{ad}'),       // soft hyphen
    ('\u{34f}', '\u{34f}'),     // combining grapheme joiner
    ('\u{61c}', '\u{61c}'),     // Arabic letter mark
    ('\u{115f}', '\u{1160}'),   // Hangul fillers
    ('\u{17b4}', '\u{17b5}'),   // invisible Khmer vowels
    ('\u{180e}', '\u{180e}'),   // Mongolian vowel separator
    ('\u{200b}', '\u{200f}'),   // zero-width characters, left-to-right and right-to-left marks
    ('\u{2028}', '\u{202e}'),   // line and paragraph separators, embeddings and overrides
    ('\u{2060}', '\u{206f}'),   // word joiner, invisible operators, isolates
    ('\u{3164}', '\u{3164}'),   // Hangul filler
    ('\u{feff}', '\u{feff}'),   // byte order mark
    ('\u{ffa0}', '\u{ffa0}'),   // half-width Hangul filler
    ('\u{fff0}', '\u{fffb}'),   // interlinear annotation
    ('\u{fffe}', '\u{ffff}'),   // noncharacters, which XML does not allow
    ('\u{1bca0}', '\u{1bca3}'), // shorthand format controls
    ('\u{1d173}', '\u{1d17a}'), // musical format controls
    ('\u{e0000}', '\u{e0fff}'), // tags
];

/// Whether a character has an effect but no glyph. Line breaks and tabs count too.
pub fn is_hidden(letter: char) -> bool {
    letter.is_control()
        || (letter > '~' && INVISIBLE.iter().any(|(first, last)| (*first..=*last).contains(&letter)))
}

/// Escapes a character as in JSON and TOML, `\u001b`, so that a document keeps its meaning; characters beyond
/// the basic plane as in JSON, by two surrogates.
pub(super) fn write(out: &mut String, letter: char) {
    for unit in letter.encode_utf16(&mut [0; 2]) {
        out.push_str(&format!("\\u{unit:04x}"));
    }
}

/// Escapes the hidden characters of a text, except those for which `stays` is true.
pub(super) fn written_out(text: &str, stays: impl Fn(char) -> bool) -> String {
    let mut out = String::with_capacity(text.len() + 16);
    for letter in text.chars() {
        if is_hidden(letter) && !stays(letter) { write(&mut out, letter) } else { out.push(letter) }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_is_hidden_and_what_is_seen_is_not() {
        let hidden = "\0\u{7}\u{8}\n\r\t\u{1b}\u{7f}\u{80}\u{85}\u{9b}\u{9f}\u{ad}\u{61c}\u{200b}\u{200d}\u{200e}\u{200f}\
                      \u{2028}\u{2029}\u{202a}\u{202e}\u{2060}\u{2066}\u{2069}\u{feff}\u{e0001}\u{e007f}";
        assert_eq!(hidden.chars().find(|letter| !is_hidden(*letter)), None);
        let seen = " ~aZ0é µ·–…−€ア中עא😀\u{fe0f}\u{a0}";
        assert_eq!(seen.chars().find(|letter| is_hidden(*letter)), None);
    }

    #[test]
    fn an_escaped_json_text_means_what_it_meant() {
        for letter in ['\u{1b}', '\u{9b}', '\u{202e}', '\u{e0041}'] {
            let json = format!("\"{}\"", written_out(&letter.to_string(), |_| false));
            assert_eq!(serde_json::from_str::<String>(&json).expect("valid JSON"), letter.to_string());
        }
    }
}
