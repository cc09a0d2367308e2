//! W0410 to W0413: masses, inertias, lengths and centres of mass that do not fit each other, for example
//! because of a wrong unit.
//!
//! Common units differ by a factor of 1000 (g, mm) or its powers, or 100 (cm); published robots differ by
//! less than 10 in all quantities compared here. The thresholds are in between.

use std::f64::consts::PI;

use super::size::{Extent, bodies, reach};
use super::{Examined, Outlier, path_of, worst};
use crate::robot::checks::Issue;
use crate::robot::model::{Body, Robot};
use crate::robot::solid::solid;

/// The code of masses and inertias in wrong units.
pub(super) const CODE: &str = "W0410";

/// Size in m of the smallest and the largest robot: a tenth of a palm-sized biped, twice the tallest walking
/// machine.
const SIZES: [f64; 2] = [0.03, 10.0];
/// Mass divided by size cubed in kg/m^3. Bolt has 10, Atlas 50, NAO 200; water has 1000.
const DENSITIES: [f64; 2] = [0.5, 1000.0];
/// Density in kg/m^3 above that of any body (tungsten: 19 300). Half the radius of gyration of such a sphere
/// is a lower bound for bodies of its mass.
const DENSEST: f64 = 20_000.0;
/// Maximum radius of gyration relative to the body's size. It is at most half of the diameter, but the size
/// is only estimated from the neighbouring joints and the shapes. Published robots have up to 0.9.
const GYRATION: f64 = 1.0;
/// The same relative to the robot's size for bodies with shapes, which may be smaller than the body.
const GYRATION_OF_SHAPES: f64 = 0.1;
/// The same for bodies without shapes, whose joints may lie in one point. TOCABI's hips and Draco's trunk have
/// 0.24.
const GYRATION_OF_ROBOT: f64 = 0.3;
/// Maximum distance of a centre of mass outside its body, relative to the body's size.
const OUTSIDE: f64 = 1.0;
/// The same relative to the robot's size.
const OUTSIDE_OF_ROBOT: f64 = 0.3;
/// A shape this many times larger than the robot has another unit than its joints.
const SHAPE: f64 = 3.0;
/// Shortest sole relative to the robot's size: point feet have 0.02.
const SHORTEST_SOLE: f64 = 0.005;

/// Masses, lengths and inertias fit each other.
pub fn check(robot: &Robot) -> Examined {
    let reach = reach(robot);
    let complete = bodies(robot).all(|(_, body)| body.mass > 0.0);
    let mut issues: Vec<Issue> = size(reach).into_iter().collect();
    issues.extend(shapes(robot, reach));
    issues.extend(soles(robot, reach));
    issues.extend(complete.then(|| mass(robot, reach)).flatten());
    issues.extend(complete.then(|| trunk(robot)).flatten());
    issues.extend(inertias(robot, reach));
    issues.extend(centres(robot, reach));
    Examined {
        name: "masses, lengths and inertias fit each other",
        detail: format!("{:.1} kg at a size of {reach:.2} m", robot.total_mass()),
        issues,
    }
}

fn size(reach: f64) -> Option<Issue> {
    let [least, most] = SIZES;
    (!(least..=most).contains(&reach)).then(|| Issue {
        code: "W0412",
        path: "links".to_owned(),
        message: format!("the robot is {} m large, from joint to joint", short(reach)),
        help: "write lengths in m: a robot in millimetres is 1000 times too large".to_owned(),
    })
}

fn shapes(robot: &Robot, reach: f64) -> Option<Issue> {
    let of_body = |(index, body): (usize, &Body)| -> Vec<Outlier> {
        let sizes = body
            .collisions
            .iter()
            .map(|collision| 2.0 * f64::from(solid(collision).0.compute_local_bounding_sphere().radius));
        let large = sizes.enumerate().filter(|(_, size)| *size > SHAPE * reach);
        large
            .map(|(at, size)| Outlier {
                excess: size,
                path: format!("{}.collisions.{at}", path_of(index)),
                message: format!(
                    "a collision shape of `{}` is {} m large, and the robot is {} m large",
                    body.name,
                    short(size),
                    short(reach)
                ),
            })
            .collect()
    };
    let found = bodies(robot).flat_map(of_body).collect();
    worst("W0412", found, "shapes", "write lengths in m: meshes in millimetres need a scale of 0.001")
}

/// Soles that are too short. Those that are too large are compared with the leg (`soles.rs`).
fn soles(robot: &Robot, reach: f64) -> Option<Issue> {
    let sides = ["left", "right"].iter().zip(&robot.feet);
    let lengths = sides.map(|(side, foot)| (side, 2.0 * foot.half_extents.x.max(foot.half_extents.y)));
    // The sole of a foot without shapes is still missing.
    let odd = lengths.filter(|(_, length)| *length > 0.0 && *length < SHORTEST_SOLE * reach);
    let found = odd.map(|(side, length)| Outlier {
        excess: reach / length,
        path: format!("feet.{side}.half_extents"),
        message: format!(
            "the {side} sole is {} m long, and the robot is {} m large",
            short(length),
            short(reach)
        ),
    });
    worst("W0412", found.collect(), "sole", "write half of the sole's length and width in m")
}

