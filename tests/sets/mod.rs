//! Options `--set` of a small run, some of which a test replaces.

/// The options for the usual assignments, without those whose path other words of the command line assign.
pub fn usual<'a>(usual: &[&'a str], others: &[&str]) -> Vec<&'a str> {
    let path = |set: &str| set.split('=').next().map(str::to_owned);
    let kept = usual.iter().filter(|set| others.iter().all(|other| path(other) != path(set)));
    kept.flat_map(|set| ["--set", *set]).collect()
}
