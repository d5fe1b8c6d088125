//! One generator until a condition holds, then another.

use mrroc::generator::{Class, Generator, Uses};
use mrroc::prelude::*;

use crate::braked::Braked;

/// Runs `A`; when the condition on the readings holds, brakes it *on its path*, by taking its path time away within a given time,
/// and then runs `B` from where it stands. If `A` is done before, so is the motion.
///
/// ```
/// use mrroc::{pose::Wrench, sensor::SensorImage};
/// use mrroc::prelude::*;
/// use mrroc_generators::combinators::Override;
/// use mrroc_generators::force::{Behaviour, Bound, ForceControl, Give};
/// use mrroc_generators::generators::{ForceLaw, GuardedApproach};
/// use mrroc_generators::rehearsal::rehearse_with;
/// use mrroc_robots::Irp6;
/// use nalgebra::Vector3;
///
/// # struct Wrist;
/// # impl Sensor for Wrist {
/// #     const KIND: &'static str = "wrist";
/// #     type Reading = Wrench;
/// #     type Configuration = ();
/// # }
/// // Along z until something is felt, braked within 0.1 s; then the tool presses with 10 N.
/// let along = GuardedApproach::<Irp6, Wrist>::along(-Vector3::z_axis(), 0.05, 0.25, 0.2, |_| false);
/// let felt = |v: &Reading<(Wrist,)>| v.0.reading().is_some_and(|felt| felt.force.norm() > 1.0);
/// let mut axes = [Behaviour::Unguarded { velocity: 0.0 }; 6];
/// axes[2] = Behaviour::Contact { load: 10.0, give: Give::FORCE, within: Bound { speed: 0.1, travel: 0.05 } };
/// let law = ForceControl::new(axes).map_err(|bad| Fault::thrown(&bad.to_string()))?;
/// let motion = Override::of(along, felt, 0.1, ForceLaw::lasting(law, 3.0, 1));
/// let irp6 = Irp6::nominal();
/// // A spring of 2 N/mm, 2 cm below the tool.
/// let table = irp6.forward(&Irp6::READY).translation.z - 0.02;
/// let force = |pose: Pose| 2000.0 * (table - pose.translation.z).max(0.0);
/// let demands = rehearse_with(motion, &irp6, Irp6::READY, 0.002, |arm| {
///     let pose = arm.measured().pose;
///     let push = pose.rotation.inverse_transform_vector(&(Vector3::z() * force(pose)));
///     (Order::new(()), Reading::new((SensorImage::new(Wrench::new(push, Vector3::zeros()), 0),)))
/// })?;
/// let end = demands.last().and_then(Demand::as_pose).map(force);
/// assert!(end.is_some_and(|end| (end - 10.0).abs() < 0.01), "{end:?}");
/// # Ok::<(), Fault>(())
/// ```
pub struct Override<A: Generator, B> {
    usual: A,
    other: B,
    when: fn(&Reading<A::Sensors>) -> bool,
    braking: f64,
    stage: Stage,
}

#[derive(Clone, Copy, PartialEq)]
enum Stage {
    Usual,
    Braking(Braked),
    Other,
}

impl<A, B> Override<A, B>
where
    A: Generator,
    B: Generator<Robots = A::Robots, Language = A::Language, Sensors = A::Sensors, Order = A::Order>,
{
    /// `usual` until `when` holds, then braked within `braking` \[s\], > 0, then `other`. At a speed `v` that is a deceleration of
    /// `1.5 v / braking` and a jerk of `4.5 v / braking²` at most, besides what the path itself takes.
    #[must_use]
    pub fn of(usual: A, when: fn(&Reading<A::Sensors>) -> bool, braking: f64, other: B) -> Self {
        const { assert!(A::CLASS.level as u8 == B::CLASS.level as u8, "both of an MP, or both of an ECP") };
        Override { usual, other, when, braking, stage: Stage::Usual }
    }
}

