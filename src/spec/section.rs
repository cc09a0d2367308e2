//! The sections of a spec and the keys allowed in them. The kinds come from the registries as a
//! [`Vocabulary`]: this module describes the form of a spec, not the behaviour of kinds.

use super::marks::below;
use super::{Kind, Param, Sampler, Ty};
use crate::spec::typed::prelude::*;
use crate::syntax::Forms;

/// The contents of a section.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Plain keys.
    Plain(&'static [Param]),
    /// The keys of one kind.
    Kind(Vec<&'static Kind>),
    /// Named terms, each of a kind, with keys common to all.
    Terms(Vec<&'static Kind>, &'static [Param]),
}

/// A section of a spec.
#[derive(Clone, Debug)]
pub struct SectionShape {
    /// Its name.
    pub name: &'static str,
    /// The noun of its kinds, for messages: `reward term`.
    pub noun: &'static str,
    /// What it holds.
    pub shape: Shape,
    /// Whether it is required.
    pub required: bool,
}

/// A file embedded in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Embedded {
    /// Its name without folder and ending.
    pub name: &'static str,
    /// Its text.
    pub text: &'static str,
}

/// All sections, robots and motions that specs can use.
#[derive(Clone, Debug, Default)]
pub struct Vocabulary {
    /// The sections in display order.
    pub sections: Vec<SectionShape>,
    /// Embedded robots.
    pub robots: Vec<Embedded>,
    /// Embedded motions.
    pub motions: Vec<Embedded>,
}

keys! {
    /// The sections of a profile.
    pub struct Overlay {}
}

keys! {
    /// The keys of a spec before its sections.
    pub struct Header {
        /// The edition of the language: 1.
        spec: u64,
        /// The spec's name; by default that of its file.
        name: Option<String>,
        /// A one-sentence summary.
        summary: Option<String>,
        /// One parent or several, relative to this file; later ones win.
        extends: Option<Specs>,
        /// Whether it is a parent that cannot be run itself; not inherited.
        #[default("false")]
        r#abstract: bool,
        /// Keys that every spec that extends this file must set: `["action.std"]`.
        requires: Option<Vec<String>>,
        /// Overlays by name, `[profile.NAME]`; each holds sections and is chosen by `--profile NAME`. With
        /// `extends = "OTHER"` it applies on top of another profile.
        profile: Option<Named<Overlay>>,
        /// Accepted warnings, each with its reason.
        allow: Option<Named<String>>,
    }
}

impl Header {
    /// The keys that are tables of their own, and no single values at the top of the file.
    pub const AROUND_SECTIONS: [&str; 2] = [Self::profile.name, Self::allow.name];
    /// The keys that a spec has and a suite has not.
    pub const OF_SPECS: [&str; 3] = [Self::name.name, Self::r#abstract.name, Self::requires.name];

    /// The names of its keys.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Self::PARAMS.iter().map(|param| param.name)
    }

    /// The names of the keys at the top of the file.
    pub fn top() -> impl Iterator<Item = &'static str> {
        Self::names().filter(|name| !Self::AROUND_SECTIONS.contains(name))
    }
}

keys! {
    /// `[robot]`
    pub struct Robot in "robot" {
        /// The robot: `robots/NAME.toml`.
        model: String,
        /// Mass of a load that the robot carries at the origin of its base.
        #[range(0.0, 1e3)]
        #[default("\"0 kg\"")]
        payload: Quantified<Kilogram>,
        /// Viscous damping of every actuated joint, in place of the figures of the robot's file; without this
        /// key those. `randomize.joint_damping` scales it. The gains of a servo are other keys:
        /// `action.damping`.
        #[range(0.0, 1e3)]
        joint_damping: Option<Quantified<NewtonMetreSecondPerRadian>>,
    }
}

either! {
    /// A spec or several.
    pub enum Specs {
        /// One.
        One(String),
        /// Several.
        Several(Vec<String>),
    }
}

keys! {
    /// `[report]`
    pub struct Report in "report" {
        /// The report's template, in `templates/`.
        #[default("\"report.md.j2\"")]
        template: String,
        /// Specs that are run and reported beside this one, relative to the file that names them.
        compare: Option<Vec<String>>,
        /// A spec that the page compares values with, relative to the file that names it; the page lists the
        /// keys in which an arm differs. Of several each arm has the one of its task, of its kind of action
        /// if there is one; an empty list: none, in place of a parent's.
        baseline: Option<Specs>,
        /// The figures of a suite's report, by name; without it those that there is data for.
        figures: Option<Vec<String>>,
        /// What is done in another way than the experiment that is reproduced, a sentence each; printed in
        /// the report, those of a baseline too.
        deviations: Option<Vec<String>>,
        /// The question that the report answers, as a sentence; without it one is made of the task and the
        /// arms. It is not inherited.
        question: Option<String>,
        /// Why the result may differ from the paper's, a sentence each; printed below the answer. They are
        /// not inherited.
        reasons: Option<Vec<String>>,
    }
}

impl Report {
    /// The path of an entry of `report.compare`.
    pub fn compared(entry: usize) -> String {
        below(&Self::compare.path(), &entry.to_string())
    }
}

keys! {
    /// Keys that every reward term takes.
    pub struct RewardTerm {
        /// Factor of the term in the reward.
        #[range(-1e6, 1e6)]
        weight: f64,
    }
}

impl Vocabulary {
    /// A section by name.
    pub fn section(&self, name: &str) -> Option<&SectionShape> {
        self.sections.iter().find(|section| section.name == name)
    }

    /// The kinds of a section; none for a plain one.
    pub fn kinds(&self, section: &str) -> &[&'static Kind] {
        match self.section(section).map(|section| &section.shape) {
            Some(Shape::Kind(kinds) | Shape::Terms(kinds, _)) => kinds,
            _ => &[],
        }
    }

    /// Values with several forms; on merging, one form replaces another.
    pub fn forms(&self) -> Forms {
        let words = Sampler::WORDS.iter().map(|word| vec![*word]).collect();
        let mut forms = Forms { values: vec![words], terms: Vec::new() };
        for section in &self.sections {
            match &section.shape {
                Shape::Plain(params) => forms_of(params, &mut forms),
                Shape::Kind(kinds) | Shape::Terms(kinds, _) => {
                    kinds.iter().for_each(|kind| forms_of(kind.params, &mut forms));
                }
            }
        }
        forms
    }
}

/// Collects the values that are tables in several forms, and the keys of named terms.
fn forms_of(params: &[Param], found: &mut Forms) {
    let holds_terms = |ty: &Ty| matches!(ty, Ty::Terms(_));
    for param in params {
        let terms = match &param.ty {
            Ty::OneOf(types) => types.iter().any(holds_terms),
            ty => holds_terms(ty),
        };
        if terms && !found.terms.contains(&param.name) {
            found.terms.push(param.name);
        }
        match &param.ty {
            Ty::OneOf(types) => {
                let tables = types.iter().filter_map(|ty| match ty {
                    Ty::Table(params) => Some(params.iter().map(|param| param.name).collect()),
                    _ => None,
                });
                let forms: Vec<Vec<&'static str>> = tables.collect();
                if forms.len() > 1 && !found.values.contains(&forms) {
                    found.values.push(forms);
                }
            }
            Ty::Table(params) => forms_of(params, found),
            _ => {}
        }
    }
}
