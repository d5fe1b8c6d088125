//! One generator until a condition holds, then another.

use mrroc::generator::{Class, Generator, Uses};
use mrroc::prelude::*;

/// Runs `A`; when the condition on the readings holds, brakes it *on its path*, by taking its path time away within a given time,
/// and then runs `B` from where it stands. If `A` is done before, so is the motion.
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
    /// The share of path time that the first still gets.
    Braking(f64),
    Other,
}

impl<A, B> Override<A, B>
where
    A: Generator,
    B: Generator<Robots = A::Robots, Language = A::Language, Sensors = A::Sensors, Order = A::Order>,
{
    /// `usual` until `when` holds, then braked within `braking` \[s\], > 0, then `other`. At a speed `v` that is a deceleration of
    /// `v / braking`.
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
        if !(self.braking.is_finite() && self.braking > 0.0) {
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
            self.stage = Stage::Braking(1.0);
        }
        let share = match self.stage {
            Stage::Usual => 1.0,
            Stage::Braking(share) if share > 0.0 => {
                let left = (share - t.dt / self.braking).max(0.0);
                self.stage = Stage::Braking(left);
                left
            }
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
        // It speeds up within 0.2 s, is braked within 0.2 s from 0.1 m/s, and speeds up within 0.2 s again: 0.5 m/s^2. Only the
        // last approach, by its gain, slows down at v gain = 0.4 m/s^2.
        for w in p.windows(3) {
            assert!((w[2] - 2.0 * w[1] + w[0]).norm() / (dt * dt) < 0.51, "{w:?}");
        }
        assert!(generator.stage == Stage::Other);
    }
}
