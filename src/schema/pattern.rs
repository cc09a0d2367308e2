//! Regular expressions for quantities: numbers with a unit of a given dimension.
//!
//! A regular expression cannot count exponents, and editors show it to users, so it must be short. These
//! accept the usual spellings: base units alone, and products with one derived unit that are no longer than
//! the unit that specforge itself writes. Numerators come first. Another spelling (`s/rad*N*m`) is valid in a
//! spec although the pattern does not match: `check` decides.

use crate::quantity::unit::{PREFIXES, UNITS, Unit};
use crate::quantity::{Dimension, Measure};

/// A number, as quantities begin.
const NUMBER: &str = "[-+]?[0-9._]+([eE][-+]?[0-9]+)?";

/// Largest power of a derived unit in a spelling.
const LARGEST: i8 = 2;

/// A text of a dimension.
pub fn quantity(dimension: Dimension) -> String {
    format!("^{NUMBER} *({})$", spellings(dimension).join("|"))
}

/// A percentage.
pub fn ratio() -> String {
    format!("^{NUMBER} *%$")
}

/// A percentage, or a quantity relative to the robot.
pub fn ratio_or(measure: Measure) -> String {
    // The unit's only special characters are `*` and the parentheses.
    let unit = measure.unit().replace('*', "\\*").replace('(', "\\(").replace(')', "\\)");
    format!("^{NUMBER} *(%|(% *)?{unit})$")
}

/// A count with a suffix.
pub fn count() -> String {
    "^[0-9._]+ *[kMG]?$".to_owned()
}

/// A unit as a pattern, and its power.
type Factor<'a> = (&'a str, i8);

/// Interchangeable units of one dimension.
struct Class {
    dimension: Dimension,
    pattern: String,
}

/// The units by dimension, in the order of the list of units.
fn classes() -> Vec<Class> {
    let mut classes: Vec<Class> = Vec::new();
    for unit in UNITS.iter().filter(|unit| unit.dimension != Dimension::NONE) {
        let pattern = written(unit);
        match classes.iter_mut().find(|class| class.dimension == unit.dimension) {
            Some(class) => class.pattern += &format!("|{pattern}"),
            None => classes.push(Class { dimension: unit.dimension, pattern }),
        }
    }
    for class in classes.iter_mut().filter(|class| class.pattern.contains('|')) {
        class.pattern = format!("({})", class.pattern);
    }
    classes
}

/// A unit with the prefixes that it takes.
fn written(unit: &Unit) -> String {
    if !unit.prefixed {
        return unit.symbol.to_owned();
    }
    let prefixes: String = PREFIXES.iter().map(|(prefix, _)| *prefix).collect();
    format!("[{prefixes}]?{}", unit.symbol)
}

/// The exponents of the base units of a dimension, in a fixed order.
fn exponents(dimension: Dimension) -> [i8; 5] {
    let Dimension { length, mass, time, current, angle } = dimension;
    [length, mass, time, current, angle]
}

/// The spellings of a dimension.
fn spellings(dimension: Dimension) -> Vec<String> {
    let (base, derived): (Vec<Class>, Vec<Class>) = classes()
        .into_iter()
        .partition(|class| exponents(class.dimension).iter().filter(|power| **power != 0).eq([&1]));
    let longest = spelled(dimension);
    let mut found: Vec<String> = Vec::new();
    let mut add = |with: Option<(&Class, i8)>| {
        let Some(left) =
            with.map_or(Some(dimension), |(class, power)| dimension.times(class.dimension, -power))
        else {
            return;
        };
        let remaining = base.iter().map(|class| (class, shared(left, class.dimension)));
        let factors: Vec<Factor<'_>> = with
            .into_iter()
            .chain(remaining)
            .filter(|(_, power)| *power != 0)
            .map(|(class, power)| (class.pattern.as_str(), power))
            .collect();
        let powers: u8 = factors.iter().map(|(_, power)| power.unsigned_abs()).sum();
        if with.is_none() || powers <= longest {
            found.extend(orders(&factors));
        }
    };
    add(None);
    for class in &derived {
        for power in (1..=LARGEST).flat_map(|power| [power, -power]) {
            add(Some((class, power)));
        }
    }
    // The usual spelling is short, and readers should see it first.
    found.sort_by_key(String::len);
    found
}

/// The sum of the powers in the unit that specforge writes: 3 for `N*m/rad`.
fn spelled(dimension: Dimension) -> u8 {
    let unit = dimension.unit();
    let factors = unit.split(['*', '/']).filter(|factor| !factor.is_empty());
    factors.map(|factor| factor.split_once('^').and_then(|(_, power)| power.parse().ok()).unwrap_or(1)).sum()
}

/// The power of a base unit in a dimension.
fn shared(dimension: Dimension, base: Dimension) -> i8 {
    exponents(dimension).iter().zip(exponents(base)).map(|(power, unit)| power * unit).sum()
}

/// The products of these factors: numerators first, each side in every order.
fn orders(factors: &[Factor<'_>]) -> Vec<String> {
    let (above, below): (Vec<Factor<'_>>, Vec<Factor<'_>>) =
        factors.iter().partition(|(_, power)| *power > 0);
    let mut products = Vec::new();
    for above in permutations(&above) {
        for below in permutations(&below) {
            let above: Vec<String> = above.iter().map(factor).collect();
            let below: Vec<String> = below.iter().map(|part| format!("/ ?{}", factor(part))).collect();
            let parts: Vec<String> =
                (!above.is_empty()).then(|| above.join(r" ?\* ?")).into_iter().chain(below).collect();
            products.push(parts.join(" ?"));
        }
    }
    products
}

/// A unit with its power.
fn factor((unit, power): &Factor<'_>) -> String {
    match power.unsigned_abs() {
        1 => (*unit).to_owned(),
        power => format!(r"{unit}\^{power}"),
    }
}

fn permutations<'a>(items: &[Factor<'a>]) -> Vec<Vec<Factor<'a>>> {
    if items.is_empty() {
        return vec![Vec::new()];
    }
    let mut all = Vec::new();
    for index in 0..items.len() {
        let mut others = items.to_vec();
        let first = others.remove(index);
        all.extend(permutations(&others).into_iter().map(|rest| [vec![first], rest].concat()));
    }
    all
}
