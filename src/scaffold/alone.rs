//! Merges several specs into one text: inheritance on documents instead of values, so that comments are
//! preserved.

use toml_edit::{DocumentMut, Item, Table, TableLike};

use crate::spec::section::Header;

/// The merged sections and profiles of parents and of the spec's own lines; later ones win. Keys that name
/// files are left out, and disabled terms are removed.
pub fn merged(parents: &[&str], own: &str) -> String {
    let mut whole = DocumentMut::new();
    for text in parents.iter().copied().chain([own]) {
        let mut part: DocumentMut = text.parse().expect("the shipped parents are TOML");
        for key in Header::top() {
            part.remove(key);
        }
        overlay(whole.as_table_mut(), part.as_table(), 0);
    }
    drop_switched_off(whole.as_table_mut());
    forget_positions(whole.as_table_mut());
    without_references(&whole.to_string())
}

/// Merges a table over another: tables merge by key, values replace, a changed kind replaces its table.
/// Sections have depth 0, named terms 1.
fn overlay(below: &mut dyn TableLike, above: &Table, depth: i32) {
    for (key, item) in above {
        let inside = if depth == 0 && key == "profile" { -1 } else { depth + 1 };
        match (below.get_mut(key), item) {
            (Some(old), new)
                if both_tables(old, new) && !changes_kind(old, new, (depth == 1).then_some(key)) =>
            {
                let new = as_table(new);
                if let Some(old) = old.as_table_like_mut() {
                    overlay(old, &new, inside);
                }
                // The space before the brace would end up before a comma.
                if let Some(inline) = old.as_inline_table_mut() {
                    inline.fmt();
                }
            }
            (Some(old), new) => {
                let decor = old.as_table().map(|table| table.decor().clone());
                *old = new.clone();
                if let (Some(table), Some(decor)) = (old.as_table_mut(), decor) {
                    *table.decor_mut() = decor;
                }
            }
            (None, new) => {
                let key = above.key(key).cloned().unwrap_or_else(|| toml_edit::Key::new(key));
                insert(below, key, new.clone());
            }
        }
    }
}

/// Inserts a key with its own comments.
fn insert(table: &mut dyn TableLike, key: toml_edit::Key, item: Item) {
    let name = key.get().to_owned();
    table.insert(&name, item);
    if let Some(mut inserted) = table.key_mut(&name) {
        *inserted.leaf_decor_mut() = key.leaf_decor().clone();
    }
}

fn both_tables(old: &Item, new: &Item) -> bool {
    old.is_table_like() && new.is_table_like()
}

/// A table in any of TOML's notations.
fn as_table(item: &Item) -> Table {
    match item {
        Item::Table(table) => table.clone(),
        Item::Value(value) => {
            value.as_inline_table().cloned().map(|table| table.into_table()).unwrap_or_default()
        }
        _ => Table::new(),
    }
}

/// Whether a table sets another kind than the one below it, whose kind is by default the term's name.
fn changes_kind(old: &Item, new: &Item, named: Option<&str>) -> bool {
    let kind = |item: &Item| item.get("kind").and_then(Item::as_str).map(str::to_owned);
    match (kind(old).or(named.map(str::to_owned)), kind(new)) {
        (Some(old), Some(new)) => old != new,
        _ => false,
    }
}

/// Removes the terms that a parent disables: without the parent there is nothing to disable. A profile keeps
/// those that the spec itself has.
fn drop_switched_off(root: &mut Table) {
    let mut inherited: Vec<(String, String)> = Vec::new();
    for (name, section) in root.iter_mut().filter(|(name, _)| name != "profile") {
        let Some(section) = section.as_table_like_mut() else { continue };
        remove_switched_off(section, |_| true);
        inherited.extend(section.iter().map(|(term, _)| (name.get().to_owned(), term.to_owned())));
    }
    let Some(profiles) = root.get_mut("profile").and_then(Item::as_table_like_mut) else { return };
    for (_, profile) in profiles.iter_mut() {
        let Some(profile) = profile.as_table_like_mut() else { continue };
        for (name, section) in profile.iter_mut() {
            let Some(section) = section.as_table_like_mut() else { continue };
            let known = |term: &str| inherited.iter().any(|(at, known)| *at == *name.get() && known == term);
            remove_switched_off(section, |term| !known(term));
        }
    }
}

fn remove_switched_off(section: &mut dyn TableLike, removable: impl Fn(&str) -> bool) {
    let off = |item: &Item| item.get("enabled").and_then(Item::as_bool) == Some(false);
    let gone = section.iter().filter(|(name, item)| off(item) && removable(name));
    let gone: Vec<String> = gone.map(|(name, _)| name.to_owned()).collect();
    gone.iter().for_each(|name| drop(section.remove(name)));
}

/// Tables follow the order of the merged document, not that of their files.
fn forget_positions(table: &mut Table) {
    table.set_position(None);
    for (_, item) in table.iter_mut() {
        match item {
            Item::Table(table) => forget_positions(table),
            Item::ArrayOfTables(tables) => tables.iter_mut().for_each(forget_positions),
            _ => {}
        }
    }
}

/// Removes references such as `[A27]` and `(docs/explanation/ppo.md)` from comments: they refer to the
/// repository.
fn without_references(text: &str) -> String {
    let clean = |line: &str| {
        let Some(at) = line.find('#') else { return line.to_owned() };
        let (code, comment) = line.split_at(at);
        let comment = without(&without(comment, " [A", ']'), " (docs/", ')');
        if comment.trim_end() == "#" { code.trim_end().to_owned() } else { format!("{code}{comment}") }
    };
    text.lines().map(|line| clean(line) + "\n").collect()
}

/// A text without the parts from an opening to the next closing character.
fn without(text: &str, opening: &str, closing: char) -> String {
    let mut kept = String::new();
    let mut rest = text;
    while let Some(start) = rest.find(opening) {
        let Some(length) = rest[start..].find(closing) else { break };
        kept += &rest[..start];
        rest = &rest[start + length + closing.len_utf8()..];
    }
    kept + rest
}
