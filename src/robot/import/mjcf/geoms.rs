//! `<geom>`: collision shapes, and the masses of bodies without `<inertial>`.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Translation3, Vector3};

use super::super::block::Block;
use super::super::intake::{Intake, value};
use super::super::tree::{Weight, massless};
use super::super::weld::join;
use super::super::xml::Element;
use super::defaults::Defaults;
use super::settings::{Settings, upright};
use crate::robot::checks::positive;
use crate::robot::{Body, Collision, Shape};

/// Default density of a geom in kg/m^3.
const DENSITY: f64 = 1000.0;

/// The meshes of a file by name.
#[derive(Debug, Default)]
pub(super) struct Meshes {
    assets: BTreeMap<String, Element>,
}

impl Meshes {
    /// The meshes of a file; one without a name is named after its file.
    pub fn read(root: &Element, defaults: &Defaults, intake: &mut Intake) -> Self {
        let mut assets = BTreeMap::new();
        for mesh in root.all("asset").flat_map(|asset| asset.all("mesh")) {
            let mesh = defaults.complete(mesh, None, intake);
            let stem = |file: &str| {
                std::path::Path::new(file).file_stem().map(|stem| stem.to_string_lossy().into_owned())
            };
            if let Some(name) =
                mesh.text("name").map(str::to_owned).or_else(|| mesh.text("file").and_then(stem))
            {
                assets.insert(name, mesh);
            }
        }
        Self { assets }
    }
}

/// Context for reading geoms.
#[derive(Debug)]
pub(super) struct Geoms<'a> {
    /// How numbers are interpreted.
    pub settings: &'a Settings,
    /// The meshes.
    pub meshes: Meshes,
    /// Names of geoms that collide through a contact pair, regardless of their masks.
    pub paired: BTreeSet<String>,
}

/// The volume of a geom, given all attributes of its class.
enum Volume {
    /// A shape supported by robot files.
    Shape(Shape),
    /// Half axes of an ellipsoid in m.
    Ellipsoid(Vector3<f64>),
    /// A mesh or another volume without a closed form.
    Other,
}

impl Geoms<'_> {
    /// The collision shape of a geom; `None` if it does not collide, or with a remark.
    pub fn collision(&self, body: &str, geom: &Element, intake: &mut Intake) -> Option<Collision> {
        for key in ["contype", "conaffinity"] {
            // Reports a mask that is not a number.
            intake.number(geom, key);
        }
        if !self.collides(geom) {
            return None;
        }
        let (volume, pose) = self.volume(geom, intake)?;
        let collision = match volume {
            Volume::Shape(shape) => Collision { shape, pose },
            Volume::Ellipsoid(half) => {
                intake.note(format!("`{body}`: an ellipsoid became the box around it"));
                Collision { shape: Shape::Box(half), pose }
            }
            Volume::Other => {
                let block = self.mesh(body, geom, intake)?;
                Collision { shape: Shape::Box(block.half), pose: pose * Translation3::from(block.centre) }
            }
        };
        if !positive(&collision.shape) {
            let message = format!("a geom of `{body}` has a size that is not positive");
            let error = super::super::physical::impossible(message, geom.place("size"));
            intake.tell(error.help("sizes are positive half lengths and radii in m"));
            return None;
        }
        // 1 is the default of MuJoCo and of specs.
        if let Some([sliding, ..]) = intake.numbers(geom, "friction").as_deref()
            && *sliding != 1.0
        {
            intake.note(format!(
                "a geom's friction coefficient of {sliding} is not taken over: the ground's is \
                 `terrain.friction` of a spec, and \
                 `friction` of a foot is a factor on it"
            ));
        }
        Some(collision)
    }

    /// Whether a geom collides, by its masks or in a contact pair.
    pub fn collides(&self, geom: &Element) -> bool {
        masked(geom) || geom.text("name").is_some_and(|name| self.paired.contains(name))
    }

    /// The box around a geom's mesh.
    fn mesh(&self, body: &str, geom: &Element, intake: &mut Intake) -> Option<Block> {
        let kind = geom.text("type").unwrap_or("sphere");
        let Some(name) = geom.text("mesh").filter(|_| kind == "mesh") else {
            let fitted = geom
                .text("mesh")
                .map(|mesh| format!(" that MuJoCo fits to the mesh {mesh}"))
                .unwrap_or_default();
            intake.note(format!("`{body}`: the {kind}{fitted} is left out; give the body a box or capsules"));
            return None;
        };
        let Some(asset) = self.meshes.assets.get(name) else {
            intake.tell(
                value(format!("there is no mesh `{name}`"), geom.place("mesh")).help("add it to <asset>"),
            );
            return None;
        };
        let (Some(file), false) =
            (asset.text("file"), asset.attribute("refpos").is_some() || asset.attribute("refquat").is_some())
        else {
            intake.note(format!(
                "`{body}`: the mesh {name} is not a file in its own frame and left out; give the body a box"
            ));
            return None;
        };
        let file = if self.settings.strip { file.rsplit(['/', '\\']).next().unwrap_or(file) } else { file };
        let scale = intake.vector(asset, "scale").unwrap_or([1.0; 3]);
        intake.mesh(body, &self.settings.meshes, file, asset.place("file"), scale)
    }

    /// Shape and pose of a geom.
    fn volume(&self, geom: &Element, intake: &mut Intake) -> Option<(Volume, Isometry3<f64>)> {
        let mut size = intake.numbers(geom, "size").unwrap_or_default();
        size.resize(3, 0.0);
        let kind = geom.text("type").unwrap_or("sphere");
        let mut pose = self.settings.pose(geom, intake);
        if geom.attribute("fromto").is_some() {
            let [ax, ay, az, bx, by, bz] = intake.vector(geom, "fromto")?;
            let (from, to) = (Vector3::new(ax, ay, az), Vector3::new(bx, by, bz));
            let Some(turn) = upright(&(from - to)) else {
                intake.tell(value("the two points of `fromto` are one".to_owned(), geom.place("fromto")));
                return None;
            };
            pose = Isometry3::from_parts(Translation3::from(0.5 * (from + to)), turn);
            size[if matches!(kind, "box" | "ellipsoid") { 2 } else { 1 }] = 0.5 * (to - from).norm();
        }
        let fitted = geom.text("mesh").is_some() && kind != "mesh";
        let volume = match kind {
            _ if fitted => Volume::Other,
            "sphere" => Volume::Shape(Shape::Sphere(size[0])),
            "capsule" => Volume::Shape(Shape::Capsule(size[1], size[0])),
            "cylinder" => Volume::Shape(Shape::Cylinder(size[1], size[0])),
            "box" => Volume::Shape(Shape::Box(Vector3::new(size[0], size[1], size[2]))),
            "ellipsoid" => Volume::Ellipsoid(Vector3::new(size[0], size[1], size[2])),
            "mesh" | "sdf" | "plane" | "hfield" => Volume::Other,
            other => {
                let error = value(format!("there is no geom type `{other}`"), geom.place("type"));
                intake.tell(error.help(
                    "the types are sphere, capsule, cylinder, box, ellipsoid, mesh, plane, hfield and sdf",
                ));
                return None;
            }
        };
        Some((volume, pose))
    }

    /// Sets mass, centre of mass and inertia of a body from its geoms; unknown if they have no closed form.
    pub fn weigh(&self, body: &mut Body, geoms: &[(Element, Isometry3<f64>)], intake: &mut Intake) -> Weight {
        let mut whole = massless(&body.name);
        let [first, last] = self.settings.groups;
        for (geom, frame) in geoms {
            let group = intake.number(geom, "group").unwrap_or(0.0);
            let density = intake.number(geom, "density").unwrap_or(DENSITY);
            let mass = intake.number(geom, "mass");
            let weightless =
                mass.unwrap_or(density) == 0.0 || matches!(geom.text("type"), Some("plane" | "hfield"));
            if group < first || group > last || weightless {
                continue;
            }
            let Some((volume, pose)) = self.volume(geom, intake) else { return Weight::Unknown };
            let hollow = geom.text("shellinertia") == Some("true");
            let Some((space, unit)) = moments(&volume).filter(|_| !hollow) else {
                intake.note(format!(
                    "`{}` has no inertial, and the mass of its {} has no closed form: write mass, com and \
                     inertia",
                    body.name,
                    geom.text("type").unwrap_or("mesh")
                ));
                return Weight::Unknown;
            };
            let mut solid = massless("");
            solid.mass = mass.unwrap_or(density * space);
            solid.inertia = Matrix3::from_diagonal(&(unit * solid.mass));
            join(&mut whole, &solid, &(frame * pose));
        }
        (body.mass, body.com, body.inertia) = (whole.mass, whole.com, whole.inertia);
        if whole.mass > 0.0 { Weight::Given } else { Weight::Absent }
    }
}

