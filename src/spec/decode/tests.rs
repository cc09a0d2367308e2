use super::*;
use crate::quantity::Dimension;
use crate::spec::typed::units::Radian;
use crate::spec::typed::{Sampled, Typed};
use crate::spec::{Edition, Sampler, Share};

const NETWORK: &[Param] = &[
    Param::default("hidden", Ty::List(&Ty::Count), "[256, 256]").range(1.0, 8192.0),
    Param::default("activation", Ty::Choice(&["relu", "tanh"]), "\"relu\""),
];

const RATE: Ty = Ty::OneOf(&[
    Ty::Number,
    Ty::Table(&[Param::required("linear", Ty::List(&Ty::Number))]),
    Ty::Table(&[Param::required("target", Ty::Number), Param::required("start", Ty::Number)]),
]);

static PARAMS: &[Param] = &[
    Param::required("rate", Ty::Quantity(Dimension::RATE)).range(1.0, 1e5),
    Param::default("delay", Ty::Quantity(Dimension::TIME), "\"4 ms\""),
    Param::optional("std", Ty::Ratio(Share::of("the effort limit"))).range(0.0, 1.0),
    Param::optional("scale", Ty::Sampler(Dimension::NONE)),
    Param::optional("noise", Ty::Sampler(Dimension::ANGLE)).range(-3.15, 3.15),
    Param::optional("samples", Ty::Count).range(1.0, 1e9),
    Param::optional("modulated", Ty::Flag),
    Param::optional("engine", Ty::Choice(&["rapier", "mujoco"])),
    Param::optional("learning_rate", RATE),
    Param::default("policy", Ty::Table(NETWORK), "{}"),
    Param::optional("com", Ty::List(&Ty::Quantity(Dimension::LENGTH))),
    Param::optional("ends", Ty::List(&Ty::Number)).length(Length::Each(&["low", "high"])),
    Param::optional("angles", Ty::List(&Ty::Number)).length(Length::OneOrEach(&["roll", "pitch", "yaw"])),
    Param::optional("speeds", Ty::List(&Ty::Number)).length(Length::Some),
    Param::optional("mass", Ty::Sampler(Dimension::MASS)).range(0.0, 1e3),
    Param::optional("joints", Ty::Named(&Ty::Quantity(Dimension::ANGLE))),
    Param::optional("feet", Ty::List(&Ty::Table(FOOT))),
];

const FOOT: &[Param] =
    &[Param::required("link", Ty::Text), Param::required("mass", Ty::Quantity(Dimension::MASS))];

fn decoded(text: &str) -> Result<Decoded, Vec<Diagnostic>> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("a.toml", text);
    document(&sources, source, PARAMS, &mut sink).ok_or(sink.diagnostics)
}

fn codes(text: &str) -> Vec<&'static str> {
    decoded(text).expect_err("has mistakes").iter().map(|diagnostic| diagnostic.code).collect()
}

/// The only diagnostic of a line next to a valid `rate`, and the text that it points to.
fn mistake(line: &str) -> (Diagnostic, String) {
    let text = format!("rate = \"1 Hz\"\n{line}\n");
    let mut diagnostics = decoded(&text).expect_err("has a mistake");
    assert_eq!(diagnostics.len(), 1, "{diagnostics:#?}");
    let diagnostic = diagnostics.remove(0);
    let span = diagnostic.labels[0].span;
    (diagnostic, text[span.start..span.end].to_owned())
}

fn fixed(line: &str) -> (&'static str, String) {
    let (diagnostic, _) = mistake(line);
    (diagnostic.code, diagnostic.fix.expect("an edit").replacement)
}

/// A number.
fn number(section: crate::spec::Section, key: &str) -> f64 {
    section.get(key).and_then(f64::read).expect("a number")
}

/// A word.
fn text(section: crate::spec::Section, key: &str) -> String {
    section.get(key).and_then(String::read).expect("a word")
}

/// The numbers of a list.
fn numbers(section: crate::spec::Section, key: &str) -> Vec<f64> {
    section.get(key).and_then(Vec::<f64>::read).expect("a list of numbers")
}

#[test]
fn values_are_in_si_and_defaults_are_filled_in() {
    let table =
        decoded("rate = \"0.5 kHz\"\nsamples = \"80 M\"\nstd = \"12.5 %\"\ncom = [\"7 cm\", \"0 m\"]")
            .expect("sound")
            .table;
    let section = crate::spec::Section::new(&table);
    assert_eq!(number(section, "rate"), 500.0);
    assert_eq!(number(section, "delay"), 0.004);
    assert_eq!(number(section, "samples"), 80e6);
    assert_eq!(number(section, "std"), 0.125);
    assert_eq!(numbers(section, "com"), [0.07, 0.0]);
    assert!(section.get("engine").is_none());
    let policy = section.section("policy").expect("a default table");
    assert_eq!(text(policy, "activation"), "relu");
    assert_eq!(numbers(policy, "hidden"), [256.0, 256.0]);
}

