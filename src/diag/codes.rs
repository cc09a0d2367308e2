//! The pages for the codes: one Markdown file per code in `codes/`, shown by `specforge explain`.
//!
//! A page is `# CODE: title` and the sections What, Why, Wrong, Right. Independent of who emits a code.

/// The page of one code.
#[derive(Clone, Copy, Debug)]
pub struct Page {
    /// `E0203`.
    pub code: &'static str,
    /// Markdown.
    pub text: &'static str,
}

impl Page {
    /// The text after the code in the first line: `wrong dimension`.
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
    "E0001" "E0002" "E0003" "E0004" "E0005" "E0006" "E0007" "E0008" "E0009"
    "E0101" "E0102" "E0103" "E0104" "E0105" "E0106" "E0107" "E0108" "E0109" "E0110"
    "E0201" "E0202" "E0203" "E0204" "E0205" "E0207" "E0210" "E0211"
    "E0301" "E0302" "E0303" "E0304"
    "E0401" "E0402" "E0403" "E0404" "E0405" "E0406" "E0407" "E0408"
    "E0410" "E0411" "E0412" "E0413" "E0414" "E0415" "E0416"
    "E0420" "E0421" "E0422" "E0423" "E0424" "E0425" "E0426" "E0427" "E0428" "E0429"
    "E0501" "E0502" "E0503" "E0504" "E0505" "E0506" "E0507" "E0508" "E0509" "E0510" "E0511"
    "E0512" "E0513"
    "E0521"
    "E0601" "E0602" "E0603" "E0604" "E0605" "E0606" "E0607" "E0608"
    "E0701" "E0702" "E0703" "E0704" "E0705" "E0706"
    "E0801" "E0802" "E0803" "E0804" "E0805" "E0806" "E0807" "E0808" "E0809" "E0810"
    "E0811" "E0812" "E0813" "E0814" "E0815" "E0816"
    "E0901" "E0902" "E0903" "E0904" "E0905" "E0906"
    "E1001"
    "R0001" "R0002" "R0003" "R0004" "R0005" "R0006" "R0007" "R0008"
    "R0010" "R0011" "R0012" "R0013"
    "W0401"
    "W0410" "W0411" "W0412" "W0413" "W0414" "W0415" "W0416" "W0417" "W0418" "W0419"
    "W0420" "W0421" "W0422" "W0423" "W0424" "W0425" "W0426"
    "W0501" "W0502" "W0503" "W0504" "W0505" "W0506" "W0507" "W0508" "W0509" "W0510" "W0511" "W0512"
    "W0513" "W0514"
    "W0520" "W0521" "W0522" "W0523" "W0524" "W0525" "W0526" "W0527"
    "W0601" "W0602" "W0603" "W0604" "W0605" "W0606" "W0607" "W0608" "W0609" "W0610"
    "W0701" "W0702"
    "W1001" "W1002" "W1003" "W1004"
};

/// The page of a code; upper or lower case.
pub fn page(code: &str) -> Option<&'static Page> {
    PAGES.iter().find(|page| page.code.eq_ignore_ascii_case(code))
}
