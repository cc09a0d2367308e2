//! Geometry of the ground: the height at a point, and the pieces from which engines build it.
//!
//! Independent of engines. Every piece is static and has the friction of [`super::EngineSettings`].

use super::scene::Terrain;

/// A static piece of ground in the world frame (z up).
#[derive(Clone, Debug, PartialEq)]
pub enum Piece<'a> {
    /// The half space below a plane: a point of the plane in m and the unit normal, up.
    Plane {
        /// A point of the plane in m.
        point: [f64; 3],
        /// The normal.
        normal: [f64; 3],
    },
    /// An axis-aligned box: centre and half extents in m.
    Box {
        /// Its centre in m.
        centre: [f64; 3],
        /// Its half extents in m.
        half: [f64; 3],
    },
    /// Heights over a square grid centred on the origin, x outer, y inner.
    Field {
        /// Side of a cell in m.
        cell: f64,
        /// Number of samples along x and y.
        counts: [usize; 2],
        /// Heights in m.
        heights: &'a [f64],
    },
}

impl Terrain {
    /// The pieces of the ground.
    pub fn pieces(&self) -> Vec<Piece<'_>> {
        let level = |z: f64| Piece::Plane { point: [0.0, 0.0, z], normal: [0.0, 0.0, 1.0] };
        match self {
            Self::Flat => vec![level(0.0)],
            // MuJoCo refuses a box without a height.
            Self::BoxObstacle { height: 0.0, .. } => vec![level(0.0)],
            Self::BoxObstacle { centre, half_length, half_width, height } => vec![
                level(0.0),
                Piece::Box {
                    centre: [*centre, 0.0, height / 2.0],
                    half: [*half_length, *half_width, height / 2.0],
                },
            ],
            Self::HeightField { cell, counts, heights } => {
                vec![level(skirt(heights)), Piece::Field { cell: *cell, counts: *counts, heights }]
            }
            Self::Slope { angle } => {
                let normal = [-libm::sin(*angle), 0.0, libm::cos(*angle)];
                vec![Piece::Plane { point: [0.0; 3], normal }]
            }
        }
    }

    /// Range along x of an obstacle, in m; `None` on ground without one.
    pub fn obstacle(&self) -> Option<[f64; 2]> {
        match self {
            Self::BoxObstacle { centre, half_length, .. } => {
                Some([centre - half_length, centre + half_length])
            }
            _ => None,
        }
    }

    /// Height of the ground in m at a point of the world's x-y plane.
    pub fn height(&self, x: f64, y: f64) -> f64 {
        match self {
            Self::Flat => 0.0,
            Self::BoxObstacle { centre, half_length, half_width, height } => {
                let above = (x - centre).abs() <= *half_length && y.abs() <= *half_width;
                if above { *height } else { 0.0 }
            }
            Self::HeightField { cell, counts, heights } => {
                within(*cell, *counts, heights, [x, y]).unwrap_or_else(|| skirt(heights))
            }
            Self::Slope { angle } => x * libm::tan(*angle),
        }
    }
}

/// Height in m of the plane that continues the ground outside a height field, so that nothing falls without
/// end: a step below the lowest point.
pub(super) fn skirt(heights: &[f64]) -> f64 {
    heights.iter().copied().fold(f64::INFINITY, f64::min) - 0.05
}

/// Height of a field at a point; `None` beyond its border. A cell is two triangles, split from its low to its
/// high corner, as in rapier and MuJoCo (`tests/terrain.rs` checks both).
pub(super) fn within(cell: f64, counts: [usize; 2], heights: &[f64], point: [f64; 2]) -> Option<f64> {
    let place = |axis: usize| {
        let last = counts[axis].checked_sub(1)?;
        let at = point[axis] / cell + last as f64 / 2.0;
        let index = (at.max(0.0) as usize).min(last.saturating_sub(1));
        (0.0..=last as f64).contains(&at).then_some((index, at - index as f64))
    };
    let ((row, u), (column, v)) = (place(0)?, place(1)?);
    let at =
        |row: usize, column: usize| heights[row.min(counts[0] - 1) * counts[1] + column.min(counts[1] - 1)];
    let (low, high) = (at(row, column), at(row + 1, column + 1));
    Some(if u >= v {
        let corner = at(row + 1, column);
        low + u * (corner - low) + v * (high - corner)
    } else {
        let corner = at(row, column + 1);
        low + v * (corner - low) + u * (high - corner)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_height_field_is_two_triangles_per_cell_and_a_lower_plane_beyond() {
        let terrain =
            Terrain::HeightField { cell: 1.0, counts: [3, 2], heights: vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0] };
        assert_eq!(terrain.height(-1.0, -0.5), 0.0);
        assert_eq!(terrain.height(0.0, 0.5), 3.0);
        assert!((terrain.height(0.5, 0.0) - 3.5).abs() < 1e-12);
        assert_eq!(terrain.height(1.0, 0.5), 5.0);
        assert_eq!(terrain.height(1.1, 0.5), -0.05);
        // A single high corner: the diagonal from the low to the high corner is a ridge or a valley.
        let corner =
            |heights: [f64; 4]| Terrain::HeightField { cell: 1.0, counts: [2, 2], heights: heights.to_vec() };
        assert_eq!(corner([0.0, 0.0, 0.0, 1.0]).height(0.0, 0.0), 0.5);
        assert_eq!(corner([0.0, 1.0, 1.0, 0.0]).height(0.0, 0.0), 0.0);
        assert_eq!(corner([0.0, 1.0, 0.0, 0.0]).height(-0.25, 0.25), 0.5);
    }

    #[test]
    fn a_slope_rises_along_x_and_its_plane_stands_square_on_it() {
        let terrain = Terrain::Slope { angle: 0.1 };
        assert!((terrain.height(2.0, 1.0) - 2.0 * libm::tan(0.1)).abs() < 1e-12);
        let Piece::Plane { normal, .. } = terrain.pieces()[0] else { unreachable!("a slope is one plane") };
        assert!((normal[0] + normal[2] * libm::tan(0.1)).abs() < 1e-12);
    }

    #[test]
    fn a_box_obstacle_is_high_only_above_itself() {
        let terrain = Terrain::BoxObstacle { centre: 1.0, half_length: 0.2, half_width: 0.5, height: 0.05 };
        assert_eq!(terrain.height(1.1, 0.4), 0.05);
        assert_eq!(terrain.height(1.3, 0.4), 0.0);
        assert_eq!(terrain.height(1.1, 0.6), 0.0);
        assert_eq!((terrain.obstacle(), Terrain::Flat.obstacle()), (Some([0.8, 1.2]), None));
        let even = Terrain::BoxObstacle { centre: 1.0, half_length: 0.2, half_width: 0.5, height: 0.0 };
        assert_eq!(
            (terrain.pieces().len(), even.pieces().len()),
            (2, 1),
            "no engine gets a box without height"
        );
    }
}
