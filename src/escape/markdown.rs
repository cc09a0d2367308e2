//! Text in Markdown pages. Code spans, emphasis and links to neighbouring pages are allowed; all other
//! Markdown and HTML (elements, images, other links, headings, tables, entities) is escaped.

use super::hidden::{is_hidden, write};

/// The context of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Paragraph,
    /// A table cell, which `|` ends even in a code span.
    Cell,
}

/// A text in a paragraph, heading or list item.
pub fn inline(text: &str) -> String {
    sentence(text, Place::Paragraph)
}

/// A text in a table cell.
pub fn cell(text: &str) -> String {
    sentence(text, Place::Cell)
}

/// A text for an existing fenced block or code span, without the line breaks and backticks that could end it.
pub fn verbatim(text: &str) -> String {
    one_line(text).replace('`', "'")
}

/// A line within a fenced block, which does not close the fence.
pub fn fenced(text: &str) -> String {
    let text = one_line(text);
    let closes = ["```", "~~~"].iter().any(|fence| text.trim_start().starts_with(fence));
    if closes { format!("\\{text}") } else { text }
}

/// A name as a code span that nothing in the name can end. Uses single backquotes if the name has none.
pub fn code(name: &str) -> String {
    let name = one_line(name);
    let mut run = 0;
    let mut longest = 0;
    for letter in name.chars() {
        run = if letter == '`' { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    let fence = "`".repeat(longest + 1);
    // A backquote at either end would merge with the fence.
    let pad = if longest > 0 { " " } else { "" };
    format!("{fence}{pad}{name}{pad}{fence}")
}

/// The alternative text of an image or the text of a link; brackets are escaped.
pub fn label(text: &str) -> String {
    inline(text).replace('[', "\\[").replace(']', "\\]").replace("\\\\[", "\\[").replace("\\\\]", "\\]")
}

/// The target of a link: a relative path.
pub fn target(path: &str) -> String {
    let mut out = String::new();
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'/' => out.push(char::from(byte)),
            _ => out += &format!("%{byte:02X}"),
        }
    }
    out
}

/// Escapes hidden characters; line breaks and tabs become spaces.
fn one_line(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '\n' | '\t' => out.push(' '),
            _ if is_hidden(letter) => write(&mut out, letter),
            _ => out.push(letter),
        }
    }
    out
}

fn sentence(text: &str, place: Place) -> String {
    let text = one_line(text);
    let mut out = String::with_capacity(text.len() + 8);
    let mut rest = begun(&text, &mut out);
    while let Some(letter) = rest.chars().next() {
        let taken = match letter {
            '`' => backticks(rest, place, &mut out),
            '\\' => backslash(rest, place, &mut out),
            _ => written(rest, letter, place, &mut out),
        };
        rest = &rest[taken..];
    }
    out
}

/// Escapes a block marker at the start of a line; returns the rest of the text.
fn begun<'a>(text: &'a str, out: &mut String) -> &'a str {
    let rest = text.trim_start_matches(' ');
    out.push_str(&text[..text.len() - rest.len()]);
    let digits = rest.len() - rest.trim_start_matches(|letter: char| letter.is_ascii_digit()).len();
    let after = &rest[digits..];
    let is_mark = |text: &str| text.len() <= 1 || text[1..].starts_with(' ');
    if (1..=9).contains(&digits) && after.starts_with(['.', ')']) && is_mark(after) {
        out.push_str(&rest[..digits]);
        out.push('\\');
        out.push_str(&after[..1]);
        return &after[1..];
    }
    let repeats = |mark: char| rest.chars().filter(|letter| *letter != ' ').all(|letter| letter == mark);
    let opens = match rest.chars().next() {
        Some('#' | '>' | '=' | '~') => true,
        Some(mark @ ('-' | '+' | '*')) => is_mark(rest) || repeats(mark),
        Some('_') => repeats('_'),
        _ => false,
    };
    if opens {
        out.push('\\');
        out.push_str(&rest[..1]);
        return &rest[1..];
    }
    rest
}