/// Whether a geom collides by its masks.
pub(super) fn masked(geom: &Element) -> bool {
    let is_zero = |key: &str| geom.text(key).is_some_and(|mask| mask.trim().parse() == Ok(0.0));
    !(is_zero("contype") && is_zero("conaffinity"))
}

/// Volume in m^3, and principal moments per mass in m^2, of a solid of uniform density.
fn moments(volume: &Volume) -> Option<(f64, Vector3<f64>)> {
    let square = |length: f64| length * length;
    Some(match volume {
        Volume::Other => return None,
        Volume::Ellipsoid(half) => {
            let [a, b, c] = [half.x, half.y, half.z].map(square);
            (4.0 / 3.0 * PI * half.x * half.y * half.z, Vector3::new(b + c, a + c, a + b) / 5.0)
        }
        Volume::Shape(Shape::Box(half)) => {
            let [a, b, c] = [half.x, half.y, half.z].map(square);
            (8.0 * half.x * half.y * half.z, Vector3::new(b + c, a + c, a + b) / 3.0)
        }
        Volume::Shape(Shape::Sphere(radius)) => {
            (4.0 / 3.0 * PI * radius * radius * radius, Vector3::from_element(0.4 * square(*radius)))
        }
        Volume::Shape(Shape::Cylinder(half, radius)) => {
            let across = (3.0 * square(*radius) + square(2.0 * half)) / 12.0;
            (2.0 * PI * square(*radius) * half, Vector3::new(across, across, 0.5 * square(*radius)))
        }
        Volume::Shape(Shape::Capsule(half, radius)) => {
            let (length, r) = (2.0 * half, *radius);
            let (tube, ball) = (PI * r * r * length, 4.0 / 3.0 * PI * r * r * r);
            let tube_across = (3.0 * r * r + length * length) / 12.0;
            // The two hemispheres at the ends, by the parallel axis theorem.
            let ball_across = 0.4 * r * r + 0.25 * length * length + 0.375 * length * r;
            let across = tube * tube_across + ball * ball_across;
            let along = tube * 0.5 * r * r + ball * 0.4 * r * r;
            let whole = tube + ball;
            (whole, Vector3::new(across, across, along) / whole)
        }
    })
}
