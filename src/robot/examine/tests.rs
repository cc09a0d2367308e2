use nalgebra::{Isometry3, Point3, Vector3};

use super::{all, issues};
use crate::robot::gravity::{GravityCompensation, Weighting};
use crate::robot::model::{Body, Collision, Robot, Shape};
use crate::robot::tests::robot;

/// The findings for TOCABI after a change: codes and paths.
fn found(change: impl FnOnce(&mut Robot)) -> Vec<(&'static str, String)> {
    let mut robot = robot("tocabi");
    change(&mut robot);
    found_in(&robot)
}

fn found_in(robot: &Robot) -> Vec<(&'static str, String)> {
    issues(all(robot)).into_iter().map(|issue| (issue.code, issue.path)).collect()
}

fn codes(change: impl FnOnce(&mut Robot)) -> Vec<&'static str> {
    found(change).into_iter().map(|(code, _)| code).collect()
}

fn joint(robot: &Robot, name: &str) -> usize {
    robot.links.iter().position(|link| link.joint.name == name).expect("the robot has this joint")
}

fn bodies(robot: &mut Robot) -> impl Iterator<Item = &mut Body> {
    std::iter::once(&mut robot.base).chain(robot.links.iter_mut().map(|link| &mut link.body))
}

/// The robot at another size and density: lengths times `size`, masses times `size^3 * density`.
fn scaled(mut robot: Robot, size: f64, density: f64) -> Robot {
    let mass = size.powi(3) * density;
    let grow = |pose: &mut Isometry3<f64>| pose.translation.vector *= size;
    for body in bodies(&mut robot) {
        (body.mass, body.inertia) = (body.mass * mass, body.inertia * (mass * size * size));
        body.com.coords *= size;
        for collision in &mut body.collisions {
            grow(&mut collision.pose);
            collision.shape = match collision.shape.clone() {
                Shape::Box(half) => Shape::Box(half * size),
                Shape::Capsule(half, radius) => Shape::Capsule(half * size, radius * size),
                Shape::Cylinder(half, radius) => Shape::Cylinder(half * size, radius * size),
                Shape::Sphere(radius) => Shape::Sphere(radius * size),
            };
        }
    }
    for link in &mut robot.links {
        grow(&mut link.joint.origin);
        let joint = &mut link.joint;
        (joint.effort_limit, joint.friction) =
            (joint.effort_limit * mass * size, joint.friction * mass * size);
        (joint.stiffness_gain, joint.damping_gain) =
            (joint.stiffness_gain * mass * size, joint.damping_gain * mass * size);
        (joint.damping, joint.armature) = (joint.damping * mass * size, joint.armature * mass * size * size);
    }
    for foot in &mut robot.feet {
        foot.half_extents *= size;
        foot.centre.coords *= size;
    }
    robot.standing_height *= size;
    robot
}

#[test]
fn robots_from_0_2_to_3_m_and_of_any_usual_density_pass() {
    for name in crate::robot::names() {
        for (size, density) in [(1.0, 1.0), (0.2, 1.0), (0.2, 3.0), (0.35, 0.3), (1.5, 1.0), (3.0, 0.5)] {
            let found = found_in(&scaled(robot(name), size, density));
            assert!(found.is_empty(), "{name} {size} {density}: {found:?}");
        }
    }
}

#[test]
fn tilted_and_uneven_soles_are_told_with_the_position_that_levels_them() {
    let ankle = |robot: &Robot, side: &str| joint(robot, &format!("{side}_AnklePitch_Joint"));
    let tilted = |by: f64| {
        let mut robot = robot("tocabi");
        for side in ["L", "R"] {
            let ankle = ankle(&robot, side);
            robot.links[ankle].joint.default_position += by;
        }
        robot
    };
    assert!(found_in(&tilted(0.009)).is_empty());
    for by in [0.02, -0.02, 0.3] {
        let robot = tilted(by);
        let found = issues(all(&robot));
        assert_eq!((found[0].code, found[0].path.as_str()), ("E0420", "feet.left"), "{by}");
        let expected =
            "write `default_position = \"-0.36 rad\"` for joint `L_AnklePitch_Joint`, and mirrored";
        assert!(found[0].help.starts_with(expected), "{}", found[0].help);
    }
    let rolled = {
        let mut robot = robot("tocabi");
        let ankle = joint(&robot, "L_AnkleRoll_Joint");
        robot.links[ankle].joint.default_position += 0.1;
        robot
    };
    let told = issues(all(&rolled));
    let help = &told.iter().find(|issue| issue.code == "E0420").expect("it is tilted").help;
    let cause = "`L_AnkleRoll_Joint` has 0.1 rad and `R_AnkleRoll_Joint` 0 rad and not -0.1 rad";
    assert!(help.contains(cause), "{help}");
    assert!(help.ends_with("write `default_position = \"0 rad\"` for joint `L_AnkleRoll_Joint`"), "{help}");
    let uneven = found(|robot| robot.feet[0].centre.z += 0.003);
    assert_eq!(uneven, [("E0420", "feet".to_owned())]);
    let flipped = {
        let mut robot = robot("tocabi");
        let foot = robot.feet[0].link;
        let turn = Isometry3::rotation(Vector3::x() * std::f64::consts::FRAC_PI_2);
        robot.links[foot].joint.origin *= turn;
        robot
    };
    let found = issues(all(&flipped));
    assert!(
        found[0].code == "E0420" && found[0].help.contains("the frame of `L_AnkleRoll_Link`"),
        "{found:?}"
    );
}

