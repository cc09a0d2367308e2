//! Longer and shorter legs: the same robot with all leg bones stretched.
//!
//! A bone is the segment from a link's joint to the next joint towards the foot. Stretching a link multiplies
//! all lengths along its bone by a factor and preserves those across: the thigh of a taller robot is longer,
//! not thicker. Mass is unchanged (it has its own randomization), so the moments of inertia about the axes
//! across the bone grow nearly with the square of the factor, and the one about the bone is unchanged.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

use super::model::{Body, Collision, Robot, Shape};
use super::symmetry;

/// Minimum distance in m between two joints for a bone that can be stretched.
const SHORTEST: f64 = 1e-3;

/// Scaling of all lengths along one direction.
#[derive(Clone, Copy, Debug)]
struct Stretch(Matrix3<f64>);

impl Stretch {
    fn new(along: &Unit<Vector3<f64>>, factor: f64) -> Self {
        Self(Matrix3::identity() + along.as_ref() * along.as_ref().transpose() * (factor - 1.0))
    }

    /// Stretches a body about the origin of its frame; its mass is unchanged.
    fn body(&self, body: &mut Body) {
        body.com = Point3::from(self.0 * body.com.coords);
        // A linear map transforms the second moments of the mass: `S = tr(I) / 2 - I`.
        let second = Matrix3::from_diagonal_element(0.5 * body.inertia.trace()) - body.inertia;
        let second = self.0 * second * self.0.transpose();
        body.inertia = Matrix3::from_diagonal_element(second.trace()) - second;
        body.collisions.iter_mut().for_each(|collision| self.collision(collision));
    }

    /// The thickness of a shape is unchanged: a capsule, cylinder or box gets longer, a sphere moves.
    fn collision(&self, collision: &mut Collision) {
        let Isometry3 { rotation, translation } = collision.pose;
        let longer = |axis: Vector3<f64>| (self.0 * (rotation * axis)).norm();
        match &mut collision.shape {
            Shape::Box(half) => {
                let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
                *half = half.component_mul(&Vector3::from(axes.map(longer)));
            }
            Shape::Capsule(half, _) | Shape::Cylinder(half, _) => *half *= longer(Vector3::z()),
            Shape::Sphere(_) => {}
        }
        let direction = rotation * Vector3::z();
        let turn = UnitQuaternion::rotation_between(&direction, &(self.0 * direction)).unwrap_or_default();
        let is_long = matches!(collision.shape, Shape::Capsule(..) | Shape::Cylinder(..));
        let turned = if is_long { turn * rotation } else { rotation };
        collision.pose = Isometry3::from_parts(Translation3::from(self.0 * translation.vector), turned);
    }
}

impl Robot {
    /// Scales both legs by a factor: bones, the mass properties and shapes of their links, and the standing
    /// height. Shared parents and the feet are unchanged.
    pub fn stretch_legs(&mut self, factor: f64) {
        if factor == 1.0 {
            // Avoids rounding errors.
            return;
        }
        for (link, next) in self.bones() {
            let bone = self.links[next].joint.origin.translation.vector;
            let Some(along) = Unit::try_new(bone, SHORTEST) else { continue };
            let stretch = Stretch::new(&along, factor);
            stretch.body(&mut self.links[link].body);
            for child in self.links.iter_mut().filter(|child| child.parent == Some(link)) {
                child.joint.origin.translation.vector = stretch.0 * child.joint.origin.translation.vector;
            }
        }
        self.standing_height = symmetry::standing_height(self);
    }