impl<A, B> Generator for Override<A, B>
where
    A: Generator,
    B: Generator<Robots = A::Robots, Language = A::Language, Sensors = A::Sensors, Order = A::Order>,
{
    type Robots = A::Robots;
    type Language = A::Language;
    type Sensors = A::Sensors;
    type Order = A::Order;
    const CLASS: Class = {
        let a = A::CLASS;
        let b = B::CLASS;
        let own = Uses { sensors: true, state: true, tick: true, ..Uses::NOTHING };
        let next = a.next_uses().and(b.first_uses()).and(b.next_uses()).and(own);
        Class { level: a.level, first: a.first_uses(), next, until: None }
    };
    const ENDS: bool = A::ENDS || B::ENDS;

    fn first_step(
        &mut self,
        c0: &Order<A::Order>,
        e: &State<A::Robots>,
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<A::Robots, A::Language>, Fault> {
        if !Braked::is_possible(self.braking) {
            return Err(Fault::thrown("the time in which a motion is braked must be finite and > 0"));
        }
        self.usual.first_step(c0, e, v, t)
    }

    fn next_step(
        &mut self,
        c0: &Order<A::Order>,
        e: &State<A::Robots>,
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<A::Robots, A::Language>, Fault> {
        if self.stage == Stage::Usual && (self.when)(v) {
            self.stage = Stage::Braking(Braked::within(self.braking));
        }
        let share = match &mut self.stage {
            Stage::Usual => 1.0,
            Stage::Braking(braked) if !braked.stands() => braked.share(t.dt),
            Stage::Braking(_) => {
                self.stage = Stage::Other;
                return self.other.first_step(c0, e, v, t);
            }
            Stage::Other => return self.other.next_step(c0, e, v, t),
        };
        self.usual.next_step(c0, e, v, Tick { dt: t.dt * share, ..t })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cooperation::Displacement;
    use crate::generators::{EyeInHand, GuardedApproach, Servoing};

    use mrroc::robot::{RobotImage, RobotState};
    use mrroc::sensor::SensorImage;
    use mrroc_robots::{Irp6, Six};
    use nalgebra::Vector3;

    struct Eye;

    impl Sensor for Eye {
        const KIND: &'static str = "eye";
        type Reading = Displacement;
        type Configuration = ();
    }

    #[test]
    fn a_search_is_braked_where_something_is_seen_and_the_tool_goes_there() {
        // It looks for something along x, and sees it from 0.1 m away on.
        let search = GuardedApproach::<Irp6, Eye>::along(Vector3::x_axis(), 0.1, 0.5, 2.0, |_| false);
        let how = Servoing {
            speed: 0.1,
            turning: 1.0,
            ramp: 0.2,
            gain: 4.0,
            tolerance: 1e-4,
            angle_tolerance: 1e-3,
            oldest: 1,
        };
        let grasp =
            EyeInHand::<Irp6, Eye>::to(Pose::identity(), Pose::identity(), |seen| Some(seen.pose), how);
        let near = |v: &Reading<(Eye,)>| v.0.reading().is_some_and(|seen| seen.pose.translation.x < 0.1);
        let mut generator = Override::of(search, near, 0.2, grasp);
        assert_eq!(
            <Override<GuardedApproach<Irp6, Eye>, EyeInHand<Irp6, Eye>>>::CLASS.to_string(),
            "ECP f*3(c, e, v)"
        );
        let object = Pose::translation(0.3, 0.02, 0.0);
        let dt = 2e-3;
        let mut at = Pose::identity();
        let mut p = vec![Vector3::zeros(); 2];
        for i in 0..4000 {
            let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: at };
            let e = State::new(RobotImage::new(state, state));
            let pose = at.inverse() * object;
            let v = Reading::new((SensorImage::new(Displacement { pose }, 0),));
            let c0 = Order::new(());
            let t = Tick { step: i, dt, duration: dt };
            let step = if i == 0 {
                generator.first_step(&c0, &e, &v, t)
            } else {
                generator.next_step(&c0, &e, &v, t)
            };
            let Step::Next(demand) = step.expect("it is there") else { break };
            at = demand.as_pose().expect("a pose");
            p.push(at.translation.vector);
        }
        assert!((at.translation.vector - object.translation.vector).norm() < 1e-4, "{at}");
        // It speeds up within 0.2 s, is braked within 0.2 s from 0.1 m/s, and speeds up within 0.2 s again: 0.5 m/s², and 0.75 m/s²
        // where it is braked. Only the last approach, by its gain, slows down at v gain = 0.4 m/s².
        for w in p.windows(3) {
            assert!((w[2] - 2.0 * w[1] + w[0]).norm() / (dt * dt) < 0.76, "{w:?}");
        }
        assert!(generator.stage == Stage::Other);
    }
}