#[test]
fn a_centre_of_mass_outside_the_soles_is_told_with_its_direction() {
    for (axis, by, place) in [
        (0, 0.5, "in front of"),
        (0, -0.5, "behind"),
        (1, 0.5, "to the left of"),
        (1, -0.5, "to the right of"),
    ] {
        let mut robot = robot("tocabi");
        robot.base.com[axis] += by;
        let found = issues(all(&robot));
        assert!(
            found.iter().any(|issue| issue.code == "E0421" && issue.message.contains(place)),
            "{place}: {found:?}"
        );
    }
}

#[test]
fn a_body_below_the_ground_and_a_base_below_the_feet_are_told() {
    let ball = |z: f64| Collision { shape: Shape::Sphere(0.1), pose: Isometry3::translation(0.0, 0.0, z) };
    let height = robot("tocabi").standing_height;
    assert_eq!(
        found(|robot| robot.base.collisions.push(ball(-height + 0.05))).first(),
        Some(&("E0422", "base".to_owned()))
    );
    assert!(!codes(|robot| robot.base.collisions.push(ball(-height + 0.101))).contains(&"E0422"));
    // With its base frame turned about x the robot is upside down.
    let turned = codes(|robot| {
        let turn = Isometry3::rotation(Vector3::x() * std::f64::consts::PI);
        let own: Vec<usize> =
            (0..robot.links.len()).filter(|index| robot.links[*index].parent.is_none()).collect();
        own.into_iter()
            .for_each(|index| robot.links[index].joint.origin = turn * robot.links[index].joint.origin);
    });
    assert!(turned.contains(&"E0422"), "{turned:?}");
}

#[test]
fn legs_inside_each_other_are_an_error_and_other_overlaps_a_warning() {
    // Soles of 0.17 m with centres 0.205 m apart.
    let wide = |half: f64| {
        move |robot: &mut Robot| robot.feet.iter_mut().for_each(|foot| foot.half_extents.y = half)
    };
    assert!(codes(wide(0.1)).is_empty());
    assert_eq!(codes(wide(0.104)), ["E0423"]);
    let long = codes(|robot| {
        let shape = Shape::Box(Vector3::new(0.05, 0.05, 0.9));
        robot.base.collisions.push(Collision { shape, pose: Isometry3::translation(0.0, 0.1025, 0.01) });
    });
    assert!(long.contains(&"W0416"), "{long:?}");
}

#[test]
fn inertias_and_masses_of_other_units_are_told() {
    let inertia = |factor: f64| found(|robot| robot.base.inertia *= factor);
    for factor in [1e9, 1e6, 1e4, 1e-3, 1e-4, 1e-6, 1e-9] {
        let told = inertia(factor);
        let code = if factor == 1e9 { "E0424" } else { "W0410" };
        assert_eq!(told, [(code, "base.inertia".to_owned())], "{factor}");
    }
    assert!(inertia(3.0).is_empty() && inertia(0.3).is_empty());
    // An error of 30 to 100 is not a unit, but no such body exists either.
    for name in crate::robot::names() {
        for factor in [30.0, 100.0] {
            let mut robot = robot(name);
            robot.base.inertia *= factor;
            assert_eq!(found_in(&robot), [("W0410", "base.inertia".to_owned())], "{name} {factor}");
        }
    }
    for (link, factor) in [(2, 30.0), (3, 30.0), (5, 100.0)] {
        let told = found(|robot| robot.links[link].body.inertia *= factor);
        assert_eq!(told, [("W0410", format!("links.{link}.inertia"))], "{link}");
    }
    // One shank, and every body.
    let shank = found(|robot| robot.links[3].body.inertia *= 1e4);
    assert_eq!(shank, [("W0410", "links.3.inertia".to_owned())]);
    assert_eq!(codes(|robot| bodies(robot).for_each(|body| body.inertia *= 1e6)), ["W0410"]);
    let grams = |robot: &mut Robot| bodies(robot).for_each(|body| body.mass *= 1e3);
    assert!(codes(grams).contains(&"W0411"));
    let tonnes = |robot: &mut Robot| bodies(robot).for_each(|body| body.mass *= 1e-3);
    assert!(codes(tonnes).contains(&"W0411"));
    assert!(!codes(|robot| robot.links[2].body.mass *= 1e3).is_empty());
}

