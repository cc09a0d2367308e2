//! E04xx and W04xx: findings of the robot checks as diagnostics in the spec and the robot file.

use crate::diag::{Diagnostic, Span};
use crate::robot::{self, Issue};
use crate::spec::Marks;

/// A finding about the robot's file: at the value in that file, and at `robot.model` of the spec, which is
/// the primary label if the file has no place for it.
pub fn issue(issue: &Issue, marks: &Marks, named: Option<Span>) -> Diagnostic {
    let found = robot::diagnostic(issue, marks);
    match named {
        Some(named) if found.labels.is_empty() => found.at(named, ""),
        Some(named) => found.note(named, "the robot of this spec"),
        None => found,
    }
}

#[cfg(test)]
pub(super) mod sample {
    use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

    use crate::robot::model::Body;
    use crate::robot::{Foot, Joint, Link, Robot};

    /// A robot with a hip roll and a knee, with TOCABI's parameters.
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
        let foot = || Foot {
            link: 1,
            half_extents: Vector3::new(0.1, 0.05, 0.02),
            centre: Point3::origin(),
            friction: 1.0,
        };
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
    use crate::spec::Mark;
    use crate::syntax::Layer;

    #[test]
    fn an_issue_points_into_the_robots_file_and_names_the_spec() {
        let in_robot = Span { source: SourceId(1), start: 10, end: 20 };
        let in_spec = Span { source: SourceId(0), start: 3, end: 8 };
        let mut marks = Marks::default();
        let mark = Mark { key: in_robot, value: in_robot, layer: Layer::File, text: String::new() };
        marks.by_path.insert("links.3".to_owned(), mark);
        let found = Issue::model("links.3.mass", "the mass is not positive", "masses are positive");
        let diagnostic = issue(&found, &marks, Some(in_spec));
        assert_eq!(diagnostic.labels.iter().map(|label| label.span).collect::<Vec<_>>(), [in_robot, in_spec]);
        let elsewhere = Issue::model("feet", "no feet", "");
        assert_eq!(issue(&elsewhere, &marks, Some(in_spec)).labels.len(), 1);
    }
}
