//! Selectors: names of joints or links with the wildcard `*`.

/// Whether a selector matches a name. Each piece between stars is matched at the first possible position, so
/// that the cost does not grow with the number of stars.
pub fn matches(selector: &str, name: &str) -> bool {
    let Some((head, rest)) = selector.split_once('*') else { return selector == name };
    let (middle, tail) = rest.rsplit_once('*').map_or((None, rest), |(middle, tail)| (Some(middle), tail));
    let Some(name) = name.strip_prefix(head) else { return false };
    let Some(mut name) = name.strip_suffix(tail) else { return false };
    for piece in middle.into_iter().flat_map(|middle| middle.split('*')) {
        match name.split_once(piece) {
            Some((_, after)) => name = after,
            None => return false,
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_any_letters() {
        assert!(matches("*_knee", "left_knee") && matches("left*", "left_knee") && matches("*", "x"));
        assert!(!matches("*_knee", "left_knee_pitch") && !matches("knee", "left_knee"));
        assert!(matches("a*b*c", "a__b_bc") && matches("**", "") && matches("*é*", "né"));
        // The head and the tail must not overlap.
        assert!(!matches("ab*ba", "aba") && !matches("*b*b*", "abc") && matches("*b*b*", "abcb"));
    }

    #[test]
    fn many_stars_are_matched_in_linear_time() {
        let name = "a".repeat(200);
        assert!(!matches(&"*a".repeat(100_000), &name));
        assert!(!matches(&format!("{}b", "*a".repeat(100)), &name));
        assert!(matches(&"*a".repeat(200), &name));
    }
}
