//! Moves all joints to a target that the coordinator may change in every step.

use mrroc::prelude::*;
use mrroc::robot::{JointVector, MAX_JOINTS};

use mrroc_generators::jerk::{JointLimits, JointState, JointTarget, MoveCursor, SynchronisedMove};

/// Where the joints are to go: an order of tight cooperation.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct JointOrder {
    /// Positions [rad or m]; those beyond the robot's joints do not count.
    pub joints: [f64; MAX_JOINTS],
}

/// Moves all joints to the target ordered, in the shortest time within limits of velocity, acceleration and jerk.
///
/// A new target is taken up in the step in which it comes, from the state of motion reached, without a step in velocity
/// or acceleration (Kröger's on-line trajectory generation). At the target it holds; it ends when the MP ends.
///
/// ```
/// use mrroc::{generator::Generator, robot::MAX_JOINTS};
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::{JointOrder, ReachState};
/// use mrroc_generators::jerk::JointLimits;
/// use mrroc_generators::rehearsal::at_rest;
/// use mrroc_robots::{Irp6, Six};
///
/// let limits = JointLimits { velocity: Six::repeat(0.5), acceleration: Six::repeat(1.0), jerk: Six::repeat(10.0) };
/// let mut reach = ReachState::<Irp6>::within(limits);
/// // The coordinator wants the first joint 0.5 rad on.
/// let mut joints = [0.0; MAX_JOINTS];
/// joints[..6].copy_from_slice((Irp6::READY + Six::x() * 0.5).as_slice());
/// let (order, e) = (Order::new(JointOrder { joints }), State::new(at_rest(&Irp6::nominal(), Irp6::READY)));
/// let (v, t) = (Reading::new(()), Tick { step: 0, dt: 0.002, duration: 0.002 });
/// let mut step = reach.first_step(&order, &e, &v, t)?;
/// for _ in 1..800 {
///     step = reach.next_step(&order, &e, &v, t)?;
/// }
/// // D / V + V / A + A / J = 1.6 s are 800 steps of 2 ms.
/// let Step::Next(demand) = step else { unreachable!() };
/// assert!(demand.as_joints().is_some_and(|q| (q[0] - Irp6::READY[0] - 0.5).abs() < 1e-9));
/// # Ok::<(), Fault>(())
/// ```
pub struct ReachState<R: Robot> {
    limits: JointLimits<R::Joints>,
    motion: Option<MoveCursor<R::Joints>>,
}

impl<R: Robot> ReachState<R> {
    /// Within `limits`. Leave a tenth of the robot's limits to the operator's feed rate.
    #[must_use]
    pub fn within(limits: JointLimits<R::Joints>) -> Self {
        ReachState { limits, motion: None }
    }
}

fn target<J: JointVector>(order: &Order<JointOrder>) -> JointTarget<J> {
    JointTarget::rest(J::from_joints(|i| order.value().joints[i]))
}

#[generator(ecp)]
impl<R: Robot> ReachState<R> {
    fn first_step(&mut self, order: &Order<JointOrder>, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let start = JointState::rest(e.demanded().joints);
        let motion = SynchronisedMove::new(&start, &target(order), &self.limits);
        self.motion = Some(MoveCursor::new(motion.map_err(|error| Fault::thrown(&error.to_string()))?));
        self.next_step(order, t)
    }

    fn next_step(&mut self, order: &Order<JointOrder>, t: Tick) -> Result<Step<R>, Fault> {
        let Some(motion) = &mut self.motion else { return Ok(Step::Next(Demand::hold())) };
        let turned = motion.turn_to(&target(order), &self.limits);
        turned.map_err(|error| Fault::thrown(&error.to_string()))?;
        let point = motion.advance(t.dt).unwrap_or_else(|| motion.here());
        Ok(Step::Next(Demand::joints(point.position)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc_robots::{Irp6, Six};

    fn order(joints: Six) -> Order<JointOrder> {
        let mut all = [0.0; MAX_JOINTS];
        all[..6].copy_from_slice(joints.as_slice());
        Order::new(JointOrder { joints: all })
    }

    #[test]
    fn a_target_that_moves_in_every_step_is_pursued_within_the_limits_and_caught() {
        const DT: f64 = 1e-3;
        let robot = Irp6::nominal();
        let start = Irp6::READY;
        let velocity = 0.5;
        let acceleration = 2.0;
        let jerk = 20.0;
        let limits = JointLimits {
            velocity: Six::repeat(velocity),
            acceleration: Six::repeat(acceleration),
            jerk: Six::repeat(jerk),
        };
        let state = RobotState { joints: start, velocity: Six::zeros(), pose: robot.forward(&start) };
        let tick = |step| Tick { step, dt: DT, duration: DT };
        let goal = |i: u64| {
            let phase = 0.002 * i.min(2000) as f64;
            start + Six::new(phase.sin(), 0.3 * phase, 0.0, -0.1, phase.cos(), 0.2) * 0.5
        };
        let mut reach = ReachState::<Irp6>::within(limits);
        let image = State::new(RobotImage::new(state, state));
        let mut trace = vec![start, start, start];
        for i in 0..6000 {
            let step = match i {
                0 => reach.first_step(&order(goal(0)), &image, tick(0)),
                _ => reach.next_step(&order(goal(i)), tick(i)),
            };
            let here = reach.motion.as_ref().expect("made in the first step").here().position;
            assert_eq!(step.expect("a plan"), Step::Next(Demand::joints(here)));
            trace.push(here);
        }
        for q in trace.windows(4) {
            let v0 = (q[1] - q[0]) / DT;
            let v1 = (q[2] - q[1]) / DT;
            let v2 = (q[3] - q[2]) / DT;
            let a0 = (v1 - v0) / DT;
            let a1 = (v2 - v1) / DT;
            assert!(v2.amax() < velocity + 1e-9 && a1.amax() < acceleration + 1e-6, "{v2} {a1}");
            assert!(((a1 - a0) / DT).amax() < jerk + 2e-3, "{}", (a1 - a0) / DT);
        }
        assert_eq!(trace[trace.len() - 1], goal(9999));
    }
}
