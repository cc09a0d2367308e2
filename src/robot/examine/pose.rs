//! E0420 to E0423 and W0416: whether the robot can stand in its default pose with the base upright, where
//! episodes begin.

use super::level::{self, APART, TILT, tilt};
use super::{Examined, Outlier, mirrored, path_of, worst};
use crate::robot::checks::Issue;
use crate::robot::kinematics::Kinematics;
use crate::robot::legs;
use crate::robot::model::Robot;
use crate::robot::self_collision::{Pair, SelfCollision};
use crate::robot::solid::{pose, solid};
use crate::robot::support::Support;

/// Depth in m by which bodies other than feet may be below the soles.
const DEPTH: f64 = 1e-3;
/// Bodies on one chain may overlap if at most this many joints apart: the joints of a hip coincide, and the
/// shapes around them overlap.
const NEAR: usize = 3;

const SIDES: [&str; 2] = ["left", "right"];

/// Every check of the default pose.
pub fn checks(robot: &Robot) -> Vec<Examined> {
    let kinematics = Kinematics::new(robot);
    vec![soles(robot, &kinematics), support(&kinematics), ground(robot, &kinematics), overlaps(robot)]
}

/// The robot is balanced (E0421).
pub fn balance(robot: &Robot) -> Examined {
    support(&Kinematics::new(robot))
}

/// The soles are flat and at one height (E0420).
fn soles(robot: &Robot, kinematics: &Kinematics) -> Examined {
    let tilts = [0, 1].map(|side| tilt(kinematics, side).0);
    let heights = [0, 1].map(|side| kinematics.sole(side).translation.z);
    let apart = (heights[0] - heights[1]).abs();
    let steepest = usize::from(tilts[1] > tilts[0]);
    let mut issues = Vec::new();
    if tilts[steepest] > TILT {
        let (side, degrees) = (SIDES[steepest], tilts[steepest].to_degrees());
        let message = if tilts.iter().all(|tilt| *tilt > TILT) {
            format!("both soles are tilted in the default pose, the {side} one by {degrees:.1} deg")
        } else {
            format!("the {side} sole is tilted by {degrees:.1} deg in the default pose")
        };
        let advice = || level::advice(robot, kinematics, steepest);
        let alone = tilts.iter().any(|tilt| *tilt <= TILT);
        let (path, help) = match mirrored::cause(robot) {
            // Joint positions do not explain a larger tilt.
            Some(cause) if tilts[steepest] <= level::FRAME || cause.levels => (cause.path, cause.help),
            None if alone && mirrored::is_known(robot) => {
                (format!("feet.{side}"), level::turned(robot, steepest))
            }
            _ => (format!("feet.{side}"), advice()),
        };
        issues.push(Issue { code: "E0420", path, message, help });
    } else if apart > APART {
        let lower = SIDES[usize::from(heights[1] < heights[0])];
        let message =
            format!("the {lower} sole is {:.1} mm below the other one in the default pose", 1e3 * apart);
        let (path, help) = match mirrored::cause(robot) {
            Some(cause) => (cause.path, cause.help),
            None => ("feet".to_owned(), boxes(robot)),
        };
        issues.push(Issue { code: "E0420", path, message, help });
    }
    Examined {
        name: "soles are flat and level in the default pose",
        detail: format!("tilt {:.1e} rad, {:.2} mm apart in height", tilts[steepest], 1e3 * apart),
        issues,
    }
}

/// Advice if one sole is lower although both legs have mirrored positions.
fn boxes(robot: &Robot) -> String {
    let below = robot.feet.each_ref().map(|foot| -1e3 * foot.sole());
    if (below[0] - below[1]).abs() <= 1e3 * APART {
        return "give both legs mirrored default positions, and both feet the same box".to_owned();
    }
    format!(
        "give both feet the same box: its lower face is {:.1} mm below the origin of the left foot and \
         {:.1} mm below that of the \
         right one",
        below[0], below[1]
    )
}

/// The centre of mass is above the support polygon (E0421).
fn support(kinematics: &Kinematics) -> Examined {
    let com = kinematics.com().xy();
    let support = Support::new(kinematics, [true; 2]);
    let margin = support.margin(&com);
    let (inside, distance) = (margin > 0.0, 1e3 * margin.abs());
    let issue = || {
        let side = |axis: usize| {
            let corners = || support.corners().iter().map(|corner| corner[axis]);
            let (low, high) =
                (corners().fold(f64::INFINITY, f64::min), corners().fold(f64::NEG_INFINITY, f64::max));
            if com[axis] > high {
                1
            } else if com[axis] < low {
                -1
            } else {
                0
            }
        };
        let place = match (side(0), side(1)) {
            (1, _) => "in front of",
            (-1, _) => "behind",
            (_, 1) => "to the left of",
            (_, -1) => "to the right of",
            _ => "beside",
        };
        Issue {
            code: "E0421",
            path: "feet".to_owned(),
            message: format!(
                "the robot falls over in its default pose: its centre of mass is {distance:.0} mm {place} \
                 the support polygon"
            ),
            help:
                "choose default positions that bring the soles below the centre of mass, or correct masses \
                and centres of mass"
                    .to_owned(),
        }
    };
    Examined {
        name: "the default pose stands: its centre of mass is above the support polygon",
        detail: format!("{distance:.0} mm {} its border", if inside { "inside" } else { "outside" }),
        issues: (!inside).then(issue).into_iter().collect(),
    }
}

