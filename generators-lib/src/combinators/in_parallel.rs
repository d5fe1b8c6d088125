//! The motions of two robots at once.

use mrroc::generator::{Class, Generator, Level, Motion};
use mrroc::prelude::*;

use super::Joined;

/// Runs a generator of one robot and a generator of another, both written for ECPs, as one motion of the MP: they begin in the
/// same step and share its path time; the one that is done first holds until the other is, too.
///
/// For generators without orders, and of one sensor at most each: the sensors are those of the first, then those of the
/// second. Its robots have transparent ECPs.
pub struct InParallel<A, B> {
    first: A,
    second: B,
    first_is_done: bool,
    second_is_done: bool,
}

impl<A, B> InParallel<A, B> {
    /// The motion of the list's first robot, and that of its second.
    #[must_use]
    pub fn of(first: A, second: B) -> Self {
        InParallel { first, second, first_is_done: false, second_is_done: false }
    }
}

/// What a generator demands in a step: to hold from where it is done.
fn demanded<R: Robot>(step: Step<R>, done: &mut bool) -> Demand<R> {
    match step {
        Step::Next(demand) => demand,
        Step::Done => {
            *done = true;
            Demand::hold()
        }
    }
}

impl<A, B, R, S> Generator for InParallel<A, B>
where
    A: Generator<Robots = R, Language = Motion, Order = ()>,
    B: Generator<Robots = S, Language = Motion, Order = ()>,
    A::Sensors: Joined<B::Sensors>,
    R: Robot,
    S: Robot,
{
    type Robots = (R, S);
    type Language = Motion;
    type Sensors = <A::Sensors as Joined<B::Sensors>>::All;
    type Order = ();
    const CLASS: Class = {
        let a = A::CLASS;
        let b = B::CLASS;
        let mut first = a.first_uses().and(b.first_uses());
        let mut next = a.next_uses().and(b.next_uses());
        // Which of them is done is a state of the coordinator.
        first.state = true;
        next.state = true;
        Class { level: Level::Mp, first, next, until: None }
    };
    const ENDS: bool = A::ENDS && B::ENDS;

    fn first_step(
        &mut self,
        c0: &Order<()>,
        e: &State<(R, S)>,
        v: &Reading<Self::Sensors>,
        t: Tick,
    ) -> Result<Step<(R, S)>, Fault> {
        let v = A::Sensors::split(v);
        let one = demanded(self.first.first_step(c0, &State::new(e.0), &v.0, t)?, &mut self.first_is_done);
        let two = demanded(self.second.first_step(c0, &State::new(e.1), &v.1, t)?, &mut self.second_is_done);
        Ok(if self.first_is_done && self.second_is_done { Step::Done } else { Step::Next((one, two)) })
    }

    fn next_step(
        &mut self,
        c0: &Order<()>,
        e: &State<(R, S)>,
        v: &Reading<Self::Sensors>,
        t: Tick,
    ) -> Result<Step<(R, S)>, Fault> {
        let v = A::Sensors::split(v);
        let mut one = Demand::hold();
        let mut two = Demand::hold();
        if !self.first_is_done {
            one = demanded(self.first.next_step(c0, &State::new(e.0), &v.0, t)?, &mut self.first_is_done);
        }
        if !self.second_is_done {
            two = demanded(self.second.next_step(c0, &State::new(e.1), &v.1, t)?, &mut self.second_is_done);
        }
        Ok(if self.first_is_done && self.second_is_done { Step::Done } else { Step::Next((one, two)) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generators::{GuardedApproach, JointMove};
    use mrroc::pose::Wrench;

    use mrroc::robot::{RobotImage, RobotState};
    use mrroc::sensor::SensorImage;
    use mrroc_robots::{Irp6, Polycrank, Seven, Simulated, SimulatedIrp6, Six};
    use nalgebra::Vector3;
    use std::time::Duration;

    #[test]
    fn two_robots_move_at_once_and_the_longer_motion_ends_both() {
        let q6 = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
        let q7 = Seven::repeat(0.3);
        let arms = (SimulatedIrp6::new(Irp6::nominal(), &q6), Simulated::new(Polycrank::new(), &q7));
        let shafts = (arms.0.shaft(), arms.1.shaft());
        let cell = Cell::new(Duration::from_millis(2))
            .robot(RobotSetup::new("irp6", Irp6::nominal(), arms.0))
            .robot(RobotSetup::new("polycrank", Polycrank::new(), arms.1));
        let cell = cell.program(move |mp| {
            let mut one = mp.robot::<Irp6>("irp6")?;
            let mut two = mp.robot::<Polycrank>("polycrank")?;
            let short = JointMove::to(q6 + Six::repeat(0.05), Six::repeat(0.4), Six::repeat(0.8));
            let long = JointMove::to(q7 + Seven::repeat(0.2), Seven::repeat(0.4), Seven::repeat(0.8));
            mp.move_robots((&mut one, &mut two), (), InParallel::of(short, long)).map(drop)
        });
        let report = cell.run().expect("within the limits");
        // 2 sqrt(D / A) of the longer one.
        let duration = report.time.as_secs_f64();
        assert!((1.0..1.02).contains(&duration), "{duration} s");
        assert!((shafts.0.state().position - q6 - Six::repeat(0.05)).amax() < 1e-3);
        assert!((shafts.1.state().position - q7 - Seven::repeat(0.2)).amax() < 1e-3);
    }

    struct Touch;

    impl Sensor for Touch {
        const KIND: &'static str = "touch";
        type Reading = Wrench;
        type Configuration = ();
    }

    #[test]
    fn each_of_two_arms_stops_at_its_own_contact() {
        let approach = || {
            GuardedApproach::<Irp6, Touch>::along(Vector3::z_axis(), 0.05, 0.5, 1.0, |felt: &Wrench| {
                felt.force.z < -1.0
            })
        };
        let mut both = InParallel::of(approach(), approach());
        let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: Pose::identity() };
        let image = RobotImage::<Irp6>::new(state, state);
        let c0 = Order::new(());
        let e = State::new((image, image));
        let felt = |pressed: bool| {
            SensorImage::new(
                Wrench::new(-Vector3::z() * f64::from(u8::from(pressed)) * 2.0, Vector3::zeros()),
                0,
            )
        };
        // The first feels something in step 20, the second in step 50.
        for step in 0..=50 {
            let v = Reading::<(Touch, Touch)>::new((felt(step >= 20), felt(step >= 50)));
            let t = Tick { step, dt: 2e-3, duration: 2e-3 };
            let told =
                if step == 0 { both.first_step(&c0, &e, &v, t) } else { both.next_step(&c0, &e, &v, t) };
            match told.expect("no fault") {
                Step::Next((one, two)) => {
                    assert!(step < 50);
                    assert_eq!(
                        (one.as_pose().is_some(), two.as_pose().is_some()),
                        (step < 20, true),
                        "{step}"
                    );
                }
                Step::Done => assert_eq!(step, 50),
            }
        }
    }
}
