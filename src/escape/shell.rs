//! Arguments of a command that a person copies into a shell.

use std::path::Path;

/// A path as an argument: quoted if the shell needs it, and never parsed as an option.
pub fn argument(path: &Path) -> String {
    let shown = path.to_string_lossy();
    let shown = if shown.starts_with('-') { format!("./{shown}") } else { shown.into_owned() };
    // Only paths with a NUL byte cannot be quoted, and no file has such a name.
    shlex::try_quote(&shown).map(std::borrow::Cow::into_owned).unwrap_or_else(|_| shown.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_arguments_and_no_options() {
        for (path, shown) in [
            ("specs/walk.toml", "specs/walk.toml"),
            ("-x.toml", "./-x.toml"),
            ("--y.toml", "./--y.toml"),
            ("my specs/a.toml", "'my specs/a.toml'"),
            ("a;b.toml", "'a;b.toml'"),
            ("./-x.toml", "./-x.toml"),
        ] {
            assert_eq!(argument(Path::new(path)), shown);
            assert_eq!(shlex::split(shown).unwrap().len(), 1);
        }
    }
}
