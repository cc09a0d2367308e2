//! The order of sections and keys, from the descriptors.

use std::collections::BTreeMap;

use super::Sort;
use super::lines::{Document, Line};
use crate::kinds::motion;
use crate::kinds::vocabulary::vocabulary;
use crate::robot::file;
use crate::spec::claim;
use crate::spec::section::Header;
use crate::spec::typed::Keys as _;
use crate::spec::{Kind, Param, Shape, Ty, Vocabulary};

/// Keys of every table that is of a kind.
const OF_A_KIND: &[&str] = &["kind", "enabled"];

/// The same of a table inside another.
const KIND: &[Param] = &[Param::optional("kind", Ty::Text), Param::optional("enabled", Ty::Flag)];

/// Keys of a suite before its sections.
const SUITE: &[&str] = &["spec", "suite", "summary", "extends", "claims"];

/// The allowed keys of every sort of file.
#[derive(Clone, Debug)]
pub struct Order {
    /// Sections and kinds of a spec.
    pub vocabulary: Vocabulary,
    /// Keys of a robot file.
    pub robot: &'static [Param],
    /// Kinds of motions.
    pub motions: Vec<&'static Kind>,
}

/// The order of the keys of one document.
pub struct Ranking<'a> {
    order: &'a Order,
    sort: Sort,
    /// The explicit kinds of the document, by the path of the table.
    kinds: BTreeMap<Vec<String>, String>,
}

impl Order {
    /// The order in this version.
    pub fn of_this_edition() -> Self {
        Self { vocabulary: vocabulary(), robot: file::PARAMS, motions: motion::kinds() }
    }

    /// The order of a document's keys.
    pub fn ranking<'a>(&'a self, sort: Sort, document: &Document<'_>) -> Ranking<'a> {
        let mut kinds = BTreeMap::new();
        for table in &document.tables {
            for entry in
                table.entries.iter().filter(|entry| entry.path.last().is_some_and(|key| key == "kind"))
            {
                let path = [table.path(), &entry.path[..entry.path.len() - 1]].concat();
                kinds.insert(path, entry.value.unwrap_or_default().trim_matches(['"', '\'']).to_owned());
            }
        }
        Ranking { order: self, sort, kinds }
    }
}

impl Ranking<'_> {
    /// The rank of a key in a table; an unknown key comes last.
    fn rank(&self, table: &[String], key: &str) -> usize {
        self.keys(table).iter().position(|known| *known == key).unwrap_or(usize::MAX)
    }

    /// The ranks of a dotted key, step by step, up to the first unknown step.
    fn ranks(&self, table: &[String], path: &[String]) -> Vec<usize> {
        let mut ranks = Vec::with_capacity(path.len());
        for depth in 0..path.len() {
            ranks.push(self.rank(&[table, &path[..depth]].concat(), &path[depth]));
            if ranks.last() == Some(&usize::MAX) {
                break;
            }
        }
        ranks
    }

    /// The keys of a table in their order; empty if the author's order stays.
    fn keys(&self, table: &[String]) -> Vec<&'static str> {
        match self.sort {
            Sort::Robot => inside(vec![self.order.robot], table),
            Sort::Motion => self.of_kinds(&self.order.motions, &[], &[], table, table),
            Sort::Spec | Sort::Suite => match table {
                [profile, _, rest @ ..] if profile == "profile" => self.section(rest, table),
                _ => self.section(table, table),
            },
        }
    }

    /// The keys of a table of a spec; `path` is its path without the profile.
    fn section(&self, path: &[String], table: &[String]) -> Vec<&'static str> {
        let vocabulary = &self.order.vocabulary;
        let [section, rest @ ..] = path else { return self.sections() };
        if self.sort == Sort::Suite && section == "claim" {
            return inside(vec![claim::keys::Claim::PARAMS], rest);
        }
        match (vocabulary.section(section).map(|section| &section.shape), rest) {
            (Some(Shape::Plain(params)), _) => inside(vec![params], rest),
            (Some(Shape::Kind(kinds)), _) => {
                self.of_kinds(kinds, OF_A_KIND, &[], rest, &table[..table.len() - rest.len()])
            }
            (Some(Shape::Terms(kinds, extra)), [_, rest @ ..]) => {
                self.of_kinds(kinds, OF_A_KIND, extra, rest, &table[..table.len() - rest.len()])
            }
            _ => Vec::new(),
        }
    }

    /// The keys before the first table, and the sections.
    fn sections(&self) -> Vec<&'static str> {
        let sections = self.order.vocabulary.sections.iter().map(|section| section.name);
        if self.sort == Sort::Suite {
            // First what all arms share, then what differs between them, then the claims.
            let of_arms = sections.filter(|section| *section != "report");
            return SUITE
                .iter()
                .copied()
                .chain(of_arms)
                .chain(["sweep", "claim", "report", "allow", "profile"])
                .collect();
        }
        Header::top().chain(sections).chain([Header::allow.name, Header::profile.name]).collect()
    }

    /// The keys of a table at `rest` inside a table of one of these kinds, at `place`: those of its own kind
    /// first, then those of the others, because a child may leave out the kind.
    fn of_kinds(
        &self,
        kinds: &[&'static Kind],
        fixed: &[&'static str],
        extra: &'static [Param],
        rest: &[String],
        place: &[String],
    ) -> Vec<&'static str> {
        let place = if self.sort == Sort::Motion { &[] } else { place };
        let own = self.kinds.get(place).or(place.last());
        let is_own = |kind: &&'static Kind| own.is_some_and(|own| own == kind.name);
        let (first, others): (Vec<&'static Kind>, Vec<&'static Kind>) =
            kinds.iter().copied().partition(is_own);
        let params = first.into_iter().chain(others).map(|kind| kind.params);
        let fixed = if self.sort == Sort::Motion { &["kind"] } else { fixed };
        let mut keys = if rest.is_empty() { fixed.to_vec() } else { Vec::new() };
        keys.extend(inside(std::iter::once(extra).chain(params).collect(), rest));
        keys
    }
}

