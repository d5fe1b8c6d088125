//! What the base stands on and among, shared by its drives and its sensors.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc_map::Walls;

use super::chassis::{Chassis, Motion};
use super::ground::Ground;
use crate::sensing::Planar;

/// How the body touched walls.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touched {
    /// How many times, counted at their beginnings.
    pub times: u32,
    /// Whether it touches now.
    pub now: bool,
    /// The deepest that it pressed into one \[m\].
    pub deepest: f64,
}

/// The world of a base. All copies are views of the same one.
#[derive(Clone, Debug)]
pub struct Floor(Rc<RefCell<State>>);

#[derive(Debug)]
struct State {
    ground: Ground,
    chassis: Chassis,
    touched: Touched,
    time: f64,
    /// How far its axle went \[m\].
    travel: f64,
}

impl Floor {
    /// A base at rest on this ground.
    #[must_use]
    pub fn new(ground: Ground, pose: Planar) -> Self {
        Self(Rc::new(RefCell::new(State {
            ground,
            chassis: Chassis::at(pose),
            touched: Touched::default(),
            time: 0.0,
            travel: 0.0,
        })))
    }

    /// Where the base truly is, and how it moves.
    #[must_use]
    pub fn motion(&self) -> Motion {
        self.0.borrow().chassis.motion
    }

    /// How it touched walls.
    #[must_use]
    pub fn touched(&self) -> Touched {
        self.0.borrow().touched
    }

    /// The drives' time \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.0.borrow().time
    }

    /// How far the middle of the axle went \[m\].
    #[must_use]
    pub fn travel(&self) -> f64 {
        self.0.borrow().travel
    }

    /// Changes the ground from now on: oil, a carpet, other walls.
    pub fn change(&self, change: impl FnOnce(&mut Ground)) {
        change(&mut self.0.borrow_mut().ground);
    }

    /// What `see` makes of the walls, if there are any.
    pub fn walls<T>(&self, see: impl FnOnce(&Walls) -> T) -> Option<T> {
        self.0.borrow().ground.walls.as_ref().map(see)
    }

    /// Runs `steps` integration steps; `drive` is told how hard the tyres push the body \[N\] and says how fast the wheels turn [rad/s].
    pub(super) fn run(&self, steps: usize, mut drive: impl FnMut([f64; 2]) -> [f64; 2]) {
        let state = &mut *self.0.borrow_mut();
        let mut pushes = [0.0; 2];
        for _ in 0..steps {
            let wheels = drive(pushes);
            pushes = state.chassis.step(wheels, &state.ground);
            state.time += Chassis::STEP;
            let motion = &state.chassis.motion;
            state.travel += motion.ahead.hypot(motion.left) * Chassis::STEP;
            let pressed = state.chassis.pressed;
            state.touched.times += u32::from(pressed > 0.0 && !state.touched.now);
            state.touched.now = pressed > 0.0;
            state.touched.deepest = state.touched.deepest.max(pressed);
        }
    }
}
