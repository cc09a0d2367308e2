//! Robot parameters that a spec overrides.

use std::borrow::Cow;

use nalgebra::Point3;

use super::model::Robot;
use crate::spec::section::Robot as Stated;
use crate::spec::{Section, Table};

/// Applies `[robot]` of a decoded spec to the robot: `joint_damping` in N m s/rad, for all actuated joints.
pub fn state(robot: &mut Robot, fields: &Table) {
    if let Some(damping) = Section::new(fields).at(Stated::joint_damping) {
        robot.links.iter_mut().for_each(|link| link.joint.damping = damping);
    }
}

/// The robot with `robot.payload` of a decoded spec in kg, at the origin of its base. It is part of no recipe's
/// model: the robot stage adds it.
pub fn loaded<'a>(robot: &'a Robot, fields: &Table) -> Cow<'a, Robot> {
    match Section::new(fields).at(Stated::payload) {
        Some(payload) if payload > 0.0 => {
            let mut robot = robot.clone();
            robot.base.load(payload, Point3::origin());
            Cow::Owned(robot)
        }
        _ => Cow::Borrowed(robot),
    }
}

/// Whether a decoded spec overrides any.
pub fn any(fields: &Table) -> bool {
    Section::new(fields).at(Stated::joint_damping).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::shipped;
    use crate::spec::{Quantity, Value};

    #[test]
    fn a_stated_damping_is_that_of_every_joint_and_nothing_else_changes() {
        let robot = shipped("tocabi").expect("it comes with the program");
        let fields = |keys: &[(&str, f64)]| {
            let quantity = |si| Value::Quantity(Quantity { si, text: String::new() });
            let keys = keys.iter().map(|(key, si)| ((*key).to_owned(), quantity(*si)));
            Table::from([("robot".to_owned(), Value::Table(keys.collect()))])
        };
        let (mut silent, mut oiled) = (robot.clone(), robot.clone());
        state(&mut silent, &fields(&[("payload", 0.0)]));
        assert_eq!((&silent, any(&fields(&[("payload", 0.0)]))), (&robot, false));
        state(&mut oiled, &fields(&[("joint_damping", 0.22)]));
        assert!(any(&fields(&[("joint_damping", 0.22)])));
        assert!(oiled.links.iter().all(|link| link.joint.damping == 0.22));
        for (link, original) in oiled.links.iter_mut().zip(&robot.links) {
            link.joint.damping = original.joint.damping;
        }
        assert_eq!(oiled, robot);
    }

    #[test]
    fn a_payload_is_on_the_base_of_the_simulated_robot() {
        let robot = shipped("tocabi").expect("it comes with the program");
        let fields = |kilograms| {
            let payload = Value::Quantity(Quantity { si: kilograms, text: String::new() });
            Table::from([("robot".to_owned(), Value::Table(Table::from([("payload".to_owned(), payload)])))])
        };
        assert_eq!(*loaded(&robot, &fields(0.0)), robot);
        let heavy = loaded(&robot, &fields(20.0)).into_owned();
        assert!((heavy.base.mass - robot.base.mass - 20.0).abs() < 1e-12 && heavy.links == robot.links);
    }
}
