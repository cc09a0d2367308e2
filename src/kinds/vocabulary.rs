//! The language's vocabulary: its sections and, from the registries, their kinds.

use super::action::Action;
use super::deploy::Deployment;
use super::evaluate::Evaluation;
use super::fine_tune::FineTuning;
use super::initial::Initial;
use super::learn::Learner;
use super::motion;
use super::observe::Observations;
use super::physics::Physics;
use super::pretrain::Pretraining;
use super::randomize::Rows;
use super::reward::Rewards;
use super::task::Task;
use super::terminate::Terminations;
use super::terrain::Ground;
use crate::robot;
use crate::spec::typed::{HasKinds, InSection, Keys};
use crate::spec::{Embedded, Kinds, Param, SectionShape, Shape, Vocabulary, section};

/// All allowed keys of a spec in this edition.
pub fn vocabulary() -> Vocabulary {
    let sections = vec![
        plain::<section::Robot>(true),
        plain::<Physics>(true),
        one::<Ground>(true),
        one::<Task>(true),
        one::<Initial>(true),
        one::<Action>(true),
        terms::<Observations>(&[], true),
        terms::<Rewards>(section::RewardTerm::PARAMS, true),
        terms::<Terminations>(&[], true),
        terms::<Rows>(&[], false),
        one::<Pretraining>(false),
        one::<Learner>(true),
        one::<FineTuning>(false),
        terms::<Evaluation>(&[], false),
        terms::<Deployment>(&[], false),
        plain::<section::Report>(false),
    ];
    Vocabulary { sections, robots: robots(), motions: motions() }
}

/// A section of plain keys.
fn plain<P: InSection + Keys>(required: bool) -> SectionShape {
    SectionShape { name: P::SECTION, noun: P::SECTION, shape: Shape::Plain(P::PARAMS), required }
}

/// A section of one kind.
fn one<K: HasKinds>(required: bool) -> SectionShape {
    let Kinds { section: name, noun, all } = K::KINDS;
    SectionShape { name, noun, shape: Shape::Kind(all()), required }
}

/// A section of named terms, which also have these keys.
fn terms<K: HasKinds>(extra: &'static [Param], required: bool) -> SectionShape {
    let Kinds { section: name, noun, all } = K::KINDS;
    SectionShape { name, noun, shape: Shape::Terms(all(), extra), required }
}

/// The robots included in the program.
fn robots() -> Vec<Embedded> {
    robot::names().filter_map(|name| robot::embedded(name).map(|text| Embedded { name, text })).collect()
}

/// The motions included in the program.
fn motions() -> Vec<Embedded> {
    let embedded =
        |name: &'static str| motion::embedded(&format!("{name}.toml")).map(|text| Embedded { name, text });
    motion::names().filter_map(embedded).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::spec::{LoadOptions, load};

    /// The mistakes in a spec of this repository, as lines.
    fn mistakes(path: &Path, profile: Option<&str>) -> Vec<String> {
        let options = LoadOptions { profile: profile.map(str::to_owned), ..LoadOptions::default() };
        let loaded = load(path, &options, &vocabulary());
        let found = loaded.sink.diagnostics.iter().map(|found| {
            let place =
                found.labels.first().map(|label| loaded.sources.place(label.span)).unwrap_or_default();
            format!("{place}: {} {} {:?}", found.code, found.message, found.help)
        });
        found.collect()
    }

    #[test]
    fn every_spec_of_the_repository_loads_in_every_profile() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs");
        let mut count = 0;
        for folder in [folder.clone(), folder.join("base")] {
            for entry in std::fs::read_dir(folder).expect("the folder") {
                let path = entry.expect("an entry").path();
                if path.extension().is_some_and(|ending| ending == "toml") {
                    // A parent of one arm of an experiment may have its own profiles, or none.
                    let text = std::fs::read_to_string(&path).expect("a file");
                    let whole = !path.parent().is_some_and(|folder| folder.ends_with("base"));
                    let has = |profile: &&str| whole || text.contains(&format!("[profile.{profile}"));
                    for profile in
                        [None].into_iter().chain(["quick", "desk"].into_iter().filter(has).map(Some))
                    {
                        let found = mistakes(&path, profile);
                        assert_eq!(found, Vec::<String>::new(), "{} {profile:?}", path.display());
                    }
                    count += 1;
                }
            }
        }
        assert!(count >= 10);
    }

    #[test]
    fn defaults_of_every_kind_decode() {
        use crate::diag::{Sink, Sources};
        use crate::spec::decode::Decoder;
        let vocabulary = vocabulary();
        for section in &vocabulary.sections {
            for kind in vocabulary.kinds(section.name) {
                let (mut sources, mut sink) = (Sources::default(), Sink::default());
                let source = sources.add("a.toml", "");
                let node = crate::syntax::parse(&sources, source, &mut sink).expect("an empty document");
                let mut decoder = Decoder::new(&mut sink);
                decoder.partial = true;
                decoder.plain(&node, kind.params, kind.name);
                let found: Vec<&str> = sink.diagnostics.iter().map(|found| found.message.as_str()).collect();
                assert!(found.is_empty(), "{} {}: {found:?}", section.name, kind.name);
            }
        }
    }

    #[test]
    fn every_robot_and_motion_that_comes_with_the_program_decodes() {
        use crate::diag::{Sink, Sources};
        use crate::spec::decode::{document, document_of_kind};
        let vocabulary = vocabulary();
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        for Embedded { name, text } in &vocabulary.robots {
            let source = sources.add(format!("{name}.toml"), *text);
            let decoded = document(&sources, source, robot::file::PARAMS, &mut sink);
            let decoded = decoded.unwrap_or_else(|| panic!("{name}: {:#?}", sink.diagnostics));
            let (robot, issues) = robot::from_table(name, &decoded.table);
            assert!(robot.is_some() && issues.is_empty(), "{name}: {issues:?}");
        }
        for Embedded { name, text } in &vocabulary.motions {
            let source = sources.add(format!("{name}.toml"), *text);
            let decoded = document_of_kind(&sources, source, &motion::kinds(), &mut sink);
            assert!(decoded.is_some(), "{name}: {:#?}", sink.diagnostics);
        }
        assert_eq!((vocabulary.robots.len(), vocabulary.motions.len()), (3, 6));
    }
}
