//! A motion of your own.

use mrroc::prelude::*;

use crate::arm::Arm;

/// How long the motion takes [s].
const DURATION: f64 = 1.0;

/// FILL IN: what the motion remembers from step to step.
#[derive(Default)]
pub struct MyMotion {
    t: f64,
}

impl MyMotion {
    /// FILL IN: the parameters of the motion.
    pub fn new() -> Self {
        MyMotion::default()
    }
}

/// One step: what is returned is demanded.
#[generator(mp)]
fn my_motion(c: &mut MyMotion, t: Tick) -> Step<(Arm, Arm)> {
    if c.t >= DURATION {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(DURATION);
    // FILL IN: the next state, as `Demand::joints`, `Demand::pose` ..; add `e: &State<(Arm, Arm)>` where you need the present one.
    Step::Next((Demand::hold(), Demand::hold()))
}