#[test]
fn lengths_and_centres_of_mass_of_other_units_are_told() {
    for name in crate::robot::names() {
        for size in [1e3, 1e2, 0.01] {
            let mut large = scaled(robot(name), size, size.powi(-3));
            large.links.iter_mut().for_each(|link| link.joint.effort_limit = 100.0);
            let found = found_in(&large);
            assert!(
                found.iter().any(|(code, _)| ["W0412", "E0424"].contains(code)),
                "{name} {size}: {found:?}"
            );
        }
    }
    let com = |z: f64| found(|robot| robot.base.com.z = z);
    assert_eq!(com(120.0)[0], ("E0424", "base.com".to_owned()));
    assert_eq!(com(12.0)[0], ("W0413", "base.com".to_owned()));
    assert_eq!(com(3.0)[0], ("W0413", "base.com".to_owned()));
    assert!(com(0.35).is_empty(), "{:?}", com(0.35));
    let shank = found(|robot| robot.links[3].body.com = Point3::new(0.0, 0.0, -15.0));
    assert!(shank.contains(&("W0413", "links.3.com".to_owned())), "{shank:?}");
    let mesh = found(|robot| {
        let shape = Shape::Box(Vector3::new(30.0, 20.0, 25.0));
        robot.base.collisions.push(Collision { shape, pose: Isometry3::translation(0.0, 0.0, 40.0) });
    });
    assert!(
        mesh.iter().any(|(code, path)| *code == "W0412" && path.starts_with("base.collisions.")),
        "{mesh:?}"
    );
    let sole = codes(|robot| robot.feet.iter_mut().for_each(|foot| foot.half_extents *= 1e3));
    assert!(sole.contains(&"E0424") || sole.contains(&"W0412"), "{sole:?}");
}

#[test]
fn figures_beyond_all_bounds_are_errors() {
    for (key, change) in [
        ("effort_limit", (|robot, value| robot.links[3].joint.effort_limit = value) as fn(&mut Robot, f64)),
        ("velocity_limit", |robot, value| robot.links[3].joint.velocity_limit = value),
        ("damping", |robot, value| robot.links[3].joint.damping = value),
        ("friction", |robot, value| robot.links[3].joint.friction = value),
        ("armature", |robot, value| robot.links[3].joint.armature = value),
        ("stiffness_gain", |robot, value| robot.links[3].joint.stiffness_gain = value),
        ("damping_gain", |robot, value| robot.links[3].joint.damping_gain = value),
        ("lower", |robot, value| robot.links[3].joint.lower = -value),
        ("upper", |robot, value| robot.links[3].joint.upper = value),
    ] {
        for value in [1e300, 1e20, 1.1e6] {
            assert_eq!(
                found(|robot| change(robot, value)),
                [("E0424", format!("links.3.joint.{key}"))],
                "{key} {value}"
            );
        }
    }
    assert_eq!(found(|robot| robot.links[2].body.mass = 1e300), [("E0424", "links.2.mass".to_owned())]);
    assert_eq!(
        found(|robot| robot.links[2].joint.origin.translation.z = -1e300),
        [("E0424", "links.2.joint.origin".to_owned())]
    );
}

