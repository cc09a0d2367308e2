//! The first lines of the index: the claims that were established, refuted, or are open.

use super::{Index, State};
use crate::escape::markdown::inline;
use crate::report::claim::Ruling;

/// Most claims whose text a line quotes; the tables below have all.
const TOLD: usize = 3;

impl Index {
    /// Three lines on the claims of the paper, if any are, and three on the others.
    pub(super) fn brief(&self) -> String {
        let of_paper = if self.names_paper() { self.lines(true, " of the paper") } else { String::new() };
        let own = if self.chosen(false).next().is_none() {
            String::new()
        } else {
            self.lines(false, if self.names_paper() { " of our own" } else { "" })
        };
        of_paper + &own
    }

    fn lines(&self, of_paper: bool, whose: &str) -> String {
        let mut texts = [(); 3].map(|()| Vec::new());
        let mut waiting = 0;
        for (suite, claim) in self.chosen(of_paper) {
            let State::Judged(judged) = self.state(suite, claim) else {
                waiting += 1;
                continue;
            };
            let place = match judged.verdict {
                Ruling::Pass => 0,
                Ruling::Fail => 1,
                Ruling::NotEstablished | Ruling::NotMeaningful => 2,
            };
            texts[place].push(format!("{} ({})", inline(claim.text.trim_end_matches('.')), self.link(suite)));
        }
        let total = self.chosen(of_paper).count();
        let [established, refuted, open] = texts;
        let judged_open = open.len();
        let line = |head: &str, count: String, texts: Vec<String>| {
            let more = texts.len().saturating_sub(TOLD);
            let rest = if more > 0 { format!("; and {more} more") } else { String::new() };
            let told = texts[..texts.len() - more].join("; ");
            let told = if told.is_empty() { told } else { format!(": {told}{rest}") };
            format!("* **{head}** {count}{told}\n")
        };
        line("Established:", format!("{} of {total} claims{whose}", established.len()), established)
            + &line("Refuted:", refuted.len().to_string(), refuted)
            + &line("Open:", format!("{judged_open} after their runs, {waiting} wait for runs"), open)
    }
}
