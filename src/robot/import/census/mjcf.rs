//! The elements and attributes of MJCF, classified. A test compares them with the schema of the linked
//! MuJoCo.

use super::table::Class::{Harmless, Imported, Left};
use super::table::Group::{
    Constraints, Deformables, DriveDynamics, Drives, FreeJoint, GravityCompensation, Masks, Medium, Plugins,
    Solver, Springs, Switches, Tendons, Transmissions, World,
};
use super::table::{Class, Row, row, whole};

/// Attributes of a joint when it is the free joint of a floating base.
pub(crate) const FREE: Row = row(
    "body/joint",
    &[
        (Imported, "name, class, type"),
        (Harmless, "group, user, pos, axis, range, limited, ref, springref"),
        (Harmless, "actuatorfrclimited, actuatorfrcrange, actuatorgravcomp, springdamper"),
        (Harmless, "margin, solimpfriction, solimplimit, solreffriction, solreflimit"),
        (Left(FreeJoint), "stiffness=0, damping=0, frictionloss=0, armature=0"),
    ],
);

/// Attributes of every joint actuator; and the alternatives to `joint` for other transmissions.
const JOINT: (Class, &str) = (Imported, "armature, class, damping, gear, joint, jointinparent, name");
const BOUNDS: (Class, &str) = (Imported, "ctrllimited, ctrlrange, forcelimited, forcerange");
const TARGET: (Class, &str) =
    (Left(Transmissions), "cranklength, cranksite, refsite, site, slidersite, tendon");
const ASIDE: (Class, &str) = (Harmless, "group, interp, lengthrange, nsample, user");
const DELAY: (Class, &str) = (Left(DriveDynamics), "delay=0");