    /// The links of both legs above the feet, each with the next link towards its foot.
    fn bones(&self) -> Vec<(usize, usize)> {
        let chains = [0, 1].map(|side| {
            let foot = self.feet[side].link;
            std::iter::successors(Some(foot), |link| self.links[*link].parent).collect::<Vec<usize>>()
        });
        let side = |own: usize| {
            let (chain, other) = (&chains[own], &chains[1 - own]);
            let pairs = chain.windows(2).map(|pair| (pair[1], pair[0]));
            pairs.filter(|(link, _)| !other.contains(link)).collect::<Vec<_>>()
        };
        [side(0), side(1)].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::leg_length;
    use crate::robot::tests::robot;

    #[test]
    fn legs_are_longer_by_the_factor_and_feet_keep_their_size() {
        for name in ["tocabi", "atlas", "g1"] {
            let before = robot(name);
            for factor in [0.7, 1.3] {
                let mut after = before.clone();
                after.stretch_legs(factor);
                let ratio = leg_length(&after).unwrap() / leg_length(&before).unwrap();
                assert!((ratio - factor).abs() < 1e-9, "{name}: {ratio}");
                assert_eq!(after.feet, before.feet);
                for foot in &before.feet {
                    assert_eq!(after.links[foot.link].body, before.links[foot.link].body);
                }
                assert_eq!(after.base, before.base);
                assert_eq!(after.total_mass(), before.total_mass());
                let stands = symmetry::standing_height(&after);
                assert!(
                    after.standing_height == stands && (stands > before.standing_height) == (factor > 1.0)
                );
            }
        }
    }

    /// A rod of 2 kg and 0.4 m along z, hanging from its joint.
    fn rod(length: f64) -> Body {
        let (mass, across) = (2.0, 2.0 * length * length / 12.0);
        Body {
            name: "rod".into(),
            mass,
            com: Point3::new(0.0, 0.0, -0.5 * length),
            inertia: Matrix3::from_diagonal(&Vector3::new(across, across, 0.0)),
            collisions: vec![Collision {
                shape: Shape::Capsule(0.5 * length, 0.05),
                pose: Isometry3::translation(0.0, 0.0, -0.5 * length),
            }],
        }
    }

    #[test]
    fn a_stretched_rod_is_the_longer_rod() {
        let mut body = rod(0.4);
        Stretch::new(&-Vector3::z_axis(), 1.5).body(&mut body);
        let expected = rod(0.6);
        assert!((body.inertia - expected.inertia).amax() < 1e-12);
        assert!((body.com - expected.com).amax() < 1e-12);
        let (Shape::Capsule(is, thick), Shape::Capsule(should, same)) =
            (&body.collisions[0].shape, &expected.collisions[0].shape)
        else {
            unreachable!("a rod is a capsule")
        };
        assert!((is - should).abs() < 1e-12 && thick == same);
        assert!((body.collisions[0].pose.translation.vector.z + 0.3).abs() < 1e-12);
    }

    #[test]
    fn an_oblique_capsule_ends_where_its_ends_are_stretched_to() {
        let ends = [Vector3::new(0.02, 0.0, -0.1), Vector3::new(-0.04, 0.03, -0.3)];
        let axis = ends[1] - ends[0];
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &axis).unwrap();
        let mut body = rod(0.4);
        body.collisions[0] = Collision {
            shape: Shape::Capsule(0.5 * axis.norm(), 0.05),
            pose: Isometry3::from_parts(Translation3::from((ends[0] + ends[1]) * 0.5), turn),
        };
        Stretch::new(&Vector3::z_axis(), 1.3).body(&mut body);
        let Shape::Capsule(half, _) = body.collisions[0].shape else { unreachable!("it was a capsule") };
        for (end, sign) in ends.iter().zip([-1.0, 1.0]) {
            let expected = Vector3::new(end.x, end.y, 1.3 * end.z);
            let found = body.collisions[0].pose * Point3::new(0.0, 0.0, sign * half);
            assert!((found.coords - expected).norm() < 1e-9, "{found:?} is not {expected:?}");
        }
    }

    #[test]
    fn what_both_legs_hang_on_is_no_leg() {
        let mut waisted = robot("tocabi");
        // A waist: link 0 carries the right leg too.
        waisted.links[6].parent = Some(0);
        let bones = waisted.bones();
        assert!(bones.iter().all(|(link, _)| *link != 0), "{bones:?}");
        assert_eq!(bones.len(), 9);
    }
}
