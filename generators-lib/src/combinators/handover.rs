//! One generator after another, while the robot moves.

use mrroc::generator::{Class, Generator, Motion};
use mrroc::prelude::*;
use mrroc_generators::between::displacement;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// Runs `A` to its end, then `B`, which begins at rest, and lets the velocity that `A` ends with fade on top of what `B`
/// demands: neither the demand nor its velocity has a step. With `x` the share of the fading time that has passed and `v` the
/// velocity left by `A`,
///
/// ```text
/// d(x) = v T (x - 6 x^3 + 8 x^4 - 3 x^5)        d'(0) = v, all else is 0 at both ends
/// ```
///
/// is added: joints to joints, or a displacement along and about the world's axes to poses. It leads off the path by `0.2 v T` at
/// most and takes accelerations of `3.95 v / T`. If `B` ends sooner, its last demand stands until the velocity has faded.
/// [`Sequence`](super::Sequence) is for what ends at rest.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::combinators::Handover;
/// use mrroc_generators::cooperation::Functional;
/// use mrroc_generators::generators::{MovingFrame, StraightLine};
/// use mrroc_generators::line::ToolLimits;
/// use mrroc_generators::profile::ProfileLimits;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
///
/// let irp6 = Irp6::nominal();
/// let from = irp6.forward(&Irp6::READY);
/// // Onto a belt of 0.1 m/s within 0.5 s, 0.2 s with it, and to a pose beside it.
/// let belt = move |age: f64| Pose::translation(0.0, 0.1 * age, 0.0) * from;
/// let onto = MovingFrame::to(Functional::new(belt), Pose::identity(), 0.5, 0.7);
/// let limits = ProfileLimits { velocity: 0.2, acceleration: 0.5 };
/// let goal = belt(0.7) * Pose::translation(0.0, 0.0, -0.05);
/// let off = StraightLine::to(goal, ToolLimits { translation: limits, rotation: limits });
/// let demands = rehearse(Handover::of(onto, off, 0.4), &irp6, Irp6::READY, 0.002)?;
/// // No acceleration is above 3.95 v / T of the fading velocity of the belt, and 0.5 m/s² of the line.
/// let p: Vec<_> = demands.iter().filter_map(Demand::as_pose).map(|pose| pose.translation.vector).collect();
/// let fastest = p[340..].windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).norm() / 4e-6).fold(0.0, f64::max);
/// assert!(fastest < 3.95 * 0.1 / 0.4 + 0.5, "{fastest}");
/// assert!((p[p.len() - 1] - goal.translation.vector).norm() < 1e-12);
/// # Ok::<(), Fault>(())
/// ```
pub struct Handover<A: Generator, B, R: Robot> {
    first: A,
    second: B,
    fading: f64,
    stage: Stage<R>,
}

enum Stage<R: Robot> {
    /// The first generator runs.
    First {
        /// Its last demand.
        last: Option<Demand<R>>,
        /// The velocity between its last two demands.
        velocity: Option<Velocity<R::Joints>>,
    },
    /// The second one runs, or is done.
    Second {
        /// Path time since it began \[s\].
        time: f64,
        /// The velocity that is fading, until it has.
        fading: Option<Velocity<R::Joints>>,
        /// Its last demand.
        last: Option<Demand<R>>,
        done: bool,
    },
}

#[derive(Clone, Copy)]
enum Velocity<J> {
    Joints(J),
    /// Of the tool's origin [m/s] and angular [rad/s], along the world's axes.
    Tool(Vector3<f64>, Vector3<f64>),
}

impl<A, B, R> Handover<A, B, R>
where
    A: Generator<Robots = R, Language = Motion>,
    B: Generator<Robots = R, Language = Motion, Sensors = A::Sensors, Order = A::Order>,
    R: Robot,
{
    /// `first`, then `second`, with the velocity between them fading within `fading` \[s\], finite, > 0.
    #[must_use]
    pub fn of(first: A, second: B, fading: f64) -> Self {
        const { assert!(A::CLASS.level as u8 == B::CLASS.level as u8, "both of an MP, or both of an ECP") };
        const { assert!(A::ENDS, "the first must end by itself") };
        Handover { first, second, fading, stage: Stage::First { last: None, velocity: None } }
    }
}

/// The velocity between two demands in the same coordinates, `dt` \[s\] > 0 apart.
fn velocity_between<R: Robot>(from: &Demand<R>, to: &Demand<R>, dt: f64) -> Option<Velocity<R::Joints>> {
    if let (Some(p), Some(q)) = (from.as_joints(), to.as_joints()) {
        return Some(Velocity::Joints((q - p) * (1.0 / dt)));
    }
    let [along, about] = displacement(&from.as_pose()?, &to.as_pose()?);
    Some(Velocity::Tool(along / dt, about / dt))
}