fn mass(robot: &Robot, reach: f64) -> Option<Issue> {
    let density = robot.total_mass() / (reach * reach * reach);
    let [least, most] = DENSITIES;
    (!(least..=most).contains(&density)).then(|| Issue {
        code: "W0411",
        path: "total_mass".to_owned(),
        message: format!(
            "the robot weighs {} kg at a size of {} m, {} kg per cubic metre of it; known robots have 10 to \
             200",
            short(robot.total_mass()),
            short(reach),
            short(density)
        ),
        help: "write masses in kg: multiply those of a file in grams by 0.001".to_owned(),
    })
}

/// Smallest share of the robot's mass that the base has: it carries the batteries or at least both hips.
const TRUNK: f64 = 0.003;

fn trunk(robot: &Robot) -> Option<Issue> {
    let share = robot.base.mass / robot.total_mass();
    (share < TRUNK).then(|| Issue {
        code: CODE,
        path: "base.mass".to_owned(),
        message: format!(
            "the base `{}` weighs {} kg of the robot's {} kg: a frame without a body?",
            robot.base.name,
            short(robot.base.mass),
            short(robot.total_mass())
        ),
        help: "write the mass of the trunk in kg, or name the body that carries it as the base".to_owned(),
    })
}

fn inertias(robot: &Robot, reach: f64) -> Option<Issue> {
    let odd = |(index, body): (usize, &Body)| {
        let largest = body.inertia.symmetric_eigenvalues().max();
        // A mass that the file lacks is zero in the import.
        if !(body.mass > 0.0 && largest > 0.0) {
            return None;
        }
        let gyration = (largest / body.mass).sqrt();
        let own = Extent::of(robot, index).diagonal().max(body.com.coords.norm());
        let shaped = !body.collisions.is_empty() || robot.feet.iter().any(|foot| foot.link + 1 == index);
        let rest = if shaped { GYRATION_OF_SHAPES } else { GYRATION_OF_ROBOT };
        let most = (GYRATION * own).max(rest * reach);
        let radius = libm::cbrt(3.0 * body.mass / (4.0 * PI * DENSEST));
        let least = 0.5 * libm::sqrt(0.4) * radius;
        let name = &body.name;
        let (excess, reason) = if gyration > most {
            let words = "and the body with its joints and shapes is";
            (gyration / most, format!("{words} {} m large in a robot of {} m", short(own), short(reach)))
        } else if gyration < least {
            (least / gyration, format!("less than that of any body of {} kg", short(body.mass)))
        } else {
            return None;
        };
        let path = format!("{}.inertia", path_of(index));
        let message = format!(
            "the inertia of `{name}` is that of its mass at a radius of {} m, {reason}",
            short(gyration)
        );
        Some(Outlier { excess, path, message })
    };
    let found = bodies(robot).filter_map(odd).collect();
    let help = "write moments of inertia about the centre of mass in kg m^2: multiply those of a file in kg \
        mm^2 by 1e-6";
    worst(CODE, found, "bodies", help)
}

fn centres(robot: &Robot, reach: f64) -> Option<Issue> {
    let odd = |(index, body): (usize, &Body)| {
        let own = Extent::of(robot, index);
        let (away, most) =
            (own.distance(&body.com), (OUTSIDE * own.diagonal()).max(OUTSIDE_OF_ROBOT * reach));
        (body.mass > 0.0 && away > most).then(|| Outlier {
            excess: away,
            path: format!("{}.com", path_of(index)),
            message: format!(
                "the centre of mass of `{}` is {} m outside of the body's joints and shapes, which span {} m",
                body.name,
                short(away),
                short(own.diagonal())
            ),
        })
    };
    let found = bodies(robot).filter_map(odd).collect();
    worst("W0413", found, "bodies", "write the centre of mass in m, in the frame of the body")
}

/// At most five significant digits, without trailing zeros: figures of files may have 17.
pub(super) fn figure(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let text = format!("{value:.4e}");
    let rounded: f64 = text.parse().unwrap_or(value);
    if (1e-4..1e7).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

/// Three significant digits.
pub(super) fn short(value: f64) -> String {
    let digits = 2 - libm::floor(libm::log10(value.abs().max(1e-300))) as i32;
    if digits > 6 { format!("{value:.2e}") } else { format!("{value:.*}", digits.clamp(0, 6) as usize) }
}

#[cfg(test)]
mod tests {
    use super::figure;

    #[test]
    fn figures_have_at_most_five_digits_and_keep_what_their_author_wrote() {
        let told = [144.5, 0.010_177_520_04, 2.0 / 3.0, 12_345_678.9, 1e-9 / 3.0, 0.0, 289.0].map(figure);
        assert_eq!(told, ["144.5", "0.010178", "0.66667", "1.2346e7", "3.3333e-10", "0", "289"]);
        assert_eq!(figure(-0.1 - 0.2), "-0.3");
    }
}