#[test]
fn drives_that_cannot_move_their_joints_are_told() {
    // One changed knee also differs from the other (W0417).
    let knee = |change: fn(&mut crate::robot::model::Joint)| -> Vec<&'static str> {
        let found = codes(|robot| change(&mut robot.links[3].joint));
        found.into_iter().filter(|code| *code != "W0417").collect()
    };
    // The knee has 289 N m; the whole robot's inertia at its size is 100 kg m^2.
    assert_eq!(knee(|joint| joint.friction = 289.0), ["E0425"]);
    assert_eq!(knee(|joint| joint.damping = 300.0), ["W0415"]);
    assert_eq!(knee(|joint| joint.armature = 200.0), ["W0415"]);
    assert_eq!(knee(|joint| joint.effort_limit = 20_000.0), ["W0414"]);
    assert_eq!(knee(|joint| joint.velocity_limit = 1000.0), ["W0414"]);
    assert_eq!(knee(|joint| (joint.lower, joint.upper) = (-4.0, 4.0)), ["W0414"]);
    assert!(knee(|joint| (joint.friction, joint.damping, joint.armature) = (100.0, 50.0, 5.0)).is_empty());
    // Just below the effort limit nothing is left to move the leg.
    assert_eq!(knee(|joint| joint.friction = 285.0), ["E0425"]);
    assert_eq!(knee(|joint| joint.friction = 180.0), ["W0415"]);
    let mut gravity = GravityCompensation::new(&robot("tocabi"), Weighting::EffortLimits);
    let standing =
        gravity.hold(&Isometry3::identity(), &robot("tocabi").default_pose(), [true; 2]).torque[3].abs();
    let weak = codes(|robot| {
        for knee in [3, 9] {
            let joint = &mut robot.links[knee].joint;
            (joint.effort_limit, joint.friction) = (1.2 * standing, 0.55 * standing);
        }
    });
    assert_eq!(weak, ["E0428"], "{standing} N m");
    assert_eq!(knee(|joint| joint.armature = 30.0), ["W0415"]);
    assert_eq!(knee(|joint| joint.velocity_limit = 0.01), ["W0414"]);
    assert_eq!(knee(|joint| (joint.lower, joint.upper) = (0.595, 0.605)), ["W0414"]);
    assert_eq!(knee(|joint| joint.stiffness_gain = 9e5), ["W0424"]);
    assert_eq!(knee(|joint| joint.damping_gain = 9e4), ["W0424"]);
    let yaw = codes(|robot| [0, 6].iter().for_each(|yaw| robot.links[*yaw].joint.effort_limit = 1e-3));
    assert!(yaw.contains(&"W0414"), "{yaw:?}");
}

#[test]
fn of_many_outliers_the_worst_is_told_with_the_number_of_the_others() {
    let mut robot = robot("tocabi");
    bodies(&mut robot).for_each(|body| body.inertia *= 1e4);
    let found = issues(all(&robot));
    assert_eq!(found.len(), 1);
    assert!(found[0].message.contains("(12 more bodies)"), "{}", found[0].message);
}

#[test]
fn feet_that_do_not_lie_left_and_right_are_told_with_the_cause() {
    let swapped = |robot: &mut Robot| robot.feet.swap(0, 1);
    assert_eq!(found(swapped), [("E0426", "feet".to_owned())]);
    let mut exchanged = robot("tocabi");
    swapped(&mut exchanged);
    let issue = super::sides(&exchanged).expect("they are exchanged");
    assert!(issue.help.contains("write `link = \"L_AnkleRoll_Link\"` in [feet.left]"), "{}", issue.help);
    for (axis, angle, message) in [
        (Vector3::z(), std::f64::consts::PI, "on the right of the robot"),
        (Vector3::z(), std::f64::consts::FRAC_PI_2, "y does not point to the left"),
        (Vector3::x(), std::f64::consts::FRAC_PI_2, "z does not point up"),
    ] {
        let mut turned = robot("tocabi");
        let turn = crate::robot::kinematics::rotation_about(&axis, angle);
        for link in turned.links.iter_mut().filter(|link| link.parent.is_none()) {
            link.joint.origin = turn * link.joint.origin;
        }
        let issue = super::sides(&turned).expect("it is turned");
        assert!(issue.message.contains(message) && issue.help.contains("turn the frame of"), "{issue:?}");
    }
    assert_eq!(super::sides(&robot("g1")), None);
}