/// Elements below `worldbody` have the same path as in a body. [`path`] maps those of default classes.
pub(crate) const TABLE: &[Row] = &[
    row("mujoco", &[(Imported, "model")]),
    row(
        "compiler",
        &[
            (
                Imported,
                "angle, assetdir, autolimits, balanceinertia, boundinertia, boundmass, coordinate, eulerseq",
            ),
            (Imported, "inertiafromgeom, inertiagrouprange, meshdir, settotalmass, strippath"),
            (Harmless, "alignfree, conflict, discardvisual, fitaabb, fusestatic, passthrough, savecanonical"),
            (Harmless, "savecompiled, saveinertial, texturedir, usethread"),
        ],
    ),
    whole("compiler/lengthrange", Harmless),
    // Simulation settings belong to a spec, simulation outputs to the robot's environment.
    row(
        "option",
        &[
            (Harmless, "ccd_iterations, ccd_tolerance, cone, impratio, integrator, iterations, jacobian"),
            (Harmless, "ls_iterations, ls_tolerance, noslip_iterations, noslip_tolerance, sdf_initpoints"),
            (Harmless, "sdf_iterations, sleep_tolerance, solver, timestep, tolerance"),
            (Left(Solver), "o_friction, o_margin, o_solimp, o_solref"),
            (Left(Medium), "density=0, gravity=0 0 -9.81, magnetic=0 -0.5 0, viscosity=0, wind=0"),
            (Left(Switches), "actuatorgroupdisable"),
        ],
    ),
    row(
        "option/flag",
        &[
            (
                Harmless,
                "autoreset, diagexact, energy, eulerdamp, fwdinv, invdiscrete, ipc, island, midphase, \
                 multiccd",
            ),
            (Harmless, "nativeccd, override, refsafe, sensor, sleep, warmstart"),
            (
                Left(Switches),
                "actuation=enable, clampctrl=enable, constraint=enable, contact=enable, damper=enable",
            ),
            (
                Left(Switches),
                "equality=enable, filterparent=enable, frictionloss=enable, gravity=enable, limit=enable",
            ),
            (Left(Switches), "spring=enable"),
        ],
    ),
    whole("size", Harmless),
    whole("statistic", Harmless),
    whole("visual", Harmless),
    row("default", &[(Imported, "class")]),
    // Equality constraints and tendons have one class for all their kinds.
    whole("default/equality", Harmless),
    whole("default/tendon", Harmless),
    row("extension", &[]),
    whole("extension/plugin", Left(Plugins)),
    row("asset", &[]),
    // A mesh that is not a file in its own frame is reported at the geom that uses it.
    row(
        "asset/mesh",
        &[
            (Imported, "class, file, name, refpos, refquat, scale"),
            (
                Harmless,
                "builtin, content_type, face, inertia, material, maxhullvert, normal, params, smoothnormal",
            ),
            (Harmless, "texcoord, vertex"),
        ],
    ),
    whole("asset/mesh/plugin", Left(Plugins)),
    whole("asset/hfield", Harmless),
    whole("asset/skin", Harmless),
    whole("asset/texture", Harmless),
    whole("asset/material", Harmless),
    whole("asset/model", Harmless),
    row(
        "body",
        &[
            (Imported, "axisangle, childclass, euler, name, pos, quat, xyaxes, zaxis"),
            (Harmless, "fuse, simple, sleep, user"),
            (Left(GravityCompensation), "gravcomp=0"),
            (Left(World), "mocap=false"),
        ],
    ),
    row("body/frame", &[(Imported, "name, childclass, axisangle, euler, pos, quat, xyaxes, zaxis")]),
    row(
        "body/inertial",
        &[(Imported, "axisangle, diaginertia, euler, fullinertia, mass, pos, quat, xyaxes, zaxis")],
    ),
    row(
        "body/joint",
        &[
            (
                Imported,
                "actuatorfrclimited, actuatorfrcrange, armature, axis, class, damping, frictionloss, limited",
            ),
            (Imported, "name, pos, range, ref, type"),
            (Harmless, "group, user"),
            // The damping from `springdamper` is imported, the stiffness is not.
            (Left(Springs), "springdamper=0, springref=0, stiffness=0"),
            (Left(GravityCompensation), "actuatorgravcomp=false"),
            (Left(Solver), "margin=0, solimpfriction, solimplimit, solreffriction, solreflimit"),
        ],
    ),
    row("body/freejoint", &[(Imported, "name"), (Harmless, "align, group")]),
    row(
        "body/geom",
        &[
            (
                Imported,
                "axisangle, class, density, euler, friction, fromto, group, mass, mesh, name, pos, quat",
            ),
            (Imported, "shellinertia, size, type, xyaxes, zaxis"),
            (Harmless, "fitscale, hfield, material, rgba, user"),
            (Left(Masks), "conaffinity=1, contype=1"),
            (
                Left(Solver),
                "adhesion=0, condim=3, gap=0, margin=0, priority=0, solimp, solmix=1, solref, surfacevel=0",
            ),
            (Left(Medium), "fluidcoef, fluidshape=none"),
        ],
    ),
    whole("body/geom/plugin", Left(Plugins)),
    // These generate bodies that are not in the file, which is an error.
    whole("body/attach", Imported),
    whole("body/composite", Imported),
    whole("body/flexcomp", Imported),
    whole("body/replicate", Imported),
    whole("body/site", Harmless),
    whole("body/camera", Harmless),
    whole("body/light", Harmless),
    whole("body/plugin", Left(Plugins)),
    row("deformable", &[]),
    whole("deformable/flex", Left(Deformables)),
    whole("deformable/skin", Harmless),
    row("contact", &[]),
    row(
        "contact/pair",
        &[
            (Imported, "class, name"),
            (Left(Masks), "geom1, geom2"),
            (Left(Solver), "adhesion, condim=3, friction, gap, margin, solimp, solref, solreffriction"),
        ],
    ),
    whole("contact/exclude", Left(Masks)),
    row("tendon", &[]),
    whole("tendon/spatial", Left(Tendons)),
    whole("tendon/fixed", Left(Tendons)),
    row("equality", &[]),
    whole("equality/connect", Left(Constraints)),
    whole("equality/weld", Left(Constraints)),
    whole("equality/joint", Left(Constraints)),
    whole("equality/tendon", Left(Constraints)),
    whole("equality/flex", Left(Constraints)),
    whole("equality/flexvert", Left(Constraints)),
    whole("equality/flexstrain", Left(Constraints)),
    row("actuator", &[]),
    row(
        "actuator/general",
        &[
            JOINT,
            BOUNDS,
            TARGET,
            ASIDE,
            DELAY,
            (Imported, "biasprm, biastype, gainprm"),
            (Harmless, "actearly, ffrange, inheritrange, input, velrange"),
            (Left(DriveDynamics), "actdim, actlimited, actrange, dynprm, dyntype=none, gaintype=fixed"),
            (Left(Transmissions), "body"),
        ],
    ),
    row("actuator/motor", &[JOINT, BOUNDS, TARGET, ASIDE, DELAY]),
    row(
        "actuator/position",
        &[
            JOINT,
            BOUNDS,
            TARGET,
            ASIDE,
            DELAY,
            (Imported, "dampratio, kp, kv"),
            (Harmless, "inheritrange"),
            (Left(DriveDynamics), "timeconst=0"),
        ],
    ),
    row("actuator/velocity", &[JOINT, BOUNDS, TARGET, ASIDE, DELAY, (Imported, "kv")]),
    row(
        "actuator/intvelocity",
        &[
            JOINT,
            BOUNDS,
            TARGET,
            ASIDE,
            DELAY,
            (Imported, "dampratio, kp, kv"),
            (Harmless, "inheritrange"),
            (Left(DriveDynamics), "actlimited, actrange"),
        ],
    ),
    row(
        "actuator/pid",
        &[
            JOINT,
            BOUNDS,
            TARGET,
            ASIDE,
            DELAY,
            (Imported, "dampratio, kp, kv"),
            (Harmless, "ffrange, inheritrange, input, posrange, velrange"),
            (Left(DriveDynamics), "imax, ki=0, slewmax"),
        ],
    ),
    whole("actuator/orientation", Left(Drives)),
    whole("actuator/damper", Left(Drives)),
    whole("actuator/cylinder", Left(Drives)),
    whole("actuator/muscle", Left(Drives)),
    whole("actuator/adhesion", Left(Drives)),
    whole("actuator/dcmotor", Left(Drives)),
    whole("actuator/plugin", Left(Drives)),
    whole("sensor", Harmless),
    row("custom", &[]),
    row("custom/numeric", &[(Imported, "data, name"), (Harmless, "size")]),
    whole("custom/text", Harmless),
    whole("custom/tuple", Harmless),
    row("keyframe", &[]),
    row("keyframe/key", &[(Imported, "name, qpos"), (Harmless, "act, ctrl, mpos, mquat, qvel, time")]),
];

