//! Pages that were judged by earlier rules: each says so at its top.

/// What such a page says.
pub const NOTICE: &str = "This page was judged by earlier rules: its record has no per-seed values, so its \
    verdicts cannot be computed again.";

/// The page with the notice below its title; `None` when it is there already, or the page has no title.
pub fn marked(page: &str) -> Option<String> {
    if page.lines().any(|line| line == NOTICE) {
        return None;
    }
    let end = page.find('\n').filter(|_| page.starts_with("# "))?;
    let (title, rest) = page.split_at(end + 1);
    Some(format!("{title}\n{NOTICE}\n{rest}"))
}

/// The page without the notice; `None` when it has none.
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
