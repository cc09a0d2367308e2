//! A robot compiled without its parameters, and the models of worlds: copies with parameters written in.
//!
//! MuJoCo's compiler takes 0.4 ms for a robot, its XML reader takes one lock for the whole process, and a
//! training in which the robot still falls begins an episode every few steps. Randomization nearly always
//! changes parameters only: a mass, a centre of mass, an inertia, a damping, a friction. So geometry is
//! compiled once, with the same placeholder parameters for every robot, and each world gets a copy with its
//! own parameters and what MuJoCo derives from them (`mj_setConst`). All worlds are made this way, including
//! the first, so none depends on what was built before it.

use mujoco_rs::mujoco_c::{mj_setConst, mju_eig3};
use mujoco_rs::prelude::{MjData, MjModel, MjtObjBase};
use nalgebra::{Matrix3, Point3};

use super::super::error::EngineError;
use super::super::mjcf;
use super::super::scene::{EngineSettings, Terrain};
use super::refused;
use crate::escape::terminal;
use crate::robot::Robot;
use crate::robot::model::Body;

/// The smallest mass in kg and moment of inertia in kg m^2 that MuJoCo's compiler accepts.
const SMALLEST: f64 = 1e-15;
/// Body 0 is the world.
const BASE: usize = 1;

/// A model without parameters, and the indices of its parts.
#[derive(Debug)]
pub(super) struct Skeleton {
    robot: Robot,
    terrain: Terrain,
    settings: EngineSettings,
    model: MjModel,
    /// The link's body of each joint.
    bodies: Vec<usize>,
    /// Indices of each joint's position and velocity in the state vectors.
    pub slots: Vec<Slot>,
    /// The geoms of the left and the right sole.
    pub soles: [usize; 2],
}

/// Indices of a joint's position and velocity in the state vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    pub position: usize,
    pub velocity: usize,
}

impl Skeleton {
    /// Compiles the geometry of a robot on its terrain.
    pub fn compile(robot: &Robot, terrain: &Terrain, settings: &EngineSettings) -> Result<Self, EngineError> {
        let (robot, terrain, settings) = (bare(robot), terrain.clone(), plain(settings));
        let text = mjcf::document(&robot, &terrain, &settings);
        let model = MjModel::from_xml_string(&text).map_err(|error| refused(&error))?;
        let id = |kind, name: &str| {
            let missing = || refused(&format!("`{name}` is not in the model"));
            // The name as in the MJCF text.
            model.name_to_id(kind, &terminal::line(name)).ok_or_else(missing)
        };
        let soles =
            [id(MjtObjBase::mjOBJ_GEOM, mjcf::SOLES[0])?, id(MjtObjBase::mjOBJ_GEOM, mjcf::SOLES[1])?];
        let (mut bodies, mut slots) =
            (Vec::with_capacity(robot.joints()), Vec::with_capacity(robot.joints()));
        for link in &robot.links {
            let joint = id(MjtObjBase::mjOBJ_JOINT, &link.joint.name)?;
            bodies.push(model.jnt_bodyid()[joint] as usize);
            let (position, velocity) =
                (model.jnt_qposadr()[joint] as usize, model.jnt_dofadr()[joint] as usize);
            slots.push(Slot { position, velocity });
        }
        Ok(Self { bodies, slots, soles, model, robot, terrain, settings })
    }

    /// Whether it has the geometry of this robot on this terrain.
    pub fn fits(&self, robot: &Robot, terrain: &Terrain, settings: &EngineSettings) -> bool {
        self.settings == plain(settings) && self.terrain == *terrain && self.robot == bare(robot)
    }

