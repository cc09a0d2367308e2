//! Sweeps from their text: axes, combinations, seeds.

use super::product::arm_name;
use super::{Sweep, is_suite};
use crate::diag::{Sink, Sources};
use crate::syntax::parse;

/// The sweep of a text, or the codes of its mistakes.
fn sweep(text: &str) -> Result<Sweep, Vec<&'static str>> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("suite.toml", text);
    let node = parse(&sources, source, &mut sink).expect("the test's TOML is valid");
    let entry = node.table().expect("a document is a table").entries["sweep"].clone();
    let decoded = Sweep::decode(&entry, None, &mut sink);
    if sink.has_errors() {
        return Err(sink.diagnostics.iter().map(|found| found.code).collect());
    }
    Ok(decoded)
}

/// The names of the arms, in order.
fn arms(text: &str) -> Vec<String> {
    let (sweep, mut sink) = (sweep(text).expect("a sound sweep"), Sink::default());
    let cells = sweep.cells(&mut sink);
    cells.iter().map(|cell| arm_name(&sweep.named(&cell.points), "alone")).collect()
}

const AXES: &str =
    "[sweep]\n[sweep.z]\npath = \"a.b\"\nvalues = [1, 2]\n[sweep.a.one]\nx.y = 1\n[sweep.a.two]\nx.y = 2\n";

#[test]
fn axes_and_points_multiply_in_the_order_of_the_file() {
    assert_eq!(arms(AXES), ["z=1,a=one", "z=1,a=two", "z=2,a=one", "z=2,a=two"]);
}

#[test]
fn a_sweep_without_axes_has_one_arm() {
    assert_eq!(arms("[sweep]\nseeds = 2\n"), ["alone"]);
}

#[test]
fn zipped_axes_go_together_and_stand_where_the_first_of_them_does() {
    let zipped = AXES.replace("[sweep]", "[sweep]\nzip = [\"a\", \"z\"]");
    assert_eq!(arms(&zipped), ["z=1,a=one", "z=2,a=two"]);
    let third = format!("{}[sweep.m]\npath = \"q\"\nvalues = [\"k\", \"l\"]\n", zipped);
    assert_eq!(arms(&third), ["z=1,a=one,m=k", "z=1,a=one,m=l", "z=2,a=two,m=k", "z=2,a=two,m=l"]);
}

#[test]
fn include_restricts_and_exclude_takes_away() {
    let include = format!("{AXES}[[sweep.include]]\nz = 1\n[[sweep.include]]\na = \"two\"\n");
    assert_eq!(arms(&include), ["z=1,a=one", "z=1,a=two", "z=2,a=two"]);
    let both = format!("{include}[[sweep.exclude]]\nz = [1, 2]\na = \"two\"\n");
    assert_eq!(arms(&both), ["z=1,a=one"]);
}

#[test]
fn a_cell_is_alone_on_an_axis_when_no_other_differs_in_that_axis_only() {
    let text = format!("{AXES}[[sweep.exclude]]\nz = 2\na = \"one\"\n");
    let cells = sweep(&text).expect("a sound sweep").cells(&mut Sink::default());
    let alone: Vec<&[bool]> = cells.iter().map(|cell| cell.alone.as_slice()).collect();
    // z=1,a=one has no twin in z; z=2,a=two has none in a.
    assert_eq!(alone, [&[true, false][..], &[false, false], &[false, true]]);
}

#[test]
fn points_of_values_are_called_by_the_value_as_it_is_written() {
    let text = "[sweep]\n[sweep.v]\npath = \"a.b\"\nvalues = [\"100 %\", 1.50, true, [256, 256]]\n";
    assert_eq!(arms(text), ["v=100 %", "v=1.50", "v=true", "v=[256, 256]"]);
}

#[test]
fn a_count_of_seeds_begins_at_one_and_a_list_is_taken_as_it_is() {
    let seeds = |text: &str| -> Vec<u64> {
        let sweep = sweep(text).expect("a sound sweep");
        sweep.seeds.expect("seeds were given").iter().map(|(seed, _)| *seed).collect()
    };
    assert_eq!(seeds("[sweep]\nseeds = 3\n"), [1, 2, 3]);
    assert_eq!(seeds("[sweep]\nseeds = [7, 3]\n"), [7, 3]);
    assert_eq!(sweep("[sweep]\nseeds = 1001\n"), Err(vec!["E0204"]));
    assert_eq!(sweep("[sweep]\nseeds = -1\n"), Err(vec!["E0204"]));
    assert_eq!(sweep("[sweep]\nseeds = 1.5\n"), Err(vec!["E0103"]));
}

#[test]
fn more_combinations_than_anyone_can_run_are_refused_without_making_them() {
    let values: Vec<String> = (0..200).map(|value| value.to_string()).collect();
    let axis = |name: &str| format!("[sweep.{name}]\npath = \"{name}\"\nvalues = [{}]\n", values.join(", "));
    let names = ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j"];
    let text = format!("[sweep]\n{}", names.map(axis).concat());
    let mut sink = Sink::default();
    assert!(sweep(&text).expect("sound axes").cells(&mut sink).is_empty());
    assert_eq!(sink.diagnostics[0].code, "E0204");
}

#[test]
fn a_suite_is_told_by_its_key_before_the_first_table() {
    assert!(is_suite("spec = 1\nsuite = \"x\"\n"));
    assert!(!is_suite("spec = 1\nname = \"x\"\n[sweep]\nsuite = 1\n"));
    assert!(!is_suite("# suite = \"x\"\nsuites = 3\n"));
}

#[test]
fn a_misspelled_key_of_a_sweep_is_not_taken_for_an_axis() {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("suite.toml", "[sweep]\nsedes = [1, 2]\n");
    let node = parse(&sources, source, &mut sink).expect("the test's TOML is valid");
    Sweep::decode(&node.table().expect("a document").entries["sweep"], None, &mut sink);
    let fixes: Vec<_> = sink.diagnostics.iter().filter_map(|found| found.fix.as_ref()).collect();
    assert_eq!(fixes.iter().map(|fix| &*fix.replacement).collect::<Vec<_>>(), ["seeds"]);
}
