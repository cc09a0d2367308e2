//! The rapier engine: multibody joints in single precision, one world per robot.
//!
//! Settings and workarounds were measured (docs/explanation/engines.md): one solver iteration with four
//! stabilization sweeps, no continuous collision detection, no contact recycling; the root's frame is at its
//! centre of mass (rapier moves a free root wrongly otherwise); every generalized damping starts at zero
//! (rapier's default is 0.1, including the root); torques are applied as the force of a weak spring, which is
//! exact to 1e-4 N m.

use nalgebra::{Unit, Vector3};
use rapier3d::dynamics::{
    CCDSolver, CoefficientCombineRule, GenericJointBuilder, ImpulseJointSet, IntegrationParameters,
    IslandManager, JointAxesMask, JointAxis, MassProperties, MultibodyIndex, MultibodyJointSet,
    RigidBodyBuilder, RigidBodyHandle, RigidBodySet, SpringCoefficients,
};
use rapier3d::geometry::{
    Array2, BroadPhaseBvh, ColliderBuilder, ColliderHandle, ColliderSet, ContactPair, Group,
    InteractionGroups, InteractionTestMode, NEW_CONTACT_BIT, NarrowPhase,
};
use rapier3d::math::{Matrix, Pose, Rotation, Vector};
use rapier3d::pipeline::PhysicsPipeline;
use rapier3d::prelude::SoftBodySet;
use rapier3d::utils::OrthonormalBasis;

use super::engine::{Engine, World};
use super::error::EngineError;
use super::scene::{Contacts, EngineSettings, State, Terrain};
use super::terrain::Piece;
use crate::robot::model::Body;
use crate::robot::solid::{pose, solid};
use crate::robot::{Foot, Robot};

/// Acceleration of gravity in m/s^2.
const GRAVITY: f32 = 9.81;
/// The free axis of a revolute multibody joint: rotation about x of the joint frames.
const ANGLE: usize = 3;
/// Stiffness in N m/rad of the spring that applies the torque.
const CARRIER: f32 = 1e-3;
/// Joint speed in rad/s above which a state counts as diverged.
const MAX_RATE: f32 = 1000.0;
/// Distance in m from the origin above which a state counts as diverged.
const MAX_DISTANCE: f32 = 1000.0;

/// The rapier engine.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rapier;

impl Engine for Rapier {
    fn name(&self) -> &'static str {
        "rapier"
    }

    fn identity(&self) -> String {
        format!("rapier3d {} f32 multibody", rapier3d::VERSION)
    }

    fn build(
        &self,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<Box<dyn World>, EngineError> {
        let mut world = Assembly::new(settings);
        world.ground(terrain, settings.friction);
        world.robot(robot, settings.friction)?;
        let mut world = world.finish(robot)?;
        world.place(state);
        Ok(Box::new(world))
    }
}

/// The sets of a rapier simulation during construction.
struct Assembly {
    parameters: IntegrationParameters,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    joints: MultibodyJointSet,
    links: Vec<RigidBodyHandle>,
    root: RigidBodyHandle,
    soles: [ColliderHandle; 2],
    skin: Vec<ColliderHandle>,
}

impl Assembly {
    fn new(settings: &EngineSettings) -> Self {
        Self {
            parameters: parameters(settings),
            bodies: RigidBodySet::new(),
            colliders: ColliderSet::new(),
            joints: MultibodyJointSet::new(),
            links: Vec::new(),
            root: RigidBodyHandle::invalid(),
            soles: [ColliderHandle::invalid(); 2],
            skin: Vec::new(),
        }
    }

    fn ground(&mut self, terrain: &Terrain, friction: f64) {
        for piece in terrain.pieces() {
            let collider = match piece {
                Piece::Plane { point, normal } => {
                    let normal = Unit::new_unchecked(vector(normal));
                    ColliderBuilder::halfspace(normal).translation(vector(point))
                }
                Piece::Box { centre, half } => {
                    let half = vector(half);
                    ColliderBuilder::cuboid(half.x, half.y, half.z).translation(vector(centre))
                }
                Piece::Field { cell, counts, heights } => field(cell, counts, heights),
            };
            let groups = InteractionGroups::new(Group::GROUP_2, Group::GROUP_1, InteractionTestMode::And);
            self.colliders
                .insert(collider.friction(friction as f32).restitution(0.0).collision_groups(groups));
        }
    }

