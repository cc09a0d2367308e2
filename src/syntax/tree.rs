//! The spanned tree: a TOML document in which every key and value has its location and its layer (file,
//! profile, assignment). Owns its text; merging moves nodes between documents.

use std::collections::BTreeMap;

use crate::diag::Span;
use crate::escape;

/// Origin of a value, from weak to strong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layer {
    /// The default of a kind or section.
    Default,
    /// A spec file or one of its parents.
    #[default]
    File,
    /// A profile, chosen by `--profile`.
    Profile,
    /// A point of a suite's sweep.
    Point,
    /// A `--set` assignment.
    Set,
}

/// A value with its location.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Its location. A table written with a header has the header's location.
    pub span: Span,
    /// Its origin.
    pub layer: Layer,
    /// The value.
    pub item: Item,
}

/// A TOML value.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A string.
    Text(String),
    /// An integer or a float.
    Number(Number),
    /// A boolean.
    Flag(bool),
    /// A date or time, which no key takes.
    Datetime,
    /// An array.
    List(Vec<Node>),
    /// A table.
    Table(Map),
}

/// A TOML number.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// As written.
    pub text: String,
    /// Its value; may be infinite or NaN.
    pub value: f64,
    /// Its value as a whole number, if it was written as an integer.
    pub whole: Option<i64>,
}

/// The entries of a table by key.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Map {
    /// The entries.
    pub entries: BTreeMap<String, Entry>,
    /// Whether this table was merged over an earlier one of the same path.
    pub inherited: bool,
    /// The keys of the table that this one replaced because its `kind` differs: their locations and values.
    pub replaced: BTreeMap<String, (Span, String)>,
}

/// A key and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Location of the key.
    pub key: Span,
    /// The value.
    pub node: Node,
}

impl Map {
    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.entries.get(key).map(|entry| &entry.node)
    }

    /// The value at a dotted path.
    pub fn at(&self, path: &str) -> Option<&Node> {
        let (table, key) = path.rsplit_once('.').map_or((None, path), |(table, key)| (Some(table), key));
        let keys = table.into_iter().flat_map(|table| table.split('.'));
        let mut map = self;
        for key in keys {
            map = map.get(key)?.table()?;
        }
        map.get(key)
    }
}

impl Node {
    /// The text, if it is one.
    pub fn text(&self) -> Option<&str> {
        match &self.item {
            Item::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The table, if it is one.
    pub fn table(&self) -> Option<&Map> {
        match &self.item {
            Item::Table(map) => Some(map),
            _ => None,
        }
    }

    /// The table, if it is one, mutable.
    pub fn table_mut(&mut self) -> Option<&mut Map> {
        match &mut self.item {
            Item::Table(map) => Some(map),
            _ => None,
        }
    }

    /// Its type, with an article, for messages.
    pub fn describe(&self) -> &'static str {
        match &self.item {
            Item::Text(_) => "a string",
            Item::Number(Number { whole: Some(_), .. }) => "an integer",
            Item::Number(_) => "a number",
            Item::Flag(_) => "a boolean",
            Item::Datetime => "a date",
            Item::List(_) => "a list",
            Item::Table(_) => "a table",
        }
    }

    /// Sets the layer of this value and all below it.
    pub fn stamp(&mut self, layer: Layer) {
        self.layer = layer;
        match &mut self.item {
            Item::List(items) => items.iter_mut().for_each(|item| item.stamp(layer)),
            Item::Table(map) => map.entries.values_mut().for_each(|entry| entry.node.stamp(layer)),
            _ => {}
        }
    }

    /// The value as TOML on one line, in the author's own spelling of numbers and units.
    pub fn toml(&self) -> String {
        match &self.item {
            Item::Text(text) => quoted(text),
            Item::Number(number) => number.text.clone(),
            Item::Flag(flag) => flag.to_string(),
            Item::Datetime => String::new(),
            Item::List(items) => format!("[{}]", items.iter().map(Self::toml).collect::<Vec<_>>().join(", ")),
            Item::Table(map) if map.entries.is_empty() => "{}".to_owned(),
            Item::Table(map) => {
                let entries = map
                    .entries
                    .iter()
                    .map(|(key, entry)| format!("{} = {}", bare_or_quoted(key), entry.node.toml()));
                format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
            }
        }
    }

    /// Sets the location of this value and all below it, for defaults that no file contains.
    pub fn place(&mut self, span: Span) {
        self.span = span;
        match &mut self.item {
            Item::List(items) => items.iter_mut().for_each(|item| item.place(span)),
            Item::Table(map) => map.entries.values_mut().for_each(|entry| {
                entry.key = span;
                entry.node.place(span);
            }),
            _ => {}
        }
    }
}

/// A key as TOML: bare if possible.
fn bare_or_quoted(key: &str) -> String {
    let bare = !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
    if bare { key.to_owned() } else { quoted(key) }
}

/// A text as a TOML basic string.
pub fn quoted(text: &str) -> String {
    let plain = |c: char| !escape::is_hidden(c) && !matches!(c, '"' | '\\' | '\'');
    if text.chars().all(plain) {
        return ["\"", text, "\""].concat();
    }
    escape::toml::string(text)
}
