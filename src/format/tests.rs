//! Tests of the canonical form: what it changes, and what it never changes.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;

fn formatted(text: &str) -> String {
    format(text, Sort::Spec, &Order::of_this_edition())
}

#[test]
fn sections_and_keys_take_the_order_of_the_registries() {
    let text = "name = \"a\"\nspec = 1\n[learn]\nseed = 1\nkind = \"ppo\"\n[robot]\nmodel = \"atlas\"\n\
                [reward.torque]\nk = \"1 /N/m\"\nweight = 0.1\n[reward.a]\nkind = \"torque\"\n";
    let expected = "spec = 1\nname = \"a\"\n\n[robot]\nmodel = \"atlas\"\n\n\
                    [reward.torque]\nweight = 0.1\nk      = \"1 /N/m\"\n[reward.a]\nkind = \"torque\"\n\n\
                    [learn]\nkind = \"ppo\"\nseed = 1\n";
    assert_eq!(formatted(text), expected);
}

#[test]
fn comments_stay_with_the_lines_that_they_explain() {
    let text = "# About the file.\n#:schema a.json\nspec=1\nname=\"a\" # short\n\n\n[learn]\nseed = 1\n# of \
        the paper\nkind = \"ppo\"\n# gamma = 0.9\n\n# About the robot.\n[robot]\nmodel = \"atlas\"\n# \
        payload = \"3 kg\"\n";
    let expected = format!(
        "# About the file.\n#:schema a.json\nspec = 1\nname = \"a\"{}# short\n\n# About the \
         robot.\n[robot]\nmodel = \"atlas\"\n# payload = \"3 kg\"\n\n[learn]\nseed = 1\n# of the paper\nkind \
         = \"ppo\"\n# gamma = 0.9\n",
        " ".repeat(36)
    );
    assert_eq!(formatted(text), expected);
}

#[test]
fn keys_do_not_cross_blank_lines_and_groups_are_aligned_by_themselves() {
    let text = "[learn]\nlambda = 0.9\ngamma = 0.9\n\nseed = 1\nepochs = 2\nwarm_up = 2\n";
    assert_eq!(
        formatted(text),
        "[learn]\ngamma  = 0.9\nlambda = 0.9\n\nepochs  = 2\nwarm_up = 2\nseed    = 1\n"
    );
}

#[test]
fn values_keep_their_text() {
    let text = "[task]\ncommand={speed={uniform=['0 m/s',\"0.5   m/s\"]}}\nlist = [ 1,\n  2, # two\n]\n\"a \
        b\" . c = 1e-3\n";
    let expected = "[task]\ncommand = {speed={uniform=['0 m/s',\"0.5   m/s\"]}}\nlist    = [ 1,\n  2, # \
        two\n]\n\"a b\".c = 1e-3\n";
    assert_eq!(formatted(text), expected);
}

#[test]
fn dotted_keys_of_a_profile_take_the_order_of_the_sections() {
    let text = "[profile.quick]\nlearn.seed = 1\naction.rate = \"1 Hz\"\nphysics.rate = \"1 \
        Hz\"\n[profile.quick.randomize]\nb.enabled = false\na.enabled = false\n";
    let expected = "[profile.quick]\nphysics.rate = \"1 Hz\"\naction.rate  = \"1 Hz\"\nlearn.seed   = \
        1\n[profile.quick.randomize]\nb.enabled = false\na.enabled = false\n";
    assert_eq!(formatted(text), expected);
}

#[test]
fn a_file_keeps_its_line_ends() {
    assert_eq!(formatted("spec=1\r\n\r\n\r\n  [learn]\r\nseed=1"), "spec = 1\r\n\r\n[learn]\r\nseed = 1\r\n");
    assert_eq!(formatted("\u{feff}spec=1\n[learn]  \nseed=1\r\n"), "spec = 1\n\n[learn]\nseed = 1\n");
    assert_eq!(formatted(""), "");
}

