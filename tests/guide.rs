//! The guide: every command and every spec of `docs/guide/` is executed, page after page in the order of
//! `docs/SUMMARY.md`, in one folder with copies of `specs/`, `robots/` and a trained policy.
//!
//! Conventions of a page:
//!
//! * A block that begins with "```toml title=PATH" is written to that file, which must pass
//!   `specforge check`.
//! * In a block that begins with "```console", each line `$ COMMAND` is run by bash and must succeed. Every
//!   other line must be part of what the commands before it in the block print.
//! * "```console tiny": `specforge run`, `cache export` and `evaluate SPEC` get a tiny budget, appended by `--set`.
//! * "```console plan": `specforge run` becomes `specforge plan`, because the run takes long.
//! * "```console elsewhere": what builds, downloads or opens a window is not run.
//! * "```text" is an illustration, and so is any block of `docs/guide/editor.md`, which is about other programs.

mod folders;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use self::folders::copy;

/// What `tiny` appends: a training of 512 samples, and evaluations of two episodes of 2 s.
const TINY: &str = "--set pretrain.samples=2000 --set pretrain.epochs=1 --set learn.samples=512 \
    --set learn.rollout=128 --set learn.environments=4 --set learn.minibatch=64 --set learn.warm_up=1 \
    --set evaluate.nominal.episodes=2 --set deploy.mujoco.episodes=2 --set deploy.rapier.episodes=2 \
    --set 'task.episode=\"2 s\"'";

/// The programs that only a block `elsewhere` may call, and nothing else may stand there.
const ELSEWHERE: &[&str] = &["make", "export", "pip", "tensorboard"];

/// The policy that pages evaluate.
const POLICY: &str = "reports/policies/tocabi_walk_torque.safetensors";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A fenced block of a page.
struct Block {
    /// Page and line of its first line.
    place: String,
    /// The words after the backticks.
    info: Vec<String>,
    body: String,
}

/// The blocks of a page.
fn blocks(page: &str, text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    for (number, line) in text.lines().enumerate() {
        match (line.strip_prefix("```"), open.take()) {
            (Some(_), Some(block)) => blocks.push(block),
            (Some(info), None) => {
                let info = info.split_whitespace().map(str::to_owned).collect();
                open = Some(Block { place: format!("{page}:{}", number + 1), info, body: String::new() });
            }
            (None, Some(block)) => open = Some(Block { body: block.body + line + "\n", ..block }),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "{page}: a block does not end");
    blocks
}

/// The pages of the guide in the order of the book.
fn pages() -> Vec<String> {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).expect("the summary is readable");
    let targets = summary.match_indices("](guide/").filter_map(|(at, _)| summary[at + 2..].split(')').next());
    targets.filter(|page| *page != "guide/editor.md").map(str::to_owned).collect()
}

/// The folder in which the commands run.
struct Workspace(tempfile::TempDir);

impl Workspace {
    fn new() -> Self {
        let workspace = Self(tempfile::tempdir().expect("a folder"));
        for folder in ["specs", "robots"] {
            copy(&root().join(folder), &workspace.path(folder));
        }
        fs::create_dir_all(workspace.path("reports/policies")).expect("a folder");
        fs::copy(root().join(POLICY), workspace.path(POLICY)).expect("the policy is copied");
        // The store is put beside it.
        fs::write(workspace.path("Cargo.toml"), "").expect("written");
        workspace
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs a command in a shell and gives what it prints; `place` names it if it fails.
    fn run(&self, command: &str, place: &str) -> String {
        let program = Path::new(env!("CARGO_BIN_EXE_specforge")).parent().expect("a folder");
        let path = std::env::var("PATH").unwrap_or_default();
        let mut shell = Command::new("bash");
        shell.args(["-c", command]).current_dir(self.0.path()).env("OMP_NUM_THREADS", "1");
        shell.env("PATH", format!("{}:{path}", program.display()));
        let output = shell.output().expect("bash can be started");
        let text = [output.stdout, output.stderr].concat();
        let text = String::from_utf8_lossy(&text).into_owned();
        assert!(output.status.success(), "{place}: `{command}` fails:\n{text}");
        text
    }

    fn spec(&self, block: &Block, title: &str) {
        let path = self.path(title);
        assert!(!path.exists(), "{}: another page writes {title}", block.place);
        fs::write(path, &block.body).expect("written");
        self.run(&format!("specforge check {title}"), &block.place);
    }

    fn console(&self, block: &Block) {
        let mode = block.info.get(1).map_or("", String::as_str);
        let mut printed = String::new();
        let mut last = String::new();
        for line in block.body.lines() {
            let Some(command) = line.strip_prefix("$ ") else {
                let text = line.trim();
                assert!(mode != "tiny" && mode != "plan", "{}: output of another command", block.place);
                assert!(
                    printed.contains(text),
                    "{}: `{last}` does not print `{text}`, but:\n{printed}",
                    block.place
                );
                continue;
            };
            last = executed(command, mode, &block.place);
            if mode != "elsewhere" {
                printed = self.run(&last, &block.place);
            }
        }
        assert!(!last.is_empty(), "{}: a console without a command", block.place);
    }
}

/// What is run for a command of a page.
fn executed(command: &str, mode: &str, place: &str) -> String {
    let program = command.split_whitespace().next().unwrap_or_default();
    assert_eq!(ELSEWHERE.contains(&program), mode == "elsewhere", "{place}: `{command}` in a block {mode:?}");
    match mode {
        "" | "elsewhere" => command.to_owned(),
        "tiny" => {
            let known = ["specforge run ", "specforge cache export ", "specforge evaluate specs/"];
            assert!(known.iter().any(|known| command.starts_with(known)), "{place}: `{command}` is not tiny");
            format!("{command} {TINY}")
        }
        "plan" => {
            let rest = command.strip_prefix("specforge run ");
            format!("specforge plan {}", rest.unwrap_or_else(|| panic!("{place}: `{command}` is not a run")))
        }
        other => panic!("{place}: a console block cannot be `{other}`"),
    }
}

#[test]
fn every_command_and_spec_of_the_guide_works() {
    let workspace = Workspace::new();
    let pages = pages();
    assert!(pages.len() >= 12, "{pages:?}");
    for page in pages {
        let text = fs::read_to_string(root().join("docs").join(&page)).expect("the page is readable");
        for block in blocks(&page, &text) {
            let title = block.info.get(1).and_then(|word| word.strip_prefix("title="));
            match (block.info.first().map(String::as_str), title) {
                (Some("toml"), Some(title)) => workspace.spec(&block, title),
                (Some("console"), None) => workspace.console(&block),
                (Some("text"), None) => {}
                _ => panic!("{}: a block of an unknown form: {:?}", block.place, block.info),
            }
        }
    }
}

#[test]
fn blocks_are_found_with_their_place() {
    let text = "a\n\n```console plan\n$ specforge run b.toml --profile quick\n```\n\n```toml title=c.toml\nd = 1\n```\n";
    let found = blocks("p.md", text);
    assert_eq!(found.len(), 2);
    assert_eq!((found[0].place.as_str(), found[1].place.as_str()), ("p.md:3", "p.md:7"));
    assert_eq!(found[1].body, "d = 1\n");
    assert_eq!(
        executed("specforge run b.toml --profile quick", "plan", ""),
        "specforge plan b.toml --profile quick"
    );
    assert!(executed("specforge run b.toml", "tiny", "").contains(" --set learn.samples=512 "));
}
