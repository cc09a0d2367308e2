//! The ground as geometry: the height below a point, and the pieces of which engines build it.
//!
//! Knows no engine. Every piece is static and shares the friction of [`super::EngineSettings`].

use super::engine::Terrain;

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
    /// A box along the axes: centre and half extents in m.
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
    /// The pieces of the ground. Beyond a height field the ground goes on as a plane a step below its
    /// lowest point, so that nothing falls for ever.
    pub fn pieces(&self) -> Vec<Piece<'_>> {
        let level = |z: f64| Piece::Plane { point: [0.0, 0.0, z], normal: [0.0, 0.0, 1.0] };
        match self {
            Self::Flat => vec![level(0.0)],
            Self::BoxObstacle { centre, half_length, half_width, height } => vec![
                level(0.0),
                Piece::Box { centre: [*centre, 0.0, height / 2.0], half: [*half_length, *half_width, height / 2.0] },
            ],
            Self::HeightField { cell, counts, heights } => {
                let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
                vec![level(lowest - 0.05), Piece::Field { cell: *cell, counts: *counts, heights }]
            }
            Self::Slope { angle } => {
                let normal = [-libm::sin(*angle), 0.0, libm::cos(*angle)];
                vec![Piece::Plane { point: [0.0; 3], normal }]
            }
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
            Self::HeightField { cell, counts, heights } => bilinear(*cell, *counts, heights, [x, y]),
            Self::Slope { angle } => x * libm::tan(*angle),
        }
    }
}

/// Height of a field at a point, interpolated; beyond the border the height of the border.
fn bilinear(cell: f64, counts: [usize; 2], heights: &[f64], point: [f64; 2]) -> f64 {
    let place = |axis: usize| {
        let last = (counts[axis] - 1) as f64;
        let at = (point[axis] / cell + last / 2.0).clamp(0.0, last);
        let index = (at as usize).min(counts[axis].saturating_sub(2));
        (index, (index + 1).min(counts[axis] - 1), at - index as f64)
    };
    let (x0, x1, u) = place(0);
    let (y0, y1, v) = place(1);
    let at = |x: usize, y: usize| heights[x * counts[1] + y];
    (1.0 - u) * ((1.0 - v) * at(x0, y0) + v * at(x0, y1)) + u * ((1.0 - v) * at(x1, y0) + v * at(x1, y1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_height_field_is_interpolated_between_its_samples_and_flat_beyond() {
        let terrain = Terrain::HeightField { cell: 1.0, counts: [3, 2], heights: vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0] };
        assert_eq!(terrain.height(-1.0, -0.5), 0.0);
        assert_eq!(terrain.height(0.0, 0.5), 3.0);
        assert!((terrain.height(0.5, 0.0) - 3.5).abs() < 1e-12);
        assert_eq!(terrain.height(9.0, 9.0), 5.0);
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
    }
}
