//! Spelling suggestions: at most one, from the names that are valid in a place.

/// Maximum length in letters of a word that gets a suggestion; the cost grows with its square.
const LONGEST: usize = 100;

/// Maximum number of names compared with a word.
const MOST: usize = 1000;

/// The valid name nearest to a word, if it is close enough to be a misspelling.
pub fn nearest<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = word.chars().count();
    if length > LONGEST {
        return None;
    }
    let limit = (length / 3).max(1);
    let mut best: Option<(usize, &str)> = None;
    // The difference of the lengths is a cheap lower bound of the distance.
    for name in names.into_iter().take(MOST).filter(|name| name.chars().count().abs_diff(length) <= limit) {
        let distance = if rearranged(word, name) { 1 } else { strsim::damerau_levenshtein(word, name) };
        if distance <= limit && best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, name));
        }
    }
    best.map(|(_, name)| name)
}

/// Whether two names have the same words in another order or with other separators: `track_velocity` and
/// `velocity-track`.
fn rearranged(a: &str, b: &str) -> bool {
    let words = |name: &str| {
        let mut words: Vec<String> = name.split(['_', '-', ' ']).map(str::to_lowercase).collect();
        words.sort();
        words
    };
    words(a) == words(b)
}

/// Whether a name can be part of a file name: letters, digits, `_`, `-` and, except at the start, `.`.
pub fn is_file_name(name: &str) -> bool {
    let is_allowed = |letter: char| letter.is_alphanumeric() || matches!(letter, '_' | '-' | '.');
    !name.is_empty() && !name.starts_with('.') && name.chars().all(is_allowed)
}

/// A name with each run of invalid characters replaced by `_`; `None` if nothing else is left or the name is
/// too long to be useful.
pub fn safe_name(name: &str, is_allowed: impl Fn(char) -> bool) -> Option<String> {
    let words: Vec<&str> = name.split(|c| !is_allowed(c)).filter(|word| !word.is_empty()).collect();
    Some(words.join("_")).filter(|safe| !safe.is_empty() && safe.chars().count() <= LONGEST)
}

/// Names for a message: `a`, `b` and `c`.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    match names.as_slice() {
        [] => "none".to_owned(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_recognised_and_other_words_are_not() {
        let names = ["weight", "kind", "stiffness", "velocity_tracking"];
        assert_eq!(nearest("wieght", names), Some("weight"));
        assert_eq!(nearest("stifness", names), Some("stiffness"));
        assert_eq!(nearest("tracking_velocity", names), Some("velocity_tracking"));
        assert_eq!(nearest("Kind", names), Some("kind"));
        assert_eq!(nearest("gravity", names), None);
    }

    #[test]
    fn a_safe_name_keeps_the_words_that_are_allowed() {
        let safe = |name: &str| safe_name(name, |c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
        assert_eq!(safe("walk / torque").as_deref(), Some("walk_torque"));
        assert_eq!(safe("a.b").as_deref(), Some("a_b"));
        assert_eq!(safe(" // "), None);
        assert_eq!(safe(&"x".repeat(101)), None);
    }

    #[test]
    fn names_are_listed_as_in_a_sentence() {
        assert_eq!(listed(["a", "b", "c"]), "`a`, `b` and `c`");
        assert_eq!(listed(["a"]), "`a`");
        assert_eq!(listed([]), "none");
    }
}
