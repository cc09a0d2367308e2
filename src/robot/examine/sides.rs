//! E0426: whether the left foot is on the left. Mirrored motions, commands and rewards depend on it.

use nalgebra::{Isometry3, Vector3};

use super::{Examined, bend};
use crate::robot::checks::Issue;
use crate::robot::kinematics::Kinematics;
use crate::robot::model::Robot;
use crate::robot::symmetry::side_of;

/// Minimum distance in m between the soles for a definite left and right.
const CLEAR: f64 = 1e-3;

/// With all joints at zero, the left foot is on the left and the right one on the right.
pub fn check(robot: &Robot) -> Examined {
    let way = across(robot);
    Examined {
        name: "the left foot is on the left",
        detail: format!("its sole is {:.0} mm to the left of the right one", 1e3 * way.y),
        issues: issue(robot).into_iter().collect(),
    }
}

/// From the right sole to the left one, with all joints at zero, in m.
fn across(robot: &Robot) -> Vector3<f64> {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&Isometry3::identity(), &vec![0.0; robot.joints()]);
    kinematics.sole(0).translation.vector - kinematics.sole(1).translation.vector
}

/// Feet on the wrong sides, with the cause.
pub fn issue(robot: &Robot) -> Option<Issue> {
    let way = across(robot);
    if way.norm() < CLEAR || (way.y > way.x.abs() && way.y > way.z.abs()) {
        return None;
    }
    if let Some(bend) = bend::of(robot) {
        return Some(bend.issue(robot));
    }
    let base = &robot.base.name;
    let [left, right] = robot.feet.each_ref().map(|foot| robot.links[foot.link].body.name.as_str());
    let turned = |message: String, axes: &str| Issue {
        code: "E0426",
        path: "base".to_owned(),
        message,
        help: format!(
            "turn the frame of `{base}`, with the figures of the body and the origins of the joints on it, \
             until {axes}, as \
             `specforge robot import` does"
        ),
    };
    if way.x.abs() >= way.y.abs().max(way.z.abs()) {
        let order = if way.x > 0.0 { "in front of" } else { "behind" };
        let message = format!(
            "the left foot `{left}` is {order} the right one `{right}`: y does not point to the left"
        );
        return Some(turned(message, "x points forward and y to the left"));
    }
    if way.z.abs() >= way.y.abs() {
        let order = if way.z > 0.0 { "above" } else { "below" };
        let message =
            format!("the left foot `{left}` is {order} the right one `{right}`: z does not point up");
        return Some(turned(message, "z points up and y to the left"));
    }
    let message = format!(
        "the left foot `{left}` is on the right of the robot and the right foot `{right}` on the left"
    );
    let exchange = format!(
        "write `link = \"{right}\"` in [feet.left] and `link = \"{left}\"` in [feet.right], with their soles"
    );
    let names = [left, right].map(side_of);
    let backward = || turned(message.clone(), "x points forward and y to the left");
    Some(match names {
        [Some(1), Some(-1)] => backward(),
        [Some(-1), Some(1)] => Issue { code: "E0426", path: "feet".to_owned(), message, help: exchange },
        _ => {
            let Issue { help, .. } = backward();
            let help = format!("{exchange}; or, where x points backward, {help}");
            Issue { code: "E0426", path: "feet".to_owned(), message, help }
        }
    })
}