    /// A new world's model and data with the parameters of this robot, on ground with this friction
    /// coefficient.
    pub fn with_figures(&self, robot: &Robot, friction: f64) -> Result<MjData<Box<MjModel>>, EngineError> {
        let mut model = Box::new(self.model.clone());
        body(&mut model, BASE, &robot.base)?;
        for (link, &id) in robot.links.iter().zip(&self.bodies) {
            body(&mut model, id, &link.body)?;
        }
        for (index, (link, slot)) in robot.links.iter().zip(&self.slots).enumerate() {
            let joint = &link.joint;
            let figures = [joint.damping, joint.friction, joint.armature, joint.effort_limit];
            if !figures.iter().all(|figure| figure.is_finite()) {
                return Err(refused(&format!("a figure of joint `{}` is not a number", joint.name)));
            }
            model.dof_damping_mut()[slot.velocity] = joint.damping;
            model.dof_frictionloss_mut()[slot.velocity] = joint.friction;
            model.dof_armature_mut()[slot.velocity] = joint.armature;
            model.actuator_ctrlrange_mut()[index] = [-joint.effort_limit, joint.effort_limit];
        }
        if !friction.is_finite() {
            return Err(refused(&"the friction of the ground is not a number"));
        }
        model.geom_friction_mut().iter_mut().for_each(|coefficients| coefficients[0] = friction);
        // As in the document: the priority makes a foot's own coefficient the pair's.
        for (foot, &sole) in robot.feet.iter().zip(&self.soles).filter(|(foot, _)| foot.friction != 1.0) {
            model.geom_friction_mut()[sole][0] = foot.friction * friction;
            model.geom_priority_mut()[sole] = 1;
        }
        let mut data = MjData::try_new(model).map_err(|error| refused(&error))?;
        // SAFETY: model and data belong together, and only constants of the model are rewritten, no sizes.
        unsafe {
            let model: *mut _ = data.model_mut().ffi_mut();
            mj_setConst(model, data.ffi_mut());
            average(data.model_mut());
        }
        data.reset();
        Ok(data)
    }
}

/// Computes the means that otherwise only the compiler computes; the solver scales its tolerance with the
/// mean inertia.
fn average(model: &mut MjModel) {
    let (dofs, bodies) = (model.dof_m0().len(), model.body_mass().len() - BASE);
    let (inertia, mass) = (model.dof_m0().iter().sum::<f64>(), model.body_mass().iter().sum::<f64>());
    let means = model.stat_mut();
    means.meaninertia = inertia / dofs as f64;
    means.meanmass = mass / bodies as f64;
}

/// Writes the mass properties of a body if the compiler would accept them.
fn body(model: &mut MjModel, id: usize, body: &Body) -> Result<(), EngineError> {
    let (mut moments, mut axes, mut turn) = ([0.0; 3], [0.0; 9], [0.0; 4]);
    let tensor: [f64; 9] = std::array::from_fn(|entry| body.inertia[(entry / 3, entry % 3)]);
    if !tensor.iter().chain(body.com.iter()).all(|figure| figure.is_finite()) {
        return Err(refused(&format!("a figure of body `{}` is not a number", body.name)));
    }
    // SAFETY: reads and writes these four arrays.
    unsafe { mju_eig3(&mut moments, &mut axes, &mut turn, &tensor) };
    let [largest, middle, smallest] = moments;
    // Comparisons with NaN are false.
    let is_possible = body.mass >= SMALLEST && smallest >= SMALLEST && middle + smallest >= largest;
    if !is_possible {
        return Err(refused(&format!(
            "no solid has the mass and the moments of inertia of body `{}`",
            body.name
        )));
    }
    model.body_mass_mut()[id] = body.mass;
    model.body_ipos_mut()[id] = [body.com.x, body.com.y, body.com.z];
    model.body_inertia_mut()[id] = moments;
    model.body_iquat_mut()[id] = turn;
    Ok(())
}

/// A robot of this geometry with placeholder parameters, chosen so that no body's frame is its inertial
/// frame: MuJoCo's compiler would take a shortcut for such a body only.
fn bare(robot: &Robot) -> Robot {
    let mut bare = robot.clone();
    for body in std::iter::once(&mut bare.base).chain(bare.links.iter_mut().map(|link| &mut link.body)) {
        body.mass = 1.0;
        body.com = Point3::new(0.01, 0.02, 0.03);
        body.inertia = Matrix3::new(0.010, 0.001, 0.002, 0.001, 0.011, 0.001, 0.002, 0.001, 0.012);
    }
    for joint in bare.links.iter_mut().map(|link| &mut link.joint) {
        (joint.damping, joint.friction, joint.armature, joint.effort_limit) = (1.0, 1.0, 1.0, 1.0);
        // Not part of the model.
        (joint.velocity_limit, joint.stiffness_gain, joint.damping_gain, joint.default_position) =
            (0.0, 0.0, 0.0, 0.0);
    }
    bare.feet.iter_mut().for_each(|foot| foot.friction = 1.0);
    bare
}

