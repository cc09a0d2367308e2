//! The engine's terrain from a decoded `[terrain]` table.

use crate::kinds::terrain::Ground;
use crate::kinds::terrain::box_obstacle::{BoxObstacle, Measured};
use crate::kinds::terrain::height_field::HeightField;
use crate::sim::Terrain;
use crate::stream::Stream;

/// The engine's terrain for `[terrain]`.
pub fn terrain(ground: &Ground) -> Terrain {
    match ground {
        Ground::BoxObstacle(obstacle) => on_the_way(obstacle),
        Ground::HeightField(rough) => field(rough),
        Ground::Slope(slope) => Terrain::Slope { angle: slope.angle },
        Ground::Flat(_) => Terrain::Flat,
    }
}

fn on_the_way(obstacle: &BoxObstacle) -> Terrain {
    let half_length = 0.5 * obstacle.length;
    let to_centre = if obstacle.reference == Measured::Front { half_length } else { 0.0 };
    Terrain::BoxObstacle {
        centre: obstacle.distance + to_centre,
        half_length,
        half_width: 0.5 * obstacle.width,
        height: obstacle.height,
    }
}

fn field(rough: &HeightField) -> Terrain {
    let (cell, start) = (rough.cell, rough.start);
    let count = |extent: f64| (extent / cell).round() as usize + 1;
    let counts = [count(rough.length), count(rough.width)];
    let mut stream = Stream::new(&format!("terrain/{}", rough.seed));
    let from_centre = |index: usize, count: usize| ((index as f64 - 0.5 * (count - 1) as f64) * cell).abs();
    let mut heights = Vec::with_capacity(counts[0] * counts[1]);
    for row in 0..counts[0] {
        for column in 0..counts[1] {
            let height = rough.amplitude * stream.uniform();
            let level = from_centre(row, counts[0]) <= start && from_centre(column, counts[1]) <= start;
            heights.push(if level { 0.0 } else { height });
        }
    }
    Terrain::HeightField { cell, counts, heights }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::typed::sample::part;

    #[test]
    fn a_box_60_cm_to_its_front_has_its_centre_half_a_length_further() {
        for (reference, expected) in [("front", 0.8), ("center", 0.6)] {
            let text = format!(
                "kind = \"box_obstacle\"\nfriction = 1.0\nheight = \"1 cm\"\ndistance = \"60 cm\"\nreference \
                 = \"{reference}\""
            );
            let Terrain::BoxObstacle { centre, height, .. } = terrain(&part(&text)) else {
                unreachable!("the kind is a box");
            };
            assert!((centre - expected).abs() < 1e-12 && height == 0.01);
        }
    }

    #[test]
    fn a_height_field_is_level_where_the_robot_starts_and_repeats() {
        let text = "kind = \"height_field\"\nfriction = 1.0\namplitude = \"5 cm\"\nlength = \"4 m\"\nwidth = \
            \"2 m\"\nseed = 3";
        let ground = terrain(&part(text));
        assert_eq!(ground, terrain(&part(text)));
        assert_eq!(ground.height(0.3, -0.3), 0.0);
        let Terrain::HeightField { counts, heights, .. } = ground else {
            unreachable!("the kind is a field")
        };
        assert_eq!(counts, [41, 21]);
        let highest = heights.iter().copied().fold(0.0, f64::max);
        assert!(highest > 0.045 && highest <= 0.05 && heights.iter().all(|height| *height >= 0.0));
    }
}
