//! The result of welding: the moving bodies and the feet.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3, Vector3};

use super::block::Block;
use super::tree::Hinge;
use crate::robot::{Body, Foot, Joint, Link, Robot};

/// A tree of selected joints.
#[derive(Clone, Debug)]
pub struct Welded {
    /// The base with everything welded to it.
    pub base: Body,
    /// Whether the base's mass has to be filled in.
    pub weigh_base: bool,
    /// For bodies whose masses have to be filled in, the parts with unknown mass; `None` is the base.
    pub unweighed: BTreeMap<Option<usize>, Vec<String>>,
    /// The moving bodies in the order of the file.
    pub links: Vec<Moving>,
    /// Left and right foot; the box is absent if the foot has no shape.
    pub feet: [(usize, Option<Block>); 2],
    /// Names of the joints that were welded, at position zero.
    pub fixed: Vec<String>,
    /// Remarks on what could not be imported unchanged.
    pub notes: Vec<String>,
}

/// A moving body.
#[derive(Clone, Debug)]
pub struct Moving {
    /// The body with everything welded to it.
    pub body: Body,
    /// Index of its parent; `None` is the base.
    pub parent: Option<usize>,
    /// Pose of the joint in the parent's frame.
    pub origin: Isometry3<f64>,
    /// The joint.
    pub hinge: Hinge,
    /// Whether its mass has to be filled in.
    pub weigh: bool,
}

/// The body that a body of the file became part of: `None` is the base.
pub(super) type Owner = Option<usize>;

impl Welded {
    /// The joints that move.
    pub fn hinges(&self) -> impl Iterator<Item = &Hinge> {
        self.links.iter().map(|link| &link.hinge)
    }

    /// The tree as a robot whose unknown values are zero: only its geometry is valid.
    pub fn skeleton(&self) -> Robot {
        let link = |moving: &Moving| {
            let hinge = &moving.hinge;
            let figure = |value: Option<f64>| value.unwrap_or(0.0);
            Link {
                body: moving.body.clone(),
                parent: moving.parent,
                joint: Joint {
                    name: hinge.name.clone(),
                    origin: moving.origin,
                    axis: hinge.axis.unwrap_or_else(Vector3::x_axis),
                    lower: figure(hinge.lower),
                    upper: figure(hinge.upper),
                    effort_limit: figure(hinge.effort_limit),
                    velocity_limit: figure(hinge.velocity_limit),
                    damping: figure(hinge.damping),
                    friction: figure(hinge.friction),
                    armature: figure(hinge.armature),
                    stiffness_gain: figure(hinge.stiffness_gain),
                    damping_gain: figure(hinge.damping_gain),
                    default_position: figure(hinge.default_position),
                },
            }
        };
        let foot = |side: usize| {
            let (link, sole) = self.feet[side];
            let [centre, half_extents] = sole.map_or([Vector3::zeros(); 2], |sole| [sole.centre, sole.half]);
            Foot { link, half_extents, centre: Point3::from(centre), friction: 1.0 }
        };
        Robot {
            name: self.base.name.clone(),
            base: self.base.clone(),
            links: self.links.iter().map(link).collect(),
            feet: [foot(0), foot(1)],
            mirror: Vec::new(),
            standing_height: 0.0,
        }
    }
}
