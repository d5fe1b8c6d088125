//! Moves the tool as a person at a panel orders, and records poses.

use core::marker::PhantomData;

use mrroc::prelude::*;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use mrroc_generators::teach::{Jogging, Kept, Reference, Space, Taught, TaughtFile, TaughtPose};

/// Teach-in: moves the tool in its own axes as a panel orders, within an acceleration, and records the demanded pose
/// when the panel asks for it. The motion ends at rest. The Move returns the generator, which has the recorded poses.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::Jog;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_generators::teach::Jogging;
/// use mrroc_robots::Irp6;
/// use nalgebra::Vector3;
///
/// // A panel on which a person jogs along x at 0.1 m/s for a second, lets go, and is done half a second later.
/// let mut steps = 0;
/// let panel = || {
///     steps += 1;
///     let speed = if steps <= 500 { 0.1 } else { 0.0 };
///     Jogging { along: Vector3::x() * speed, done: steps > 750, ..Jogging::default() }
/// };
/// let irp6 = Irp6::nominal();
/// let demands = rehearse(Jog::by(panel, 0.5, 1.0, 0), &irp6, Irp6::READY, 0.002)?;
/// let end = demands.last().and_then(Demand::as_pose);
/// let distance = end.map(|end| irp6.forward(&Irp6::READY).inv_mul(&end).translation.vector.norm());
/// // The ramps at 0.5 m/s² cost at the start what they give at the end.
/// assert!(distance.is_some_and(|distance| (distance - 0.1).abs() < 1e-9), "{distance:?}");
/// # Ok::<(), Fault>(())
/// ```
pub struct Jog<R, F> {
    panel: F,
    acceleration: f64,
    turning_acceleration: f64,
    pose: Pose,
    along: Vector3<f64>,
    about: Vector3<f64>,
    recorded: Vec<Pose>,
    pressed: bool,
    kept: Option<Kept>,
    of: PhantomData<R>,
}

impl<R: Robot, F: FnMut() -> Jogging> Jog<R, F> {
    /// By `panel`, asked once a step, within an `acceleration` [m/s²] and a `turning_acceleration` [rad/s²], both > 0; with
    /// memory for `most` poses.
    #[must_use]
    pub fn by(panel: F, acceleration: f64, turning_acceleration: f64, most: usize) -> Self {
        Jog {
            panel,
            acceleration,
            turning_acceleration,
            pose: Pose::identity(),
            along: Vector3::zeros(),
            about: Vector3::zeros(),
            recorded: Vec::with_capacity(most),
            pressed: false,
            kept: None,
            of: PhantomData,
        }
    }

    /// The same, which leaves every pose in `file`, too, as soon as it is recorded: a fault loses none of them.
    #[must_use]
    pub fn kept_in(self, file: &TaughtFile) -> Self {
        Jog { kept: Some(file.kept()), ..self }
    }

    /// The recorded poses, to be replayed with these shares of velocity and acceleration; `None` if not in (0, 1].
    #[must_use]
    pub fn taught(&self, velocity: f64, acceleration: f64) -> Option<Taught> {
        let poses = self.recorded.iter().map(|pose| TaughtPose::of_pose(velocity, acceleration, pose));
        let poses = poses.collect::<Option<_>>()?;
        Some(Taught { space: Space::AngleAxis, reference: Reference::Absolute, poses })
    }
}

/// `v`, changed towards `goal` by at most `most`.
fn towards(v: Vector3<f64>, goal: Vector3<f64>, most: f64) -> Vector3<f64> {
    let left = goal - v;
    if left.norm() <= most { goal } else { v + left * (most / left.norm()) }
}

#[generator(ecp)]
impl<R: Robot, F: FnMut() -> Jogging> Jog<R, F> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        if ![self.acceleration, self.turning_acceleration].iter().all(|a| a.is_finite() && *a > 0.0) {
            return Err(Fault::thrown("the accelerations of jogging must be finite and > 0"));
        }
        self.pose = e.demanded().pose;
        self.next_step(t)
    }

    fn next_step(&mut self, t: Tick) -> Result<Step<R>, Fault> {
        let Jogging { along, about, record, done } = (self.panel)();
        let (along, about) = if done { (Vector3::zeros(), Vector3::zeros()) } else { (along, about) };
        if !(along.norm_squared() + about.norm_squared()).is_finite() {
            return Err(Fault::thrown("the panel asks for a velocity that is not finite"));
        }
        self.along = towards(self.along, along, self.acceleration * t.dt);
        self.about = towards(self.about, about, self.turning_acceleration * t.dt);
        let rotation = UnitQuaternion::from_scaled_axis(self.about * t.dt);
        self.pose *= Pose::from_parts(Translation3::from(self.along * t.dt), rotation);
        self.pose.rotation.renormalize_fast();
        if !core::mem::replace(&mut self.pressed, record) && record {
            // Memory was set aside for so many: a step must not ask for more.
            let kept = self.kept.as_ref().is_none_or(|kept| kept.record(&self.pose));
            if self.recorded.len() == self.recorded.capacity() || !kept {
                return Err(Fault::thrown("there is no room to record one more pose"));
            }
            self.recorded.push(self.pose);
        }
        let at_rest = self.along == Vector3::zeros() && self.about == Vector3::zeros();
        Ok(if done && at_rest { Step::Done } else { Step::Next(Demand::pose(self.pose)) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc_robots::{Irp6, Six};

    #[test]
    fn what_is_recorded_is_where_the_closed_form_says_and_survives_its_file() {
        let start = Pose::new(Vector3::new(0.8, 0.0, 0.3), Vector3::x() * 3.0);
        let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: start };
        let e = State::<Irp6>::new(RobotImage::new(state, state));
        let t = Tick { step: 0, dt: 0.01, duration: 0.01 };
        let mut i = 0;
        let panel = || {
            i += 1;
            Jogging {
                along: Vector3::z() * 0.1,
                record: i == 1 || (100..105).contains(&i),
                done: i > 120,
                ..Default::default()
            }
        };
        let mut jog = Jog::<Irp6, _>::by(panel, 1.0, 1.0, 2);
        let mut step = jog.first_step(&e, t);
        while matches!(step, Ok(Step::Next(_))) {
            step = jog.next_step(t);
        }
        assert_eq!(step, Ok(Step::Done));
        // Ten steps up to 0.1 m/s, by 0.01 m/s each: dt sum(v) = 0.01 (0.01 .. 0.1) = 5.5 mm, then 1 mm a step; ten down.
        let taught = jog.taught(0.2, 0.1).expect("shares");
        let heights: Vec<_> = jog.recorded.iter().map(|pose| start.inv_mul(pose).translation.z).collect();
        assert_eq!(heights.len(), 2);
        assert!((heights[0] - 1e-4).abs() < 1e-12 && (heights[1] - 0.0955).abs() < 1e-12, "{heights:?}");
        let end = start.inv_mul(&jog.pose).translation.z;
        assert!((end - 0.1155 - 0.0045).abs() < 1e-12, "{end}");
        let again: Taught = taught.to_string().parse().expect("in order");
        let pose = again.poses[1].pose(again.space).expect("six coordinates");
        assert!((pose.translation.vector - jog.recorded[1].translation.vector).norm() == 0.0);
        assert!(pose.rotation.angle_to(&jog.recorded[1].rotation) < 1e-7);
    }
}
