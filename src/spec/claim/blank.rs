//! The keys of a claim whose text must not be empty. The others have errors of their own.

use super::keys::{Claim, Compare, Over, Paper, Quantifier};

const ARM: &str = "name the arm by its points, `axis=point` joined by commas";
const AXIS: &str = "name an axis of the suite";

/// A key with an empty text.
pub(super) struct Empty {
    /// Its path.
    pub path: String,
    /// What to write.
    pub help: &'static str,
}

/// Whether a text has no letters.
pub(super) fn is_blank(text: &str) -> bool {
    text.trim().is_empty()
}

/// The keys with an empty text, in the order of the reference page.
pub(super) fn of(claim: &Claim) -> Vec<Empty> {
    let mut found = Vec::new();
    let mut look = |path: String, text: Option<&String>, help: &'static str| {
        if text.is_some_and(|text| is_blank(text)) {
            found.push(Empty { path, help });
        }
    };
    let own = |key: &str| key.to_owned();
    look(own(Claim::text.name), Some(&claim.text), "say in a sentence what is claimed");
    let help = "name another stage of the same runs, for example `evaluate.flat`, or remove `baseline`";
    look(own(Claim::baseline.name), claim.baseline.as_ref(), help);
    let help = "name the points of another arm, for example `ground=flat`, or remove `twin`";
    look(own(Claim::twin.name), claim.twin.as_ref(), help);
    if let Some(compare) = &claim.compare {
        look(Compare::a.path(), Some(&compare.a), ARM);
        look(Compare::b.path(), Some(&compare.b), ARM);
    }
    look(own(Claim::arm.name), claim.arm.as_ref(), ARM);
    if let Some(Over::Quantifier(over)) = &claim.over {
        look(Quantifier::some.path(), over.some.as_ref(), AXIS);
        look(Quantifier::none.path(), over.none.as_ref(), AXIS);
        look(Quantifier::trend.path(), over.trend.as_ref(), AXIS);
    }
    let help = "name a test of `specforge list statistic`, or remove `test` for `welch`";
    look(own(Claim::test.name), Some(&claim.test), help);
    let help =
        "name a parameter that the evaluation varies, for example `action_delay`, or remove `parameter`";
    look(own(Claim::parameter.name), claim.parameter.as_ref(), help);
    if let Some(paper) = &claim.paper {
        let help = "say where the paper says it, or remove `paper`";
        look(Paper::r#where.path(), Some(&paper.r#where), help);
        look(
            Paper::value.path(),
            Some(&paper.value),
            "say what the paper says in few words, or remove `paper`",
        );
    }
    found
}