/// Copies the code span that a run of backticks opens, or escapes the backticks. Returns the length consumed.
fn backticks(rest: &str, place: Place, out: &mut String) -> usize {
    let run = rest.len() - rest.trim_start_matches('`').len();
    let Some(length) =
        span(rest, run).filter(|length| place == Place::Paragraph || !rest[..*length].contains("\\|"))
    else {
        (0..run).for_each(|_| out.push_str("\\`"));
        return run;
    };
    let span = &rest[..length];
    match place {
        Place::Paragraph => out.push_str(span),
        Place::Cell => out.push_str(&span.replace('|', "\\|")),
    }
    length
}

/// Length in bytes of the code span that a run of backticks opens, if a run of the same length closes it.
fn span(rest: &str, run: usize) -> Option<usize> {
    let mut at = run;
    while let Some(found) = rest[at..].find('`') {
        let start = at + found;
        let length = rest[start..].len() - rest[start..].trim_start_matches('`').len();
        if length == run {
            return Some(start + length);
        }
        at = start + length;
    }
    None
}

/// Handles a backslash and the punctuation that it escapes. Returns the length consumed.
fn backslash(rest: &str, place: Place, out: &mut String) -> usize {
    match rest[1..].chars().next() {
        // Renderers differ on whether `\\|` ends a cell.
        Some('|') if place == Place::Cell => {
            out.push_str("&#92;&#124;");
            2
        }
        Some('\\') => {
            out.push_str("&#92;&#92;");
            2
        }
        Some(mark) if mark.is_ascii_punctuation() => {
            out.push_str(&rest[..2]);
            2
        }
        Some(_) => {
            out.push('\\');
            1
        }
        // The backslash must not escape what follows in the page.
        None => {
            out.push_str("&#92;");
            1
        }
    }
}

/// Writes a character outside of code. Returns the length consumed.
fn written(rest: &str, letter: char, place: Place, out: &mut String) -> usize {
    let after = &rest[letter.len_utf8()..];
    match letter {
        // A line break is harmless, even in a cell.
        '<' if after.starts_with("br>") => {
            out.push_str("<br>");
            return 4;
        }
        '<' if after
            .starts_with(|next: char| next.is_ascii_alphabetic() || matches!(next, '/' | '!' | '?')) =>
        {
            out.push_str("&lt;");
        }
        '&' if is_entity(after) => out.push_str("&amp;"),
        '|' if place == Place::Cell => out.push_str("\\|"),
        '!' if after.starts_with('[') => {
            out.push_str("!\\[");
            return 2;
        }
        ']' if after.starts_with('(') && !leads_beside(after) => {
            out.push_str("]\\(");
            return 2;
        }
        ']' if after.starts_with([':', '[']) => out.push_str("\\]"),
        // GitHub turns bare addresses into links.
        ':' if after.starts_with("//") || out.ends_with("mailto") || out.ends_with("xmpp") => {
            out.push_str("\\:")
        }
        'w' | 'W' if rest.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("www.")) => {
            out.push_str(&rest[..3]);
            out.push_str("\\.");
            return 4;
        }
        _ => out.push(letter),
    }
    letter.len_utf8()
}

/// Whether the text after `&` makes it an entity.
fn is_entity(after: &str) -> bool {
    let name = after.strip_prefix('#').unwrap_or(after);
    let end = name.find(|letter: char| !letter.is_ascii_alphanumeric());
    end.is_some_and(|end| end > 0 && name[end..].starts_with(';'))
}