/// The keys of the table at a path inside tables with these keys.
fn inside(params: Vec<&'static [Param]>, path: &[String]) -> Vec<&'static str> {
    let mut params: Vec<&'static Param> = params.into_iter().flatten().collect();
    let mut steps = path.iter();
    while let Some(step) = steps.next() {
        let found: Vec<&'static Param> = params.into_iter().filter(|param| param.name == step).collect();
        // Named terms have a name between their table and their keys.
        if found.iter().any(|param| holds_terms(&param.ty)) && steps.next().is_none() {
            return Vec::new();
        }
        params = found.iter().flat_map(|param| tables(&param.ty)).flatten().collect();
    }
    params.iter().map(|param| param.name).collect()
}

/// The tables that a type allows.
fn tables(ty: &'static Ty) -> Vec<&'static [Param]> {
    match ty {
        Ty::Table(params) => vec![params],
        Ty::OneOf(types) => types.iter().flat_map(tables).collect(),
        Ty::List(item) => tables(item),
        Ty::Kind(kinds) | Ty::Terms(kinds) => {
            let kinds = (kinds.all)();
            std::iter::once(KIND).chain(kinds.iter().map(|kind| kind.params)).collect()
        }
        _ => Vec::new(),
    }
}

/// Whether a type allows a table of named terms.
fn holds_terms(ty: &Ty) -> bool {
    match ty {
        Ty::Terms(_) => true,
        Ty::OneOf(types) => types.iter().any(holds_terms),
        _ => false,
    }
}

impl Document<'_> {
    /// Sorts tables and keys. Unknown ones keep their order after the others.
    pub fn arrange(&mut self, ranking: &Ranking<'_>) {
        let (root, tables) = self.tables.split_at_mut(1);
        tables
            .sort_by_cached_key(|table| table.path().first().map_or(0, |section| ranking.rank(&[], section)));
        for table in root.iter_mut().chain(tables) {
            let path = table.path().to_vec();
            for group in table.entries.chunk_by_mut(|line, next| next.lead.is_empty() && !line.is_explained())
            {
                arrange_group(group, &path, ranking);
            }
        }
    }
}

/// Sorts adjacent lines. What is above and below the group stays there.
fn arrange_group(group: &mut [Line<'_>], table: &[String], ranking: &Ranking<'_>) {
    let lead = group.first_mut().map(|line| std::mem::take(&mut line.lead)).unwrap_or_default();
    let tail = group.last_mut().map(|line| std::mem::take(&mut line.tail)).unwrap_or_default();
    group.sort_by_cached_key(|entry| ranking.ranks(table, &entry.path));
    if let Some(first) = group.first_mut() {
        first.lead = lead;
    }
    if let Some(last) = group.last_mut() {
        last.tail = tail;
    }
}
