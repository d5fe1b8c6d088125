//! Passes the coordinator's displacements on for as long as the robot follows them.

use core::marker::PhantomData;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;

use mrroc_generators::cooperation::Displacement;

/// The ECP's half of tight cooperation by displacements where something may be in the way. If the measured tool is
/// farther behind its demand than the lag of the drives explains, it has touched something, and a fault stops all arms.
/// This detects contact without a sensor.
///
/// ```
/// use mrroc::generator::Generator;
/// use mrroc::prelude::*;
/// use mrroc::robot::RobotImage;
/// use mrroc_generators::cooperation::Displacement;
/// use mrroc_generators::generators::WatchedTransmit;
/// use mrroc_generators::rehearsal::at_rest;
/// use mrroc_robots::Irp6;
///
/// let irp6 = Irp6::nominal();
/// let at = *at_rest(&irp6, Irp6::READY).demanded();
/// let mut watch = WatchedTransmit::<Irp6>::within(5e-3, 0.05);
/// let pose = Pose::translation(0.0, 0.0, 0.01);
/// let (order, v) = (Order::new(Displacement { pose }), Reading::new(()));
/// # let t = Tick { step: 0, dt: 0.002, duration: 0.002 };
/// // The tool is 4.9 mm behind its demand, and then 5.1 mm.
/// let mut measured = at;
/// measured.pose *= Pose::translation(0.0, 0.0, -4.9e-3);
/// let e = State::new(RobotImage::new(measured, at));
/// assert_eq!(watch.next_step(&order, &e, &v, t)?, Step::Next(Demand::displacement(pose)));
/// measured.pose *= Pose::translation(0.0, 0.0, -0.2e-3);
/// let e = State::new(RobotImage::new(measured, at));
/// assert!(watch.next_step(&order, &e, &v, t).is_err());
/// # Ok::<(), Fault>(())
/// ```
pub struct WatchedTransmit<R> {
    distance: f64,
    angle: f64,
    of: PhantomData<R>,
}

impl<R: Robot> WatchedTransmit<R> {
    /// The tool may be `distance` \[m\] and `angle` \[rad\] off, both > 0; at the speed `v` a lag of the drives of `d` seconds and one
    /// step `T` explain `v (d + T)`.
    #[must_use]
    pub fn within(distance: f64, angle: f64) -> Self {
        WatchedTransmit { distance, angle, of: PhantomData }
    }
}

#[generator(ecp)]
impl<R: Robot> WatchedTransmit<R> {
    fn next_step(&self, order: &Order<Displacement>, e: &State<R>) -> Result<Step<R>, Fault> {
        let off = e.demanded().pose.inv_mul(&e.measured().pose);
        let shares =
            [(off.translation.vector.norm(), self.distance, "m"), (off.rotation.angle(), self.angle, "rad")];
        for (actual, limit, unit) in shares {
            // What is not a number is off, too.
            if actual.partial_cmp(&limit).is_none_or(|order| order.is_gt()) {
                return Err(Fault::new(FaultKind::FollowingError).exceeds(actual, limit, unit));
            }
        }
        Ok(Step::Next(Demand::displacement(order.value().pose)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::pose::Pose;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc_robots::{Irp6, Six};

    #[test]
    fn an_arm_that_is_held_back_stops_the_motion() {
        let at = |pose| RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose };
        let e = |off| {
            State::<Irp6>::new(RobotImage::new(at(Pose::translation(off, 0.0, 0.0)), at(Pose::identity())))
        };
        let pose = Pose::translation(0.1, 0.2, 0.3);
        let order = Order::new(Displacement { pose });
        let watched = WatchedTransmit::within(5e-3, 0.02);
        let step = watched.next_step(&order, &e(4e-3)).expect("near");
        assert_eq!(step, Step::Next(Demand::displacement(pose)));
        let fault = watched.next_step(&order, &e(6e-3)).expect_err("far");
        assert_eq!(fault.excess().map(|x| (x.actual, x.limit, x.unit)), Some((6e-3, 5e-3, "m")));
    }
}
