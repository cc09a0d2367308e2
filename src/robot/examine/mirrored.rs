//! Asymmetric default positions, which cause most poses with tilted soles. Levelling one sole by its ankle
//! would move the error to the other leg.

use super::level::{self, rounded};
use crate::robot::kinematics::Kinematics;
use crate::robot::legs;
use crate::robot::model::Robot;
use crate::robot::symmetry;

/// Maximum difference in rad of mirrored positions.
const ALIKE: f64 = 1e-3;
/// Maximum number of pairs listed by name; of the rest only the count is shown.
const NAMED: usize = 3;

/// Two joints whose default positions do not mirror each other.
#[derive(Clone, Copy, Debug)]
struct Unlike {
    /// The joint of the left leg, or one on the centre line.
    joint: usize,
    /// Its mirror image; itself for a joint on the centre line.
    image: usize,
    /// The sign of the mirrored coordinate.
    sign: f64,
}

/// A position that should replace the one in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Change {
    joint: usize,
    position: f64,
}

/// Why the two sides of a pose do not mirror each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// Place of the first position to change, as a path in the robot's file.
    pub path: String,
    /// What differs and which positions to write.
    pub help: String,
    /// Whether the suggested positions level both soles.
    pub levels: bool,
}

/// Default positions that do not mirror each other, with suggested positions. `None` if they do, or if the
/// robot has no mirror map.
pub fn cause(robot: &Robot) -> Option<Cause> {
    let pairs = unlike(robot, &map(robot)?);
    let first = pairs.first()?;
    let differ = in_words(robot, &pairs);
    let changes = [true, false].map(|of_left| changes(robot, &pairs, of_left));
    let changed = changes.each_ref().map(|changes| with(robot, changes));
    let levels = [0, 1].map(|way| within(robot, &changes[way]) && level::is_level(&changed[way]));
    let path = |changes: &[Change]| {
        let joint = changes.first().map_or(first.joint, |change| change.joint);
        format!("links.{joint}.joint.default_position")
    };
    let told = |way: usize, more: &str| Cause {
        path: path(&changes[way]),
        help: format!("{differ}: write {}{more}", written(robot, &changes[way])),
        levels: levels[way],
    };
    Some(match levels {
        [true, true] => told(1, ", or the same the other way round"),
        [true, false] => told(0, ""),
        [false, true] => told(1, ""),
        [false, false] => {
            let way = usize::from(level::steepest(&changed[1]) < level::steepest(&changed[0]));
            let rest = level::rest(&changed[way]);
            told(
                way,
                &rest.map_or_else(String::new, |rest| format!(", so that both legs are alike; then {rest}")),
            )
        }
    })
}

/// Whether the robot has a mirror map, so that the positions of both sides can be compared.
pub fn is_known(robot: &Robot) -> bool {
    map(robot).is_some()
}

/// The mirror map of a robot, which may be incomplete.
fn map(robot: &Robot) -> Option<Vec<(usize, f64)>> {
    if robot.mirror.is_empty() { symmetry::mirror_map(robot).ok() } else { Some(robot.mirror.clone()) }
}

/// The difference of two default positions in rad, and a text (W0417) with the expected value.
pub fn difference(robot: &Robot, pair: [usize; 2], sign: f64) -> (f64, String) {
    let [own, other] = pair.map(|index| &robot.links[index].joint);
    let turned = if sign < 0.0 { " with the other sign" } else { "" };
    let words = format!(
        "the default position is {} rad of joint `{}` and {} rad of joint `{}`, its mirror image{turned}",
        rounded(own.default_position),
        own.name,
        rounded(other.default_position),
        other.name
    );
    ((own.default_position - sign * other.default_position).abs(), words)
}

/// Joints whose default positions differ from those of their images, left leg first.
fn unlike(robot: &Robot, mirror: &[(usize, f64)]) -> Vec<Unlike> {
    let left = legs::own(&Kinematics::new(robot), 0);
    let position = |joint: usize| robot.links[joint].joint.default_position;
    let pairs =
        mirror.iter().enumerate().map(|(joint, (image, sign))| Unlike { joint, image: *image, sign: *sign });
    let once = |pair: &Unlike| {
        left.contains(&pair.joint) || (!left.contains(&pair.image) && pair.joint <= pair.image)
    };
    let differs = |pair: &Unlike| (position(pair.joint) - pair.sign * position(pair.image)).abs() > ALIKE;
    pairs.filter(once).filter(differs).collect()
}

/// The positions that make one side the image of the other; joints on the centre line become zero.
fn changes(robot: &Robot, pairs: &[Unlike], of_left: bool) -> Vec<Change> {
    let position = |joint: usize| robot.links[joint].joint.default_position;
    let change = |pair: &Unlike| match (pair.joint == pair.image, of_left) {
        (true, _) => Change { joint: pair.joint, position: 0.0 },
        (false, true) => Change { joint: pair.joint, position: pair.sign * position(pair.image) },
        (false, false) => Change { joint: pair.image, position: pair.sign * position(pair.joint) },
    };
    pairs.iter().map(change).collect()
}

fn with(robot: &Robot, changes: &[Change]) -> Robot {
    let mut robot = robot.clone();
    for Change { joint, position } in changes {
        robot.links[*joint].joint.default_position = *position;
    }
    robot
}

fn within(robot: &Robot, changes: &[Change]) -> bool {
    changes.iter().all(|Change { joint, position }| {
        let own = &robot.links[*joint].joint;
        (own.lower..=own.upper).contains(position)
    })
}

/// What differs: a clause.
fn in_words(robot: &Robot, pairs: &[Unlike]) -> String {
    let joint = |index: usize| &robot.links[index].joint;
    let words = |Unlike { joint: own, image, sign }: &Unlike| {
        let (own, other) = (joint(*own), joint(*image));
        let position = rounded(own.default_position);
        if own.name == other.name {
            return format!("`{}` in the middle of the robot has {position} rad", own.name);
        }
        let wanted = rounded(sign * own.default_position);
        let sign = if *sign < 0.0 { format!(" and not {wanted} rad") } else { String::new() };
        format!(
            "`{}` has {position} rad and `{}` {} rad{sign}",
            own.name,
            other.name,
            rounded(other.default_position)
        )
    };
    let named: Vec<String> = pairs.iter().take(NAMED).map(words).collect();
    let more = match pairs.len().saturating_sub(NAMED) {
        0 => String::new(),
        count => format!("; {count} more"),
    };
    format!("the default positions of left and right do not mirror each other ({}{more})", named.join("; "))
}

fn written(robot: &Robot, changes: &[Change]) -> String {
    let one = |Change { joint, position }: &Change| {
        format!(
            "`default_position = \"{} rad\"` for joint `{}`",
            rounded(*position),
            robot.links[*joint].joint.name
        )
    };
    changes.iter().map(one).collect::<Vec<_>>().join(", ")
}