/// A demand moved on by a velocity for `time` \[s\].
fn moved<R: Robot>(demand: Demand<R>, velocity: Velocity<R::Joints>, time: f64) -> Result<Demand<R>, Fault> {
    let refused = || Fault::thrown("a moving hand-over needs joint demands on both sides, or poses");
    match velocity {
        Velocity::Joints(v) => Ok(Demand::joints(demand.as_joints().ok_or_else(refused)? + v * time)),
        Velocity::Tool(v, w) => {
            let pose = demand.as_pose().ok_or_else(refused)?;
            let position = Translation3::from(pose.translation.vector + v * time);
            let rotation = UnitQuaternion::from_scaled_axis(w * time) * pose.rotation;
            Ok(Demand::pose(Pose::from_parts(position, rotation)))
        }
    }
}

impl<A, B, R> Handover<A, B, R>
where
    A: Generator<Robots = R, Language = Motion>,
    B: Generator<Robots = R, Language = Motion, Sensors = A::Sensors, Order = A::Order>,
    R: Robot,
{
    /// What the second demands, with what is left of the first's velocity.
    fn faded(&mut self, step: Step<R>, t: Tick) -> Result<Step<R>, Fault> {
        let Stage::Second { time, fading, last, done } = &mut self.stage else { return Ok(step) };
        *time += t.dt;
        let x = *time / self.fading;
        let demand = match step {
            Step::Next(demand) => demand,
            Step::Done => {
                *done = true;
                match (*last, *fading) {
                    (Some(last), Some(_)) if x < 1.0 => last,
                    _ => return Ok(Step::Done),
                }
            }
        };
        *last = Some(demand);
        let Some(velocity) = *fading else { return Ok(Step::Next(demand)) };
        if x >= 1.0 {
            *fading = None;
            return Ok(Step::Next(demand));
        }
        let share = x - x * x * x * (6.0 - x * (8.0 - 3.0 * x));
        moved(demand, velocity, self.fading * share).map(Step::Next)
    }

    /// The first's demand, or the second's first step where the first is done.
    fn lead(
        &mut self,
        step: Step<R>,
        c0: &Order<A::Order>,
        e: &State<R>,
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        let Stage::First { last, velocity } = &mut self.stage else { return Ok(step) };
        if let Step::Next(demand) = step {
            if let (Some(last), true) = (*last, t.dt > 0.0) {
                *velocity = velocity_between(&last, &demand, t.dt);
            }
            *last = Some(demand);
            return Ok(step);
        }
        if !(self.fading.is_finite() && self.fading > 0.0) {
            return Err(Fault::thrown("the time in which a velocity fades must be finite and > 0"));
        }
        self.stage = Stage::Second { time: 0.0, fading: *velocity, last: None, done: false };
        let step = self.second.first_step(c0, e, v, t)?;
        self.faded(step, t)
    }
}

