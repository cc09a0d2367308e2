//! The worked examples of CONTRIBUTING.md: patches that apply to this tree and hold the code that the page shows.
//! `.ci/run` builds and tests the tree with both of them.

use std::fs;
use std::path::Path;
use std::process::Command;

const PATCHES: [&str; 2] = ["reward_term", "metric"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn patch(name: &str) -> String {
    root().join("tests/contributing").join(format!("{name}.patch")).display().to_string()
}

/// The Rust code of CONTRIBUTING.md, block by block, without indentation.
fn shown() -> Vec<Vec<String>> {
    let page = fs::read_to_string(root().join("CONTRIBUTING.md")).expect("CONTRIBUTING.md is there");
    let mut blocks: Vec<Vec<String>> = Vec::new();
    let mut inside = false;
    for line in page.lines().map(str::trim) {
        match line {
            "```rust" => {
                inside = true;
                blocks.push(Vec::new());
            }
            "```" => inside = false,
            _ if inside && !line.is_empty() => blocks.last_mut().expect("a block").push(line.to_owned()),
            _ => {}
        }
    }
    blocks
}

/// The lines that a patch adds, without indentation.
fn added(name: &str) -> Vec<String> {
    let text = fs::read_to_string(patch(name)).expect("the patch is there");
    let lines = text.lines().filter(|line| !line.starts_with("+++"));
    lines
        .filter_map(|line| line.strip_prefix('+'))
        .map(|line| line.trim().to_owned())
        .filter(|line| !line.is_empty())
        .collect()
}

#[test]
fn the_examples_apply_to_this_tree() {
    let mut command = Command::new("git");
    command.args(["apply", "--check"]).args(PATCHES.map(patch)).current_dir(root());
    let output = command.output().expect("git is installed");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_page_shows_the_code_of_the_examples() {
    let blocks = shown();
    assert_eq!(blocks.len(), PATCHES.len(), "one block of Rust for each patch");
    for (block, name) in blocks.iter().zip(PATCHES) {
        let added = added(name);
        let holds = added.windows(block.len()).any(|lines| lines == block);
        assert!(holds, "{name}.patch does not add these lines of CONTRIBUTING.md: {block:#?}");
    }
}
