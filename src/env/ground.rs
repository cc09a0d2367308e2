//! The engine's terrain from a decoded `[terrain]` table.

use crate::sim::Terrain;
use crate::spec::Section;
use crate::stream::Stream;

/// The terrain that the table describes.
pub fn terrain(section: Section) -> Terrain {
    match section.text("kind") {
        "box_obstacle" => obstacle(section),
        "height_field" => field(section),
        "slope" => Terrain::Slope { angle: section.si("angle") },
        _ => Terrain::Flat,
    }
}

fn obstacle(section: Section) -> Terrain {
    let half_length = 0.5 * section.si("length");
    let to_centre = if section.text("reference") == "front" { half_length } else { 0.0 };
    Terrain::BoxObstacle {
        centre: section.si("distance") + to_centre,
        half_length,
        half_width: 0.5 * section.si("width"),
        height: section.si("height"),
    }
}

fn field(section: Section) -> Terrain {
    let (cell, start) = (section.si("cell"), section.si("start"));
    let count = |extent: f64| (extent / cell).round() as usize + 1;
    let counts = [count(section.si("length")), count(section.si("width"))];
    let mut stream = Stream::new(&format!("terrain/{}", section.count("seed")));
    let from_centre = |index: usize, count: usize| ((index as f64 - 0.5 * (count - 1) as f64) * cell).abs();
    let mut heights = Vec::with_capacity(counts[0] * counts[1]);
    for row in 0..counts[0] {
        for column in 0..counts[1] {
            let height = section.si("amplitude") * stream.uniform();
            let level = from_centre(row, counts[0]) <= start && from_centre(column, counts[1]) <= start;
            heights.push(if level { 0.0 } else { height });
        }
    }
    Terrain::HeightField { cell, counts, heights }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::{Quantity, Table, Value};

    fn table(kind: &str, numbers: &[(&str, f64)]) -> Table {
        let mut table = Table::from([("kind".into(), Value::Text(kind.into()))]);
        for (key, si) in numbers {
            table.insert((*key).into(), Value::Quantity(Quantity { si: *si, text: String::new() }));
        }
        table
    }

    #[test]
    fn a_box_60_cm_to_its_front_has_its_centre_half_a_length_further() {
        let numbers = [("height", 0.01), ("length", 0.4), ("width", 8.0), ("distance", 0.6)];
        for (reference, expected) in [("front", 0.8), ("center", 0.6)] {
            let mut table = table("box_obstacle", &numbers);
            table.insert("reference".into(), Value::Text(reference.into()));
            let Terrain::BoxObstacle { centre, height, .. } = terrain(Section::new(&table)) else {
                unreachable!("the kind is a box");
            };
            assert!((centre - expected).abs() < 1e-12 && height == 0.01);
        }
    }

    #[test]
    fn a_height_field_is_level_where_the_robot_starts_and_repeats() {
        let numbers = [("amplitude", 0.05), ("cell", 0.1), ("length", 4.0), ("width", 2.0), ("start", 0.4)];
        let mut table = table("height_field", &numbers);
        table.insert("seed".into(), Value::Count(3));
        let ground = terrain(Section::new(&table));
        assert_eq!(ground, terrain(Section::new(&table)));
        assert_eq!(ground.height(0.3, -0.3), 0.0);
        let Terrain::HeightField { counts, heights, .. } = ground else { unreachable!("the kind is a field") };
        assert_eq!(counts, [41, 21]);
        let highest = heights.iter().copied().fold(0.0, f64::max);
        assert!(highest > 0.045 && highest <= 0.05 && heights.iter().all(|height| *height >= 0.0));
    }
}