impl<A, B, R> Generator for Handover<A, B, R>
where
    A: Generator<Robots = R, Language = Motion>,
    B: Generator<Robots = R, Language = Motion, Sensors = A::Sensors, Order = A::Order>,
    R: Robot,
{
    type Robots = R;
    type Language = Motion;
    type Sensors = A::Sensors;
    type Order = A::Order;
    const CLASS: Class = {
        let a = A::CLASS;
        let b = B::CLASS;
        // The second may begin in any step, even in the first one.
        let mut next = a.next_uses().and(b.first_uses()).and(b.next_uses());
        next.state = true;
        next.tick = true;
        Class { level: a.level, first: a.first_uses().and(next), next, until: None }
    };
    const ENDS: bool = B::ENDS;

    fn first_step(
        &mut self,
        c0: &Order<A::Order>,
        e: &State<R>,
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        let step = self.first.first_step(c0, e, v, t)?;
        self.lead(step, c0, e, v, t)
    }

    fn next_step(
        &mut self,
        c0: &Order<A::Order>,
        e: &State<R>,
        v: &Reading<A::Sensors>,
        t: Tick,
    ) -> Result<Step<R>, Fault> {
        match self.stage {
            Stage::First { .. } => {
                let step = self.first.next_step(c0, e, v, t)?;
                self.lead(step, c0, e, v, t)
            }
            Stage::Second { done, .. } => {
                let step = if done { Step::Done } else { self.second.next_step(c0, e, v, t)? };
                self.faded(step, t)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cooperation::Functional;
    use crate::generators::{MovingFrame, StraightLine};
    use crate::line::ToolLimits;
    use crate::profile::ProfileLimits;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc_robots::{Irp6, Six};

    /// Positions demanded at each step, with exact drives.
    fn run<G>(mut generator: G, start: Pose, dt: impl Fn(u64) -> f64) -> Vec<Vector3<f64>>
    where
        G: Generator<Robots = Irp6, Language = Motion, Sensors = (), Order = ()>,
    {
        let mut pose = start;
        let mut trace = vec![start.translation.vector];
        for step in 0..5000 {
            let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose };
            let c0 = Order::new(());
            let e = State::new(RobotImage::new(state, state));
            let v = Reading::new(());
            let t = Tick { step, dt: dt(step), duration: 2e-3 };
            let stepped = if step == 0 {
                generator.first_step(&c0, &e, &v, t)
            } else {
                generator.next_step(&c0, &e, &v, t)
            };
            let Step::Next(demand) = stepped.expect("in range") else { return trace };
            pose = demand.as_pose().expect("a pose");
            trace.push(pose.translation.vector);
        }
        panic!("it does not end");
    }

    /// Onto a belt of 0.1 m/s, then straight up: the belt's velocity must not end at once.
    fn picking(
        up: f64,
    ) -> Handover<MovingFrame<Irp6, impl crate::cooperation::Transform>, StraightLine<Irp6>, Irp6> {
        let belt = Functional::new(|age| Pose::translation(0.1 * age, 0.0, 0.0));
        let limits = ProfileLimits { velocity: 0.2, acceleration: 0.5 };
        let limits = ToolLimits { translation: limits, rotation: limits };
        Handover::of(
            MovingFrame::to(belt, Pose::translation(0.0, 0.05, 0.0), 0.6, 0.8),
            StraightLine::to(Pose::translation(0.1, 0.05, up), limits),
            0.4,
        )
    }

    #[test]
    fn the_velocity_goes_on_and_the_second_still_ends_where_it_should() {
        for up in [0.2, 0.001, 0.0] {
            let trace = run(picking(up), Pose::identity(), |_| 2e-3);
            let end = trace[trace.len() - 1];
            assert!((end - Vector3::new(0.1, 0.05, up)).norm() < 1e-12, "{end}");
            // From 0.8 s on: 3.95 v / T of the fading, and 0.5 m/s² of the line.
            for w in trace[395..].windows(3) {
                let a = (w[2] - w[1] * 2.0 + w[0]) / 4e-6;
                assert!(a.x.abs() <= 3.95 * 0.1 / 0.4 + 0.5 && a.norm() < 2.0, "{a}");
            }
            // Astray by a fifth of v T along the belt.
            let farthest = trace.iter().map(|p| p.x).fold(0.0, f64::max);
            assert!(farthest <= 0.1 + 0.02, "{farthest}");
        }
    }

    #[test]
    fn a_suspension_at_the_hand_over_changes_nothing_of_the_end() {
        let free = run(picking(0.2), Pose::identity(), |_| 2e-3);
        for at in 395..410 {
            let trace =
                run(picking(0.2), Pose::identity(), |i| if (at..at + 7).contains(&i) { 0.0 } else { 2e-3 });
            assert!((trace[trace.len() - 1] - free[free.len() - 1]).norm() < 1e-12);
            assert!(trace.windows(2).all(|w| (w[1] - w[0]).norm() < 5e-4));
        }
    }

    #[test]
    fn joints_go_on_at_their_velocity() {
        let [from, to] = [0.0, 1e-3].map(|q| Demand::<Irp6>::joints(Six::repeat(q)));
        let left = velocity_between(&from, &to, 2e-3).expect("both are joints");
        let moved = moved(to, left, 0.1).expect("joints").as_joints().expect("joints");
        assert!((moved - Six::repeat(1e-3 + 0.5 * 0.1)).amax() < 1e-15, "{moved}");
    }

    #[test]
    fn what_begins_in_other_coordinates_is_refused() {
        let joints = Demand::<Irp6>::joints(Six::zeros());
        let pose = Demand::<Irp6>::pose(Pose::identity());
        let still = Velocity::Tool(Vector3::zeros(), Vector3::zeros());
        assert!(
            moved(joints, still, 0.1).is_err() && moved(pose, Velocity::Joints(Six::zeros()), 0.1).is_err()
        );
    }
}
