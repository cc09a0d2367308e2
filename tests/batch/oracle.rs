//! One step of MuJoCo on the engines' own document, with its solver run to the end.

use std::sync::Arc;

use mujoco_rs::prelude::{MjData, MjModel, MjtObjBase};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use specforge::robot::Robot;
use specforge::sim::{Contacts, EngineSettings, State, Terrain, mjcf};

/// Margin of height fields in m.
const MARGIN: f64 = 1e-9;

/// A robot in MuJoCo.
pub struct Oracle {
    pub data: MjData<Arc<MjModel>>,
    pub dofs: Vec<usize>,
    pub bodies: Vec<usize>,
    soles: [usize; 2],
}

impl Oracle {
    pub fn new(robot: &Robot, terrain: &Terrain, settings: &EngineSettings) -> Self {
        let text = mjcf::document(robot, terrain, settings);
        let tight =
            text.replace("iterations=\"50\" tolerance=\"1e-10\"", "iterations=\"200\" tolerance=\"1e-17\"");
        assert_ne!(tight, text, "the document says how far the solver goes");
        // Any margin makes MuJoCo go on until it has the least overlap of a box and a prism
        // (src/sim/batch/solid.rs).
        let field = "type=\"hfield\" hfield=\"field\"";
        let tight = tight.replace(field, &format!("{field} margin=\"{MARGIN}\""));
        let model = MjModel::from_xml_string(&tight).expect("MuJoCo takes the document");
        let id = |kind, name: &str| model.name_to_id(kind, name).expect("it is in the model");
        let dof = |name: &str| model.jnt_dofadr()[id(MjtObjBase::mjOBJ_JOINT, name)] as usize;
        let dofs = robot.links.iter().map(|link| dof(&link.joint.name)).collect();
        let links = robot.links.iter().map(|link| link.body.name.as_str());
        let bodies = std::iter::once(robot.base.name.as_str()).chain(links);
        let bodies = bodies.map(|name| id(MjtObjBase::mjOBJ_BODY, name)).collect();
        let soles = mjcf::SOLES.map(|name| id(MjtObjBase::mjOBJ_GEOM, name));
        Self { data: MjData::try_new(Arc::new(model)).expect("there is memory"), dofs, bodies, soles }
    }

    /// Accelerations (base linear and angular in world axes, joints) of a step from a state, and its
    /// contacts.
    pub fn step(&mut self, state: &State, torque: &[f64], push: [f64; 3]) -> (Vec<f64>, Contacts) {
        let [w, x, y, z] = state.base_orientation;
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        self.data.reset();
        let positions = self.data.qpos_mut();
        positions[..3].copy_from_slice(&state.base_position);
        positions[3..7].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
        // A hinge has one position and one velocity, the free joint seven and six.
        self.dofs.iter().zip(&state.position).for_each(|(dof, value)| positions[dof + 1] = *value);
        let before = self.data.qvel_mut();
        before[..3].copy_from_slice(&state.base_velocity);
        before[3..6].copy_from_slice((turn.inverse() * Vector3::from(state.base_rate)).as_slice());
        self.dofs.iter().zip(&state.velocity).for_each(|(dof, value)| before[*dof] = *value);
        let before = before.to_vec();
        self.data.ctrl_mut().copy_from_slice(torque);
        self.data.xfrc_applied_mut()[self.bodies[0]][..3].copy_from_slice(&push);
        self.data.step();
        let step = self.data.model().opt().timestep;
        let change: Vec<f64> = self.data.qvel().iter().zip(&before).map(|(a, b)| (a - b) / step).collect();
        // The angular velocity keeps its axes within the step.
        let angular = turn * Vector3::new(change[3], change[4], change[5]);
        let mut all = change[..3].to_vec();
        all.extend(angular.as_slice());
        all.extend(self.dofs.iter().map(|dof| change[*dof]));
        (all, self.contacts())
    }

    fn contacts(&self) -> Contacts {
        let mut contacts = Contacts::default();
        for (index, contact) in self.data.contact().iter().enumerate() {
            if contact.efc_address < 0 {
                continue;
            }
            let geoms = contact.geom.map(|geom| geom as usize);
            match self.soles.iter().position(|sole| geoms.contains(sole)) {
                Some(side) => {
                    let sign = if geoms[1] == self.soles[side] { 1.0 } else { -1.0 };
                    let force = self.data.contact_force(index);
                    for axis in 0..3 {
                        let sum: f64 = (0..3).map(|row| contact.frame[3 * row + axis] * force[row]).sum();
                        contacts.foot_force[side][axis] += sign * sum;
                    }
                }
                None => contacts.body = true,
            }
        }
        contacts
    }
}
