//! The index of all reports: every claim of every suite with the paper's number, the measured number and the
//! verdict, from the records next to the reports. Independent of the store and of how suites are parsed.

mod brief;
pub mod mark;

use std::collections::BTreeMap;

use super::claim::{self, Judged, Ruling};
use super::request::Request;
use super::sidecar::Sidecar;
use super::tasks::TaskRecord;
use super::wording::significance;
use crate::escape::markdown::{self, cell, code};
use crate::spec::claim::Claim;
use crate::statistics::multiplicity::holm;

/// The file name in the folder of reports.
pub const FILE: &str = "README.md";

/// A suite in the index.
#[derive(Clone, Debug, Default)]
pub struct Listed {
    /// Its name.
    pub name: String,
    /// The path of its page in the folder of reports, without `.md`.
    pub page: String,
    /// A summary of its question.
    pub summary: String,
    /// Its file, as the command that runs it names it.
    pub file: String,
    /// The available profiles.
    pub profiles: Vec<String>,
    /// Its claims, in order.
    pub claims: Vec<Claim>,
}

/// Compares the stages that a report was rendered from with those that its command would run today.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Standing {
    /// All stages are the same.
    Current,
    /// Some stages differ: the values that they read, or the program, changed since.
    Earlier {
        /// The kinds of today's stages that are missing from the report, in plan order.
        kinds: Vec<String>,
        /// Number of today's stages that are missing from the report.
        lacking: usize,
        /// Number of today's stages.
        stages: usize,
        /// Number of the report's stages that no longer exist today.
        gone: usize,
    },
    /// The specs are missing from the paths in the command.
    WithoutSpecs,
}

/// The content of the index.
#[derive(Clone, Debug, Default)]
pub struct Index {
    /// The suites, sorted by name.
    pub suites: Vec<Listed>,
    /// The records of the reports, by page path in the folder of reports, without `.md`.
    pub reports: BTreeMap<String, Sidecar>,
    /// Whether the reports match today's specs and program, by the same path. Without an entry the index does
    /// not say.
    pub standings: BTreeMap<String, Standing>,
}

/// The state of a listed claim.
enum State<'a> {
    /// It was judged.
    Judged(&'a Judged),
    /// The report was rendered for another text, metric or expectation of the claim, or by other rules.
    Changed,
    /// The report is missing.
    NotRun,
}

const TITLE: &str = "\
# Reports

What was claimed and what became of it.

";

const HEAD: &str = "
Suite by suite, each claim with its verdict. `specforge report --index` writes this page from the \
records beside the
reports and from the suites' files; edits by hand are lost then.

PASS: what the claim expects is established. FAIL: the opposite is established. NOT ESTABLISHED: neither is, \
or a run is missing.
NOT MEANINGFUL: a speed, reward, force or torque of robots that fail their task. A verdict is corrected for \
the number of claims
of its page";

/// Part of the introduction, if any claims are the paper's.
const OF_PAPER: &str = "; the column beside it for that of all claims of the paper, by Holm's method";

/// Explains the numbers, if any claims are the paper's.
const NUMBERS: &str = " Claims of the paper are those about its own setting; studies at smaller budgets are \
    claims of our own. Numbers are those of this project's own runs at the scale that is named, not of the \
    paper's robot.";

/// The profile for desktop computers in specs that `specforge new` writes.
const DESK: &str = "desk";

const PAGES: &str = "
## Pages

The runs of a page are *today's* when the stages that it was rendered from are, fingerprint by fingerprint, \
those that its command
would make with the specs and the program of this commit. Otherwise a value that they read or the program's \
way of making them
changed since, and the command makes them anew.

| page | what it shows | made again by | its runs |
|---|---|---|---|
";

impl Standing {
    /// The text in a cell of the table of pages.
    fn in_words(&self) -> String {
        match self {
            Self::Current => "today's".to_owned(),
            Self::WithoutSpecs => "their specs are not here".to_owned(),
            Self::Earlier { lacking: 0, gone, .. } => format!("{gone} stages more than today's"),
            Self::Earlier { kinds, lacking, stages, .. } => {
                format!("of an earlier state: {lacking} of {stages} stages differ ({})", kinds.join(", "))
            }
        }
    }
}

