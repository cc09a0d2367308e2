//! The pages behind the codes: one Markdown file per code in `codes/`, shown by `specforge explain`.
//!
//! A page is `# CODE: title` and the sections What, Why, Wrong, Right. Knows nothing of who emits a code.

/// The page of one code.
#[derive(Clone, Copy, Debug)]
pub struct Page {
    /// `E0203`.
    pub code: &'static str,
    /// Markdown.
    pub text: &'static str,
}

impl Page {
    /// What stands after the code in the first line: `unit mismatch`.
    pub fn title(&self) -> &'static str {
        let first = self.text.lines().next().unwrap_or_default();
        first.split_once(": ").map_or(first, |(_, title)| title)
    }
}

macro_rules! pages {
    ($($code:literal)*) => {
        &[$(Page { code: $code, text: include_str!(concat!("codes/", $code, ".md")) }),*]
    };
}

/// Every code, sorted.
pub static PAGES: &[Page] = pages! {
    "E0203"
};

/// The page of a code, in either case of letters.
pub fn page(code: &str) -> Option<&'static Page> {
    PAGES.iter().find(|page| page.code.eq_ignore_ascii_case(code))
}