#[test]
fn a_table_that_is_written_in_part_keeps_the_other_defaults() {
    let table = decoded("rate = \"1 Hz\"\npolicy.activation = \"tanh\"").expect("sound").table;
    let policy = crate::spec::Section::new(&table).section("policy").expect("there");
    assert_eq!((text(policy, "activation").as_str(), numbers(policy, "hidden").len()), ("tanh", 2));
}

#[test]
fn samplers_are_plain_values_or_one_distribution() {
    let sampler = |line: &str| {
        let table = decoded(&format!("rate = \"1 Hz\"\n{line}")).expect("sound").table;
        Sampled::<Radian>::read(&table["noise"]).expect("a distribution")
    };
    assert_eq!(sampler("noise = \"0.1 rad\""), Sampler::Constant(0.1));
    assert_eq!(sampler("noise = { normal = [\"0 rad\", \"1e-4 rad\"] }"), Sampler::Normal([0.0, 1e-4]));
    assert_eq!(
        sampler("noise = { choice = [\"1 rad\", \"180 deg\"] }"),
        Sampler::Choice(vec![1.0, std::f64::consts::PI])
    );
    assert_eq!(sampler("noise = { log_uniform = [\"1 rad\", \"2 rad\"] }"), Sampler::LogUniform([1.0, 2.0]));
}

