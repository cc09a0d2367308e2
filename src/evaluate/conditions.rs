//! Conditions of an evaluation's episodes for each kind of protocol: commanded speeds and parameter sets.

use std::collections::BTreeMap;

use crate::env::Randomized;
use crate::kinds::evaluate::parameter_sets::Sampling;
use crate::kinds::evaluate::{Evaluation, ParameterSets, Speeds};
use crate::kinds::randomize;
use crate::spec::value::KIND;
use crate::spec::{Quantity, Table, Value};
use crate::stream::Stream;

/// Conditions of one episode.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Condition {
    /// Forward speed in m/s commanded throughout; `None` stands for the middle of the task's range.
    pub command: Option<f64>,
    /// Deviations from the nominal physics.
    pub randomized: Randomized,
    /// Factors on physical parameters, by the name of their randomization, in place of `randomized`.
    pub parameters: BTreeMap<String, f64>,
}

/// The conditions of an evaluation; `condition` holds what its episodes have in common, `seed` names the
/// random streams.
pub fn conditions(evaluation: &Evaluation, condition: Condition, seed: u64) -> Vec<Condition> {
    match evaluation {
        Evaluation::Speeds(speeds) => at_speeds(speeds, &condition),
        Evaluation::ParameterSets(sets) => of_sets(sets, &condition, seed),
        Evaluation::Episodes(episodes) => vec![condition; episodes.episodes as usize],
    }
}

/// Each speed in ascending order, with its repetitions in a row.
fn at_speeds(speeds: &Speeds, condition: &Condition) -> Vec<Condition> {
    let of_speed =
        |speed| vec![Condition { command: Some(speed), ..condition.clone() }; speeds.repeats as usize];
    speeds.grid().into_iter().flat_map(of_speed).collect()
}

/// One condition per set. Each parameter's factors come from their own stream, so that they do not depend on
/// the other parameters.
fn of_sets(sets: &ParameterSets, condition: &Condition, seed: u64) -> Vec<Condition> {
    let (count, scale) = (sets.sets as usize, &sets.scale);
    let column = |name: &&str| {
        let stream = Stream::new(&format!("{seed}/evaluate/parameters/{name}"));
        let shares = match sets.sampling {
            Sampling::LatinHypercube => strata(count, stream),
            Sampling::Uniform => independent(count, stream),
        };
        shares.into_iter().map(|share| scale[0] + (scale[1] - scale[0]) * share).collect()
    };
    let names: Vec<&str> = sets.parameters.iter().map(|parameter| parameter.word()).collect();
    let columns: Vec<Vec<f64>> = names.iter().map(column).collect();
    let set = |index: usize| {
        names.iter().map(|name| (*name).to_owned()).zip(columns.iter().map(|column| column[index])).collect()
    };
    (0..count).map(|index| Condition { parameters: set(index), ..condition.clone() }).collect()
}

/// One number in each of `count` equal parts of `[0, 1)`, in random order (Latin hypercube; McKay, Beckman
/// and Conover 1979).
fn strata(count: usize, mut stream: Stream) -> Vec<f64> {
    let order = stream.permutation(count);
    order.into_iter().map(|part| (part as f64 + stream.uniform()) / count as f64).collect()
}

fn independent(count: usize, mut stream: Stream) -> Vec<f64> {
    (0..count).map(|_| stream.uniform()).collect()
}

