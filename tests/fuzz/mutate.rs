//! Damages texts as authors, editors and broken disks do: by tokens, by bytes and by structure.

use specforge::stream::Stream;

/// Words that mean something in a spec, and some that mean trouble.
const WORDS: &[&str] = &[
    "[",
    "]",
    "[[",
    "]]",
    "{",
    "}",
    "=",
    ",",
    ".",
    "\"",
    "'",
    "\"\"\"",
    "#",
    "\n",
    "\r\n",
    "\0",
    "\u{feff}",
    "µ",
    "²",
    "\u{202e}",
    "spec",
    "name",
    "extends",
    "abstract",
    "profile",
    "allow",
    "kind",
    "enabled",
    "weight",
    "k",
    "scale",
    "per",
    "joints",
    "links",
    "robot",
    "physics",
    "terrain",
    "task",
    "initial",
    "action",
    "observe",
    "reward",
    "terminate",
    "randomize",
    "pretrain",
    "learn",
    "evaluate",
    "deploy",
    "report",
    "sweep",
    "claim",
    "suite",
    "seeds",
    "values",
    "path",
    "exclude",
    "uniform",
    "normal",
    "log_uniform",
    "choice",
    "linear",
    "kl_target",
    "true",
    "false",
    "inf",
    "-inf",
    "nan",
    "0",
    "-1",
    "1e400",
    "1e-400",
    "9223372036854775808",
    "0x7fffffffffffffff",
    "1979-05-27T07:32:00Z",
    "\"4 ms\"",
    "\"-4 ms\"",
    "\"1e308 km\"",
    "\"4 rad/s\"",
    "\"10 %\"",
    "\"300 Hz\"",
    "\"80 M\"",
    "\"1 ^9\"",
    "\"/\"",
    "\"m^99\"",
    "\"\"",
    "\"*\"",
    "\"..\"",
    "\"whole.toml\"",
    "\"spec.toml\"",
    "\"tocabi\"",
    "\"../../etc/passwd\"",
    "[reward.torque]\n",
    "[profile.quick]\n",
    "[learn]\n",
    "action.delay = ",
    "{ uniform = [2, 1] }",
    "enabled = false\n",
    "kind = \"position\"\n",
    "spec = 1\n",
];

/// A text with one to four damages.
pub fn damaged(text: &str, stream: &mut Stream) -> String {
    let mut text = text.to_owned();
    for _ in 0..=stream.below(4) {
        text = match stream.below(12) {
            0..=6 => by_tokens(&text, stream),
            7..=9 => by_characters(&text, stream),
            _ => by_structure(&text, stream),
        };
    }
    text
}

/// A random assignment for `--set`.
pub fn assignment(text: &str, stream: &mut Stream) -> String {
    let tokens = tokens(text);
    let mut word = || {
        let own = stream.below(2) == 0 && !tokens.is_empty();
        if own { tokens[stream.below(tokens.len())].to_owned() } else { pick(stream).to_owned() }
    };
    format!("{}.{}={}", word(), word(), word())
}

fn pick(stream: &mut Stream) -> &'static str {
    WORDS[stream.below(WORDS.len())]
}

/// Words, strings, numbers, blanks and single signs.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = match first {
            '"' => rest[1..].find('"').map_or(rest.len(), |end| end + 2),
            '#' => rest.find('\n').unwrap_or(rest.len()),
            first if is_word(first) => rest.find(|c: char| !is_word(c)).unwrap_or(rest.len()),
            first => first.len_utf8(),
        };
        let (token, after) = rest.split_at(length);
        tokens.push(token);
        rest = after;
    }
    tokens
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '-' | '.')
}

/// Drops, doubles, swaps or replaces tokens.
fn by_tokens(text: &str, stream: &mut Stream) -> String {
    let mut tokens = tokens(text);
    if tokens.is_empty() {
        return pick(stream).to_owned();
    }
    let at = stream.below(tokens.len());
    let other = stream.below(tokens.len());
    match stream.below(6) {
        0 => drop(tokens.remove(at)),
        1 => tokens.insert(at, tokens[other]),
        2 => tokens.swap(at, other),
        3 => tokens[at] = tokens[other],
        4 => tokens[at] = pick(stream),
        _ => tokens.insert(at, pick(stream)),
    }
    tokens.concat()
}

/// Drops, inserts or changes a character, or cuts the text off.
fn by_characters(text: &str, stream: &mut Stream) -> String {
    let mut characters: Vec<char> = text.chars().collect();
    let at = stream.below(characters.len() + 1);
    let strange = char::from_u32(stream.below(0x2_0000) as u32).unwrap_or('\u{fffd}');
    let byte = stream.below(128) as u8 as char;
    match stream.below(5) {
        0 => characters.truncate(at),
        1 => characters.insert(at, strange),
        2 => characters.insert(at, byte),
        _ if at == characters.len() => {}
        3 => characters[at] = byte,
        _ => drop(characters.remove(at)),
    }
    characters.into_iter().collect()
}

/// Deep nesting, long keys, huge numbers, many tables, lines in another order.
fn by_structure(text: &str, stream: &mut Stream) -> String {
    let size = 1 << stream.below(11);
    match stream.below(7) {
        0 => format!("{text}\nx = {}{}\n", "[".repeat(size), "]".repeat(size)),
        1 => format!("{text}\nx = {}1{}\n", "{ a = ".repeat(size), " }".repeat(size)),
        2 => format!("{text}\n[reward.{}]\n", "long".repeat(size)),
        3 => format!("{text}\n[learn]\nseed = {}\n", "9".repeat(size)),
        4 => format!(
            "{text}\n{}\n",
            (0..size).map(|number| format!("[reward.r{number}]\n")).collect::<String>()
        ),
        5 => format!("{text}\n[action{}]\nrate = \"1 Hz\"\n", ".a".repeat(size)),
        _ => {
            let mut lines: Vec<&str> = text.lines().collect();
            let (a, b) = (stream.below(lines.len().max(1)), stream.below(lines.len().max(1)));
            if a < lines.len() && b < lines.len() {
                lines.swap(a, b);
            }
            lines.join("\n")
        }
    }
}
