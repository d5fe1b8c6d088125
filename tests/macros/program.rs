//! Stand-ins of a program's instructions, for programs that are not to compile: signatures, no behaviour.

use mrroc::{Condition, Fault, Generator, Robot, RobotHandle, RobotsOf, SensorHandle, SensorsOf};

use crate::cell::{Camera, Polycrank, Rnt, WristForce};

/// `Mp::move_robots`.
pub fn move_robots<G: Generator>(
    _robots: impl RobotsOf<G::Robots>,
    _sensors: impl SensorsOf<G::Sensors>,
    generator: G,
) -> Result<G, Fault> {
    Ok(generator)
}

/// `Ecp::<R>::move_robot`.
pub fn move_robot<R: Robot, G: Generator<Robots = R>>(
    _sensors: impl SensorsOf<G::Sensors>,
    generator: G,
) -> Result<G, Fault> {
    Ok(generator)
}

/// `Mp::wait_until`.
pub fn wait_until<C: Condition>(
    _robots: impl RobotsOf<C::Robots>,
    _sensors: impl SensorsOf<C::Sensors>,
    condition: C,
) -> Result<C, Fault> {
    Ok(condition)
}

/// A handle.
pub fn rnt() -> RobotHandle<Rnt> {
    unimplemented!("stand-in")
}

/// A handle.
pub fn polycrank() -> RobotHandle<Polycrank> {
    unimplemented!("stand-in")
}

/// A handle.
pub fn force() -> SensorHandle<WristForce> {
    unimplemented!("stand-in")
}

/// A handle.
pub fn camera() -> SensorHandle<Camera> {
    unimplemented!("stand-in")
}
