//! A declaration gives the keys, the struct and the paths.

use super::units::{Metre, Second};
use super::{
    Declared, InSection, Key, Keys, Quantified, Ratio, Sampled, Typed, choice, either, keys, kind, reference,
};
use crate::spec::{Length, Presence, Quantity, Sampler, Section, Share, Signal, Table, Ty, Value};

reference! {
    /// What a gain is a share of.
    OwnGain = "the robot's own gain";
}

choice! {
    /// A rule.
    enum Rule {
        /// As the root.
        Root = "sqrt",
        /// As it is.
        Linear = "linear",
    }
}

either! {
    /// A rule or a share.
    #[derive(Copy)]
    enum Gain {
        /// A rule.
        Rule(Rule),
        /// A share.
        Share(Ratio<OwnGain>),
    }
}

keys! {
    /// Keys of several tables.
    struct Common in "thing" {
        /// How many.
        #[default("3")]
        count: u64,
    }
}

kind! {
    struct Thing in "thing" = "tests", needs [Torque] {
        /// How long it is,
        /// in two lines.
        #[range(0.0, 5.0)]
        length: Quantified<Metre>,
        /// When.
        at: Option<Sampled<Second>>,
        /// Its gain.
        gain: Gain,
        /// Widths.
        #[length(Length::Some)]
        widths: Vec<u64>,
        ..common: Common,
    }
}

fn quantity(si: f64) -> Value {
    Value::Quantity(Quantity { si, text: String::new() })
}

fn table() -> Table {
    Table::from([
        ("length".into(), quantity(1.5)),
        ("gain".into(), Value::Text("sqrt".into())),
        ("widths".into(), Value::List(vec![Value::Count(2), Value::Count(3)])),
        ("count".into(), Value::Count(4)),
    ])
}

#[test]
fn a_declaration_gives_the_keys_with_everything_about_them() {
    let [length, at, gain, widths, count] = Thing::PARAMS else { panic!("five keys: {:?}", Thing::PARAMS) };
    assert_eq!(
        (length.name, length.doc, length.range),
        ("length", "How long it is, in two lines.", Some((0.0, 5.0)))
    );
    assert!(matches!((length.ty, length.presence), (Ty::Quantity(_), Presence::Required)));
    assert!(matches!((at.ty, at.presence), (Ty::Sampler(_), Presence::Optional)));
    assert!(matches!(
        gain.ty,
        Ty::OneOf([Ty::Choice(["sqrt", "linear"]), Ty::Ratio(Share { of: "the robot's own gain", .. })])
    ));
    assert_eq!(widths.length, Some(Length::Some));
    assert!(matches!(count.presence, Presence::Default("3")));
    assert_eq!((Thing::KIND.name, Thing::KIND.needs), ("tests", [Signal::Torque].as_slice()));
}

#[test]
fn a_decoded_table_is_the_struct() {
    let thing = Section::new(&table()).read::<Thing>();
    let common = Common { count: 4 };
    assert_eq!(
        thing,
        Thing { length: 1.5, at: None, gain: Gain::Rule(Rule::Root), widths: vec![2, 3], common }
    );
    let mut other = table();
    other.insert("at".into(), quantity(2.0));
    other.insert("gain".into(), quantity(0.5));
    let thing = Section::new(&other).read::<Thing>();
    assert_eq!((thing.at, thing.gain), (Some(Sampler::Constant(2.0)), Gain::Share(0.5)));
    other.remove("count");
    assert_eq!(Section::new(&other).read::<Thing>().common, Common { count: 3 }, "the default");
    other.remove("length");
    assert_eq!(Thing::of_table(&other), None, "a table without a key that must be written");
}

#[test]
fn a_key_finds_its_value_and_its_place() {
    let table = table();
    let section = Section::new(&table);
    assert_eq!((section.value(Thing::length), section.value(Thing::at)), (Some(1.5), None));
    assert!(section.holds(Common::count) && !section.holds(Thing::at));
    assert_eq!((Thing::length.path(), Common::count.path()), ("thing.length".into(), "thing.count".into()));
    let free: Key<(), bool> = Key::new("flag");
    assert_eq!((free.below("a.b"), Thing::SECTION), ("a.b.flag".into(), "thing"));
    assert_eq!((Rule::Root.word(), Rule::read(&Value::Text("none".into()))), ("sqrt", None));
}
