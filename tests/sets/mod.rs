//! Options `--set` of a small run, some of which a test replaces.

/// The options for the usual assignments and more; those of the same path replace the usual ones.
pub fn options<'a>(usual: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    let path = |set: &'a str| set.split('=').next();
    let kept = usual.iter().filter(|set| more.iter().all(|other| path(other) != path(set)));
    kept.chain(more).flat_map(|set| ["--set", *set]).collect()
}
