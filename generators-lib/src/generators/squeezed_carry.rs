//! Several arms carry a rigid body along a path and keep their internal force by wrist sensors.

use core::marker::PhantomData;

use mrroc::fault::FaultKind;
use mrroc::generator::{Motion, RobotList, RobotsEach, SensorList, SensorsEach};
use mrroc::pose::Wrench;
use mrroc::prelude::*;

use mrroc_generators::cooperation::{BodyFrame, BodyPath, Correction, Grasps};
use mrroc_generators::cooperation::{InternalForce, Placed, Sharing, SqueezeLaw, central_squeeze};

/// Moves all tools of the list `L` with the body, each displaced a little, only in the direction of internal forces:
/// `X_WE_i = X_WB(t) X_BE_i X_EE'_i`. `X_EE'` is the answer of a [`SqueezeLaw`] to the internal part of the loads that
/// the sensors of the list `V`, one at each wrist, read. This does not disturb the path of the body.
///
/// A reading counts until the next one comes. These are faults: a reading that is too old, a sensor that has read
/// nothing for as long, and a correction beyond the bounds of the law. At standstill nothing is corrected.
///
/// ```
/// use mrroc::{pose::Wrench, sensor::SensorImage};
/// use mrroc::prelude::*;
/// use mrroc_generators::conformance::Given;
/// use mrroc_generators::cooperation::{BodyFrame, GraspStiffness, SqueezeBounds, SqueezeGains, SqueezeLaw, StraightBody};
/// use mrroc_generators::generators::SqueezedCarry;
/// use mrroc_generators::line::ToolLimits;
/// use mrroc_generators::profile::ProfileLimits;
/// use mrroc_generators::rehearsal::{at_rest, rehearse_all};
/// use mrroc_robots::Irp6;
/// use nalgebra::Vector3;
///
/// # struct Wrist;
/// # impl Sensor for Wrist {
/// #     const KIND: &'static str = "wrist";
/// #     type Reading = Wrench;
/// #     type Configuration = ();
/// # }
/// let stiffness = GraspStiffness { force: 2000.0, torque: 20.0 };
/// let gains = SqueezeGains { stiffness, rate: 5.0, inertia: 0.0 };
/// let bounds = SqueezeBounds { speed: 0.2, turning: 0.2, travel: 0.1, angle: 0.1 };
/// let law = SqueezeLaw::new(gains, bounds, 0.01).map_err(|bad| Fault::thrown(&bad.to_string()))?;
/// let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
/// let limits = ToolLimits { translation: limits, rotation: limits };
/// let path = StraightBody::by(Pose::translation(0.1, 0.0, 0.0), limits);
/// let arms = [0.0, 0.5].map(|y| {
///     let base = Pose::translation(0.0, y, 0.0);
///     at_rest(&Irp6::nominal().with_base(base), Irp6::READY)
/// });
/// let carry = SqueezedCarry::<[Irp6; 2], [Wrist; 2], _>::along(BodyFrame::Centroid, path, law, 0.0, 1);
/// // Both feel in every step that they are pulled apart by 20 N, along y.
/// let felt = [0, 1].map(|i| {
///     let pull = Vector3::y() * if i == 0 { 20.0 } else { -20.0 };
///     let force = arms[i].measured().pose.rotation.inverse_transform_vector(&pull);
///     SensorImage::<Wrist>::new(Wrench::new(force, Vector3::zeros()), 0)
/// });
/// let demands = rehearse_all(carry, 0.002, |_| {
///     Ok(Given { order: Order::new(()), e: State::new(arms), v: Reading::new(felt) })
/// })?;
/// // Each yields at a F / K = 0.05 m/s, so they come nearer by 0.2 mm in each of the 600 steps.
/// let y = |i: usize| demands[599][i].as_pose().map_or(0.0, |pose| pose.translation.y);
/// assert!((y(1) - y(0) - (0.5 - 600.0 * 2e-4)).abs() < 1e-9, "{}", y(1) - y(0));
/// # Ok::<(), Fault>(())
/// ```
pub struct SqueezedCarry<L: RobotList, V, P, O = Motion> {
    body: BodyFrame,
    path: P,
    law: SqueezeLaw,
    squeeze: f64,
    oldest: u32,
    unread: u32,
    starts: L::Each<Pose>,
    grasps: Grasps<L::Each<Pose>>,
    split: Option<InternalForce<L::Each<Sharing>>>,
    corrections: L::Each<Correction>,
    of: PhantomData<(V, O)>,
}