impl Index {
    /// The page.
    pub fn page(&self) -> String {
        let of_paper = self.names_paper();
        let mut page = TITLE.to_owned() + &self.brief() + HEAD;
        page += if of_paper { OF_PAPER } else { "" };
        page += ".";
        page += if of_paper { NUMBERS } else { "" };
        page += &format!("\n\n{}\n", self.counts());
        page += &self.meaningless();
        page += &self.claims("## Claims of the paper", true);
        page += &self.claims(if of_paper { "## Claims of our own" } else { "## Claims" }, false);
        page += &self.pages();
        page += &self.absent();
        page
    }

    fn state(&self, suite: &Listed, claim: &Claim) -> State<'_> {
        let Some(report) = self.reports.get(&suite.page) else { return State::NotRun };
        match report.claims.iter().find(|judged| judged.id == claim.id) {
            Some(judged) if claim::is_of(judged, claim) && !report.is_by_other_rules() => {
                State::Judged(judged)
            }
            _ => State::Changed,
        }
    }

    /// Whether any claims of the suites are the paper's.
    fn names_paper(&self) -> bool {
        self.chosen(true).next().is_some()
    }

    /// The claims that are the paper's, or those that are not.
    fn chosen(&self, of_paper: bool) -> impl Iterator<Item = (&Listed, &Claim)> {
        let all = self.suites.iter().flat_map(|suite| suite.claims.iter().map(move |claim| (suite, claim)));
        all.filter(move |(_, claim)| claim.paper.is_some() == of_paper)
    }

    /// `Of 12 claims of the paper 3 pass ...`.
    fn counts(&self) -> String {
        let sentence = |of_paper: bool, whose: &str| {
            let (mut counts, mut total, mut weaker, mut meaningless) = ([0; 5], 0, [0; 2], 0);
            for (suite, claim) in self.chosen(of_paper) {
                total += 1;
                let place = match self.state(suite, claim) {
                    State::Judged(judged) => match judged.verdict {
                        Ruling::Pass => 0,
                        Ruling::Fail => 1,
                        Ruling::NotEstablished => 2,
                        Ruling::NotMeaningful => {
                            meaningless += 1;
                            2
                        }
                    },
                    State::Changed => 3,
                    State::NotRun => 4,
                };
                counts[place] += 1;
                if claim.paper.as_ref().is_some_and(|paper| paper.weaker) {
                    weaker[0] += 1;
                    weaker[1] += usize::from(place == 0);
                }
            }
            let [pass, fail, open, changed, absent] = counts;
            let meaningless = match meaningless {
                0 => String::new(),
                some => format!(" ({some} of them not meaningful, because robots fail their task)"),
            };
            let changed = if changed > 0 {
                format!(", {changed} changed since their report was rendered")
            } else {
                String::new()
            };
            let less = match weaker {
                [0, _] => String::new(),
                [all, passed] => {
                    format!(
                        " {all} of the {total} expect less than the paper says, and {passed} of those pass."
                    )
                }
            };
            format!(
                "Of {total} claims{whose} {pass} pass, {fail} fail, {open} are not \
                 established{meaningless}{changed}, {absent} were not run.{less}"
            )
        };
        match self.names_paper() {
            true => format!("{} {}", sentence(true, " of the paper"), sentence(false, " of our own")),
            false => sentence(false, ""),
        }
    }

    fn claims(&self, heading: &str, of_paper: bool) -> String {
        if self.chosen(of_paper).next().is_none() {
            return String::new();
        }
        let mut text = format!("\n{heading}\n\n");
        text += if of_paper {
            "| suite | claim | the paper | ours | verdict | over all claims | scale | seeds \
             |\n|---|---|---|---|---|---|---|---|\n"
        } else {
            "| suite | claim | ours | verdict | scale | seeds |\n|---|---|---|---|---|---|\n"
        };
        let over_all = self.over_all(of_paper);
        for ((suite, claim), over_all) in self.chosen(of_paper).zip(over_all) {
            let mut cells = vec![claim.text.clone()];
            cells.extend(claim.paper.as_ref().map(|paper| paper.in_words()));
            cells.extend(match self.state(suite, claim) {
                State::Judged(judged) => {
                    let verdict = format!("**{}**{}", judged.verdict.word(), self.reservation(suite));
                    [claim::in_brief(judged, suite.claims.len()), verdict]
                }
                State::Changed => ["\u{2013}".to_owned(), "changed since, render again".to_owned()],
                State::NotRun => ["\u{2013}".to_owned(), "not run".to_owned()],
            });
            cells.extend(of_paper.then_some(over_all));
            cells.extend(self.scale(suite));
            text += &row(&self.link(suite), &cells);
        }
        text
    }

    /// The verdict of each claim after Holm's correction over all of them. A claim without a p value counts
    /// as p = 1.
    fn over_all(&self, of_paper: bool) -> Vec<String> {
        let judged = |(suite, claim): (&Listed, &Claim)| match self.state(suite, claim) {
            State::Judged(judged) => Some(judged),
            State::Changed | State::NotRun => None,
        };
        let judged: Vec<Option<&Judged>> = self.chosen(of_paper).map(judged).collect();
        let p = |judged: &Option<&Judged>| judged.and_then(|judged| judged.p).unwrap_or(1.0);
        let adjusted = holm(&judged.iter().map(p).collect::<Vec<_>>());
        let verdict = |(judged, p): (&Option<&Judged>, f64)| match judged {
            None => "\u{2013}".to_owned(),
            Some(judged) => match judged.verdict {
                Ruling::Pass | Ruling::Fail if p > judged.alpha => {
                    format!("{} (p = {})", Ruling::NotEstablished.word(), significance(p))
                }
                Ruling::Pass | Ruling::Fail => format!("{} (p = {})", judged.verdict.word(), significance(p)),
                ruling => ruling.word().to_owned(),
            },
        };
        judged.iter().zip(adjusted).map(verdict).collect()
    }

    /// A caveat on a verdict: no policy of the suite does its task, or some are not judged.
    fn reservation(&self, suite: &Listed) -> String {
        let tasks = self.reports.get(&suite.page).map_or(&[][..], |report| &report.tasks);
        let none = !tasks.is_empty() && tasks.iter().all(TaskRecord::fails);
        let unjudged = !none && tasks.iter().any(|task| task.unjudged > 0);
        let known = [
            none.then_some(" (no policy does its task)"),
            unjudged.then_some(" (not every policy is judged)"),
        ];
        known.into_iter().flatten().collect()
    }

    /// The claims that are not meaningful, with the runs that fail their task.
    fn meaningless(&self) -> String {
        let of = |(name, report): (&String, &Sidecar)| {
            Some(format!("* {}: {}\n", link_to(name), cell(&claim::meaningless(&report.claims)?)))
        };
        let told: String = self.reports.iter().filter_map(of).collect();
        if told.is_empty() { told } else { format!("\n{told}") }
    }

    /// Scale factor and seeds of a suite's report.
    fn scale(&self, suite: &Listed) -> [String; 2] {
        match self.reports.get(&suite.page).map(|report| &report.facts) {
            Some(facts) => [facts.scale.clone(), facts.seeds.len().max(1).to_string()],
            None => ["\u{2013}".to_owned(), "\u{2013}".to_owned()],
        }
    }

    fn link(&self, suite: &Listed) -> String {
        match self.reports.contains_key(&suite.page) {
            true => link_to(&suite.page),
            false => cell(&suite.name),
        }
    }

    /// Every report with the command that reproduces it.
    fn pages(&self) -> String {
        if self.reports.is_empty() {
            return String::new();
        }
        let mut text = PAGES.to_owned();
        for (name, report) in &self.reports {
            let command = code(&report.command());
            let standing = self.standings.get(name).map_or("\u{2013}".to_owned(), Standing::in_words);
            text += &row(&link_to(name), &[about(report), command, standing]);
        }
        text += "\n`specforge trace reports/NAME/FIGURE.svg` and `specforge trace reports/NAME.md#TABLE.ROW` \
            name the runs, spec values and commits behind a \
                 figure or a number.\n";
        text
    }

    /// The suites without a report.
    fn absent(&self) -> String {
        let absent = || self.suites.iter().filter(|suite| !self.reports.contains_key(&suite.page));
        if absent().next().is_none() {
            return String::new();
        }
        let mut text =
            "\n## Not run\n\nThere is no committed report of these suites; the command makes one.\n\n"
                .to_owned();
        for suite in absent() {
            let (name, summary) =
                (markdown::inline(&suite.name), markdown::inline(suite.summary.trim_end_matches('.')));
            let profile = self.profile(suite);
            let command = Request::for_spec(&suite.file, profile).command("run");
            text += &format!("* **{name}**: {summary}. {}\n", code(&command));
        }
        text
    }

    /// The profile to run a suite with: that of its profiles with most reports here, else the one for desktop
    /// computers.
    fn profile<'a>(&self, suite: &'a Listed) -> Option<&'a str> {
        let runs = |name: &str| {
            self.reports.values().filter(|report| report.request.profile.as_deref() == Some(name)).count()
        };
        let own = suite.profiles.iter().map(String::as_str);
        let most = own
            .rev()
            .map(|name| (runs(name), name))
            .max_by_key(|(runs, _)| *runs)
            .filter(|(runs, _)| *runs > 0);
        most.map(|(_, name)| name)
            .or_else(|| suite.profiles.iter().map(String::as_str).find(|name| *name == DESK))
    }
}

