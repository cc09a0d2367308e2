//! The figures of suites from made-up runs: drawn, legible, the same every time, with captions that say n.

#[path = "report/made_up_claims.rs"]
mod made_up_claims;
#[path = "report/made_up_suite.rs"]
mod made_up_suite;
#[path = "report/synthetic.rs"]
mod synthetic;

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use made_up_suite::suite;
use specforge::diag::Sources;
use specforge::outcome::Trace;
use specforge::report::figure::{self, Figure};
use specforge::report::model::ReportInput;
use specforge::report::plot::Anchor;
use specforge::report::plot::drawing::{Item, text_width};
use specforge::report::{Templates, render};

const FIGURES: [&str; 13] = [
    "learning_curves",
    "learning_curves:fine_tune",
    "claims",
    "survival_grid",
    "metric_grid:evaluate.nominal.speed_error",
    "speeds:evaluate.grid.survival",
    "speeds:evaluate.grid.speed_error",
    "return_histogram:evaluate.sets",
    "failure_loadings",
    "failure_deciles",
    "ankle_torque:evaluate.flat,evaluate.box",
    "contact_forces",
    "time_lapse",
];

/// The figures.
fn drawn() -> &'static [Figure] {
    static DRAWN: OnceLock<Vec<Figure>> = OnceLock::new();
    DRAWN.get_or_init(draw)
}

/// Draws them and writes them into the target folder for people to look at.
fn draw() -> Vec<Figure> {
    let mut input = suite();
    input.figures = FIGURES.map(str::to_owned).into();
    let figures = figure::all(&input);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("suite_figures");
    fs::create_dir_all(&folder).expect("the folder can be made");
    for figure in &figures {
        fs::write(folder.join(format!("{}.svg", figure.id)), figure.drawing.to_svg())
            .expect("it can be written");
    }
    figures
}

/// The figures whose intervals take no long resampling; that one gives the same numbers twice,
/// `tests/failures.rs` says.
fn ids_without_resampling() -> Vec<String> {
    FIGURES.iter().filter(|name| **name != "failure_loadings").map(|name| (*name).to_owned()).collect()
}

fn named<'a>(figures: &'a [Figure], id: &str) -> &'a Figure {
    figures.iter().find(|figure| figure.id == id).unwrap_or_else(|| panic!("{id} is drawn"))
}

#[test]
fn every_figure_that_is_named_is_drawn_in_its_order_and_the_same_each_time() {
    let figures = drawn();
    let ids: Vec<String> = FIGURES.iter().map(|name| name.replace([':', '.', ','], "_")).collect();
    assert_eq!(figures.iter().map(|figure| figure.id.clone()).collect::<Vec<_>>(), ids);
    let mut input = suite();
    input.figures = ids_without_resampling();
    for again in figure::all(&input) {
        let figure = named(figures, &again.id);
        assert_eq!(figure.drawing.to_svg(), again.drawing.to_svg(), "{}", figure.id);
    }
}

#[test]
fn every_figure_says_n_and_names_its_sources() {
    for figure in drawn() {
        let says_n =
            figure.caption.contains("n = ") || figure.caption.contains(" runs") || figure.id == "claims";
        assert!(says_n, "{}: {}", figure.id, figure.caption);
        assert!(!figure.sources.is_empty(), "{}", figure.id);
    }
}

#[test]
fn no_text_is_cut_at_an_edge_and_no_two_texts_lie_on_each_other() {
    for figure in drawn() {
        let words = figure.drawing.items.iter().filter_map(|item| match item {
            Item::Words(words) if !words.upwards => Some(words),
            _ => None,
        });
        let boxes: Vec<([f64; 4], &str)> = words
            .map(|words| {
                // Estimated widths are generous; a tenth is left for fonts that are narrower.
                let width = 0.9 * text_width(&words.text, words.size);
                let left = match words.anchor {
                    Anchor::Start => words.at[0],
                    Anchor::Middle => words.at[0] - 0.5 * width,
                    Anchor::End => words.at[0] - width,
                };
                ([left, words.at[1] - 0.7 * words.size, left + width, words.at[1]], words.text.as_str())
            })
            .collect();
        for (place, (a, text)) in boxes.iter().enumerate() {
            let inside =
                a[0] >= 0.0 && a[1] >= 0.0 && a[2] <= figure.drawing.width && a[3] <= figure.drawing.height;
            assert!(inside, "{}: `{text}` {a:?} of {}", figure.id, figure.drawing.width);
            for (b, other) in &boxes[..place] {
                let apart = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
                assert!(apart, "{}: `{text}` lies on `{other}`", figure.id);
            }
        }
    }
}

