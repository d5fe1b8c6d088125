//! The same program with force sensors at the wrists, which keep the stress in the body low.

use mrroc::generator::{RobotHandle, SensorHandle};
use mrroc::prelude::*;
use mrroc_generators::cooperation::{
    BodyFrame, BodyPath, Displacement, GraspStiffness, SqueezeBounds, SqueezeGains, SqueezeLaw,
};
use mrroc_generators::generators::SqueezedCarry;
use mrroc_robots::sensors::{WristForce, WristOrder};
use mrroc_robots::{Gripper, Polycrank, Rnt};

use crate::generators::Trigger;
use crate::orders::{Arms, Phase};
use crate::paths::soft;
use crate::places::{bar, legs, limits};

/// Stiffness of a hand's grasp [N/m], [N m/rad].
pub const STIFFNESS: GraspStiffness = GraspStiffness { force: 5e4, torque: 500.0 };
/// From a demand to the reading that tells of it \[s\]: the step, the cell's delay of 7 ms, about 20 ms of the drives, 3 ms
/// of the sensor's filter, a step until it is read.
const DELAY: f64 = 0.034;
/// The bias is the mean of so many readings.
const AVERAGED: u32 = 100;
/// Steps after which a reading is too old.
const OLDEST: u32 = 1;

/// The sensors at the wrists.
pub type Wrists = (WristForce, WristForce);

/// How the arms answer to stress: it decays at 18/s, so that `rate * (delay + inertia)` is 0.8, where the law asks for less
/// than 1.
///
/// # Errors
/// A figure is out of range.
pub fn law() -> Result<SqueezeLaw, Fault> {
    let gains = SqueezeGains { stiffness: STIFFNESS, rate: 18.0, inertia: 0.01 };
    let bounds = SqueezeBounds { speed: 0.02, turning: 0.2, travel: 0.005, angle: 0.05 };
    SqueezeLaw::new(gains, bounds, DELAY).map_err(|bad| Fault::thrown(&bad.to_string()))
}

/// Carries the body at `X_WB` along `path`, and yields to stress: the library's generator.
#[allow(non_snake_case)]
fn squeezed<P: BodyPath>(X_WB: Pose, path: P) -> Result<SqueezedCarry<Arms, Wrists, P, Displacement>, Fault> {
    Ok(SqueezedCarry::along(BodyFrame::InWorld(X_WB), path, law()?, 0.0, OLDEST))
}

/// Waits until all sensors have given so many readings.
struct Readings(u32);

#[condition(mp)]
fn readings(c: &mut Readings, v: &Reading<(WristForce, WristForce)>) -> bool {
    let given = v.0.reading().is_some() && v.1.reading().is_some();
    c.0 = c.0.saturating_sub(u32::from(given));
    c.0 == 0
}

/// Measures the bias of the sensors, while nothing touches the tools.
fn zero(
    mp: &mut Mp,
    rnt: &mut RobotHandle<Rnt>,
    polycrank: &mut RobotHandle<Polycrank>,
    wrists: &mut (SensorHandle<WristForce>, SensorHandle<WristForce>),
) -> Result<(), Fault> {
    for order in [WristOrder::MeasureBias, WristOrder::Read] {
        wrists.0.configure(order);
        wrists.1.configure(order);
        mp.wait_until((&mut *rnt, &mut *polycrank), (&mut wrists.0, &mut wrists.1), Readings(AVERAGED))?;
    }
    Ok(())
}

/// The whole task.
///
/// # Errors
/// The first fault of the cell.
#[allow(non_snake_case)]
pub fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let (mut rnt, mut polycrank) = (mp.robot::<Rnt>("rnt")?, mp.robot::<Polycrank>("polycrank")?);
    let mut hands = (mp.robot::<Gripper>("rnt-hand")?, mp.robot::<Gripper>("polycrank-hand")?);
    let mut wrists = (mp.sensor::<WristForce>("rnt-wrist")?, mp.sensor::<WristForce>("polycrank-wrist")?);
    zero(mp, &mut rnt, &mut polycrank, &mut wrists)?;
    mp.move_robots((&mut rnt, &mut polycrank), (), Trigger::to(Phase::Approach))?;
    mp.move_robots([&mut hands.0, &mut hands.1], (), Trigger::to(Phase::Close))?;
    let mut X_WB = bar();
    for X_BsB in legs() {
        let carry = squeezed(X_WB, soft(X_BsB, limits())?)?;
        mp.move_robots((&mut rnt, &mut polycrank), (&mut wrists.0, &mut wrists.1), carry)?;
        X_WB *= X_BsB;
    }
    mp.move_robots([&mut hands.0, &mut hands.1], (), Trigger::to(Phase::Open))?;
    mp.move_robots((&mut rnt, &mut polycrank), (), Trigger::to(Phase::Withdraw))?;
    Ok(())
}