/// The settings without the friction of the ground, which is a parameter, too.
fn plain(settings: &EngineSettings) -> EngineSettings {
    EngineSettings { friction: 1.0, ..settings.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot;
    use crate::stream::Stream;

    const SETTINGS: EngineSettings = EngineSettings { step: 0.002, friction: 0.7, contact_time: None };

    /// A robot with every parameter changed by up to 30 %.
    fn drawn(name: &str, number: u32) -> Robot {
        let (mut robot, mut stream) =
            (robot::shipped(name).expect("it ships"), Stream::new(&format!("{name}/{number}")));
        let mut factor = || 0.7 + 0.6 * stream.uniform();
        for body in std::iter::once(&mut robot.base).chain(robot.links.iter_mut().map(|link| &mut link.body))
        {
            body.mass *= factor();
            body.inertia *= factor();
            body.com *= factor();
        }
        for joint in robot.links.iter_mut().map(|link| &mut link.joint) {
            for figure in
                [&mut joint.damping, &mut joint.friction, &mut joint.armature, &mut joint.effort_limit]
            {
                *figure *= factor();
            }
        }
        robot.feet[1].friction = factor();
        robot
    }

    /// The largest difference between the parameters of two models, relative to the larger one.
    fn difference(ours: &MjModel, theirs: &MjModel) -> f64 {
        let flat = |model: &MjModel| -> Vec<f64> {
            let mut all = vec![model.stat().meaninertia, model.stat().meanmass, model.stat().extent];
            for one in [
                model.body_mass(),
                model.body_subtreemass(),
                model.dof_damping(),
                model.dof_frictionloss(),
                model.dof_armature(),
                model.dof_invweight0(),
                model.dof_m0(),
                model.qpos0(),
                model.actuator_acc0(),
            ] {
                all.extend(one);
            }
            for three in [model.body_ipos(), model.body_inertia(), model.geom_friction()] {
                all.extend(three.as_flattened());
            }
            for two in [model.body_invweight0(), model.actuator_ctrlrange()] {
                all.extend(two.as_flattened());
            }
            all.extend(model.body_iquat().as_flattened());
            all.extend(model.geom_priority().iter().map(|&priority| f64::from(priority)));
            all
        };
        let share = |(a, b): (&f64, &f64)| if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) };
        let (ours, theirs) = (flat(ours), flat(theirs));
        assert_eq!(ours.len(), theirs.len());
        ours.iter().zip(&theirs).map(share).fold(0.0, f64::max)
    }

    #[test]
    fn a_model_with_figures_is_what_the_compiler_makes_of_them() {
        for name in robot::names() {
            let shipped = robot::shipped(name).expect("it ships");
            let skeleton = Skeleton::compile(&shipped, &Terrain::Flat, &SETTINGS).expect("it compiles");
            for robot in [shipped, drawn(name, 1), drawn(name, 2)] {
                assert!(skeleton.fits(&robot, &Terrain::Flat, &SETTINGS));
                let ours = skeleton.with_figures(&robot, SETTINGS.friction).expect("it is possible");
                let text = mjcf::document(&robot, &Terrain::Flat, &SETTINGS);
                let theirs = MjModel::from_xml_string(&text).expect("it compiles");
                let difference = difference(ours.model(), &theirs);
                assert!(difference < 1e-9, "{name}: {difference}");
            }
        }
    }

    #[test]
    fn a_robot_of_another_geometry_needs_a_compilation_of_its_own() {
        let shipped = robot::shipped("g1").expect("it ships");
        let skeleton = Skeleton::compile(&shipped, &Terrain::Flat, &SETTINGS).expect("it compiles");
        let mut taller = shipped.clone();
        taller.stretch_legs(1.01);
        assert!(!skeleton.fits(&taller, &Terrain::Flat, &SETTINGS));
        assert!(!skeleton.fits(&shipped, &Terrain::Slope { angle: 0.1 }, &SETTINGS));
        assert!(!skeleton.fits(&shipped, &Terrain::Flat, &EngineSettings { step: 0.001, ..SETTINGS }));
        assert!(skeleton.fits(&shipped, &Terrain::Flat, &EngineSettings { friction: 0.1, ..SETTINGS }));
    }

    #[test]
    fn figures_that_no_solid_has_are_refused() {
        let shipped = robot::shipped("g1").expect("it ships");
        let skeleton = Skeleton::compile(&shipped, &Terrain::Flat, &SETTINGS).expect("it compiles");
        let spoiled: [fn(&mut Robot); 6] = [
            |robot| robot.base.mass = 0.0,
            |robot| robot.base.inertia[(0, 0)] *= 100.0,
            |robot| robot.base.inertia[(1, 1)] = f64::NAN,
            |robot| robot.links[3].body.com.x = f64::INFINITY,
            |robot| robot.links[3].body.inertia *= -1.0,
            |robot| robot.links[3].joint.damping = f64::NAN,
        ];
        for spoil in spoiled {
            let mut robot = shipped.clone();
            spoil(&mut robot);
            assert!(skeleton.with_figures(&robot, 1.0).is_err());
        }
        assert!(skeleton.with_figures(&shipped, f64::NAN).is_err());
        assert!(skeleton.with_figures(&shipped, 1.0).is_ok());
    }
}