#[test]
fn the_curves_of_the_fine_tuning_are_those_of_its_own_stage() {
    let curves = named(drawn(), "learning_curves_fine_tune");
    assert!(
        curves.caption.contains("n = 3") && curves.caption.contains("begins with the policies"),
        "{}",
        curves.caption
    );
    assert_eq!(curves.sources.len(), 12);
    assert!(curves.sources.iter().all(|source| source.stage == "fine_tune"), "{:?}", curves.sources);
    let mut without = suite();
    without.arms.iter_mut().for_each(|arm| arm.fine_tuning.clear());
    without.figures = vec!["learning_curves:fine_tune".to_owned()];
    assert!(figure::all(&without).is_empty());
}

#[test]
fn a_strip_is_drawn_for_each_point_of_the_first_axis_and_none_without_traces() {
    let strips = |input: &ReportInput| figure::all(input).pop().map(|figure| figure.sources);
    let mut input = suite();
    input.figures = vec!["time_lapse".to_owned()];
    let sources = strips(&input).expect("there are traces");
    assert_eq!(sources.len(), 2, "{sources:?}");
    let point = |place: usize| sources[place].arm.split(',').next().map(str::to_owned);
    assert_ne!(point(0), point(1), "{sources:?}");
    // The first run with a trace stands for its arm.
    let lost = |input: &mut ReportInput, gone: &dyn Fn(&str) -> bool| {
        for arm in input.arms.iter_mut().filter(|arm| gone(&arm.name)) {
            arm.evaluations.iter_mut().for_each(|measured| measured.evaluation.trace = Trace::default());
        }
    };
    lost(&mut input, &|name| name == sources[0].arm);
    let others = strips(&input).expect("there are other traces");
    assert_eq!((others.len(), others[0].arm == sources[0].arm), (2, false), "{others:?}");
    lost(&mut input, &|_| true);
    assert_eq!(strips(&input), None);
}

#[test]
fn the_claims_are_drawn_with_their_verdicts() {
    let figures = drawn();
    let claims = named(figures, "claims");
    let svg = claims.drawing.to_svg();
    // A speed is not meaningful where robots fail their task.
    for word in ["PASS", "NOT MEANINGFUL", "NOT ESTABLISHED"] {
        assert!(svg.contains(&format!(">{word}: ")), "{word}: {svg}");
    }
    assert!(claims.caption.contains("4 comparisons of 3 claims; n counts"), "{}", claims.caption);
}

#[test]
fn the_bold_words_beside_a_claim_are_not_cut() {
    let mut input = suite();
    input.figures = vec!["claims".to_owned()];
    // Those of two claims that are decided: no words of another row are wider.
    let suite = input.suite.as_mut().expect("a suite");
    suite.claims.retain(|claim| claim.sides.len() == 1);
    let figures = figure::all(&input);
    let drawing = &named(&figures, "claims").drawing;
    let bold = drawing.items.iter().filter_map(|item| match item {
        Item::Words(words) if words.bold && words.anchor == Anchor::Start => Some(words),
        _ => None,
    });
    let ends: Vec<f64> = bold.map(|words| words.at[0] + 1.1 * text_width(&words.text, words.size)).collect();
    assert!(!ends.is_empty() && ends.iter().all(|end| *end < drawing.width), "{ends:?} of {}", drawing.width);
}

#[test]
fn the_peaks_of_two_engines_and_of_two_courses_stand_in_the_captions() {
    let figures = drawn();
    let forces = named(figures, "contact_forces");
    assert!(forces.caption.contains("control=torque,std=10 %: 1.20 in the window"), "{}", forces.caption);
    let torques = named(figures, "ankle_torque_evaluate_flat_evaluate_box");
    assert!(torques.caption.contains("control=position,std=10 %: "), "{}", torques.caption);
}

