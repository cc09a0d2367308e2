//! What a physics step and a control step ask of Rust's allocator, once a world is warm. MuJoCo is C: what it
//! takes from the system by itself is not seen here.

#![cfg(all(feature = "rapier", feature = "mujoco"))]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

mod worlds;

use specforge::env::Mode;
use specforge::robot;
use specforge::sim::{self, EngineSettings, State, Terrain};

/// Counts the allocations of each thread.
struct Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call is handed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer came from `alloc` above with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of some warm steps of a standing robot: in handing over torques, in the engine, in looking at
/// it.
fn allocations(engine: &str) -> [u64; 3] {
    const STEPS: u64 = 500;
    let robot = robot::shipped("tocabi").unwrap();
    let mut state = State {
        base_position: [0.0, 0.0, robot.standing_height],
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        position: robot.default_pose(),
        velocity: vec![0.0; robot.joints()],
        ..State::default()
    };
    let settings = EngineSettings { step: 0.002, friction: 1.0, contact_time: None };
    let mut world = sim::open(engine).unwrap().build(&robot, &Terrain::Flat, &settings, &state).unwrap();
    let torque = vec![5.0; robot.joints()];
    let mut counts = [0; 3];
    let mut since = COUNT.get();
    let mut count = |slot: Option<usize>| {
        let now = COUNT.get();
        if let Some(slot) = slot {
            counts[slot] += now - since;
        }
        since = now;
    };
    for step in 0..2 * STEPS {
        let warm = |slot| (step >= STEPS).then_some(slot);
        count(None);
        world.apply(&torque);
        count(warm(0));
        world.advance();
        count(warm(1));
        std::hint::black_box(world.is_sane());
        world.read(&mut state);
        std::hint::black_box(world.contacts());
        count(warm(2));
    }
    counts
}

/// Allocations of some warm control steps of a robot that stands under position control.
fn allocations_of_control(engine: &str) -> u64 {
    let blueprint = worlds::blueprint("stand", "position", "");
    let mut environment = blueprint.environment(sim::open(engine).unwrap(), &Mode::Training).unwrap();
    let action = vec![0.0; environment.view().sizes().action];
    let mut observation = vec![0.0; environment.view().sizes().observation];
    environment.begin("1/test/env/0/episode/0");
    let mut step = || {
        assert_eq!(environment.step(&action).end, None);
        environment.view().observe(&mut observation);
    };
    (0..100).for_each(|_| step());
    let before = COUNT.get();
    (0..100).for_each(|_| step());
    COUNT.get() - before
}

#[test]
fn a_warm_physics_step_asks_nothing_of_rusts_allocator_but_within_rapier() {
    assert_eq!(allocations("mujoco"), [0; 3]);
    let [apply, advance, look] = allocations("rapier");
    assert_eq!([apply, look], [0; 2]);
    println!("rapier itself allocates {:.1} times per step", advance as f64 / 500.0);
}

#[test]
fn a_warm_control_step_asks_nothing_of_rusts_allocator() {
    assert_eq!(allocations_of_control("mujoco"), 0);
}
