//! W0417: values that differ between a joint or body and its mirror image, usually because of a mistake in
//! the file.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::scale::figure;
use super::{Examined, Outlier, level, mirrored, path_of, worst};
use crate::robot::checks::Issue;
use crate::robot::kinematics::Kinematics;
use crate::robot::model::{Body, Joint, Robot, Shape};

/// Relative difference, as a share of the larger value, up to which the two sides agree: measured halves
/// differ by less.
const SHARE: f64 = 0.1;
/// Difference of limits in rad up to which the two sides agree.
const ANGLE: f64 = 0.1;

/// Difference of default positions in rad up to which the two sides agree.
const POSE: f64 = 0.02;

/// Relative difference of inertia tensors up to which the two sides agree.
const TENSOR: f64 = 0.25;
/// Distance of a centre of mass from the mirror image of the other, as a share of the standing height, up to
/// which the two sides agree.
const CENTRE: f64 = 0.02;
/// Share of the robot's mass below which bodies are brackets, whose places and inertia do not matter.
const BRACKET: f64 = 2e-3;

/// A joint parameter to compare with the mirror image.
struct Figure {
    key: &'static str,
    unit: &'static str,
    of: fn(&Joint) -> f64,
}

const FIGURES: [Figure; 7] = [
    Figure { key: "effort_limit", unit: "N m", of: |joint| joint.effort_limit },
    Figure { key: "velocity_limit", unit: "rad/s", of: |joint| joint.velocity_limit },
    Figure { key: "damping", unit: "N m s/rad", of: |joint| joint.damping },
    Figure { key: "friction", unit: "N m", of: |joint| joint.friction },
    Figure { key: "armature", unit: "kg m^2", of: |joint| joint.armature },
    Figure { key: "stiffness_gain", unit: "N m/rad", of: |joint| joint.stiffness_gain },
    Figure { key: "damping_gain", unit: "N m s/rad", of: |joint| joint.damping_gain },
];

/// Joints and bodies of both sides have the same parameters. Where `in_si` is false, masses or inertias are in
/// wrong units, which is reported elsewhere, and their distributions are not compared.
pub fn check(robot: &Robot, in_si: bool) -> Examined {
    let pairs: Vec<(usize, usize, f64)> = robot
        .mirror
        .iter()
        .enumerate()
        .filter(|(index, (image, _))| index < image)
        .map(|(index, (image, sign))| (index, *image, *sign))
        .collect();
    let mut found = Vec::new();
    for &(index, image, sign) in &pairs {
        found.extend(joints(robot, [index, image], sign));
        found.extend(masses(robot, [index, image]));
        found.extend(shapes(robot, [index, image]));
    }
    // A foot whose frame is turned has a tilted sole, which the check of the pose reports.
    if in_si && level::is_level(robot) {
        found.extend(distributions(robot, &pairs));
    }
    found.extend(grip(robot));
    let help = "write the same figure on both sides, or, where the machine differs, allow this warning with \
        the reason";
    let issues: Vec<Issue> = worst("W0417", found, "figures", help).into_iter().collect();
    Examined {
        name: "left and right have the same figures",
        detail: format!("{} pairs of joints", pairs.len()),
        issues,
    }
}

/// The difference of two values as a share of the larger one, if they disagree.
fn apart(one: f64, other: f64) -> Option<f64> {
    let share = (one - other).abs() / one.abs().max(other.abs());
    (share > SHARE).then_some(share)
}

fn joints(robot: &Robot, pair: [usize; 2], sign: f64) -> Vec<Outlier> {
    let [one, other] = pair.map(|index| &robot.links[index].joint);
    let mut found = Vec::new();
    for Figure { key, unit, of } in &FIGURES {
        if let Some(excess) = apart(of(one), of(other)) {
            let message = format!(
                "`{key}` is {} {unit} of joint `{}` and {} {unit} of joint `{}`, its mirror image",
                figure(of(one)),
                one.name,
                figure(of(other)),
                other.name
            );
            found.push(Outlier { excess, path: format!("links.{}.joint.{key}", pair[1]), message });
        }
    }
    let mirrored = if sign < 0.0 { [-other.upper, -other.lower] } else { [other.lower, other.upper] };
    let off = (one.lower - mirrored[0]).abs().max((one.upper - mirrored[1]).abs());
    if off > ANGLE {
        let range = |joint: &Joint| format!("{:.3} .. {:.3} rad", joint.lower, joint.upper);
        let turned = if sign < 0.0 { " the other way round" } else { "" };
        let message = format!(
            "the range is {} of joint `{}` and {} of joint `{}`, its mirror image{turned}",
            range(one),
            one.name,
            range(other),
            other.name
        );
        let excess = off / (one.upper - one.lower).max(other.upper - other.lower);
        found.push(Outlier { excess, path: format!("links.{}.joint.lower", pair[1]), message });
    }
    let (apart, message) = mirrored::difference(robot, pair, sign);
    // If the soles are not level, the check of the pose reports it, with the positions to write.
    if apart > POSE && level::is_level(robot) {
        let excess = apart / (one.upper - one.lower).max(other.upper - other.lower);
        found.push(Outlier { excess, path: format!("links.{}.joint.default_position", pair[1]), message });
    }
    found
}

