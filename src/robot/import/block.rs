//! Boxes aligned with the axes of a body, and bounding boxes of its shapes.

use nalgebra::Vector3;

use crate::robot::{Collision, Shape};

/// A box aligned with the axes of its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Its centre in m.
    pub centre: Vector3<f64>,
    /// Its half extents in m.
    pub half: Vector3<f64>,
}

/// Whether a shape is aligned with the axes of its body, possibly permuted.
pub(super) fn along_axes(collision: &Collision) -> bool {
    let turn = collision.pose.rotation.to_rotation_matrix().into_inner();
    turn.iter().all(|entry| entry.abs() < 1e-9 || (entry.abs() - 1.0).abs() < 1e-9)
}

/// The axis-aligned bounding box of a shape in the body's frame.
pub(super) fn around(collision: &Collision) -> Block {
    let turn = collision.pose.rotation.to_rotation_matrix().into_inner().abs();
    let half = match &collision.shape {
        Shape::Box(half) => turn * half,
        Shape::Capsule(half, radius) => turn.column(2) * *half + Vector3::from_element(*radius),
        Shape::Cylinder(half, radius) => {
            // A disc with normal n reaches r sqrt(1 - n_i^2) along axis i.
            let disc = turn.column(2).map(|along| radius * libm::sqrt((1.0 - along * along).max(0.0)));
            turn.column(2) * *half + disc
        }
        Shape::Sphere(radius) => Vector3::from_element(*radius),
    };
    Block { centre: collision.pose.translation.vector, half }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3};

    use super::*;

    #[test]
    fn the_box_around_a_turned_box_holds_its_corners() {
        let half = Vector3::new(0.3, 0.1, 0.05);
        let pose = Isometry3::new(Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.2, -0.4, 0.6));
        let block = around(&Collision { shape: Shape::Box(half), pose });
        let mut reach = Vector3::zeros();
        for corner in 0..8 {
            let sign = |bit: usize| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let at = pose * Point3::new(sign(0) * half.x, sign(1) * half.y, sign(2) * half.z);
            reach = reach.sup(&(at.coords - block.centre).abs());
        }
        assert!((reach - block.half).norm() < 1e-12);
    }

    #[test]
    fn the_box_around_a_turned_cylinder_touches_its_rims() {
        let (half, radius) = (0.3, 0.1);
        let pose = Isometry3::new(Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.2, -0.4, 0.6));
        let block = around(&Collision { shape: Shape::Cylinder(half, radius), pose });
        let mut reach = Vector3::zeros();
        for step in 0..10_000 {
            let (sine, cosine) = libm::sincos(std::f64::consts::TAU * f64::from(step) / 10_000.0);
            for end in [-half, half] {
                let at = pose * Point3::new(radius * cosine, radius * sine, end);
                reach = reach.sup(&(at.coords - block.centre).abs());
            }
        }
        assert!((reach - block.half).norm() < 1e-7);
    }
}
