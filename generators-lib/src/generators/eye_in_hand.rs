//! Moves the tool to an object that a camera on the tool sees.

use core::marker::PhantomData;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use nalgebra::Translation3;

use mrroc_generators::line::LinePath;

/// How fast a tool follows what it sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servoing {
    /// Largest speed [m/s], > 0.
    pub speed: f64,
    /// Largest angular speed [rad/s], > 0.
    pub turning: f64,
    /// Time from rest to the largest speed \[s\], > 0.
    pub ramp: f64,
    /// Share of the remaining displacement that is covered in a second [1/s], > 0. Its product with the delay of the image must
    /// be well below 1.
    pub gain: f64,
    /// Distance at which the tool has arrived \[m\], > 0.
    pub tolerance: f64,
    /// Angle at which the tool has arrived \[rad\], > 0.
    pub angle_tolerance: f64,
    /// Age of an image that is too old \[steps\].
    pub oldest: u32,
}

/// Moves the tool to a place beside an object, by the pose of the object in the camera: `X_WG = X_WE X_EC X_CO X_OG`.
/// `X_WE` is the *measured* pose of the tool, not the demanded one, because the camera was there. While nothing is
/// seen, the tool goes on to where the object was last.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc::sensor::SensorImage;
/// use mrroc_generators::cooperation::Displacement;
/// use mrroc_generators::generators::{EyeInHand, Servoing};
/// use mrroc_generators::rehearsal::rehearse_with;
/// use mrroc_robots::Irp6;
///
/// # struct Camera;
/// # impl Sensor for Camera {
/// #     const KIND: &'static str = "camera";
/// #     type Reading = Displacement;
/// #     type Configuration = ();
/// # }
/// let irp6 = Irp6::nominal();
/// let object = irp6.forward(&Irp6::READY) * Pose::translation(0.1, 0.05, 0.1);
/// let (speed, turning, tolerance, angle_tolerance) = (0.1, 0.5, 1e-4, 1e-3);
/// let how = Servoing { speed, turning, ramp: 0.2, gain: 4.0, tolerance, angle_tolerance, oldest: 1 };
/// // The camera is at the origin of the tool.
/// let to_it = EyeInHand::<Irp6, Camera>::to(Pose::identity(), Pose::identity(), |seen| Some(seen.pose), how);
/// let demands = rehearse_with(to_it, &irp6, Irp6::READY, 0.002, |arm| {
///     let pose = arm.measured().pose.inv_mul(&object);
///     (Order::new(()), Reading::new((SensorImage::new(Displacement { pose }, 0),)))
/// })?;
/// let end = demands.last().and_then(Demand::as_pose);
/// assert!(end.is_some_and(|end| (end.translation.vector - object.translation.vector).norm() <= 1e-4));
/// # Ok::<(), Fault>(())
/// ```
#[allow(non_snake_case)]
pub struct EyeInHand<R, S: Sensor> {
    see: fn(&S::Reading) -> Option<Pose>,
    X_EC: Pose,
    X_OG: Pose,
    how: Servoing,
    pose: Pose,
    goal: Option<Pose>,
    rate: f64,
    of: PhantomData<R>,
}

impl<R: Robot, S: Sensor> EyeInHand<R, S> {
    /// To `X_OG` beside the object that `see` finds in a reading (`X_CO`), with the camera at `X_EC` on the tool.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn to(X_OG: Pose, X_EC: Pose, see: fn(&S::Reading) -> Option<Pose>, how: Servoing) -> Self {
        EyeInHand { see, X_EC, X_OG, how, pose: Pose::identity(), goal: None, rate: 0.0, of: PhantomData }
    }
}

#[generator(ecp)]
impl<R: Robot, S: Sensor> EyeInHand<R, S> {
    fn first_step(&mut self, e: &State<R>, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        let Servoing { speed, turning, ramp, gain, tolerance, angle_tolerance, .. } = self.how;
        let all = [speed, turning, ramp, gain, tolerance, angle_tolerance];
        if !all.iter().all(|x| x.is_finite() && *x > 0.0) {
            return Err(Fault::thrown(
                "speeds, ramp, gain and tolerances of visual servoing must be finite and > 0",
            ));
        }
        self.pose = e.demanded().pose;
        self.next_step(e, v, t)
    }

