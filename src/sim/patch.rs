//! The ground as convex planar patches, and the height by which a polygon must be lifted to lie above all of
//! them.
//!
//! Exact for every terrain: over the common region of a plane polygon and a plane patch the gap between them
//! is linear, so its minimum is at a corner of that region. Independent of engines and robots.

use super::scene::Terrain;
use super::terrain;

/// A plane `z = slope . (x, y) + level` in m over a convex region of the x-y plane.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Patch {
    slope: [f64; 2],
    level: f64,
    /// Corners of the region in m, counter-clockwise; an empty list is the whole plane.
    region: Vec<[f64; 2]>,
}

impl Patch {
    fn everywhere(slope: [f64; 2], level: f64) -> Self {
        Self { slope, level, region: Vec::new() }
    }

    /// The triangle between three points, counter-clockwise when seen from above.
    fn triangle(corners: [[f64; 3]; 3]) -> Self {
        let [a, b, c] = corners;
        let (u, v) = ([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
        let area = u[0] * v[1] - u[1] * v[0];
        let slope = [(u[2] * v[1] - v[2] * u[1]) / area, (u[0] * v[2] - v[0] * u[2]) / area];
        let level = a[2] - slope[0] * a[0] - slope[1] * a[1];
        Self { slope, level, region: corners.map(|[x, y, _]| [x, y]).to_vec() }
    }

    fn height(&self, x: f64, y: f64) -> f64 {
        x * self.slope[0] + y * self.slope[1] + self.level
    }

    /// Largest height of the patch above a polygon, in m; negative if the patch is below it everywhere, minus
    /// infinity if the two do not overlap.
    fn above(&self, polygon: &[[f64; 3]]) -> f64 {
        let mut common = polygon.to_vec();
        for (index, from) in self.region.iter().enumerate() {
            let to = self.region[(index + 1) % self.region.len()];
            common = kept(&common, *from, to);
        }
        common.iter().fold(f64::NEG_INFINITY, |highest, [x, y, z]| highest.max(self.height(*x, *y) - z))
    }
}

/// The part of a polygon to the left of a line in the x-y plane (Sutherland and Hodgman 1974).
fn kept(polygon: &[[f64; 3]], from: [f64; 2], to: [f64; 2]) -> Vec<[f64; 3]> {
    let side = |point: &[f64; 3]| {
        (to[0] - from[0]) * (point[1] - from[1]) - (to[1] - from[1]) * (point[0] - from[0])
    };
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, point) in polygon.iter().enumerate() {
        let next = &polygon[(index + 1) % polygon.len()];
        let (here, there) = (side(point), side(next));
        if here >= 0.0 {
            kept.push(*point);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            let share = here / (here - there);
            kept.push(std::array::from_fn(|axis| point[axis] + share * (next[axis] - point[axis])));
        }
    }
    kept
}

impl Terrain {
    /// Largest height in m of the ground above a convex planar polygon: the height by which the polygon must
    /// be lifted to lie on the ground. Negative if there is space below it.
    pub fn above(&self, polygon: &[[f64; 3]]) -> f64 {
        let patches = self.patches(polygon);
        patches.iter().fold(f64::NEG_INFINITY, |highest, patch| highest.max(patch.above(polygon)))
    }

    /// The patches below and around a polygon.
    fn patches(&self, polygon: &[[f64; 3]]) -> Vec<Patch> {
        match self {
            Self::Flat => vec![Patch::everywhere([0.0; 2], 0.0)],
            Self::Slope { angle } => vec![Patch::everywhere([libm::tan(*angle), 0.0], 0.0)],
            Self::BoxObstacle { centre, half_length, half_width, height } => {
                let (back, front) = (centre - half_length, centre + half_length);
                let region = vec![
                    [back, -half_width],
                    [front, -half_width],
                    [front, *half_width],
                    [back, *half_width],
                ];
                let top = Patch { slope: [0.0; 2], level: *height, region };
                vec![Patch::everywhere([0.0; 2], 0.0), top]
            }
            Self::HeightField { cell, counts, heights } => {
                let mut patches = Vec::new();
                let [rows, columns] = [0, 1].map(|axis| cells_below(polygon, axis, *cell, counts[axis]));
                for row in rows {
                    for column in columns.clone() {
                        patches.extend(cell_patches(*cell, *counts, heights, [row, column]));
                    }
                }
                // The plane outside the border is below all of the field, and computing how far takes a pass
                // over all heights.
                let beyond =
                    |[x, y, _]: &[f64; 3]| terrain::within(*cell, *counts, heights, [*x, *y]).is_none();
                if patches.is_empty() || polygon.iter().any(beyond) {
                    patches.push(Patch::everywhere([0.0; 2], terrain::skirt(heights)));
                }
                patches
            }
        }
    }
}

/// The cells of a height field along an axis that a polygon may lie over.
fn cells_below(polygon: &[[f64; 3]], axis: usize, cell: f64, count: usize) -> std::ops::Range<usize> {
    let last = count.saturating_sub(1);
    let place = |value: f64| libm::floor(value / cell + last as f64 / 2.0);
    let (low, high) = polygon.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| {
        (low.min(place(point[axis])), high.max(place(point[axis])))
    });
    // One more cell on the far side, for corners on a grid line; casts saturate.
    (low.max(0.0) as usize).min(last)..((high + 1.0).max(0.0) as usize).min(last)
}

