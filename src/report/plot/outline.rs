//! Removes points of a line that make no visible difference.

use super::drawing::Point;

/// Drops points that lie within `tolerance` pixels of the remaining line (Ramer 1972, Douglas and Peucker
/// 1973). The first and the last point stay.
pub fn simplified(points: &[Point], tolerance: f64) -> Vec<Point> {
    let mut keep = vec![false; points.len()];
    let (Some(first), Some(last)) = (keep.first_mut(), points.len().checked_sub(1)) else {
        return Vec::new();
    };
    *first = true;
    keep[last] = true;
    let mut pieces = vec![(0, last)];
    while let Some((start, end)) = pieces.pop() {
        if let Some((index, distance)) = farthest(points, start, end)
            && distance > tolerance
        {
            keep[index] = true;
            pieces.extend([(start, index), (index, end)]);
        }
    }
    points.iter().zip(&keep).filter(|(_, kept)| **kept).map(|(point, _)| *point).collect()
}

/// The point between two others that is farthest from their chord, and its distance.
fn farthest(points: &[Point], start: usize, end: usize) -> Option<(usize, f64)> {
    let (a, b) = (points[start], points[end]);
    let distances = (start + 1..end).map(|index| (index, distance_to_segment(points[index], a, b)));
    distances.max_by(|one, two| one.1.total_cmp(&two.1))
}

fn distance_to_segment(point: Point, a: Point, b: Point) -> f64 {
    let (along, offset) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
    let length = along[0] * along[0] + along[1] * along[1];
    let dot = along[0] * offset[0] + along[1] * offset[1];
    let share = if length > 0.0 { (dot / length).clamp(0.0, 1.0) } else { 0.0 };
    let (x, y) = (offset[0] - share * along[0], offset[1] - share * along[1]);
    libm::sqrt(x * x + y * y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_keeps_its_ends_and_a_corner_stays() {
        let straight: Vec<Point> = (0..50).map(|index| [f64::from(index), 2.0 * f64::from(index)]).collect();
        assert_eq!(simplified(&straight, 0.1), vec![[0.0, 0.0], [49.0, 98.0]]);
        let bent = [[0.0, 0.0], [5.0, 0.05], [10.0, 0.0], [10.0, 10.0]];
        assert_eq!(simplified(&bent, 0.1), vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]]);
        assert_eq!(simplified(&[], 0.1), Vec::<Point>::new());
    }
}