    /// Adds the base and the links, children shifted by the base's centre of mass.
    fn robot(&mut self, robot: &Robot, friction: f64) -> Result<(), EngineError> {
        let anchor = robot.base.com.coords;
        self.root = self.body(&robot.base, anchor);
        self.shapes(&robot.base, self.root, anchor, friction);
        for (index, link) in robot.links.iter().enumerate() {
            let handle = self.body(&link.body, Vector3::zeros());
            let (parent, shift) = match link.parent {
                Some(parent) => (self.links[parent], Vector3::zeros()),
                None => (self.root, anchor),
            };
            let turn = Rotation::from_rotation_arc(Vector::X, vec3(&link.joint.axis));
            let mut origin = pose(&link.joint.origin);
            origin.translation -= vec3(&shift);
            let joint = GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES)
                .contacts_enabled(false)
                .local_frame1(origin * Pose::from_parts(Vector::ZERO, turn))
                .local_frame2(Pose::from_parts(Vector::ZERO, turn))
                .limits(JointAxis::AngX, [link.joint.lower as f32, link.joint.upper as f32])
                .build();
            self.joints.insert(parent, handle, joint, true).ok_or_else(|| EngineError::Model {
                engine: "rapier",
                reason: format!("joint `{}` does not extend the tree", link.joint.name),
            })?;
            self.links.push(handle);
            match robot.feet.iter().position(|foot| foot.link == index) {
                Some(side) => self.soles[side] = self.sole(&robot.feet[side], handle),
                None => self.shapes(&link.body, handle, Vector3::zeros(), friction),
            }
        }
        Ok(())
    }

    fn body(&mut self, body: &Body, anchor: Vector3<f64>) -> RigidBodyHandle {
        let inertia = Matrix::from_cols_array(&std::array::from_fn(|i| body.inertia[(i % 3, i / 3)] as f32));
        let com = vec3(&(body.com.coords - anchor));
        let mass = MassProperties::with_inertia_matrix(com, body.mass as f32, inertia);
        self.bodies.insert(RigidBodyBuilder::dynamic().can_sleep(false).additional_mass_properties(mass))
    }

    fn shapes(&mut self, body: &Body, handle: RigidBodyHandle, anchor: Vector3<f64>, friction: f64) {
        for collision in &body.collisions {
            let (shape, place) = solid(collision);
            let mut place = pose(&place);
            place.translation -= vec3(&anchor);
            let collider = self.attach(ColliderBuilder::new(shape).position(place), handle, friction);
            self.skin.push(collider);
        }
    }

    /// A foot's friction is a factor on the ground's.
    fn sole(&mut self, foot: &Foot, handle: RigidBodyHandle) -> ColliderHandle {
        let half = vec3(&foot.half_extents);
        let shape = ColliderBuilder::cuboid(half.x, half.y, half.z).translation(vec3(&foot.centre.coords));
        self.attach(shape.friction_combine_rule(CoefficientCombineRule::Multiply), handle, foot.friction)
    }

    fn attach(&mut self, shape: ColliderBuilder, handle: RigidBodyHandle, friction: f64) -> ColliderHandle {
        let groups = InteractionGroups::new(Group::GROUP_1, Group::GROUP_2, InteractionTestMode::And);
        let collider = shape.density(0.0).friction(friction as f32).restitution(0.0).collision_groups(groups);
        self.colliders.insert_with_parent(collider, handle, &mut self.bodies)
    }

    /// Sets the joints' parameters and combines the sets into a world.
    fn finish(mut self, robot: &Robot) -> Result<RapierWorld, EngineError> {
        for (_, body) in self.bodies.iter_mut() {
            body.recompute_mass_properties_from_colliders(&self.colliders);
        }
        let refused = |reason: &str| EngineError::Model { engine: "rapier", reason: reason.into() };
        let tree = self
            .joints
            .rigid_body_link(self.root)
            .ok_or_else(|| refused("the robot has no joints"))?
            .multibody;
        let ids: Vec<usize> =
            self.links.iter().filter_map(|&link| self.joints.rigid_body_link(link).map(|id| id.id)).collect();
        let multibody =
            self.joints.get_multibody_mut(tree).ok_or_else(|| refused("the tree is incomplete"))?;
        multibody.forward_kinematics(&self.bodies, true);
        multibody.set_self_contacts_enabled(false);
        multibody.damping_mut().fill(0.0);
        let mut slots = Vec::with_capacity(ids.len());
        for (link, id) in robot.links.iter().zip(ids) {
            let dof = multibody.link(id).ok_or_else(|| refused("a link is missing"))?.assembly_id();
            multibody.damping_mut()[dof] = link.joint.damping as f32;
            multibody.armature_mut()[dof] = link.joint.armature as f32;
            multibody.frictions_mut()[dof] = link.joint.friction as f32;
            slots.push(Slot { link: id, dof });
        }
        Ok(RapierWorld {
            pipeline: PhysicsPipeline::new(),
            parameters: self.parameters,
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            narrow_phase: NarrowPhase::new(),
            bodies: self.bodies,
            colliders: self.colliders,
            impulse_joints: ImpulseJointSet::new(),
            joints: self.joints,
            soft_bodies: SoftBodySet::new(),
            ccd: CCDSolver::new(),
            tree,
            slots,
            root: self.root,
            anchor: vec3(&robot.base.com.coords),
            soles: self.soles,
            skin: self.skin,
        })
    }
}

