//! E04xx: what the robot's own checks found, as diagnostics at the spec and in the robot's file.

use std::collections::BTreeMap;

use crate::diag::{Diagnostic, Span};

/// A finding about the robot's file: at the value in that file when it has a place, and at `robot.model` of the spec.
pub fn issue(
    (code, path): (&'static str, &str),
    message: &str,
    places: &BTreeMap<String, Span>,
    named: Option<Span>,
) -> Diagnostic {
    let mut diagnostic = Diagnostic::error(code, message);
    let mut path = path;
    let place = loop {
        if let Some(place) = places.get(path) {
            break Some(*place);
        }
        match path.rsplit_once('.') {
            Some((above, _)) => path = above,
            None => break None,
        }
    };
    match (place, named) {
        (Some(place), Some(named)) => diagnostic = diagnostic.at(place, "").note(named, "the robot of this spec"),
        (Some(place), None) | (None, Some(place)) => diagnostic = diagnostic.at(place, ""),
        (None, None) => {}
    }
    diagnostic
}

#[cfg(test)]
pub(super) mod sample {
    use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

    use crate::robot::model::Body;
    use crate::robot::{Foot, Joint, Link, Robot};

    /// A robot with a hip roll and a knee, with TOCABI's figures.
    pub fn biped() -> Robot {
        let body = |name: &str| Body {
            name: name.to_owned(),
            mass: 1.0,
            com: Point3::origin(),
            inertia: Matrix3::identity(),
            collisions: vec![],
        };
        let link = |name: &str, parent, (lower, upper), effort_limit, stiffness_gain| Link {
            body: body(name),
            parent,
            joint: Joint {
                name: name.to_owned(),
                origin: Isometry3::identity(),
                axis: Vector3::x_axis(),
                lower,
                upper,
                effort_limit,
                velocity_limit: 4.0,
                damping: 0.0,
                friction: 0.0,
                armature: 0.0,
                stiffness_gain,
                damping_gain: 1.0,
                default_position: 0.0,
            },
        };
        let foot = || Foot { link: 1, half_extents: Vector3::new(0.1, 0.05, 0.02), centre: Point3::origin() };
        Robot {
            name: "biped".to_owned(),
            base: body("base"),
            links: vec![
                link("hip_roll", None, (-3.0, 3.0), 232.0, 5000.0),
                link("knee", Some(0), (-0.5, 3.0), 289.0, 3700.0),
            ],
            feet: [foot(), foot()],
            mirror: vec![(0, 1.0), (1, 1.0)],
            standing_height: 0.9,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diag::SourceId;

    #[test]
    fn an_issue_points_into_the_robots_file_and_names_the_spec() {
        let in_robot = Span { source: SourceId(1), start: 10, end: 20 };
        let in_spec = Span { source: SourceId(0), start: 3, end: 8 };
        let places = BTreeMap::from([("links.3".to_owned(), in_robot)]);
        let diagnostic = issue(("E0405", "links.3.mass"), "the mass is not positive", &places, Some(in_spec));
        assert_eq!(diagnostic.labels.iter().map(|label| label.span).collect::<Vec<_>>(), [in_robot, in_spec]);
        let diagnostic = issue(("E0405", "feet"), "no feet", &places, Some(in_spec));
        assert_eq!(diagnostic.labels.len(), 1);
    }
}
