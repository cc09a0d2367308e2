//! The pages of the parts of a suite other than the sections of its arms: the sweep and the claims.

use serde_json::json;

use super::Page;
use crate::spec::Param;
use crate::spec::claim::keys::Claim;
use crate::spec::typed::Keys;

/// The words explained here.
pub const WORDS: [&str; 3] = ["claim", "suite", "sweep"];

const SUITE: &str = "\
# suite

One spec over many values and seeds, and what that is expected to show. A file with `suite = \"NAME\"` in \
place of `name` is a suite:

  extends                  The spec that all arms have in common; any section may be written below it.
  [sweep]                  The axes and the seeds (`specforge explain sweep`).
  [[claim]]                What is claimed (`specforge explain claim`).
  [report]                 `figures` and `template`; `claims = \"count\"` ends a run with exit code 5 when a \
  claim fails.

`specforge new FILE --suite SPEC` writes one, `specforge plan FILE` shows what its runs share.
";

const SWEEP: &str = "\
# sweep

The axes of a suite. Every combination of their points is an arm; every arm is trained once per seed.

  seeds                    A number, `3`, or a list, `[1, 2, 5]`: what reports take means and intervals over.
  [sweep.AXIS]             An axis, in one of two forms:
    path, values           One value of the spec and what it takes: `path = \"action.stiffness\"`, `values = \
    [\"100 %\", \"50 %\"]`.
    POINT = { ... }        Named points, each with any number of values, or with another parent: `torque = \
    { extends = \"t.toml\" }`.
  zip                      Axes whose points go together instead of multiplying: `zip = [\"stiffness\", \
  \"damping\"]`.
  include, exclude         Combinations that are taken or left out, by some of the axes: \
  `[[sweep.exclude]]`, `control = \"torque\"`.

An arm is called by its points: `control=position,stiffness=50 %`.
";

/// The page of a word about suites.
pub fn page(word: &str) -> Option<Page> {
    let text = match word {
        "claim" => claim(),
        "suite" => SUITE.to_owned(),
        "sweep" => SWEEP.to_owned(),
        _ => return None,
    };
    Some(Page { what: "section", name: word.to_owned(), text, facts: json!({}) })
}

fn claim() -> String {
    let line = |param: &Param| format!("  {:<24} {}\n", param.name, param.doc);
    format!(
        "# claim\n\nWhat a suite is expected to show, one `[[claim]]` each. It is checked before anything \
         runs, and judged by its test \
         afterwards: PASS, FAIL or NOT ESTABLISHED.\n\n{}",
        Claim::PARAMS.iter().map(line).collect::<String>()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_has_a_page_and_every_key_of_a_claim_is_on_it() {
        assert!(WORDS.iter().all(|word| page(word).is_some()) && page("clam").is_none());
        let text = claim();
        assert!(Claim::PARAMS.iter().all(|param| text.contains(&format!("  {} ", param.name))), "{text}");
    }

    #[test]
    fn every_key_of_a_sweep_that_is_no_axis_is_explained() {
        use crate::spec::suite::axis::RESERVED;
        assert!(RESERVED.iter().all(|key| SWEEP.contains(key)));
    }
}
