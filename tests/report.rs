//! Reports from made-up input: figures, tables, templates and their errors.

#[path = "report/synthetic.rs"]
mod synthetic;

use std::path::Path;

use specforge::report::figure;

#[test]
fn every_figure_is_drawn_and_the_same_each_time() {
    let input = synthetic::input();
    let figures = figure::all(&input);
    let again = figure::all(&input);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("figures");
    std::fs::create_dir_all(&folder).expect("the folder for the figures can be made");
    for (figure, twin) in figures.iter().zip(&again) {
        let svg = figure.drawing.to_svg();
        assert_eq!(svg, twin.drawing.to_svg(), "{}", figure.id);
        std::fs::write(folder.join(format!("{}.svg", figure.id)), svg).expect("the figure can be written");
    }
    let ids: Vec<&str> = figures.iter().map(|figure| figure.id.as_str()).collect();
    let lapses = ["time_lapse_atlas_run_torque", "time_lapse_atlas_run_position"];
    assert_eq!(ids, ["learning_curves", "endings", "speed", lapses[0], lapses[1], "torques", "contact_forces"]);
}
