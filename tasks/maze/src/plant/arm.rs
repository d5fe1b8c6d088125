//! The drives of an arm that carries a stylus among walls.
//!
//! ```text
//! q -> X_WE -> seat of the stylus in M -> stylus -> F on the tool -> J^T F on the joints -> motors -> q
//! ```

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use mrroc::pose::Pose;
use mrroc::robot::{DriveFault, Driver, Measured, Regulators, Robot as _, SimulatedDrives};
use mrroc_map::{Place, Walls};
use mrroc_robots::models::{Driven, Kinematics};
use mrroc_robots::{Irp6, Shaft, Simulated, SimulatedIrp6, Six};
use nalgebra::{Vector3, Vector6};

use super::stylus::{STIFFNESS, Stylus};
use crate::places::{BALL, HEIGHT};

/// What arm and probe share.
#[derive(Debug)]
#[allow(non_snake_case)]
pub struct World {
    /// Where the maze truly stands.
    pub X_WM: Pose,
    /// Its walls.
    pub walls: Walls,
    /// The stylus.
    pub stylus: Stylus,
    /// The drives' time \[s\].
    pub time: f64,
    /// When the switch closed first after it had been open for [`Self::QUIET`] \[s\] ..
    pub onset: f64,
    /// .. and when it was closed last \[s\].
    pub last: f64,
    /// The ball's places between the walls, to be drawn [m, M].
    pub trace: Vec<Place>,
}

impl World {
    /// The switch is open when it has been for so long \[s\].
    pub const QUIET: f64 = 3e-3;

    fn step(&mut self, tip: &Vector3<f64>) {
        self.time += SUB;
        let p = self.X_WM.inverse_transform_point(&(*tip).into());
        if p.z > HEIGHT + BALL {
            self.stylus.lift();
            return;
        }
        let closed = self.stylus.move_to(&Place::new(p.x, p.y), &self.walls, self.time);
        if closed {
            if self.time - self.last > Self::QUIET {
                self.onset = self.time;
            }
            self.last = self.time;
        }
        if p.x < 0.0 || p.y < 0.0 {
            // Beside the maze, which is looked for: its way begins within.
            self.stylus.way = 0.0;
            return;
        }
        if let Some(ball) = self.stylus.ball()
            && self.trace.last().is_none_or(|last| (last - ball).norm() > 3e-4)
        {
            self.trace.push(ball);
        }
    }
}

/// The stylus is looked at so often in a servo period ..
const TIMES: u32 = 4;
/// .. which is every so many seconds.
const SUB: f64 = 0.002 / TIMES as f64;

/// An IRp-6 with a stylus.
#[derive(Debug)]
#[allow(non_snake_case)]
pub struct Probing {
    arm: SimulatedIrp6,
    shaft: Shaft,
    world: Rc<RefCell<World>>,
    X_FE: Pose,
    tip: Vector3<f64>,
}

impl Probing {
    /// These drives, in this world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn new(arm: SimulatedIrp6, X_FE: Pose, world: Rc<RefCell<World>>) -> Self {
        let shaft = arm.shaft();
        let tip = (arm.robot().forward(&shaft.state().position) * X_FE).translation.vector;
        Self { arm, shaft, world, X_FE, tip }
    }

    fn load(&mut self) {
        let world = self.world.borrow();
        let bent = world.stylus.deflection();
        if bent.norm_squared() == 0.0 {
            (0..6).for_each(|i| self.arm.push(i, 0.0));
            return;
        }
        let force = world.X_WM.rotation * Vector3::new(-STIFFNESS * bent.x, -STIFFNESS * bent.y, 0.0);
        let q = self.shaft.state().position;
        let robot = self.arm.robot();
        let lever = robot.forward(&q).rotation * self.X_FE.translation.vector;
        let torque = lever.cross(&force);
        let wrench = Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z);
        let at_motors = robot.motor_torques(&robot.motors(&q), &robot.jacobian(&q).tr_mul(&wrench));
        // A drive's load counts against its motion.
        (0..6).for_each(|i| self.arm.push(i, -at_motors[i]));
    }

    fn in_world<T>(&mut self, period: impl FnOnce(&mut SimulatedIrp6) -> T) -> T {
        self.load();
        let outcome = period(&mut self.arm);
        let tip = (self.arm.robot().forward(&self.shaft.state().position) * self.X_FE).translation.vector;
        let mut world = self.world.borrow_mut();
        for i in 1..=TIMES {
            let share = f64::from(i) / f64::from(TIMES);
            world.step(&(self.tip + (tip - self.tip) * share));
        }
        self.tip = tip;
        outcome
    }
}

impl Driver<Irp6> for Probing {
    fn period(&self) -> Duration {
        self.arm.period()
    }

    fn measured(&self) -> Result<Measured<Six>, DriveFault> {
        self.arm.measured()
    }

    fn tick(&mut self, demanded: &Six) -> Result<Measured<Six>, DriveFault> {
        self.in_world(|arm| arm.tick(demanded))
    }

    fn motor_currents(&self) -> Option<Six> {
        self.arm.motor_currents()
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<Irp6>> {
        Some(self)
    }

    fn has_brakes(&self) -> bool {
        self.arm.has_brakes()
    }

    fn switch_off(&mut self) {
        self.arm.switch_off();
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.arm.switch_on()
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        self.arm.has_regulator(joint, set)
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        self.arm.choose_regulators(sets);
    }
}

impl SimulatedDrives<Irp6> for Probing {
    fn brake(&mut self) -> Measured<Six> {
        self.in_world(Simulated::brake)
    }
}