#[test]
fn figures_that_differ_between_left_and_right_are_one_warning_with_both_joints() {
    let message = |change: &dyn Fn(&mut Robot)| {
        let mut robot = robot("tocabi");
        change(&mut robot);
        let found: Vec<_> = issues(all(&robot)).into_iter().filter(|issue| issue.code == "W0417").collect();
        assert!(found.len() < 2);
        found.into_iter().next().map(|issue| issue.message)
    };
    assert_eq!(message(&|_| {}), None);
    for (change, expected) in [
        (
            &(|robot: &mut Robot| robot.links[3].joint.effort_limit /= 2.0) as &dyn Fn(&mut Robot),
            "`effort_limit` is 144.5 N m",
        ),
        (&|robot: &mut Robot| robot.links[3].joint.velocity_limit *= 1.2, "`velocity_limit` is"),
        (&|robot: &mut Robot| robot.links[9].joint.damping += 20.0, "`damping` is"),
        (&|robot: &mut Robot| robot.links[3].joint.upper -= 0.3, "the range is"),
        (&|robot: &mut Robot| robot.links[0].joint.upper -= 0.15, "the range is"),
        (&|robot: &mut Robot| robot.links[3].body.mass *= 1.3, "the mass is"),
        (&|robot: &mut Robot| robot.feet[0].half_extents.x *= 1.5, "the left sole has"),
        (&|robot: &mut Robot| robot.links[9].body.inertia *= 1.5, "the inertia of"),
        (
            &|robot: &mut Robot| {
                let inertia = &mut robot.links[2].body.inertia;
                (inertia.m11, inertia.m33) = (inertia.m33, inertia.m11);
            },
            "the inertia of",
        ),
        (&|robot: &mut Robot| robot.links[2].body.com.z += 0.05, "the centre of mass of"),
        (&|robot: &mut Robot| robot.links[8].body.com.y += 0.06, "the centre of mass of"),
        (&|robot: &mut Robot| robot.links[3].body.collisions.clear(), "`L_Knee_Link` has 0 collision shapes"),
        (
            &|robot: &mut Robot| {
                let shape = &mut robot.links[9].body.collisions[0].shape;
                *shape = Shape::Sphere(0.09);
            },
            "a collision shape has",
        ),
        (&|robot: &mut Robot| robot.feet[1].friction = 0.5, "the friction of the left sole is 1,"),
        (&|robot: &mut Robot| robot.links[3].joint.damping = 8.0 / 3.0, "`damping` is 2.6667 N m s/rad"),
    ] {
        let message = message(change).expect(expected);
        assert!(message.starts_with(expected), "{message}");
        assert!(message.contains("sole") || (message.contains("L_") && message.contains("R_")), "{message}");
    }
    let several = message(&|robot: &mut Robot| {
        robot.links[2].joint.effort_limit /= 1.5;
        robot.links[3].joint.effort_limit /= 3.0;
    });
    assert!(several.is_some_and(|told| told.contains("L_Knee_Joint") && told.ends_with("(1 more figures)")));
}

#[test]
fn soles_that_are_too_large_or_no_mirror_images_are_told() {
    let both = |change: fn(&mut crate::robot::Foot)| codes(|robot| robot.feet.iter_mut().for_each(change));
    let right = |change: fn(&mut crate::robot::Foot)| found(|robot| change(&mut robot.feet[1]));
    for (change, words) in [
        ((|foot| (foot.half_extents.z, foot.centre.z) = (0.5, 0.34)) as fn(&mut crate::robot::Foot), "tall"),
        (|foot| foot.half_extents.x = 0.4, "long"),
        (|foot| foot.centre.z = -0.6, "far"),
    ] {
        assert!(both(change).contains(&"W0412"), "{words}");
    }
    let different = [("W0417", "feet.right.half_extents".to_owned())];
    assert_eq!(right(|foot| (foot.half_extents.z, foot.centre.z) = (0.03, -0.1285)), different);
    assert_eq!(right(|foot| foot.half_extents.y *= 0.8), different);
    let elsewhere = [("W0417", "feet.right.centre".to_owned())];
    assert_eq!(right(|foot| foot.centre.y += 0.02), elsewhere);
    assert_eq!(right(|foot| foot.centre.x -= 0.03), elsewhere);
    assert_eq!(right(|foot| foot.centre.x += 0.004), []);
    // Both soles may lie outward, and the fix is the mirror image.
    let outward = |robot: &mut Robot| (robot.feet[0].centre.y, robot.feet[1].centre.y) = (0.02, -0.02);
    assert_eq!(found(outward), []);
    let mut inward = robot("tocabi");
    (inward.feet[0].centre.y, inward.feet[1].centre.y) = (0.02, 0.02);
    let issue = issues(all(&inward)).into_iter().find(|issue| issue.code == "W0417").expect("they differ");
    assert!(
        issue.help.starts_with("write `centre = [\"0.03 m\", \"-0.02 m\", \"-0.145 m\"]`"),
        "{}",
        issue.help
    );
}