/// Position of a joint in the multibody: its link and its index in the generalized vectors.
#[derive(Clone, Copy, Debug)]
struct Slot {
    link: usize,
    dof: usize,
}

/// One robot in one rapier world.
struct RapierWorld {
    pipeline: PhysicsPipeline,
    parameters: IntegrationParameters,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    impulse_joints: ImpulseJointSet,
    joints: MultibodyJointSet,
    soft_bodies: SoftBodySet,
    ccd: CCDSolver,
    tree: MultibodyIndex,
    slots: Vec<Slot>,
    root: RigidBodyHandle,
    /// Centre of mass of the base in its frame: the origin of the root's frame.
    anchor: Vector,
    soles: [ColliderHandle; 2],
    skin: Vec<ColliderHandle>,
}

impl RapierWorld {
    /// Sets the state of a new world.
    fn place(&mut self, state: &State) {
        let [w, x, y, z] = state.base_orientation.map(|value| value as f32);
        let turn = Rotation::from_xyzw(x, y, z, w).normalize();
        let arm = turn * self.anchor;
        let (rate, velocity) = (vector(state.base_rate), vector(state.base_velocity));
        let root = Pose::from_parts(vector(state.base_position) + arm, turn);
        self.bodies[self.root].set_position(root, true);
        let tree =
            self.joints.get_multibody_mut(self.tree).expect("the multibody lives as long as the world");
        tree.forward_kinematics(&self.bodies, true);
        let mut shift = vec![0.0; tree.ndofs()];
        for (slot, position) in self.slots.iter().zip(&state.position) {
            shift[slot.dof] = *position as f32;
        }
        tree.apply_displacements(&shift);
        tree.forward_kinematics(&self.bodies, false);
        tree.update_rigid_bodies(&mut self.bodies, true);
        let mut velocities = tree.generalized_velocity_mut();
        let linear = velocity + rate.cross(arm);
        for (entry, value) in [linear.x, linear.y, linear.z, rate.x, rate.y, rate.z].into_iter().enumerate() {
            velocities[entry] = value;
        }
        for (slot, value) in self.slots.iter().zip(&state.velocity) {
            velocities[slot.dof] = *value as f32;
        }
    }

    /// Force in N of the ground on a collider in the last step, from the contacts that the solver used: other
    /// manifold points have stale impulses.
    fn force(&self, collider: ColliderHandle) -> Vector {
        let pairs = self.narrow_phase.contact_pairs_with(collider);
        pairs.fold(Vector::ZERO, |sum, pair| sum + self.pair_force(pair, collider))
    }

    fn pair_force(&self, pair: &ContactPair, collider: ColliderHandle) -> Vector {
        let sign = if pair.collider1 == collider { -1.0 } else { 1.0 };
        let mut impulse = Vector::ZERO;
        for manifold in pair.solver_manifolds() {
            let normal = manifold.data.normal;
            let tangent = (-normal).orthonormal_vector();
            let bitangent = (-normal).cross(tangent);
            for contact in &manifold.data.solver_contacts {
                let point = &manifold.points[(contact.contact_id[0] & !NEW_CONTACT_BIT) as usize].data;
                impulse += normal * point.impulse
                    - tangent * point.tangent_impulse.x
                    - bitangent * point.tangent_impulse.y;
            }
        }
        impulse * sign / self.parameters.dt
    }

    /// Whether the ground pushed on a collider in the last step.
    fn touches(&self, collider: ColliderHandle) -> bool {
        self.narrow_phase.contact_pairs_with(collider).any(|pair| {
            pair.solver_manifolds().iter().any(|manifold| {
                let solved = |id: u32| manifold.points[(id & !NEW_CONTACT_BIT) as usize].data.impulse > 0.0;
                manifold.data.solver_contacts.iter().any(|contact| solved(contact.contact_id[0]))
            })
        })
    }
}

