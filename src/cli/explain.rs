//! `specforge explain WORD`: the page of a code.

use super::{Exit, Format, Global, output};
use crate::diag::codes;

/// Arguments of `explain`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// A code such as E0203
    #[arg(value_name = "CODE|KIND|UNIT")]
    word: String,
}

/// Prints the page.
pub fn run(options: &Options, global: &Global) -> Exit {
    let word = options.word.trim();
    let Some(page) = codes::page(word) else {
        output::complain(global, &format!("nothing is called `{word}`"), nearest(word).as_deref());
        return Exit::Usage;
    };
    match global.format {
        Format::Json => {
            output::json(&serde_json::json!({ "code": page.code, "title": page.title(), "text": page.text }));
        }
        Format::Human | Format::Github => output::data(page.text),
    }
    Exit::Ok
}

/// The code that the word most likely means.
fn nearest(word: &str) -> Option<String> {
    let word = word.to_uppercase();
    let distance = |code: &str| strsim::damerau_levenshtein(&word, code);
    let page = codes::PAGES.iter().min_by_key(|page| distance(page.code))?;
    (distance(page.code) <= 2).then(|| format!("did you mean `{}`?", page.code))
}