    fn next_step(&mut self, e: &State<R>, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        let how = self.how;
        let age = v.0.age();
        if v.0.reading().is_some() && age > how.oldest {
            return Err(Fault::new(FaultKind::SensorStale).exceeds(age.into(), how.oldest.into(), "step"));
        }
        let seen = v.0.reading().as_ref().and_then(self.see);
        self.goal = seen.map(|seen| e.measured().pose * self.X_EC * seen * self.X_OG).or(self.goal);
        let Some(goal) = self.goal else { return Ok(Step::Next(Demand::hold())) };
        if !(Translation3::from(goal.translation.vector).vector.sum() + goal.rotation.coords.sum())
            .is_finite()
        {
            return Err(Fault::thrown("the place of what the camera sees is not finite"));
        }
        let line = LinePath::new(self.pose, goal);
        if line.length() <= how.tolerance && line.angle() <= how.angle_tolerance {
            return Ok(Step::Done);
        }
        // In seconds at the largest speeds; the rate is the share of these.
        let left = (line.length() / how.speed).max(line.angle() / how.turning);
        self.rate = (self.rate + t.dt / how.ramp).min(1.0).min(how.gain * left);
        if left > 0.0 && left.is_finite() {
            self.pose = line.pose(self.rate * t.dt / left);
        }
        Ok(Step::Next(Demand::pose(self.pose)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::payload::Payload;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc::sensor::SensorImage;
    use mrroc_robots::{Irp6, Six};
    use nalgebra::Vector3;

    struct Camera;

    #[derive(Clone, Copy, Payload)]
    struct Seen {
        pose: Pose,
    }

    impl Sensor for Camera {
        const KIND: &'static str = "camera";
        type Reading = Seen;
        type Configuration = ();
    }

    #[test]
    fn the_tool_comes_to_its_place_beside_an_object_that_is_moved_during_the_motion() {
        let camera = Pose::translation(0.0, 0.05, -0.1);
        let beside = Pose::translation(0.0, 0.0, -0.02);
        let how = Servoing {
            speed: 0.2,
            turning: 1.0,
            ramp: 0.2,
            gain: 4.0,
            tolerance: 1e-4,
            angle_tolerance: 1e-3,
            oldest: 2,
        };
        let mut generator = EyeInHand::<Irp6, Camera>::to(beside, camera, |seen| Some(seen.pose), how);
        let t = Tick { step: 0, dt: 4e-3, duration: 4e-3 };
        let mut at = Pose::new(Vector3::new(0.8, 0.0, 0.4), Vector3::new(3.0, 0.1, 0.0));
        let mut object = Pose::new(Vector3::new(0.9, 0.1, 0.1), Vector3::new(3.1, 0.0, 0.4));
        let ended = (0..2000).find(|i| {
            if *i == 100 {
                object = Pose::translation(0.0, -0.05, 0.0) * object;
            }
            let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: at };
            let e = State::new(RobotImage::new(state, state));
            let pose = (at * camera).inverse() * object;
            let v = Reading::new((SensorImage::new(Seen { pose }, 0),));
            let step = if *i == 0 { generator.first_step(&e, &v, t) } else { generator.next_step(&e, &v, t) };
            let displacement = at.inv_mul(&generator.pose);
            assert!(
                displacement.translation.vector.norm() <= 0.2 * t.dt * (1.0 + 1e-9)
                    && displacement.rotation.angle() <= 1.0 * t.dt + 1e-9
            );
            at = generator.pose;
            step.expect("seen") == Step::Done
        });
        assert!(ended.is_some());
        let off = at.inv_mul(&(object * beside));
        assert!(off.translation.vector.norm() <= 1e-4 && off.rotation.angle() <= 1e-3, "{off}");
    }
}