#[test]
fn the_shape_of_a_value_chooses_among_several_types() {
    for (line, key) in [
        ("1e-4", None),
        ("{ linear = [1, 2] }", Some("linear")),
        ("{ target = 1, start = 2 }", Some("start")),
    ] {
        let table = decoded(&format!("rate = \"1 Hz\"\nlearning_rate = {line}")).expect("sound").table;
        match (&table["learning_rate"], key) {
            (Value::Table(table), Some(key)) => assert!(table.contains_key(key)),
            (Value::Quantity(quantity), None) => assert_eq!(quantity.si, 1e-4),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(mistake("learning_rate = true").0.code, "E0103");
}

#[test]
fn units_that_are_missing_unknown_or_wrong_are_told_apart() {
    assert_eq!(fixed("delay = 0.05"), ("E0201", "\"0.05 s\"".to_owned()));
    // More than half a turn is in degrees.
    assert_eq!(fixed("noise = { uniform = [\"-1 rad\", 30] }"), ("E0201", "\"30 deg\"".to_owned()));
    assert_eq!(fixed("delay = \"0.05\""), ("E0201", "\"0.05 s\"".to_owned()));
    assert_eq!(mistake("delay = 0.05").0.message, "a duration needs a unit");
    assert_eq!(fixed("std = 0.1"), ("E0201", "\"10 %\"".to_owned()));
    assert_eq!(fixed("delay = \"4 sec\""), ("E0202", "s".to_owned()));
    let (diagnostic, place) = mistake("delay = \"4 ms/rad\"");
    assert_eq!((diagnostic.code, place.as_str()), ("E0203", "ms/rad"));
    let (diagnostic, place) = mistake("joints.knee = \"0.8 rad/s\"");
    assert_eq!((diagnostic.code, place.as_str()), ("E0203", "rad/s"));
    assert_eq!(diagnostic.message, "wrong dimension: expected an angle, found an angular velocity");
    assert_eq!(diagnostic.labels[0].text, "`rad/s` is an angular velocity");
    assert_eq!(mistake("std = \"3 N\"").0.code, "E0203");
}

#[test]
fn values_out_of_range_or_not_finite_are_refused() {
    let (diagnostic, place) = mistake("std = \"150 %\"");
    assert_eq!((diagnostic.code, place.as_str()), ("E0204", "\"150 %\""));
    assert_eq!(diagnostic.help, ["it must be between 0 % and 100 %"]);
    let (diagnostic, _) = mistake("noise = \"200 deg\"");
    assert_eq!(diagnostic.help[0], "it must be between -3.15 rad and 3.15 rad (-180.4 deg and 180.4 deg)");
    assert_eq!(mistake("samples = 0").0.code, "E0204");
    assert_eq!(mistake("policy.hidden = [0]").0.code, "E0204");
    assert_eq!(mistake("delay = \"1e999 s\"").0.code, "E0205");
    assert_eq!(mistake("learning_rate = inf").0.code, "E0205");
    assert_eq!(mistake("noise = { uniform = [\"nan rad\", \"1 rad\"] }").0.code, "E0205");
}

#[test]
fn empty_ranges_and_scales_that_are_not_positive_are_refused() {
    assert_eq!(fixed("scale = { uniform = [1.4, 0.6] }"), ("E0210", "[0.6, 1.4]".to_owned()));
    assert_eq!(mistake("scale = { choice = [] }").0.code, "E0210");
    assert_eq!(mistake("noise = { normal = [\"0 rad\", \"-1 rad\"] }").0.code, "E0210");
    assert_eq!(mistake("scale = { uniform = [0.0, 1.5] }").0.code, "E0211");
    assert_eq!(mistake("scale = { log_uniform = [0, 1.5] }").0.code, "E0211");
    assert_eq!(mistake("scale = -1").0.code, "E0211");
    assert_eq!(mistake("scale = { unifrom = [1, 2] }").0.code, "E0102");
    assert_eq!(mistake("scale = { uniform = [1] }").0.code, "E0103");
    assert_eq!(mistake("scale = { uniform = [1, 2], normal = [1, 2] }").0.code, "E0103");
}

#[test]
fn wrong_types_get_the_edit_when_it_is_obvious() {
    assert_eq!(fixed("modulated = \"true\""), ("E0103", "true".to_owned()));
    assert_eq!(fixed("modulated = \"True\""), ("E0103", "true".to_owned()));
    assert_eq!(fixed("learning_rate.linear = [\".5\", 1]"), ("E0103", "0.5".to_owned()));
    assert_eq!(fixed("learning_rate.linear = [\"0.3\", 1]"), ("E0103", "0.3".to_owned()));
    assert_eq!(fixed("engine = \"rapeir\""), ("E0106", "\"rapier\"".to_owned()));
    assert_eq!(fixed("policy.hidden = 256"), ("E0103", "[256]".to_owned()));
    let help = |text: &str| mistake(text).0.help.concat();
    assert_eq!(help("policy.hidden.0 = 64"), "write `hidden = [64]`");
    assert_eq!(help("policy.hidden = { 0 = 64, 1 = 32 }"), "write `hidden = [64, 32]`");
    assert!(!help("policy.hidden = { size = 64 }").contains('{'));
    assert_eq!(mistake("samples = 1.5").0.code, "E0103");
    assert_eq!(mistake("samples = \"3 Q\"").0.code, "E0202");
    assert_eq!(mistake("policy = 3").0.code, "E0103");
    assert_eq!(mistake("delay = \"soon\"").0.code, "E0103");
    assert_eq!(mistake("delay = 1979-05-27").0.code, "E0103");
}

#[test]
fn lists_have_as_many_items_as_their_key_asks_for() {
    let help = |line: &str| {
        let (diagnostic, _) = mistake(line);
        (diagnostic.code, diagnostic.message, diagnostic.help.concat())
    };
    let said = |message: &str, help: &str| ("E0103", message.to_owned(), help.to_owned());
    assert_eq!(
        help("ends = [1, 2, 3]"),
        said("`ends` takes a list of 2, found 3", "write `ends = [low, high]`")
    );
    let or_one = "write `angles = [roll, pitch, yaw]`, or one number for all";
    assert_eq!(help("angles = [1, 2]"), said("`angles` takes a list of 1 or 3, found 2", or_one));
    let one = "write at least one, for example `speeds = [1]`";
    assert_eq!(help("speeds = []"), said("`speeds` takes a list of 1 or more, found none", one));
    for line in ["ends = [1, 2]", "angles = [1]", "angles = [1, 2, 3]", "speeds = [1, 2, 3, 4]"] {
        assert!(decoded(&format!("rate = \"1 Hz\"\n{line}")).is_ok(), "{line}");
    }
}

#[test]
fn a_normal_distribution_stays_within_the_bounds_to_three_deviations() {
    let (diagnostic, place) = mistake("mass = { normal = [\"3 kg\", \"2 kg\"] }");
    assert_eq!((diagnostic.code, place.as_str()), ("E0204", "[\"3 kg\", \"2 kg\"]"));
    let help = "three standard deviations around the mean reach from -3 kg to 9 kg: lower the standard deviation, or use `uniform`";
    assert_eq!(diagnostic.help.last().map(String::as_str), Some(help));
    assert_eq!(mistake("scale = { normal = [1.0, 0.5] }").0.code, "E0211");
    assert!(
        decoded("rate = \"1 Hz\"\nmass = { normal = [\"0.3 kg\", \"0.1 kg\"] }").is_ok(),
        "0.3 - 3 * 0.1 is zero"
    );
}

#[test]
fn counts_tell_what_is_wrong_with_them() {
    assert_eq!(mistake("samples = \"-1 M\"").0.code, "E0204");
    assert_eq!(mistake("samples = \"99999999999 M\"").0.code, "E0204");
    let (fraction, _) = mistake("samples = \"1.23456789 M\"");
    assert_eq!(fraction.message, "`samples` takes a whole number, found \"1.23456789 M\"");
    assert_eq!(mistake("samples = 18446744073709551615").0.code, "E0204");
}

#[test]
fn of_several_tables_the_one_with_a_key_that_is_written_is_meant() {
    let (diagnostic, _) = mistake("learning_rate = { target = 0.01 }");
    assert_eq!(diagnostic.message, "missing key `start` in `learning_rate`");
}

#[test]
fn unknown_keys_get_a_suggestion_or_the_list() {
    assert_eq!(fixed("dealy = \"4 ms\""), ("E0102", "delay".to_owned()));
    let (diagnostic, place) = mistake("policy.gravity = 1");
    assert_eq!((diagnostic.code, place.as_str()), ("E0102", "gravity"));
    assert_eq!(diagnostic.help, ["the valid keys are `activation` and `hidden`"]);
}

#[test]
fn what_elements_of_a_list_lack_alike_is_one_mistake() {
    let (diagnostic, place) =
        mistake("feet = [{ link = \"a\" }, { link = \"b\" }, { link = \"c\", mass = \"1 kg\" }]");
    assert_eq!(diagnostic.message, "missing key `mass` in `feet.0` and in 1 more of `feet`");
    assert_eq!((diagnostic.code, place.as_str()), ("E0101", "{ link = \"a\" }"));
    assert_eq!(codes("rate = \"1 Hz\"\nfeet = [{ link = \"a\" }, { mass = \"1 kg\" }]"), ["E0101", "E0101"]);
}

#[test]
fn all_mistakes_are_reported_in_one_run_and_each_once() {
    let text = "dealy = 1\nstd = 0.1\nsamples = \"x\"\npolicy.hidden = [0, \"a\"]\nnoise = \
        { uniform = [\"2 rad\", \"1 s\"] }";
    let mut found = codes(text);
    found.sort_unstable();
    assert_eq!(found, ["E0101", "E0102", "E0103", "E0103", "E0201", "E0203", "E0204"]);
}

#[test]
fn every_value_knows_its_place_its_layer_and_its_text() {
    let text = "rate = \"1 Hz\"\ncom = [\"1 m\", \"2 m\"]\n";
    let marks = decoded(text).expect("sound").marks;
    let rate = marks.get("rate").expect("written");
    assert_eq!(&text[rate.value.start..rate.value.end], "\"1 Hz\"");
    assert_eq!((rate.layer, rate.text.as_str()), (Layer::File, "\"1 Hz\""));
    assert_eq!(marks.get("delay").expect("a default").layer, Layer::Default);
    assert_eq!(marks.get("com.1").expect("an item").text, "\"2 m\"");
    assert_eq!(marks.nearest("com[1].unit").expect("the item"), marks.get("com.1").expect("an item"));
}

static TORQUE: Kind = Kind {
    name: "torque",
    since: Edition::ONE,
    doc: "",
    params: &[Param::required("std", Ty::Number)],
    needs: &[],
};
static POSITION: Kind = Kind {
    name: "position",
    since: Edition::ONE,
    doc: "",
    params: &[Param::required("stiffness", Ty::Number)],
    needs: &[],
};
static LATER: Kind = Kind { name: "later", since: Edition(2), doc: "", params: &[], needs: &[] };

fn of_kind(text: &str) -> Result<Table, Vec<(&'static str, Option<String>)>> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("a.toml", text);
    let decoded = document_of_kind(&sources, source, &[&TORQUE, &POSITION, &LATER], &mut sink);
    decoded.map(|decoded| decoded.table).ok_or_else(|| {
        sink.diagnostics.into_iter().map(|error| (error.code, error.fix.map(|fix| fix.replacement))).collect()
    })
}

#[test]
fn a_kind_chooses_the_keys() {
    let table = of_kind("kind = \"torque\"\nstd = 0.1").expect("sound");
    assert_eq!(table["kind"], Value::Text("torque".to_owned()));
    assert_eq!(of_kind("kind = \"torqe\"\nstd = 1"), Err(vec![("E0301", Some("\"torque\"".to_owned()))]));
    assert_eq!(of_kind("kind = \"torque\"\nstd = 1\nstiffness = 2"), Err(vec![("E0105", None)]));
    assert_eq!(of_kind("kind = \"later\""), Err(vec![("E0302", None)]));
    assert_eq!(of_kind("std = 1"), Err(vec![("E0101", None)]));
    assert_eq!(of_kind("kind = 3"), Err(vec![("E0103", None)]));
}

#[test]
fn a_line_to_fill_in_is_no_valid_value() {
    for param in PARAMS {
        let rate = if param.name == "rate" { "" } else { "rate = \"1 Hz\"\n" };
        let text = format!("{rate}{} = {}\n", param.name, super::choice::blank(&param.ty));
        assert!(decoded(&text).is_err(), "{text}");
    }
    let found = decoded("std = \"1 %\"").expect_err("the rate is missing");
    assert_eq!(found[0].help, ["add the line `rate = \"<number> Hz\"`"]);
}
