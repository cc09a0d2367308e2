//! Tests of what a schema accepts: patterns for quantities of a dimension, lengths of lists.

use serde_json::{Value, json};

use super::table::{self, Keys};
use super::{Definitions, pattern};
use crate::quantity::unit::{PREFIXES, UNITS};
use crate::quantity::{Dimension, quantity};
use crate::spec::{Length, Param, Ty};

/// The dimensions of keys, and the units for each.
const WRITTEN: &[(Dimension, &[&str])] = &[
    (Dimension::LENGTH, &["m", "cm", "mm"]),
    (Dimension::TIME, &["s", "ms", "min", "h"]),
    (Dimension::RATE, &["Hz", "kHz", "/s"]),
    (Dimension::ANGLE, &["rad", "deg", "mrad"]),
    (Dimension::VELOCITY, &["m/s", "km/h", "mm / s"]),
    (Dimension::ANGULAR_VELOCITY, &["rad/s", "deg/s", "rpm"]),
    (Dimension::FORCE, &["N", "kN", "kg*m/s^2"]),
    (Dimension::TORQUE, &["N*m", "m*N", "J", "kg*m^2/s^2"]),
    (Dimension::IMPULSE, &["N*s", "kg*m/s"]),
    (Dimension::INERTIA, &["kg*m^2", "g * mm^2"]),
    (Dimension::STIFFNESS, &["N*m/rad", "N*m/deg"]),
    (Dimension::DAMPING, &["N*m*s/rad", "J*s/rad"]),
    (Dimension::PER_ANGLE, &["/rad"]),
    (Dimension::PER_ANGLE_SQUARED, &["/rad^2"]),
    (Dimension::PER_VELOCITY_SQUARED, &["s^2/m^2"]),
    (Dimension::PER_ANGULAR_VELOCITY_SQUARED, &["s^2/rad^2"]),
    (Dimension::PER_FORCE, &["/N"]),
    (Dimension::PER_TORQUE, &["/N/m", "/m/N", "/J"]),
];

fn matches(pattern: &str, text: &str) -> bool {
    regex_lite::Regex::new(pattern).expect("a regular expression").is_match(text)
}

#[test]
fn a_pattern_takes_the_spellings_of_its_dimension_and_of_no_other() {
    for (dimension, units) in WRITTEN {
        let pattern = pattern::quantity(*dimension);
        for unit in *units {
            assert_eq!(quantity(&format!("1 {unit}")).expect("a unit").dimension, *dimension, "{unit}");
            for number in ["1", "-0.5", "1e-4", "+2.", ".5", "1_000"] {
                assert!(matches(&pattern, &format!("{number} {unit}")), "{number} {unit}: {pattern}");
            }
        }
        let others =
            WRITTEN.iter().filter(|(other, _)| other != dimension).flat_map(|(_, units)| units.iter());
        for unit in others {
            assert!(!matches(&pattern, &format!("1 {unit}")), "{unit} is not {}", dimension.name());
        }
        for wrong in ["1", "m", "", "1 furlong", "1 %", "inf s", "1 N m"] {
            assert!(!matches(&pattern, wrong), "`{wrong}` is not {}", dimension.name());
        }
    }
}

#[test]
fn a_pattern_takes_nothing_that_the_language_refuses() {
    let mut units: Vec<String> = UNITS.iter().map(|unit| unit.symbol.to_owned()).collect();
    for unit in UNITS.iter().filter(|unit| unit.prefixed) {
        units.extend(PREFIXES.iter().map(|(prefix, _)| format!("{prefix}{}", unit.symbol)));
    }
    units.extend(["kmin", "mh", "kdeg", "krpm", "x", "Ms^2"].map(str::to_owned));
    for (dimension, _) in WRITTEN {
        let pattern = pattern::quantity(*dimension);
        for unit in &units {
            for text in
                [format!("1 {unit}"), format!("1 {unit}/s"), format!("1 /{unit}"), format!("1 N*{unit}")]
            {
                let legal = quantity(&text).is_ok_and(|parsed| parsed.dimension == *dimension);
                assert!(legal || !matches(&pattern, &text), "`{text}` is not {}", dimension.name());
            }
        }
    }
}

#[test]
fn counts_and_ratios_have_patterns_of_their_own() {
    for good in ["80 M", "200 k", "16384", "1.5M"] {
        assert!(matches(&pattern::count(), good), "{good}");
    }
    assert!(!matches(&pattern::count(), "80 m") && !matches(&pattern::count(), "many"));
    assert!(matches(&pattern::ratio(), "12.5 %") && !matches(&pattern::ratio(), "12.5"));
}

#[test]
fn a_list_has_the_length_that_its_key_asks_for_and_a_form_without_a_list_none() {
    const LIST: Ty = Ty::List(&Ty::Number);
    let schema = |ty: Ty, length| {
        table::key(&Param::optional("a", ty).length(length), &mut Definitions::new(Keys::Some))
    };
    let bounds = |schema: &Value| [schema["minItems"].clone(), schema["maxItems"].clone()];
    assert_eq!(bounds(&schema(LIST, Length::Some)), [json!(1), Value::Null]);
    assert_eq!(bounds(&schema(LIST, Length::Each(&["low", "high"]))), [json!(2), json!(2)]);
    let angles = schema(LIST, Length::OneOrEach(&["roll", "pitch", "yaw"]));
    assert_eq!(
        angles["anyOf"].as_array().expect("two lengths").iter().map(bounds).collect::<Vec<_>>(),
        [[json!(1), json!(1)], [json!(3), json!(3)]]
    );
    let forms = schema(Ty::OneOf(&[Ty::Number, LIST]), Length::Some)["anyOf"].clone();
    assert_eq!([bounds(&forms[0]), bounds(&forms[1])], [[Value::Null, Value::Null], [json!(1), Value::Null]]);
}
