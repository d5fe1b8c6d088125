//! Waits until the robot has reached its demand.

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::robot::JointVector;

/// Holds until every joint, as measured, stays near its demand for a while: before a measurement or a grasp.
///
/// A robot that does not settle in time is a fault.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::Settle;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::{Irp6, Six};
///
/// // Within 1 mrad for 0.2 s, which must happen within a second.
/// let settle = Settle::within(Six::repeat(1e-3), 0.2, 1.0);
/// // A robot that follows exactly is there at once: it is done in its hundredth step.
/// let demands = rehearse(settle, &Irp6::nominal(), Irp6::READY, 0.002)?;
/// assert_eq!(demands, vec![Demand::hold(); 99]);
/// # Ok::<(), Fault>(())
/// ```
pub struct Settle<R: Robot> {
    tolerance: R::Joints,
    dwell: f64,
    timeout: f64,
    near: f64,
    time: f64,
}

impl<R: Robot> Settle<R> {
    /// Within `tolerance` [rad or m] of the demand for `dwell` \[s\], which must happen within `timeout` \[s\]; all > 0.
    #[must_use]
    pub fn within(tolerance: R::Joints, dwell: f64, timeout: f64) -> Self {
        Settle { tolerance, dwell, timeout, near: 0.0, time: 0.0 }
    }
}

#[generator(ecp)]
impl<R: Robot> Settle<R> {
    fn next_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        if ![self.dwell, self.timeout].iter().all(|x| x.is_finite() && *x > 0.0) {
            return Err(Fault::thrown("dwell and timeout of a robot that settles must be finite and > 0"));
        }
        let off = e.measured().joints - e.demanded().joints;
        // The joint that is farthest off, if any is; what is not a number is.
        let off = (0..R::Joints::LEN).map(|i| (i, off[i].abs(), self.tolerance[i]));
        let far = off
            .filter(|(_, off, tolerance)| off.partial_cmp(tolerance).is_none_or(|order| order.is_gt()))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        self.near = if far.is_some() { 0.0 } else { self.near + t.dt };
        self.time += t.dt;
        // The sum of n increments may miss n * dt by rounding; that must not cost a step.
        let rounding = 1e-9 * t.dt;
        if self.near >= self.dwell - rounding {
            return Ok(Step::Done);
        }
        match far {
            Some((joint, off, tolerance)) if self.time >= self.timeout - rounding => {
                let unit = "rad or m";
                Err(Fault::new(FaultKind::TimedOut).at_joint(joint).exceeds(off, tolerance, unit))
            }
            Some(_) | None => Ok(Step::Next(Demand::hold())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::pose::Pose;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc_robots::{Irp6, Six};

    #[test]
    fn it_waits_for_the_last_joint_and_no_longer_than_told() {
        let at = |q: Six| RobotState { joints: q, velocity: Six::zeros(), pose: Pose::identity() };
        let e = |off: f64| State::<Irp6>::new(RobotImage::new(at(Six::repeat(off)), at(Six::zeros())));
        let t = Tick { step: 0, dt: 0.1, duration: 0.1 };
        let settle = || Settle::<Irp6>::within(Six::repeat(1e-3), 0.25, 1.0);
        let mut quick = settle();
        let offs = [0.1, 1e-4, 1e-2, 1e-4, 1e-4, 1e-4];
        let steps = offs.map(|off| quick.next_step(&e(off), t).expect("in time"));
        assert!(steps[..5].iter().all(|step| *step == Step::Next(Demand::hold())));
        assert_eq!(steps[5], Step::Done);
        let mut never = settle();
        let fault = (0..10).find_map(|_| never.next_step(&e(0.1), t).err()).expect("after a second");
        assert_eq!((fault.kind(), fault.excess().map(|x| x.actual)), (FaultKind::TimedOut, Some(0.1)));
    }
}