/// The path of an element below another one: bodies nest, and a class has the attributes of the elements it
/// applies to.
pub(crate) fn path(above: &str, name: &str) -> String {
    match (above, name) {
        ("mujoco", "worldbody") | ("body" | "body/frame", "body") => "body".to_owned(),
        ("mujoco", name) => name.to_owned(),
        ("body/frame", name) => format!("body/{name}"),
        ("default", "default") => "default".to_owned(),
        ("default", "joint" | "geom" | "site" | "camera" | "light") => format!("body/{name}"),
        ("default", "mesh" | "texture" | "material") => format!("asset/{name}"),
        ("default", "pair") => format!("contact/{name}"),
        ("default", name) if name != "equality" && name != "tendon" => format!("actuator/{name}"),
        (above, name) => format!("{above}/{name}"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::knows;
    use super::*;

    /// Output of `mj_printSchema`, one element per line: `body/joint: name class` (written by
    /// tests/schema_of_mujoco.rs).
    const KNOWN: &str = include_str!("mjcf.txt");

    /// The elements of the list with their attributes.
    fn known() -> impl Iterator<Item = (&'static str, Vec<&'static str>)> {
        let lines = KNOWN.lines().filter(|line| !line.starts_with('#'));
        lines.map(|line| {
            let (path, attributes) = line.split_once(':').expect("a line is `path: attributes`");
            (path, attributes.split_whitespace().collect())
        })
    }

    /// The path that classifies an element of the list.
    fn classified(place: &str) -> String {
        match place {
            "mujoco" => "mujoco".to_owned(),
            _ => place.split('/').fold("mujoco".to_owned(), |above, name| path(&above, name)),
        }
    }

    #[test]
    fn every_element_and_attribute_of_mujocos_schema_is_classified() {
        for (place, attributes) in known() {
            let path = classified(place);
            assert!(knows(TABLE, &path, None), "{place}");
            for attribute in attributes {
                assert!(knows(TABLE, &path, Some(attribute)), "`{attribute}` of {place}");
            }
        }
        assert!(!knows(TABLE, "body/joint", Some("backlash")) && !knows(TABLE, "body/wheel", None));
    }

    #[test]
    fn nothing_is_classified_that_mujoco_does_not_have() {
        // Elements that MuJoCo expands before it checks its schema.
        let early = ["body/frame", "body/replicate"];
        for row in TABLE.iter().filter(|row| !early.contains(&row.path)) {
            let (_, attributes) = known()
                .find(|(place, _)| *place == row.path)
                .unwrap_or_else(|| panic!("{} is not in the list", row.path));
            for name in row.names() {
                assert!(attributes.contains(&name), "`{name}` of {}", row.path);
            }
        }
        let joint = known().find(|(place, _)| *place == "body/joint").expect("joints are in the list").1;
        assert!(joint.iter().all(|name| knows(&[FREE], "body/joint", Some(name))), "a free joint is one");
    }
}
