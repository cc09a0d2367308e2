//! Poses of URDF, and the versions of the format; later versions also have quaternions.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::intake::{Intake, value};
use super::xml::Element;

/// The supported versions; from 1.1 on an origin may have a quaternion.
const VERSIONS: [&str; 3] = ["1.0", "1.1", "1.2"];

/// The pose of the `<origin>` inside an element.
pub(super) fn origin(element: &Element, intake: &mut Intake) -> Isometry3<f64> {
    let Some(origin) = element.child("origin") else { return Isometry3::identity() };
    let place = intake.vector(origin, "xyz").unwrap_or_default();
    let turn = match (origin.attribute("rpy"), origin.attribute("quat_xyzw")) {
        (Some(_), Some(quaternion)) => {
            let error = value("an origin has `rpy` and `quat_xyzw`".to_owned(), quaternion.span);
            intake.tell(error.help("give one of them"));
            None
        }
        (_, Some(_)) => quaternion(origin, intake),
        _ => {
            let [roll, pitch, yaw] = intake.vector(origin, "rpy").unwrap_or_default();
            Some(UnitQuaternion::from_euler_angles(roll, pitch, yaw))
        }
    };
    Isometry3::from_parts(Translation3::from(Vector3::from(place)), turn.unwrap_or_default())
}

fn quaternion(origin: &Element, intake: &mut Intake) -> Option<UnitQuaternion<f64>> {
    let [x, y, z, w] = intake.vector(origin, "quat_xyzw")?;
    let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9);
    if turn.is_none() {
        let error = value("`quat_xyzw` of <origin> has no length".to_owned(), origin.place("quat_xyzw"));
        intake.tell(error.help("no rotation is 0 0 0 1"));
    }
    turn
}

/// Reports an unknown version, and features beyond the stated one.
pub(super) fn version(robot: &Element, intake: &mut Intake) {
    match robot.text("version").map(str::trim) {
        None | Some("1" | "1.0") if has_quaternion(robot) => intake.note(
            "an origin has `quat_xyzw`, which URDF has since version 1.1: it is taken over although the file \
             does not say \
             that it is of that version"
                .to_owned(),
        ),
        Some(version) if version != "1" && !VERSIONS.contains(&version) => {
            let shown: String = version.chars().take(20).collect();
            intake.note(format!(
                "the file is of the unknown URDF version {shown:?}: it is read as version {}; the versions \
                 are {}",
                VERSIONS[VERSIONS.len() - 1],
                VERSIONS.join(", ")
            ));
        }
        _ => {}
    }
}

fn has_quaternion(element: &Element) -> bool {
    let own = element.name == "origin" && element.attribute("quat_xyzw").is_some();
    // Visuals are not imported.
    own || element.children.iter().filter(|child| child.name != "visual").any(has_quaternion)
}
