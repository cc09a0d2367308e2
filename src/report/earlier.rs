//! The notice at the top of pages that were judged by earlier rules.

/// The notice.
pub const NOTICE: &str = "This page was judged by earlier rules: its record has no per-seed values, so its \
    verdicts cannot be computed again.";

/// Adds the notice below the title; `None` if the page already has it or has no title.
pub fn marked(page: &str) -> Option<String> {
    if page.lines().any(|line| line == NOTICE) {
        return None;
    }
    let end = page.find('\n').filter(|_| page.starts_with("# "))?;
    let (title, rest) = page.split_at(end + 1);
    Some(format!("{title}\n{NOTICE}\n{rest}"))
}

/// Removes the notice; `None` if the page does not have it.
pub fn unmarked(page: &str) -> Option<String> {
    let notice = format!("\n{NOTICE}\n");
    page.contains(&notice).then(|| page.replacen(&notice, "", 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_notice_stands_once_below_the_title() {
        let page = marked("# exp1\n\nWhich stiffness.\n").expect("it is not marked");
        assert_eq!(page, format!("# exp1\n\n{NOTICE}\n\nWhich stiffness.\n"));
        assert_eq!((marked(&page), marked("no title\n")), (None, None));
        assert_eq!(unmarked(&page).as_deref(), Some("# exp1\n\nWhich stiffness.\n"));
        assert_eq!(unmarked("# exp1\n"), None);
    }
}