impl World for RapierWorld {
    fn apply(&mut self, torque: &[f64]) {
        let tree =
            self.joints.get_multibody_mut(self.tree).expect("the multibody lives as long as the world");
        for (slot, torque) in self.slots.iter().zip(torque) {
            let joint = &mut tree.link_mut(slot.link).expect("slots name links of the tree").joint;
            let position = joint.coords()[ANGLE];
            joint.set_spring(ANGLE, CARRIER, position + *torque as f32 / CARRIER);
            // The row of an inactive limit has no impulse but costs a solve of the mass matrix.
            let limit = joint.data.limits[ANGLE];
            let kept = (limit.min..=limit.max).contains(&position);
            joint.data.limit_axes.set(JointAxesMask::ANG_X, !kept);
        }
    }

    fn advance(&mut self) {
        self.pipeline.step(
            Vector::new(0.0, 0.0, -GRAVITY),
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.joints,
            &mut self.soft_bodies,
            &mut self.ccd,
            &(),
            &(),
        );
    }

    fn read(&self, state: &mut State) {
        let tree = self.joints.get_multibody(self.tree).expect("the multibody lives as long as the world");
        let root = tree.root().local_to_world();
        let arm = root.rotation * self.anchor;
        let velocities = tree.generalized_velocity();
        let rate = Vector::new(velocities[3], velocities[4], velocities[5]);
        let velocity = Vector::new(velocities[0], velocities[1], velocities[2]) - rate.cross(arm);
        state.base_position = triple(root.translation - arm);
        let turn = [root.rotation.w, root.rotation.x, root.rotation.y, root.rotation.z].map(f64::from);
        let norm = libm::sqrt(turn.iter().map(|value| value * value).sum());
        state.base_orientation = turn.map(|value| value / norm);
        state.base_velocity = triple(velocity);
        state.base_rate = triple(rate);
        state.position.clear();
        state.velocity.clear();
        for slot in &self.slots {
            let joint = tree.link(slot.link).expect("slots name links of the tree").joint();
            state.position.push(f64::from(joint.coords()[ANGLE]));
            state.velocity.push(f64::from(velocities[slot.dof]));
        }
    }

    fn contacts(&self) -> Contacts {
        Contacts {
            foot_force: self.soles.map(|sole| triple(self.force(sole))),
            body: self.skin.iter().any(|&collider| self.touches(collider)),
        }
    }

    fn push(&mut self, force: [f64; 3]) {
        let body = &mut self.bodies[self.root];
        body.reset_forces(true);
        body.add_force(vector(force), true);
    }

    fn is_sane(&self) -> bool {
        let tree = self.joints.get_multibody(self.tree).expect("the multibody lives as long as the world");
        let place = tree.root().local_to_world().translation;
        // Comparisons with NaN are false, so NaN is caught, too.
        let slow = tree.generalized_velocity().iter().all(|rate| rate.abs() < MAX_RATE);
        let near = place.abs().max_element() < MAX_DISTANCE && place.is_finite();
        slow && near && self.pipeline.quarantine().bodies().is_empty()
    }
}

/// The measured settings, for a step and a contact softness.
fn parameters(settings: &EngineSettings) -> IntegrationParameters {
    let mut parameters = IntegrationParameters {
        dt: settings.step as f32,
        num_solver_iterations: 1,
        num_internal_pgs_iterations: 1,
        num_internal_stabilization_iterations: 4,
        max_ccd_substeps: 0,
        contact_recycling: false,
        ..IntegrationParameters::default()
    };
    if let Some(time) = settings.contact_time {
        // A critically damped contact with the time constant of MuJoCo's `solref`.
        let softness = SpringCoefficients::new((1.0 / (std::f64::consts::TAU * time)) as f32, 1.0);
        parameters.contact_softness = softness;
        parameters.static_contact_softness = softness;
        parameters.num_internal_pgs_iterations = 8;
        parameters.num_internal_stabilization_iterations = 0;
    }
    parameters
}

/// A height field; rapier's lies in x-z with y up, so it is rotated about x, which reverses its rows.
fn field(cell: f64, counts: [usize; 2], heights: &[f64]) -> ColliderBuilder {
    let [along, across] = counts;
    let mut grid = Array2::repeat(across, along, 0.0);
    for (index, height) in heights.iter().enumerate() {
        grid[(across - 1 - index % across, index / across)] = *height as f32;
    }
    let scale = Vector::new(((along - 1) as f64 * cell) as f32, 1.0, ((across - 1) as f64 * cell) as f32);
    ColliderBuilder::heightfield(grid, scale).rotation(Vector::new(std::f32::consts::FRAC_PI_2, 0.0, 0.0))
}

fn vector(from: [f64; 3]) -> Vector {
    Vector::new(from[0] as f32, from[1] as f32, from[2] as f32)
}

fn vec3(from: &Vector3<f64>) -> Vector {
    vector([from.x, from.y, from.z])
}

fn triple(from: Vector) -> [f64; 3] {
    [from.x, from.y, from.z].map(f64::from)
}