#[test]
fn a_metric_that_is_a_share_has_the_interval_of_wilson_at_every_speed() {
    let figures = drawn();
    let crossed = named(figures, "speeds_evaluate_grid_survival");
    assert!(crossed.drawing.to_svg().contains(" of 75: "), "three policies at 25 speeds");
    assert!(
        crossed.caption.contains("Each arm: n = 75 episodes at 25 speeds, 3 policies"),
        "{}",
        crossed.caption
    );
}

#[test]
fn parameter_sets_in_which_nothing_varies_have_no_figure_and_no_panic() {
    let mut input = suite();
    let measured = input.arms.iter_mut().flat_map(|arm| &mut arm.evaluations);
    let parameters =
        measured.flat_map(|measured| &mut measured.evaluation.episodes).map(|one| &mut one.parameters);
    parameters.flat_map(|parameters| parameters.values_mut()).for_each(|scale| *scale = 1.0);
    input.figures = ["failure_loadings", "failure_deciles"].map(str::to_owned).into();
    assert!(figure::all(&input).is_empty());
    assert!(render(&input, &Templates::default(), &mut Sources::default()).is_ok());
}

#[test]
fn a_suite_without_a_list_gets_the_figures_that_there_is_data_for() {
    let mut input = suite();
    input
        .arms
        .iter_mut()
        .for_each(|arm| arm.evaluations.retain(|measured| measured.stage != "evaluate.sets"));
    input.figures.clear();
    let ids: Vec<String> = figure::all(&input).into_iter().map(|figure| figure.id).collect();
    assert!(
        ids.starts_with(&["learning_curves".to_owned(), "claims".to_owned(), "survival_grid".to_owned()]),
        "{ids:?}"
    );
    input.arms.iter_mut().for_each(|arm| arm.evaluations.clear());
    let ids: Vec<String> = figure::all(&input).into_iter().map(|figure| figure.id).collect();
    assert!(!ids.contains(&"speeds".to_owned()) && ids.contains(&"learning_curves".to_owned()), "{ids:?}");
}

#[test]
fn the_page_of_a_suite_has_its_parts_in_order_and_shows_every_figure() {
    let mut input = suite();
    input.figures = FIGURES.map(str::to_owned).into();
    input.deviations = vec!["The robot is made up".to_owned()];
    let files =
        render(&input, &Templates::default(), &mut Sources::default()).expect("the template has no mistake");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("suite_page");
    fs::create_dir_all(&folder).expect("the folder can be made");
    fs::write(folder.join("made_up.md"), &files[0].text).expect("it can be written");
    let text = &files[0].text;
    let parts = [
        "**Question.** ",
        "**Answer.** Of 3 claims 1 passes, 0 fail and 2 are not established.",
        "**Before you rely on this:**",
        "<details><summary>What was run</summary>",
        "<details><summary>Claims: ",
        "<details><summary>Learning</summary>",
        "<details><summary>Evaluation: ",
        "<details><summary>Deviations ",
        "<details><summary>Cost and origin</summary>",
    ];
    let places: Vec<usize> = parts
        .iter()
        .map(|part| text.find(&format!("\n{part}")).unwrap_or_else(|| panic!("{part}")))
        .collect();
    assert!(places.is_sorted(), "{places:?}");
    for figure in drawn() {
        assert!(text.contains(&format!("made_up/{}.svg", figure.id)), "{}", figure.id);
    }
    assert!(text.contains("### Fine-tuning") && text.contains("| 3 of 3 | 983 k |"), "{text}");
    assert!(text.contains("</summary>\n\n* The robot is made up.\n"), "{text}");
    assert!(
        text.contains("### Why sets of `evaluate.sets` fail") && text.contains("action_delay |"),
        "{text}"
    );
    let pair = "| torque, std 10 % minus position, std 10 %, seed 1 | 160 |";
    assert!(text.contains(pair), "the arms meet on the same sets: {text}");
}