/// The two triangles of a cell, split from its low to its high corner as in both engines.
fn cell_patches(cell: f64, counts: [usize; 2], heights: &[f64], [row, column]: [usize; 2]) -> [Patch; 2] {
    let at = |row: usize, column: usize| {
        let place = |index: usize, count: usize| (index as f64 - (count - 1) as f64 / 2.0) * cell;
        [place(row, counts[0]), place(column, counts[1]), heights[row * counts[1] + column]]
    };
    let (low, high) = (at(row, column), at(row + 1, column + 1));
    [Patch::triangle([low, at(row + 1, column), high]), Patch::triangle([low, high, at(row, column + 1)])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Stream;

    /// A square of 20 cm around a point.
    fn square(x: f64, y: f64, z: f64) -> [[f64; 3]; 4] {
        [[x - 0.1, y - 0.1, z], [x + 0.1, y - 0.1, z], [x + 0.1, y + 0.1, z], [x - 0.1, y + 0.1, z]]
    }

    #[test]
    fn a_peak_below_the_middle_of_a_square_lifts_it() {
        let mut heights = vec![0.0; 25];
        heights[12] = 0.04;
        let terrain = Terrain::HeightField { cell: 0.15, counts: [5, 5], heights };
        assert!((terrain.above(&square(0.0, 0.0, 0.01)) - 0.03).abs() < 1e-12);
        // Two centimetres beside the peak, where the ground falls by 4 cm in 15 cm.
        let beside = terrain.above(&square(0.12, 0.0, 0.0));
        assert!((beside - 0.04 * (1.0 - 0.02 / 0.15)).abs() < 1e-12, "{beside}");
        assert_eq!(terrain.above(&square(9.0, 9.0, 0.0)), -0.05, "beyond the field the ground is 5 cm lower");
    }

    #[test]
    fn the_plane_beyond_a_field_is_looked_at_only_from_beyond_its_border() {
        let mut stream = Stream::new("test/patch/border");
        let heights: Vec<f64> = (0..11 * 11).map(|_| 0.08 * stream.uniform()).collect();
        let skirt = Patch::everywhere([0.0; 2], terrain::skirt(&heights));
        let field = Terrain::HeightField { cell: 0.1, counts: [11, 11], heights };
        let mut inside = 0;
        for _ in 0..300 {
            let polygon = square(1.6 * stream.uniform() - 0.8, 1.6 * stream.uniform() - 0.8, 0.0);
            let within = polygon.iter().flat_map(|[x, y, _]| [x, y]).all(|place| place.abs() <= 0.5);
            assert_eq!(field.patches(&polygon).contains(&skirt), !within);
            assert_eq!(field.above(&polygon), field.above(&polygon).max(skirt.above(&polygon)), "to the bit");
            inside += usize::from(within);
        }
        assert!((30..270).contains(&inside), "{inside} of 300");
    }

    #[test]
    fn the_edge_of_a_box_lifts_a_square_whose_corners_are_beside_it() {
        let bar = Terrain::BoxObstacle { centre: 0.5, half_length: 0.05, half_width: 4.0, height: 0.03 };
        assert_eq!(bar.above(&square(0.5, 0.0, 0.0)), 0.03);
        assert_eq!(bar.above(&square(0.2, 0.0, 0.0)), 0.0);
        let tilted = [[0.4, -0.1, 0.0], [0.6, -0.1, 0.02], [0.6, 0.1, 0.02], [0.4, 0.1, 0.0]];
        // Its surface over the near edge of the bar, at 0.45 m, is 5 mm high.
        assert!((bar.above(&tilted) - 0.025).abs() < 1e-12);
    }

    #[test]
    fn nothing_of_the_ground_is_above_a_polygon_that_was_lifted() {
        let mut stream = Stream::new("test/patch");
        let heights: Vec<f64> = (0..21 * 31).map(|_| 0.08 * stream.uniform()).collect();
        let field = Terrain::HeightField { cell: 0.07, counts: [21, 31], heights };
        for _ in 0..200 {
            let (x, y) = (1.2 * stream.uniform() - 0.6, 1.6 * stream.uniform() - 0.8);
            let lean = 0.4 * stream.uniform() - 0.2;
            let polygon = square(x, y, 0.0).map(|[a, b, _]| [a, b, lean * (a - x)]);
            let lift = field.above(&polygon);
            let mut least = f64::INFINITY;
            for index in 0..60 * 60 {
                let point = [index / 60, index % 60].map(|step| step as f64 / 59.0 * 0.2 - 0.1);
                let gap = lean * point[0] + lift - field.height(x + point[0], y + point[1]);
                least = least.min(gap);
            }
            assert!((-1e-12..8e-3).contains(&least), "the least gap of a grid is {least} m");
        }
    }
}
