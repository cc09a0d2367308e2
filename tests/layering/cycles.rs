//! Finds the cycles between the modules of a folder: its files and subfolders, each with all that is below
//! it.
//!
//! An edge is a path that begins with `crate`, `self` or `super` and leads to another module of the folder,
//! directly or through the `pub use` of a module. Tests and comments may name anything.

use std::collections::{BTreeMap, BTreeSet};

/// The path of a module below the crate's root, empty for the root itself.
pub type Module = Vec<String>;

/// The edges between the modules of a folder, by their names there.
type Edges = BTreeMap<String, BTreeSet<String>>;

/// The modules of a crate and what they use.
pub struct Crate {
    /// The paths of each module without its tests, as they are written.
    paths: BTreeMap<Module, Vec<Vec<String>>>,
    /// What a module makes visible under its own name, and where that comes from.
    exported: BTreeMap<Module, Vec<String>>,
}

impl Crate {
    /// A crate of modules with these texts.
    pub fn new(modules: impl IntoIterator<Item = (Module, String)>) -> Self {
        let (mut paths, mut exported) = (BTreeMap::new(), BTreeMap::new());
        let mut open: Vec<_> = modules.into_iter().map(|(module, text)| (module, code(&text))).collect();
        while let Some((module, code)) = open.pop() {
            let (code, inner) = without_inner(&code);
            open.extend(inner.into_iter().map(|(name, code)| ([module.as_slice(), &[name]].concat(), code)));
            for path in public_uses(&code) {
                let name = path.iter().rev().find(|name| *name != "self").cloned().unwrap_or_default();
                exported.insert([module.as_slice(), &[name]].concat(), path);
            }
            paths.insert(module, rooted(&code));
        }
        Self { paths, exported }
    }

    /// The folders in which modules use each other in a cycle, with the modules of each cycle.
    pub fn cycles(&self) -> BTreeMap<String, Vec<BTreeSet<String>>> {
        let folders = self.edges().into_iter().map(|(folder, edges)| (folder.join("/"), circles(&edges)));
        folders.filter(|(_, circles)| !circles.is_empty()).collect()
    }

    fn edges(&self) -> BTreeMap<Module, Edges> {
        let mut folders: BTreeMap<Module, Edges> = BTreeMap::new();
        for (module, paths) in &self.paths {
            for target in paths.iter().map(|path| self.target(module, path, 8)) {
                let common = module.iter().zip(&target).take_while(|(own, other)| own == other).count();
                if let (Some(own), Some(other)) = (module.get(common), target.get(common)) {
                    let edges = folders.entry(module[..common].to_vec()).or_default();
                    edges.entry(own.clone()).or_default().insert(other.clone());
                }
            }
        }
        folders
    }

    /// The module in which a path ends, through at most so many `pub use`.
    fn target(&self, module: &[String], path: &[String], uses: usize) -> Module {
        let (mut at, mut rest) = (module.to_vec(), path);
        while let Some((first, others)) = rest.split_first() {
            match first.as_str() {
                "crate" => at.clear(),
                "super" => drop(at.pop()),
                "self" => {}
                _ => break,
            }
            rest = others;
        }
        while let Some((first, others)) = rest.split_first() {
            at.push(first.clone());
            if !self.paths.contains_key(&at) {
                let used = self.exported.get(&at);
                at.pop();
                return match used {
                    Some(used) if at != module && uses > 0 => self.target(&at, used, uses - 1),
                    _ => at,
                };
            }
            rest = others;
        }
        at
    }
}

/// The modules that reach each other, each group once.
fn circles(edges: &Edges) -> Vec<BTreeSet<String>> {
    let reached = |from: &String| {
        let (mut found, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(next) = open.pop() {
            let unseen = edges.get(next).into_iter().flatten().filter(|other| found.insert((*other).clone()));
            open.extend(unseen.collect::<Vec<_>>());
        }
        found
    };
    let all: BTreeMap<&String, BTreeSet<String>> =
        edges.keys().map(|module| (module, reached(module))).collect();
    let mut circles: Vec<BTreeSet<String>> = Vec::new();
    for (module, reached) in all.iter().filter(|(module, reached)| reached.contains(**module)) {
        if !circles.iter().any(|circle| circle.contains(*module)) {
            let back = |other: &&String| all.get(other).is_some_and(|of_other| of_other.contains(*module));
            circles.push(reached.iter().filter(back).cloned().collect());
        }
    }
    circles
}

/// A text without its comments and without what only tests see.
fn code(text: &str) -> String {
    let mut code = String::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if !line.trim_start().starts_with("#[cfg(test)]") && !line.trim_start().starts_with("#[cfg(all(test")
        {
            code += line.split("//").next().unwrap_or_default();
            code.push('\n');
            continue;
        }
        let indent = line.len() - line.trim_start().len();
        let ends =
            |line: &str| line.len() - line.trim_start().len() == indent && line.ends_with(['}', ';', ',']);
        let _ = lines.by_ref().find(|line| ends(line));
    }
    code
}

/// A text without the modules that are written inside it, and those with their names.
fn without_inner(code: &str) -> (String, Vec<(String, String)>) {
    let (mut own, mut inner) = (String::new(), Vec::new());
    let mut lines = code.lines();
    while let Some(line) = lines.next() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let ["mod", name, "{"] | [_, "mod", name, "{"] = words.as_slice() {
            let end = line[..line.len() - line.trim_start().len()].to_owned() + "}";
            let body: Vec<&str> = lines.by_ref().take_while(|line| *line != end).collect();
            inner.push(((*name).to_owned(), body.join("\n")));
        } else {
            own += line;
            own.push('\n');
        }
    }
    (own, inner)
}

