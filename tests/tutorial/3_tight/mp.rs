//! The coordinator: one motion of both robots.

use std::f64::consts::TAU;

use mrroc::prelude::*;

use crate::arm::Arm;
use crate::orders::Lift;

pub fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let mut left = mp.robot::<Arm>("left")?;
    let mut right = mp.robot::<Arm>("right")?;
    mp.move_robots((&mut left, &mut right), (), Together { t: 0.0 })?;
    Ok(())
}

/// How long the motion takes [s].
const DURATION: f64 = 4.0;

/// Up by 0.1 m and down again.
struct Together {
    t: f64,
}

#[generator(mp)]
fn together(c: &mut Together, t: Tick) -> Step<(Arm, Arm), Lift> {
    if c.t >= DURATION {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(DURATION);
    let height = 0.05 - 0.05 * (TAU * c.t / DURATION).cos();
    Step::Next((Lift { height }, Lift { height }))
}