/// The subject of a report; its arms if its spec has no summary.
fn about(report: &Sidecar) -> String {
    let arms = || report.arms.iter().map(|arm| arm.name.as_str()).collect::<Vec<_>>().join(", ");
    if report.summary.is_empty() { arms() } else { report.summary.clone() }
}

/// A row of a table, starting with a link.
fn row(link: &str, cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|text| cell(text)).collect();
    format!("| {link} | {} |\n", cells.join(" | "))
}

/// The link to a report in the folder of the index or below it.
fn link_to(page: &str) -> String {
    let name = page.rsplit('/').next().unwrap_or(page);
    format!("[{}]({}.md)", markdown::label(&cell(name)), markdown::target(page))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sidecar::{Facts, RULES};
    use crate::spec::claim::tests::sample;
    use crate::spec::claim::{MetricPath, Paper};

    fn claim(id: &str, paper: bool) -> Claim {
        Claim {
            id: id.into(),
            text: format!("{id} holds"),
            metric: MetricPath { stage: "evaluate.nominal".into(), name: "survival".into() },
            paper: paper.then(|| Paper {
                place: "Exp. 1".into(),
                value: "always | ever".into(),
                number: None,
                weaker: id == "third",
            }),
            ..sample("control=torque", None)
        }
    }

    fn index() -> Index {
        let suite = |name: &str, claims| Listed {
            name: name.into(),
            summary: "What it is about".into(),
            page: name.into(),
            file: format!("specs/studies/{name}.toml"),
            profiles: vec!["desk".into(), "paper".into()],
            claims,
        };
        let judged = Judged {
            id: "first".into(),
            text: "first holds".into(),
            metric: "evaluate.nominal.survival".into(),
            expect: "control=torque > 0.5".into(),
            verdict: Ruling::Pass,
            p: Some(0.012),
            alpha: 0.05,
            ..Judged::default()
        };
        let facts = Facts { seeds: vec![1, 2, 3], scale: "5 %".into(), ..Facts::default() };
        let report = Sidecar { claims: vec![judged], facts, rules: RULES, ..Sidecar::default() };
        Index {
            suites: vec![
                suite("done", vec![claim("first", true), claim("second", true)]),
                suite("open", vec![claim("third", true), claim("fourth", false)]),
            ],
            reports: BTreeMap::from([("done".to_owned(), report)]),
            standings: BTreeMap::new(),
        }
    }

    #[test]
    fn a_claim_is_judged_changed_or_not_run() {
        let page = index().page();
        assert!(
            page.contains("Of 3 claims of the paper 1 pass, 0 fail, 0 are not established, 1 changed since"),
            "{page}"
        );
        let row = "| [done](done.md) | first holds | Exp. 1: always \\| ever | nothing was measured | \
            **PASS** | PASS (p = 0.036) | 5 % | 3 |";
        assert!(page.contains(row), "{page}");
        assert!(
            page.contains(
                "| second holds | Exp. 1: always \\| ever | \u{2013} | changed since, render again |"
            ),
            "{page}"
        );
        let weaker =
            "| open | third holds | Exp. 1: always \\| ever (this claim expects less) | \u{2013} | not run |";
        assert!(page.contains(weaker), "{page}");
        assert!(page.contains("1 of the 3 expect less than the paper says, and 0 of those pass."), "{page}");
    }

    #[test]
    fn suites_that_were_not_run_are_run_with_a_profile_that_the_project_has() {
        let command = |profiles: &[&str], ran: Option<&str>| {
            let mut index = index();
            let report = index.reports.get_mut("done").expect("a report");
            report.request.profile = ran.map(str::to_owned);
            index.suites[1].profiles = profiles.iter().map(|name| (*name).to_owned()).collect();
            let page = index.page();
            let line = page.lines().find(|line| line.starts_with("* **open**")).expect("it was not run");
            line.split('`').nth(1).expect("a command").to_owned()
        };
        let open = "specforge run specs/studies/open.toml";
        assert_eq!(command(&[], Some("desk")), open);
        assert_eq!(command(&["night", "short"], Some("short")), format!("{open} --profile short"));
        assert_eq!(command(&["night", "short"], None), open);
        assert_eq!(command(&["desk", "night"], None), format!("{open} --profile desk"));
    }

    #[test]
    fn a_page_without_claims_of_a_paper_does_not_speak_of_one() {
        let mut index = index();
        index.suites = index.suites.split_off(1);
        index.suites[0].claims = vec![claim("fourth", false)];
        let page = index.page();
        assert!(!page.contains("paper") && !page.contains("repository"), "{page}");
        assert!(page.contains("Of 1 claims 0 pass") && page.contains("\n## Claims\n"), "{page}");
    }

    #[test]
    fn a_verdict_is_corrected_for_all_claims_of_the_paper() {
        let page = |p: f64, rules: u32| {
            let mut index = index();
            let report = index.reports.get_mut("done").expect("a report");
            report.claims[0].p = Some(p);
            report.rules = rules;
            index.page()
        };
        // Three claims of the paper, two of them not run: 3 p.
        assert!(page(0.016, RULES).contains("| **PASS** | PASS (p = 0.048) |"));
        assert!(page(0.017, RULES).contains("| **PASS** | NOT ESTABLISHED (p = 0.051) |"));
        // Other rules may give another verdict.
        for rules in [RULES - 1, RULES + 1] {
            let other = page(0.016, rules);
            assert!(other.contains("| \u{2013} | changed since, render again | \u{2013} |"), "{other}");
            assert!(other.contains("Of 3 claims of the paper 0 pass"), "{other}");
        }
    }

    #[test]
    fn claims_that_are_not_meaningful_are_named_first_with_their_runs() {
        let mut index = index();
        let claim = &mut index.reports.get_mut("done").expect("a report").claims[0];
        claim.verdict = Ruling::NotMeaningful;
        claim.failing = vec!["control=torque,seed=2".into()];
        let page = index.page();
        let told = page.find("1 claim is not meaningful").expect("it is told");
        assert!(told < page.find("## Claims").expect("claims") && page.contains("torque, seed 2"), "{page}");
        assert!(page.contains("| **NOT MEANINGFUL** | NOT MEANINGFUL |"), "{page}");
        assert!(page.contains("(1 of them not meaningful, because robots fail their task)"), "{page}");
    }

    #[test]
    fn a_page_of_an_earlier_state_is_named_with_the_stages_that_differ() {
        let row = |standing: Standing| {
            let mut index = index();
            index.standings.insert("done".to_owned(), standing);
            let page = index.page();
            page.lines().find(|line| line.starts_with("| [done](done.md) |  |")).expect("its row").to_owned()
        };
        let kinds = vec!["learner".to_owned(), "evaluate".to_owned()];
        let earlier = Standing::Earlier { kinds, lacking: 5, stages: 8, gone: 5 };
        assert!(row(earlier).ends_with("| of an earlier state: 5 of 8 stages differ (learner, evaluate) |"));
        let larger = Standing::Earlier { kinds: Vec::new(), lacking: 0, stages: 8, gone: 2 };
        assert!(row(larger).ends_with("| 2 stages more than today's |"));
        assert!(row(Standing::Current).ends_with("| today's |"));
        assert!(row(Standing::WithoutSpecs).ends_with("| their specs are not here |"));
    }

    #[test]
    fn a_verdict_on_policies_that_all_fail_their_task_says_so() {
        let page = |failing: usize| {
            let mut index = index();
            let record = TaskRecord { policies: 3, failing, ..TaskRecord::default() };
            index.reports.get_mut("done").expect("a report").tasks = vec![record];
            index.page()
        };
        assert!(page(3).contains("| **PASS** (no policy does its task) |"));
        assert!(page(2).contains("| **PASS** |"));
    }

    #[test]
    fn suites_without_a_report_are_listed_with_their_command_and_the_others_are_not() {
        let page = index().page();
        let rest = page.split("## Not run").nth(1).expect("a suite was not run");
        let absent = rest.split("\n## ").next().expect("its section");
        assert!(
            absent.contains("`specforge run specs/studies/open.toml --profile desk`")
                && !absent.contains("done"),
            "{absent}"
        );
    }
}
