//! The drives of an arm that carries a stylus among walls.
//!
//! ```text
//! q -> X_WE -> seat of the stylus in M -> stylus -> F on the tool -> J^T F on the joints -> motors -> q
//! ```

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::pose::{Pose, Wrench};
use mrroc::robot::Robot as _;
use mrroc_map::{Place, Walls};
use mrroc_robots::{Irp6, SimulatedIrp6, Surrounded, Surroundings};
use nalgebra::Vector3;

use super::stylus::{STIFFNESS, Stylus};
use crate::places::HEIGHT;

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
        if p.z > HEIGHT + self.stylus.radius() {
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
            // Beside the maze, which is looked for: its distance counts from within.
            self.stylus.distance = 0.0;
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
pub type Probing = Surrounded<Irp6, 6, Touching>;

/// What the arm's stylus is among.
#[derive(Debug)]
#[allow(non_snake_case)]
pub struct Touching {
    world: Rc<RefCell<World>>,
    X_FE: Pose,
    tip: Vector3<f64>,
}

/// These drives, in this world.
#[must_use]
#[allow(non_snake_case)]
pub fn probing(arm: SimulatedIrp6, X_FE: Pose, world: Rc<RefCell<World>>) -> Probing {
    let tip = tip(&arm, &X_FE);
    Surrounded::by(arm, Touching { world, X_FE, tip })
}

/// Where the seat of the stylus is \[m\].
#[allow(non_snake_case)]
fn tip(arm: &SimulatedIrp6, X_FE: &Pose) -> Vector3<f64> {
    (arm.robot().forward(&arm.state().position) * X_FE).translation.vector
}

impl Surroundings<Irp6, 6> for Touching {
    fn begin(&mut self, arm: &mut SimulatedIrp6) {
        let world = self.world.borrow();
        let bent = world.stylus.deflection();
        let force = world.X_WM.rotation * Vector3::new(-STIFFNESS * bent.x, -STIFFNESS * bent.y, 0.0);
        arm.push_tool(&self.X_FE, &Wrench { force, torque: Vector3::zeros() });
    }

    fn end(&mut self, arm: &SimulatedIrp6) {
        let tip = tip(arm, &self.X_FE);
        let mut world = self.world.borrow_mut();
        for i in 1..=TIMES {
            let share = f64::from(i) / f64::from(TIMES);
            world.step(&(self.tip + (tip - self.tip) * share));
        }
        self.tip = tip;
    }
}
