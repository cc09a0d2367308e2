//! The machinery of migration, with an edition that only these tests know: it renames a key and drops
//! another.

use super::*;

/// Edition 2 of the tests: `action.std` is called `action.exploration`.
fn rename(document: &mut DocumentMut) -> Vec<Change> {
    let Some(action) = document.get_mut("action").and_then(Item::as_table_mut) else { return Vec::new() };
    let Some((key, value)) = action.remove_entry("std") else { return Vec::new() };
    let mut renamed = toml_edit::Key::new("exploration");
    *renamed.leaf_decor_mut() = key.leaf_decor().clone();
    action.insert_formatted(&renamed, value);
    vec![Change { path: "action.std".to_owned(), what: "is now called `exploration`".to_owned() }]
}

/// Edition 3 of the tests: `[report]` is gone.
fn drop_report(document: &mut DocumentMut) -> Vec<Change> {
    let dropped = document.remove("report").is_some();
    let change =
        Change { path: "report".to_owned(), what: "is gone: every run writes all figures".to_owned() };
    dropped.then_some(change).into_iter().collect()
}

const TWO: &[Step] =
    &[Step { from: Edition(1), apply: rename }, Step { from: Edition(2), apply: drop_report }];

fn migrated(text: &str, steps: &[Step]) -> Result<Migrated, Vec<&'static str>> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("a.toml", text);
    let result = migrate(&sources, source, steps, &mut sink);
    result.ok_or_else(|| sink.diagnostics.iter().map(|found| found.code).collect())
}

const OLD: &str = "# About the file.\nspec = 1 # the edition\n\n[action]\n# ten percent\nstd  = \"10 %\" # \
    of the limit\nrate = \"250 Hz\"\n\n[report]\nfigures = []\n";

#[test]
fn a_file_of_the_newest_edition_stays_as_it_is() {
    let same = migrated(OLD, STEPS).expect("edition 1 is known");
    assert_eq!((same.from, same.to, same.text.as_str()), (Edition::ONE, Edition::ONE, OLD));
    assert_eq!(same.changes, []);
}

#[test]
fn steps_are_taken_one_after_the_other_and_comments_stay() {
    let new = migrated(OLD, TWO).expect("edition 1 is known");
    assert_eq!((new.from, new.to), (Edition(1), Edition(3)));
    assert!(new.text.starts_with("# About the file.\nspec = 3 # the edition\n"), "{}", new.text);
    assert!(new.text.contains("# ten percent\nexploration  = \"10 %\" # of the limit\n"), "{}", new.text);
    assert!(!new.text.contains("[report]"));
    let paths: Vec<&str> = new.changes.iter().map(|change| change.path.as_str()).collect();
    assert_eq!(paths, ["action.std", "report"]);
    let again = migrated(&new.text, TWO).expect("edition 3 is known");
    assert_eq!((again.text, again.changes), (new.text, vec![]));
}

#[test]
fn a_file_in_between_takes_only_the_steps_that_it_lacks() {
    let new = migrated(&OLD.replace("spec = 1", "spec = 2"), TWO).expect("edition 2 is known");
    assert!(new.text.contains("std  = \"10 %\"") && !new.text.contains("[report]"), "{}", new.text);
}

#[test]
fn what_has_no_known_edition_is_refused() {
    assert_eq!(migrated("spec = 2\n", STEPS), Err(vec!["E0003"]));
    assert_eq!(migrated("spec = 0\n", TWO), Err(vec!["E0003"]));
    assert_eq!(migrated("spec = \"1\"\n", TWO), Err(vec!["E0003"]));
    assert_eq!(migrated("name = \"a\"\n", TWO), Err(vec!["E0002"]));
    assert_eq!(migrated("spec = \n", TWO), Err(vec!["E0001"]));
}
