//! The templates that a template references with `include`, `import`, `from` and `extends`.

use std::ops::Range;

use minijinja::machinery::{Token, tokenize};
use minijinja::syntax::SyntaxConfig;

/// A template's name and its position in the text that references it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    /// The name.
    pub name: String,
    /// Byte range of the name.
    pub place: Range<usize>,
}

/// The names in a tag, at least one of which must exist. Computed names are unknown here.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reference {
    /// The alternatives: `{% include ["own.md.j2", "report.md.j2"] %}` has two.
    pub names: Vec<Named>,
    /// Whether all of them may be missing: `ignore missing`.
    pub optional: bool,
}

/// All references of a text.
pub fn references(text: &str, syntax: &SyntaxConfig) -> Vec<Reference> {
    let (mut found, mut tag) = (Vec::new(), Tag::default());
    for (token, span) in tokenize(text, false, syntax.clone()).map_while(Result::ok) {
        let place = span.start_offset as usize..span.end_offset as usize;
        match token {
            Token::BlockStart => tag = Tag::default(),
            Token::BlockEnd => found.extend(std::mem::take(&mut tag).references()),
            Token::Ident(word) => tag.word(word),
            Token::Str(name) => tag.named.push(Named { name: name.to_owned(), place }),
            Token::String(name) => tag.named.push(Named { name: name.into(), place }),
            Token::BracketOpen => tag.alternatives = true,
            Token::TemplateData(_)
            | Token::ParenOpen
            | Token::ParenClose
            | Token::BracketClose
            | Token::Comma => {}
            // An operator: the name is computed.
            _ => tag.computed = true,
        }
    }
    found
}

#[derive(Default)]
struct Tag {
    /// The first word of the tag.
    keyword: String,
    named: Vec<Named>,
    alternatives: bool,
    computed: bool,
    missing: bool,
}

impl Tag {
    fn word(&mut self, word: &str) {
        match word {
            _ if self.keyword.is_empty() => word.clone_into(&mut self.keyword),
            "missing" => self.missing = true,
            _ => {}
        }
    }

    fn references(self) -> Vec<Reference> {
        let Self { keyword, mut named, alternatives, computed, missing } = self;
        if !matches!(keyword.as_str(), "include" | "import" | "from" | "extends") || computed {
            return Vec::new();
        }
        if keyword == "from" {
            named.truncate(1);
        }
        match alternatives {
            _ if named.is_empty() => Vec::new(),
            true => vec![Reference { names: named, optional: missing }],
            // `"a" if x else "b"`: either may be used.
            false => {
                named.into_iter().map(|name| Reference { names: vec![name], optional: missing }).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<(Vec<String>, bool)> {
        let found = references(text, &SyntaxConfig::default());
        let all = |reference: Reference| {
            (reference.names.into_iter().map(|named| named.name).collect(), reference.optional)
        };
        found.into_iter().map(all).collect()
    }

    #[test]
    fn names_are_found_in_every_tag_that_reads_a_template() {
        let one = |name: &str, optional| (vec![name.to_owned()], optional);
        assert_eq!(names("{% include 'a' %}{% extends \"b\" %}"), [one("a", false), one("b", false)]);
        assert_eq!(
            names("{% from 'a' import f, g %}{%- import 'b' as b -%}"),
            [one("a", false), one("b", false)]
        );
        assert_eq!(names("{% include 'a' ignore missing %}"), [one("a", true)]);
        assert_eq!(names("{% include ['a', 'b'] %}"), [(vec!["a".to_owned(), "b".to_owned()], false)]);
        assert_eq!(names("{% include 'a' if x else 'b' %}"), [one("a", false), one("b", false)]);
        assert_eq!(names("{% include x ~ '.j2' %}{% include x %}{{ 'a' }}{# {% include 'a' %} #}"), []);
        assert_eq!(names("{% raw %}{% include 'a' %}{% endraw %}{% set x = 'a' %}"), []);
    }

    #[test]
    fn a_name_has_its_place() {
        let text = "x {% include 'a.j2' %}";
        let place = references(text, &SyntaxConfig::default())[0].names[0].place.clone();
        assert_eq!(&text[place], "'a.j2'");
    }
}
