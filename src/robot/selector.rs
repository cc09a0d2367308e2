//! Selectors: names of joints or links in which `*` stands for any letters.

/// Whether a selector matches a name.
pub fn matches(selector: &str, name: &str) -> bool {
    match selector.split_once('*') {
        None => selector == name,
        Some((head, rest)) => name.strip_prefix(head).is_some_and(|tail| {
            (0..=tail.len()).filter(|at| tail.is_char_boundary(*at)).any(|at| matches(rest, &tail[at..]))
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_any_letters() {
        assert!(matches("*_knee", "left_knee") && matches("left*", "left_knee") && matches("*", "x"));
        assert!(!matches("*_knee", "left_knee_pitch") && !matches("knee", "left_knee"));
    }
}