/// Only the soles touch the ground (E0422).
fn ground(robot: &Robot, kinematics: &Kinematics) -> Examined {
    let floor =
        [0, 1].map(|side| kinematics.sole(side).translation.z).into_iter().fold(f64::INFINITY, f64::min);
    let own =
        robot.links.iter().enumerate().filter(|(index, _)| robot.feet.iter().all(|foot| foot.link != *index));
    let links = own.map(|(index, link)| (index + 1, &link.body, *kinematics.pose(index)));
    let all = std::iter::once((0, &robot.base, *kinematics.base())).chain(links);
    let heights: Vec<(usize, &str, f64)> = all
        .flat_map(|(index, body, place)| {
            let lowest = body.collisions.iter().map(move |collision| {
                let (shape, own) = solid(collision);
                f64::from(shape.compute_aabb(&pose(&(place * own))).mins.z)
            });
            lowest.reduce(f64::min).map(|lowest| (index, body.name.as_str(), lowest - floor))
        })
        .collect();
    let below = heights.iter().filter(|(.., height)| *height < -DEPTH).map(|(index, name, height)| Outlier {
        excess: -height,
        path: path_of(*index),
        message: format!("`{name}` is {:.0} mm below the soles in the default pose", -1e3 * height),
    });
    let help = "correct its collision shapes or the default pose: an episode ends when anything but a foot \
        touches the ground";
    let mut issues: Vec<Issue> = worst("E0422", below.collect(), "bodies", help).into_iter().collect();
    if -floor <= 0.0 {
        issues.push(Issue {
            code: "E0422",
            path: "base".to_owned(),
            message: format!(
                "the base's origin is {:.0} mm below the soles in the default \
                pose",
                1e3 * floor
            ),
            help: "turn or move the base's frame: z points up, x forward, and heights are measured at its \
                origin"
                .to_owned(),
        });
    }
    let lowest = heights.into_iter().min_by(|a, b| a.2.total_cmp(&b.2));
    Examined {
        name: "only the soles touch the ground in the default pose",
        detail: match lowest {
            Some((_, name, height)) => format!("`{name}` is the next, {:.0} mm above it", 1e3 * height),
            None => "no other body has a collision shape".to_owned(),
        },
        issues,
    }
}

/// No two bodies overlap (E0423, W0416).
fn overlaps(robot: &Robot) -> Examined {
    let pairs = SelfCollision::overlapping(robot);
    let kinematics = Kinematics::new(robot);
    let legs = [0, 1].map(|side| legs::own(&kinematics, side));
    let side_of =
        |body: usize| legs.iter().position(|leg| body.checked_sub(1).is_some_and(|link| leg.contains(&link)));
    let crossing = |pair: &Pair| matches!(pair.map(side_of), [Some(one), Some(other)] if one != other);
    let (crossed, others): (Vec<Pair>, Vec<Pair>) = pairs.into_iter().partition(crossing);
    let others: Vec<Pair> = others.into_iter().filter(|pair| !is_near(robot, *pair)).collect();
    let outlier = |pair: &Pair| {
        let [first, second] = SelfCollision::names(robot, *pair);
        let message = format!("`{first}` and `{second}` collide in the default pose");
        Outlier { excess: 0.0, path: path_of(pair[1]), message }
    };
    let help = "move the legs apart in the default pose, or give the bodies smaller collision shapes";
    let mut issues: Vec<Issue> =
        worst("E0423", crossed.iter().map(outlier).collect(), "pairs", help).into_iter().collect();
    let help = "give them smaller collision shapes: bodies that begin inside each other are not checked for \
        self-collisions";
    issues.extend(worst("W0416", others.iter().map(outlier).collect(), "pairs", help));
    Examined {
        name: "no two bodies collide in the default pose",
        detail: format!("{} pairs are checked for self-collisions", SelfCollision::pairs(robot).len()),
        issues,
    }
}

/// Whether two bodies are connected by a chain of few joints.
fn is_near(robot: &Robot, [first, second]: Pair) -> bool {
    let parent = |body: &usize| {
        body.checked_sub(1).map(|link| robot.links[link].parent.map_or(0, |parent| parent + 1))
    };
    std::iter::successors(Some(second), parent).take(NEAR + 1).any(|body| body == first)
}