/// The table `[randomize]` that scales each of these parameters by its factor, the same for the whole robot.
pub fn scaled(parameters: &BTreeMap<String, f64>) -> Table {
    let number = |si: f64| Value::Quantity(Quantity { si, text: si.to_string() });
    let row = |(name, factor): (&String, &f64)| {
        let kind = randomize::KINDS.iter().find(|row| row.kind.name == name);
        let shared = kind.is_some_and(|row| row.kind.params.iter().any(|param| param.name == randomize::PER));
        let mut row = Table::from([
            (KIND.to_owned(), Value::Text(name.clone())),
            ("scale".to_owned(), number(*factor)),
        ]);
        row.extend(
            shared.then(|| (randomize::PER.to_owned(), Value::Text(randomize::ONE_FOR_ALL.to_owned()))),
        );
        (name.clone(), Value::Table(row))
    };
    parameters.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize::PerLink;
    use crate::kinds::randomize::link_mass::LinkMass;
    use crate::spec::typed::sample::part;
    use crate::spec::{Sampler, Section};

    fn speeds(keys: &str) -> Vec<f64> {
        let made = conditions(&part(&format!("kind = \"speeds\"\n{keys}")), Condition::default(), 1);
        made.into_iter().map(|condition| condition.command.expect("a speed")).collect()
    }

    #[test]
    fn the_paper_s_grid_is_twenty_five_speeds_to_the_last_bit() {
        let grid = "from = \"0.02 m/s\"\nto = \"0.5 m/s\"\nstep = \"0.02 m/s\"";
        let written: Vec<f64> =
            (1..=25).map(|index| format!("{:.2}", 0.02 * f64::from(index)).parse().unwrap()).collect();
        assert_eq!(speeds(grid), written);
    }

    #[test]
    fn a_list_joins_the_grid_in_rising_order_and_speeds_are_repeated() {
        let list = "from = \"0.1 m/s\"\nto = \"0.3 m/s\"\nstep = \"0.1 m/s\"\nrepeats = 2\n\
                    speeds = [\"0.3 m/s\", \"0.05 m/s\", \"0.1 m/s\"]";
        assert_eq!(speeds(list), [0.05, 0.05, 0.1, 0.1, 0.2, 0.2, 0.3, 0.3]);
        assert_eq!(speeds("speeds = [\"-0.2 m/s\"]"), [-0.2]);
    }

    fn sets(sets: u64, sampling: &str, names: &[&str]) -> Vec<BTreeMap<String, f64>> {
        let text = format!(
            "kind = \"parameter_sets\"\nsets = {sets}\nsampling = \"{sampling}\"\nparameters = {names:?}"
        );
        let made = conditions(&part(&text), Condition::default(), 1000);
        made.into_iter().map(|condition| condition.parameters).collect()
    }

    #[test]
    fn a_latin_hypercube_has_one_number_in_every_part_of_every_range() {
        let drawn = sets(200, "latin_hypercube", &["link_mass", "leg_length"]);
        for name in ["link_mass", "leg_length"] {
            let mut parts: Vec<usize> =
                drawn.iter().map(|set| ((set[name] - 0.7) / 0.6 * 200.0) as usize).collect();
            assert_ne!(parts, (0..200).collect::<Vec<_>>());
            parts.sort_unstable();
            assert_eq!(parts, (0..200).collect::<Vec<_>>(), "{name}");
        }
        // Random pairing: the factors of two parameters are uncorrelated (standard error 0.07).
        let product = |set: &BTreeMap<String, f64>| (set["link_mass"] - 1.0) * (set["leg_length"] - 1.0);
        let correlation = drawn.iter().map(product).sum::<f64>() / 200.0 / (0.6 * 0.6 / 12.0);
        assert!(correlation.abs() < 0.25, "{correlation}");
    }

    #[test]
    fn a_parameter_keeps_its_factors_when_others_are_added() {
        for sampling in ["latin_hypercube", "uniform"] {
            let (one, two) =
                (sets(20, sampling, &["leg_length"]), sets(20, sampling, &["link_com", "leg_length"]));
            let own =
                |sets: &[BTreeMap<String, f64>]| sets.iter().map(|set| set["leg_length"]).collect::<Vec<_>>();
            assert_eq!(own(&one), own(&two));
            assert!(own(&one).iter().all(|factor| (0.7..1.3).contains(factor)));
        }
        let uniform = sets(20, "uniform", &["leg_length"]);
        assert_ne!(uniform, sets(20, "latin_hypercube", &["leg_length"]));
    }

    #[test]
    fn a_set_scales_by_the_rows_of_the_randomization_s_own_registry() {
        let table = scaled(&BTreeMap::from([("leg_length".to_owned(), 1.1), ("link_mass".to_owned(), 0.8)]));
        let section = Section::new(&table);
        let row = |name: &str| section.section(name).expect("a row");
        assert_eq!(
            (row("link_mass").value(LinkMass::scale), row("link_mass").value(LinkMass::per)),
            (Some(Sampler::Constant(0.8)), Some(PerLink::Robot))
        );
        assert_eq!(
            (row("leg_length").value(LinkMass::scale), row("leg_length").holds(LinkMass::per)),
            (Some(Sampler::Constant(1.1)), false)
        );
    }
}