/// Whether `(TARGET)` is a relative path, or an anchor within it.
fn leads_beside(after: &str) -> bool {
    let Some(target) =
        after.strip_prefix('(').and_then(|rest| rest.split_once(')')).map(|(target, _)| target)
    else {
        return false;
    };
    let plain =
        |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '-' | '.' | '/' | '#');
    !target.is_empty()
        && target.chars().all(plain)
        && !target.starts_with(['/', '.'])
        && !target.contains("..")
        && !target.contains("//")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_usual_sentence_stays_as_it_is() {
        for text in [
            "Atlas runs under direct joint torque commands",
            "`torque` survives in 32 of 32 episodes (94 % [80, 98]), a < 0.5, b <= 3 & more",
            "what fails is these settings ([walking](walking_position.md)), see [Claims](#claims)",
            "**PASS**: 0.8 m/s; 1.5 N m, -0.2 rad, +3 %, 12:30, x_y_z",
            "1.23",
            "-0.5",
            " over ",
            "torque `a`<br>position `b`",
            "``a ` b``",
        ] {
            assert_eq!(inline(text), text);
        }
        assert_eq!(cell("a | `b|c`"), "a \\| `b\\|c`");
        assert_eq!(inline("a | b"), "a | b");
    }

    #[test]
    fn elements_images_links_and_entities_are_shown_as_written() {
        for (text, expected) in [
            ("<script>alert(1)</script>", "&lt;script>alert(1)&lt;/script>"),
            ("<!-- x --> <?php <a", "&lt;!-- x --> &lt;?php &lt;a"),
            ("<https://a.b>", "&lt;https\\://a.b>"),
            ("![x](https://a.b/c.png)", "!\\[x]\\(https\\://a.b/c.png)"),
            ("[x](//a.b) [y](../z) [z](javascript:a)", "[x]\\(//a.b) [y]\\(../z) [z]\\(javascript:a)"),
            ("[x]: http://a.b", "[x\\]: http\\://a.b"),
            ("see WWW.a.b, mailto:a@b", "see WWW\\.a.b, mailto\\:a@b"),
            ("&lt;b&gt; &#x202e;", "&amp;lt;b&amp;gt; &amp;#x202e;"),
            ("R&D; 5 & 6", "R&amp;D; 5 & 6"),
            ("`<b>` and <b>", "`<b>` and &lt;b>"),
            ("a ` <b>", "a \\` &lt;b>"),
            ("\\`<b>`", "\\`&lt;b>\\`"),
            ("\\<b> \\\\<b> \\", "\\<b> &#92;&#92;&lt;b> &#92;"),
        ] {
            assert_eq!(inline(text), expected, "{text}");
        }
    }

    #[test]
    fn no_text_begins_a_block_and_none_has_a_second_line() {
        for (text, expected) in [
            ("# x", "\\# x"),
            ("  > x", "  \\> x"),
            ("- x", "\\- x"),
            ("* * *", "\\* * *"),
            ("---", "\\---"),
            ("___", "\\___"),
            ("===", "\\==="),
            ("~~~", "\\~~~"),
            ("1. x", "1\\. x"),
            ("2) x", "2\\) x"),
            ("```sh", "\\`\\`\\`sh"),
            ("a\n# b\r\n\n* c", "a # b\\u000d  * c"),
            ("\u{1b}[31m\u{202e}", "\\u001b[31m\\u202e"),
        ] {
            assert_eq!(inline(text), expected, "{text}");
        }
    }

    #[test]
    fn a_cell_has_no_borders_of_its_own() {
        assert_eq!(cell("a\\|b"), "a&#92;&#124;b");
        assert_eq!(cell("`a\\|b`"), "\\`a&#92;&#124;b\\`");
        assert_eq!(cell("a\nb"), "a b");
    }

    #[test]
    fn labels_targets_and_verbatim_text_end_where_they_should() {
        assert_eq!(label("a](b) [c]"), "a\\](b) \\[c\\]");
        assert_eq!(label("![a](//b)"), "!\\[a\\]\\(//b)");
        assert_eq!(target("a b/c(d).svg"), "a%20b/c%28d%29.svg");
        assert_eq!(verbatim("a`b\n```"), "a'b '''");
        assert_eq!(fenced("specforge run 'a`b.toml'\n"), "specforge run 'a`b.toml' ");
        assert_eq!((fenced(" ```x"), fenced("~~~")), ("\\ ```x".to_owned(), "\\~~~".to_owned()));
    }

    #[test]
    fn a_name_is_code_whatever_is_in_it() {
        assert_eq!(code("specs/walk.toml"), "`specs/walk.toml`");
        assert_eq!(code("a`b.toml"), "`` a`b.toml ``");
        assert_eq!(code("``a`"), "``` ``a` ```");
        assert_eq!(code("a\n*b*"), "`a *b*`");
        let hostile = "x`**PASS** [y](z.md) <b>`";
        for text in [inline(&code(hostile)), cell(&code(hostile))] {
            assert_eq!(text, format!("`` {hostile} ``"));
        }
    }
}