#[test]
fn robots_are_not_aligned_and_links_keep_their_order() {
    let text = "name = \"a\"\n[feet.left]\nlink=\"l\"\n[base]\nmass=\"1 \
        kg\"\nname=\"b\"\n[[links]]\nname=\"l\"\n[links.joint]\nname=\"j\"\n[[links]]\nname=\"k\"\n";
    let expected = "name = \"a\"\n\n[base]\nname = \"b\"\nmass = \"1 kg\"\n\n[[links]]\nname = \
        \"l\"\n[links.joint]\nname = \"j\"\n[[links]]\nname = \"k\"\n\n[feet.left]\nlink = \"l\"\n";
    assert_eq!(format(text, Sort::Robot, &Order::of_this_edition()), expected);
}

#[test]
fn a_suite_ends_with_its_sweep_its_claims_and_its_report() {
    let text = "suite = \"a\"\nspec = 1\n[report]\nfigures = []\n[[claim]]\ntext = \"b\"\nid = \
        \"c\"\n[sweep.x]\nb = {}\na = {}\n[robot]\nmodel = \"atlas\"\n[sweep]\nseeds = 3\n";
    let expected = "spec  = 1\nsuite = \"a\"\n\n[robot]\nmodel = \"atlas\"\n\n[sweep.x]\nb = {}\na = \
        {}\n[sweep]\nseeds = 3\n\n[[claim]]\nid   = \"c\"\ntext = \"b\"\n\n[report]\nfigures = []\n";
    assert_eq!(format(text, Sort::Suite, &Order::of_this_edition()), expected);
}

#[test]
fn what_a_file_describes_is_told_by_its_keys() {
    let sort = |text: &str| {
        let mut sources = crate::diag::Sources::default();
        let source = sources.add("a.toml", text);
        let node = crate::syntax::parse(&sources, source, &mut crate::diag::Sink::default()).expect("TOML");
        Sort::of(node.table().expect("a document is a table"))
    };
    assert_eq!(sort("spec = 1"), Some(Sort::Spec));
    assert_eq!(sort("spec = 1\nsuite = \"a\""), Some(Sort::Suite));
    assert_eq!(sort("base = {}\nlinks = []"), Some(Sort::Robot));
    assert_eq!(sort("kind = \"walk\""), Some(Sort::Motion));
    assert_eq!(sort("[package]\nname = \"a\""), None);
}

/// Random documents: tables, keys, comments and blank lines in any order.
fn document() -> impl Strategy<Value = String> {
    let keys = ["kind", "rate", "std", "delay", "k", "weight", "seed", "strange", "motion"];
    let tables =
        ["learn", "action", "reward.a", "reward.torque", "profile.x", "profile.x.learn", "zebra", "task"];
    let values = ["1", "\"4  ms\"", "[1,\n  2, # inside\n]", "{ a = 1 }", "'''a\n\nb'''", "true"];
    let line = (0..10usize, 0..keys.len(), 0..values.len(), 0..tables.len()).prop_map(
        move |(sort, key, value, table)| match sort {
            0 => "\n".to_owned(),
            1 => format!("# about {key}\n"),
            2 | 3 => format!("[{}]\n", tables[table]),
            4 => format!("  {}  =  {}   # behind\n", keys[key], values[value]),
            5 => format!("a.b{key} . {} = {}\n", keys[key], values[value]),
            _ => format!("{}={}\n", keys[key], values[value]),
        },
    );
    proptest::collection::vec(line, 0..24).prop_map(|lines| lines.concat())
}

/// Number of occurrences of each comment in a text.
fn comments(text: &str) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for line in text.lines() {
        if let Some(at) = line.find('#') {
            *counts.entry(line[at..].trim_end().to_owned()).or_default() += 1;
        }
    }
    counts
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn formatting_is_idempotent_and_keeps_values_and_comments(text in document()) {
        let Ok(before) = toml::from_str::<toml::Table>(&text) else { return Ok(()) };
        for sort in [Sort::Spec, Sort::Suite, Sort::Robot, Sort::Motion] {
            let once = format(&text, sort, &Order::of_this_edition());
            let after = toml::from_str::<toml::Table>(&once);
            prop_assert_eq!(after.as_ref(), Ok(&before), "{}", once);
            prop_assert_eq!(comments(&once), comments(&text), "{}", once);
            prop_assert_eq!(&format(&once, sort, &Order::of_this_edition()), &once);
        }
    }
}