impl<L: RobotsEach<Placed, O>, V: SensorsEach<Wrench>, P: BodyPath, O: 'static> SqueezedCarry<L, V, P, O> {
    /// The body whose frame is `body` at the start along `path`, pressed together by `squeeze` \[N\] (0 for no internal
    /// force) in grasps as stiff as the law has them; readings may be `oldest` steps old.
    #[must_use]
    pub fn along(body: BodyFrame, path: P, law: SqueezeLaw, squeeze: f64, oldest: u32) -> Self {
        const { assert!(<L as RobotList>::LEN == <V as SensorList>::LEN, "one wrist sensor for each robot") };
        let starts = L::array(|_| Pose::identity());
        let corrections = L::array(|_| Correction::default());
        let grasps = Grasps::close(&Pose::identity(), starts);
        let split = None;
        let of = PhantomData;
        SqueezedCarry { body, path, law, squeeze, oldest, unread: 0, starts, grasps, split, corrections, of }
    }

    #[allow(non_snake_case)]
    fn advance(&mut self, v: &Reading<V>, t: Tick) -> Result<Step<L, O>, Fault> {
        let Some(X_WB) = self.path.advance(t.dt)? else { return Ok(Step::Done) };
        let readings = v.each::<Wrench>();
        let all_read = readings.as_ref().iter().all(Option::is_some);
        self.unread = if all_read { 0 } else { self.unread + 1 };
        let ages = readings.as_ref().iter().flatten().map(|(_, age)| *age);
        let age = ages.fold(self.unread, u32::max);
        if age > self.oldest {
            return Err(Fault::new(FaultKind::SensorStale).exceeds(age.into(), self.oldest.into(), "step"));
        }
        let mut internal = L::array(|i| readings.as_ref()[i].map_or(Wrench::default(), |(wrench, _)| wrench));
        if let Some(split) = self.split.as_ref() {
            split.keep_internal(internal.as_mut());
        }
        let mut tools = L::array(|i| self.grasps.tool(i, &X_WB));
        for (i, X_WE) in tools.as_mut().iter_mut().enumerate() {
            let excess = internal.as_ref()[i] - central_squeeze(self.grasps.poses(), i, self.squeeze);
            let dt = if all_read { t.dt } else { 0.0 };
            *X_WE *= self.law.advance(&mut self.corrections.as_mut()[i], &excess, dt)?;
        }
        Ok(Step::Next(L::each(|i| Placed { X_WEs: self.starts.as_ref()[i], X_WE: tools.as_ref()[i] })))
    }
}

#[generator(mp)]
impl<L: RobotsEach<Placed, O>, V: SensorsEach<Wrench>, P: BodyPath, O: 'static> SqueezedCarry<L, V, P, O> {
    #[allow(non_snake_case)]
    fn first_step(&mut self, e: &State<L>, v: &Reading<V>, t: Tick) -> Result<Step<L, O>, Fault> {
        self.starts = e.demanded_poses();
        let X_WB = self.body.pose(self.starts.as_ref());
        self.grasps = Grasps::close(&X_WB, self.starts);
        let share = |i| Sharing::elastic(self.grasps.poses(), i, self.law.stiffness());
        self.split = Some(InternalForce::new(L::array(share)));
        self.path.begin(&X_WB)?;
        self.advance(v, t)
    }

    fn next_step(&mut self, v: &Reading<V>, t: Tick) -> Result<Step<L, O>, Fault> {
        self.advance(v, t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc::sensor::{Sensor, SensorImage};
    use mrroc_generators::cooperation::{GraspStiffness, SqueezeBounds, SqueezeGains, TimedBody};
    use mrroc_robots::{Irp6, Six};
    use nalgebra::Vector3;

    struct Wrist;

    impl Sensor for Wrist {
        const KIND: &'static str = "wrist";
        type Reading = Wrench;
        type Configuration = ();
    }

    fn image(x: f64) -> RobotImage<Irp6> {
        let pose = Pose::translation(x, 0.0, 0.3);
        let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose };
        RobotImage::new(state, state)
    }

    #[test]
    fn arms_yield_to_a_squeeze_and_not_to_a_weight() {
        let stiffness = GraspStiffness { force: 5e4, torque: 500.0 };
        let gains = SqueezeGains { stiffness, rate: 5.0, inertia: 0.0 };
        let bounds = SqueezeBounds { speed: 0.01, turning: 0.1, travel: 1e-3, angle: 0.01 };
        let law = SqueezeLaw::new(gains, bounds, 0.01).expect("reserve");
        let rest = TimedBody::new(1.0, |_| Pose::identity());
        let mut generator =
            SqueezedCarry::<[Irp6; 2], [Wrist; 2], _>::along(BodyFrame::Centroid, rest, law, 0.0, 1);
        let load = |x| SensorImage::new(Wrench::new(Vector3::new(x, 0.0, -15.0), Vector3::zeros()), 0);
        let e = State::new([image(0.5), image(0.9)]);
        let v = Reading::<[Wrist; 2]>::new([load(-25.0), load(25.0)]);
        let t = Tick { step: 0, dt: 2e-3, duration: 2e-3 };
        let Ok(Step::Next(demands)) = generator.first_step(&e, &v, t) else { panic!("a fault or the end") };
        // F / K a T = 25 / 5e4 * 5 * 2e-3 outwards, and nothing downwards.
        for (demand, x) in demands.iter().zip([0.5 - 5e-6, 0.9 + 5e-6]) {
            assert_eq!(*demand, mrroc::generator::Demand::pose(Pose::translation(x, 0.0, 0.3)));
        }
        let old = Reading::new([SensorImage::new(Wrench::default(), 2); 2]);
        let fault = generator.next_step(&old, t).expect_err("two steps old");
        assert_eq!(fault.kind(), FaultKind::SensorStale);
    }
}