#[test]
fn a_base_of_a_gram_is_told() {
    for name in ["atlas", "g1", "tocabi"] {
        let mut robot = robot(name);
        let factor = 1e-3 / robot.base.mass;
        (robot.base.mass, robot.base.inertia) = (1e-3, robot.base.inertia * factor);
        let told = found_in(&robot);
        assert!(told.contains(&("W0410", "base.mass".to_owned())), "{name}: {told:?}");
    }
}

#[test]
fn soles_above_their_ankles_are_told() {
    for name in ["atlas", "g1", "tocabi"] {
        let raised = |rise: f64| {
            let mut robot = robot(name);
            robot.feet.iter_mut().for_each(|foot| foot.centre.z = foot.half_extents.z + rise);
            found_in(&robot).into_iter().filter(|(code, _)| *code == "W0412").collect::<Vec<_>>()
        };
        assert_eq!(raised(0.02), [("W0412", "feet.left.centre".to_owned())], "{name}");
        assert_eq!(raised(-0.01), [], "{name}");
    }
}

#[test]
fn hip_motors_that_cannot_hold_the_robot_on_one_foot_are_told() {
    for name in ["atlas", "g1", "tocabi"] {
        let own = robot(name);
        let kinematics = crate::robot::Kinematics::new(&own);
        let rolls: Vec<usize> = (0..own.joints())
            .filter(|joint| kinematics.axis(*joint).x.abs() > 0.7)
            .filter(|joint| kinematics.pose(*joint).translation.z > -0.3 * own.standing_height)
            .collect();
        assert_eq!(rolls.len(), 2, "{name}");
        let told = |effort: f64| {
            let mut robot = own.clone();
            rolls.iter().for_each(|roll| robot.links[*roll].joint.effort_limit = effort);
            let issues = issues(all(&robot));
            issues.into_iter().filter(|issue| issue.code == "W0414").map(|issue| issue.message).collect()
        };
        let weak: Vec<String> = told(0.04 * own.total_mass());
        assert_eq!(weak.len(), 1, "{name}: {weak:?}");
        assert!(weak[0].contains("standing on one foot takes"), "{weak:?}");
        assert_eq!(told(2.0 * own.total_mass()), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn a_servo_exactly_at_a_limit_is_no_finding_whatever_the_rounding() {
    for factor in [1.0, 3.0, 7.0, 0.1, 1.0 / 3.0] {
        let told = codes(|robot| {
            for knee in [3, 9] {
                let joint = &mut robot.links[knee].joint;
                joint.effort_limit *= factor;
                joint.damping_gain = joint.effort_limit / 0.05;
                joint.stiffness_gain = joint.effort_limit / 1e-3;
            }
        });
        assert!(!told.contains(&"W0424"), "{factor}: {told:?}");
    }
}

#[test]
fn motors_that_cannot_hold_the_default_pose_are_an_error() {
    let weak = |factor: f64| {
        codes(move |robot: &mut Robot| {
            robot.links.iter_mut().for_each(|link| link.joint.effort_limit *= factor)
        })
    };
    assert!(!weak(1.0).contains(&"E0428"));
    assert!(weak(0.02).contains(&"E0428"));
    // A missing effort limit is not a weak motor.
    assert!(!weak(0.0).contains(&"E0428"));
}

#[test]
fn soles_that_several_joints_level_get_default_positions_that_do_it() {
    let mut aslant = robot("tocabi");
    for (joint, side) in [(2, 1.0), (8, -1.0)] {
        let own = &mut aslant.links[joint].joint;
        own.axis = crate::robot::kinematics::rotation_about(&Vector3::x(), 0.5 * side) * own.axis;
    }
    let issue =
        issues(all(&aslant)).into_iter().find(|issue| issue.code == "E0420").expect("its soles are tilted");
    assert!(issue.help.starts_with("write these default positions"), "{}", issue.help);
    // The suggested positions level both soles: the other leg's joints are the images of the named ones.
    let mirror = crate::robot::symmetry::mirror_map(&aslant).expect("it is symmetric");
    for part in issue.help.split(": ").nth(1).expect("a list").split(", ") {
        let (value, name) = part.split_once(" rad\" for ").expect("a position");
        let value: f64 = value.trim_start_matches('"').parse().expect("a number");
        let index = joint(&aslant, name.trim_matches('`'));
        let (image, sign) = mirror[index];
        aslant.links[index].joint.default_position = value;
        aslant.links[image].joint.default_position = sign * value;
    }
    assert!(!found_in(&aslant).iter().any(|(code, _)| *code == "E0420"), "{:?}", found_in(&aslant));
}
