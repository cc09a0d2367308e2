//! The closed list of units and SI prefixes.
//!
//! A unit is a dimension and a scale to SI. The scale is stored as a power of ten times a factor, so that `4
//! ms` and `0.004 s` are exactly the same number.

use super::Dimension;

/// A unit of the language.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Its symbol.
    pub symbol: &'static str,
    /// Its dimension.
    pub dimension: Dimension,
    /// Power of ten of its size in SI units.
    pub exponent: i32,
    /// The rest of its size in SI units.
    pub factor: f64,
    /// Whether it takes SI prefixes.
    pub prefixed: bool,
    /// Its name, for the reference.
    pub name: &'static str,
}

/// A unit with its own factor and without prefixes.
const fn plain(symbol: &'static str, dimension: Dimension, factor: f64, name: &'static str) -> Unit {
    Unit { symbol, dimension, exponent: 0, factor, prefixed: false, name }
}

/// A coherent SI unit, which takes prefixes.
const fn si(symbol: &'static str, dimension: Dimension, name: &'static str) -> Unit {
    Unit { symbol, dimension, exponent: 0, factor: 1.0, prefixed: true, name }
}

/// Every unit of the language.
pub const UNITS: &[Unit] = &[
    si("m", Dimension::LENGTH, "metre"),
    Unit { exponent: -3, ..si("g", Dimension::MASS, "gram") },
    si("s", Dimension::TIME, "second"),
    plain("min", Dimension::TIME, 60.0, "minute"),
    plain("h", Dimension::TIME, 3600.0, "hour"),
    si("N", Dimension::FORCE, "newton"),
    si("Pa", Dimension::new(-1, 1, -2, 0, 0), "pascal"),
    si("rad", Dimension::ANGLE, "radian"),
    plain("deg", Dimension::ANGLE, std::f64::consts::PI / 180.0, "degree"),
    si("Hz", Dimension::RATE, "hertz"),
    plain("rpm", Dimension::ANGULAR_VELOCITY, std::f64::consts::TAU / 60.0, "revolution per minute"),
    si("W", Dimension::new(2, 1, -3, 0, 0), "watt"),
    si("J", Dimension::TORQUE, "joule"),
    si("V", Dimension::new(2, 1, -3, -1, 0), "volt"),
    si("A", Dimension::new(0, 0, 0, 1, 0), "ampere"),
    Unit { exponent: -2, ..plain("%", Dimension::NONE, 1.0, "percent of the reference that the key names") },
];

/// The SI prefixes of the language and their powers of ten.
pub const PREFIXES: &[(&str, i32)] =
    &[("n", -9), ("u", -6), ("µ", -6), ("m", -3), ("c", -2), ("k", 3), ("M", 6), ("G", 9)];

/// The unit with this symbol, including a prefix.
pub fn find(symbol: &str) -> Option<Unit> {
    let exact = |symbol: &str| UNITS.iter().find(|unit| unit.symbol == symbol).copied();
    exact(symbol).or_else(|| {
        PREFIXES.iter().find_map(|(prefix, exponent)| {
            let unit = exact(symbol.strip_prefix(prefix)?)?;
            unit.prefixed.then_some(Unit { exponent: unit.exponent + exponent, ..unit })
        })
    })
}

/// Common wrong spellings of units, with the correct one.
const ALIASES: &[(&str, &str)] = &[
    ("sec", "s"),
    ("second", "s"),
    ("seconds", "s"),
    ("hr", "h"),
    ("hour", "h"),
    ("hours", "h"),
    ("minute", "min"),
    ("minutes", "min"),
    ("meter", "m"),
    ("meters", "m"),
    ("metre", "m"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("°", "deg"),
    ("radian", "rad"),
    ("radians", "rad"),
    ("rads", "rad"),
    ("hertz", "Hz"),
    ("kilogram", "kg"),
    ("newton", "N"),
    ("percent", "%"),
    ("Nm", "N*m"),
    ("Nms", "N*m*s"),
    ("Ns", "N*s"),
];

/// The probably intended unit.
pub fn suggest(symbol: &str) -> Option<String> {
    // The Greek letter looks like the micro sign.
    if let Some(micro) =
        symbol.strip_prefix('\u{3bc}').map(|unit| format!("u{unit}")).filter(|unit| find(unit).is_some())
    {
        return Some(micro);
    }
    if let Some((_, unit)) = ALIASES.iter().find(|(alias, _)| alias.eq_ignore_ascii_case(symbol)) {
        return Some((*unit).to_owned());
    }
    let written = ["kg", "ms", "mm", "cm", "km", "kHz"];
    let known = UNITS.iter().map(|unit| unit.symbol).chain(written);
    let mut known: Vec<&str> = known.collect();
    known.sort_by_key(|unit| (strsim::damerau_levenshtein(unit, symbol), unit.len()));
    known.iter().find(|unit| unit.eq_ignore_ascii_case(symbol)).or(known.first()).and_then(|unit| {
        let near = unit.eq_ignore_ascii_case(symbol)
            || (symbol.len() > 1 && strsim::damerau_levenshtein(unit, symbol) <= symbol.len() / 3);
        near.then(|| (*unit).to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prefixes_scale_si_units_and_no_others() {
        assert_eq!(find("kg").expect("kg").exponent, 0);
        assert_eq!(find("mm").expect("mm").exponent, -3);
        assert_eq!(find("min").expect("min").factor, 60.0);
        assert_eq!(find("ms").expect("ms").dimension, Dimension::TIME);
        assert!(find("kmin").is_none());
        assert!(find("m%").is_none());
        assert!(find("kdeg").is_none());
    }

    #[test]
    fn a_slip_gets_the_unit_that_was_meant() {
        assert_eq!(suggest("sec").as_deref(), Some("s"));
        assert_eq!(suggest("hz").as_deref(), Some("Hz"));
        assert_eq!(suggest("KG").as_deref(), Some("kg"));
        assert_eq!(suggest("Nm").as_deref(), Some("N*m"));
        assert_eq!(suggest("\u{3bc}s").as_deref(), Some("us"));
        assert_eq!(suggest("furlong"), None);
    }
}