fn masses(robot: &Robot, pair: [usize; 2]) -> Option<Outlier> {
    let [one, other] = pair.map(|index| &robot.links[index].body);
    let excess = apart(one.mass, other.mass)?;
    // Bodies of a few grams are brackets, which may be on one side only.
    let counts = (one.mass - other.mass).abs() > BRACKET * robot.total_mass();
    let message = format!(
        "the mass is {:.5} kg of `{}` and {:.5} kg of `{}`, its mirror image",
        one.mass, one.name, other.mass, other.name
    );
    counts.then(|| Outlier { excess, path: format!("{}.mass", path_of(pair[1] + 1)), message })
}

/// Centres of mass and inertia tensors. With all joints at zero a robot with a mirror map is symmetric, so they
/// are compared there, in the base's frame.
fn distributions(robot: &Robot, pairs: &[(usize, usize, f64)]) -> Vec<Outlier> {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&Isometry3::identity(), &vec![0.0; robot.joints()]);
    let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
    let centre = |index: usize| (kinematics.pose(index) * robot.links[index].body.com).coords;
    let tensor = |index: usize| {
        let turn = kinematics.pose(index).rotation.to_rotation_matrix();
        turn * robot.links[index].body.inertia * turn.inverse()
    };
    let mut found = Vec::new();
    for &(index, image, _) in pairs {
        let [one, other] = [index, image].map(|index| &robot.links[index].body);
        if one.mass.max(other.mass) < 4.0 * BRACKET * robot.total_mass() {
            continue;
        }
        let away = (mirror * centre(index) - centre(image)).norm();
        if away > CENTRE * robot.standing_height.abs() {
            found.push(Outlier {
                excess: away / robot.standing_height.abs(),
                path: format!("{}.com", path_of(image + 1)),
                message: format!(
                    "the centre of mass of `{}` is {:.0} mm away from the mirror image of that of `{}`",
                    other.name,
                    1e3 * away,
                    one.name
                ),
            });
        }
        let [own, turned] = [mirror * tensor(index) * mirror, tensor(image)];
        let share = (own - turned).norm() / own.norm().max(turned.norm());
        if share > TENSOR {
            found.push(Outlier {
                excess: share,
                path: format!("{}.inertia", path_of(image + 1)),
                message: format!(
                    "the inertia of `{}` differs by {:.0} % from the mirror image of that of `{}`",
                    other.name,
                    100.0 * share,
                    one.name
                ),
            });
        }
    }
    found
}

/// Number and volume of the collision shapes.
fn shapes(robot: &Robot, pair: [usize; 2]) -> Option<Outlier> {
    let [one, other] = pair.map(|index| &robot.links[index].body);
    let path = format!("{}.collisions", path_of(pair[1] + 1));
    let [count, others] = [one, other].map(|body| body.collisions.len());
    if count != others {
        let message = format!(
            "`{}` has {count} collision shapes and `{}`, its mirror image, has {others}",
            one.name, other.name
        );
        return Some(Outlier { excess: 1.0, path, message });
    }
    let [own, image] = [one, other].map(volumes);
    let differ = own.iter().zip(&image).filter_map(|(own, image)| Some((apart(*own, *image)?, own, image)));
    let (excess, own, image) = differ.reduce(|a, b| if b.0 > a.0 { b } else { a })?;
    let message = format!(
        "a collision shape has {:.4} l of `{}` and {:.4} l of `{}`, its mirror image",
        1e3 * own,
        one.name,
        1e3 * image,
        other.name
    );
    Some(Outlier { excess, path, message })
}

/// The volumes of the collision shapes in m^3, sorted.
fn volumes(body: &Body) -> Vec<f64> {
    let volume = |shape: &Shape| match shape {
        Shape::Box(half) => 8.0 * half.x * half.y * half.z,
        Shape::Capsule(half, radius) => PI * radius * radius * (2.0 * half + 4.0 / 3.0 * radius),
        Shape::Cylinder(half, radius) => PI * radius * radius * 2.0 * half,
        Shape::Sphere(radius) => 4.0 / 3.0 * PI * radius.powi(3),
    };
    let mut volumes: Vec<f64> = body.collisions.iter().map(|collision| volume(&collision.shape)).collect();
    volumes.sort_by(f64::total_cmp);
    volumes
}

/// The friction of the soles.
fn grip(robot: &Robot) -> Option<Outlier> {
    let [left, right] = robot.feet.each_ref().map(|foot| foot.friction);
    let excess = apart(left, right)?;
    let message = format!(
        "the friction of the left sole is {}, and that of the right one {}",
        figure(left),
        figure(right)
    );
    Some(Outlier { excess, path: "feet.right.friction".to_owned(), message })
}