/// All paths of a text that begin with `crate`, `self` or `super`.
fn rooted(code: &str) -> Vec<Vec<String>> {
    let mut paths = Vec::new();
    for root in ["crate", "self", "super"] {
        for (at, _) in code.match_indices(&format!("{root}::")) {
            // `super::super` is one path.
            if !code[..at]
                .ends_with(|before: char| before.is_alphanumeric() || before == '_' || before == ':')
            {
                paths.extend(tree(&code[at..]));
            }
        }
    }
    paths
}

/// The paths of the items that a text uses and makes visible beyond itself, from the module on.
fn public_uses(code: &str) -> Vec<Vec<String>> {
    let mut paths = Vec::new();
    for (at, _) in code.match_indices("pub") {
        let rest = &code[at + "pub".len()..];
        let rest =
            rest.strip_prefix('(').and_then(|rest| rest.split_once(')')).map_or(rest, |(_, rest)| rest);
        if let Some(path) = rest.strip_prefix(" use ") {
            paths.extend(tree(path));
        }
    }
    paths
}

/// The paths of a use tree, or the path of an expression, at the beginning of a text.
fn tree(text: &str) -> Vec<Vec<String>> {
    let (mut path, mut rest) = (Vec::new(), text.trim_start());
    loop {
        if let Some(group) = rest.strip_prefix('{') {
            let below = items(group).into_iter().flat_map(tree);
            return below.map(|below| [path.as_slice(), &below].concat()).collect();
        }
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        if end > 0 {
            path.push(rest[..end].to_owned());
        }
        match rest[end..].strip_prefix("::") {
            Some(after) => rest = after,
            None => return if path.is_empty() { Vec::new() } else { vec![path] },
        }
    }
}

/// The items of a brace group that has just been opened.
fn items(group: &str) -> Vec<&str> {
    let (mut depth, mut from, mut items) = (0, 0, Vec::new());
    for (at, letter) in group.char_indices() {
        match letter {
            '{' => depth += 1,
            ',' | '}' if depth == 0 => {
                items.push(&group[from..at]);
                from = at + 1;
                if letter == '}' {
                    break;
                }
            }
            '}' => depth -= 1,
            _ => {}
        }
    }
    items
}

/// A crate of these modules, and its cycles as `folder: one two`.
fn cycles_of(modules: &[(&str, &str)]) -> Vec<String> {
    let module = |path: &str| path.split('/').filter(|name| !name.is_empty()).map(str::to_owned).collect();
    let found = Crate::new(modules.iter().map(|(path, text)| (module(path), (*text).to_owned()))).cycles();
    let lines = found.iter().flat_map(|(folder, circles)| circles.iter().map(move |circle| (folder, circle)));
    lines.map(|(folder, circle)| format!("{folder}: {}", Vec::from_iter(circle.clone()).join(" "))).collect()
}

#[test]
fn a_cycle_is_found_by_super_self_crate_groups_and_paths_in_expressions() {
    let root = [("", ""), ("a", ""), ("a/x", "fn f() { super::y::f(); }")];
    for back in [
        "use super::x::f;",
        "use crate::a::x;",
        "use super::{\n    z,\n    x::{self, f},\n};",
        "super::x::f()",
    ] {
        assert_eq!(cycles_of(&[&root[..], &[("a/y", back)]].concat()), ["a: x y"], "{back}");
    }
    // A folder stands for all that is below it, and longer cycles are cycles.
    let files = [
        ("a/y", ""),
        ("a/y/deep", "use super::super::z;"),
        ("a/z", "use crate::{a::w::Thing, b};"),
        ("a/w", "use super::x::f;"),
    ];
    assert_eq!(cycles_of(&[&root[..], &files].concat()), ["a: w x y z"]);
    assert_eq!(
        cycles_of(&[("", ""), ("a", "use self::x::f;"), ("a/x", "use super::f;")]),
        Vec::<String>::new()
    );
}

#[test]
fn what_a_module_uses_in_public_is_found_where_it_comes_from() {
    let one = [
        ("", ""),
        ("a", "mod x;\npub(super) use x::{F, y::G};\npub use self::z::H;"),
        ("a/x", "use super::H;"),
    ];
    assert_eq!(cycles_of(&[&one[..], &[("a/z", "use super::F;")]].concat()), ["a: x z"]);
    assert_eq!(cycles_of(&[&one[..], &[("a/z", "use super::K;")]].concat()), Vec::<String>::new());
}

#[test]
fn in_a_module_inside_a_file_super_is_that_file() {
    let around = |path: &str| format!("fn z() {{}}\npub mod prelude {{\n    pub use {path}::z;\n}}\n");
    let cycles = |text: &str| cycles_of(&[("", ""), ("a", ""), ("a/y", text), ("a/z", "use super::y;")]);
    assert_eq!(cycles(&around("super")), Vec::<String>::new());
    assert_eq!(cycles(&around("super::super")), ["a: y z"]);
}

#[test]
fn tests_and_comments_may_name_anything() {
    let x = ("a/x", "use super::y;");
    for text in [
        "// super::x",
        "#[cfg(test)]\nmod tests {\n    use super::super::x;\n}",
        "#[cfg(test)]\n#[path = \"x.rs\"]\nmod tests;\n// use super::x;",
    ] {
        assert_eq!(cycles_of(&[("", ""), ("a", ""), x, ("a/y", text)]), Vec::<String>::new(), "{text}");
    }
    let after = "#[cfg(test)]\nmod tests;\nuse super::x;";
    assert_eq!(
        cycles_of(&[("", ""), ("a", ""), x, ("a/y", after)]),
        ["a: x y"],
        "the test ends with its module"
    );
}
