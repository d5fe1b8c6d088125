//! A motion without a cell: what a generator demands of a robot that does exactly as it is told, for a unit test or to plot it.
//!
//! A cell also checks every demand against the limits of its robot; a rehearsal does not.
//!
//! ```
//! use mrroc::prelude::*;
//! use mrroc_generators::generators::Sleep;
//! use mrroc_generators::rehearsal::rehearse;
//! use mrroc_robots::{Irp6, Six};
//!
//! // 0.5 s are 250 steps of 2 ms.
//! let demands = rehearse(Sleep::lasting(0.5), &Irp6::nominal(), Six::zeros(), 0.002)?;
//! assert_eq!(demands, vec![Demand::hold(); 250]);
//! # Ok::<(), Fault>(())
//! ```

use mrroc::generator::{Generator, Motion, Robots};
use mrroc::prelude::*;
use mrroc::robot::{RobotImage, RobotState};

use crate::conformance::Given;

/// Steps after which a motion counts as endless.
pub const MOST: u64 = 1_000_000;

/// What is demanded of the robots of `G` in one step.
pub type Demands<G> = <<G as Generator>::Robots as Robots<<G as Generator>::Language>>::Demands;

/// The image of a robot that is demanded to be at `joints` [rad or m] and is there, at rest, without a tool.
#[must_use]
pub fn at_rest<R: Robot>(robot: &R, joints: R::Joints) -> RobotImage<R> {
    let state = RobotState { joints, velocity: joints * 0.0, pose: robot.forward(&joints) };
    RobotImage::new(state, state)
}

/// All that a generator of one robot demands from `joints` [rad or m] on, in steps of `dt` \[s\], > 0, until it is done.
///
/// # Errors
/// A [`Fault`] of the generator; one for a demanded pose that the robot cannot take; one after [`MOST`] steps.
pub fn rehearse<G, R>(generator: G, robot: &R, joints: R::Joints, dt: f64) -> Result<Vec<Demand<R>>, Fault>
where
    G: Generator<Robots = R, Language = Motion, Sensors = (), Order = ()>,
    R: Robot,
{
    rehearse_with(generator, robot, joints, dt, |_| (Order::new(()), Reading::new(())))
}

/// The same of a generator that is given an order and readings in each step, which `given` makes of the robot's image.
///
/// # Errors
/// Those of [`rehearse`].
pub fn rehearse_with<G, R>(
    generator: G,
    robot: &R,
    joints: R::Joints,
    dt: f64,
    mut given: impl FnMut(&RobotImage<R>) -> (Order<G::Order>, Reading<G::Sensors>),
) -> Result<Vec<Demand<R>>, Fault>
where
    G: Generator<Robots = R, Language = Motion>,
    R: Robot,
{
    let start = at_rest(robot, joints);
    let mut now = start;
    rehearse_all(generator, dt, |last| {
        if let Some(demand) = last {
            now = followed(robot, &start, &now, demand, dt)?;
        }
        let (order, v) = given(&now);
        Ok(Given { order, e: State::new(now), v })
    })
}

/// All that a generator of any robots demands, in steps of `dt` \[s\], > 0, until it is done. `given` says what it is given in a
/// step, from what it demanded last.
///
/// # Errors
/// A [`Fault`] of the generator or of `given`; one after [`MOST`] steps.
pub fn rehearse_all<G: Generator>(
    mut generator: G,
    dt: f64,
    mut given: impl FnMut(Option<&Demands<G>>) -> Result<Given<G>, Fault>,
) -> Result<Vec<Demands<G>>, Fault> {
    let mut demands = Vec::new();
    for step in 0..MOST {
        let t = Tick { step, dt, duration: dt };
        let Given { order, e, v } = given(demands.last())?;
        let stepped = match step {
            0 => generator.first_step(&order, &e, &v, t),
            _ => generator.next_step(&order, &e, &v, t),
        };
        match stepped? {
            Step::Next(told) => demands.push(told),
            Step::Done => return Ok(demands),
        }
    }
    Err(Fault::thrown("the motion does not end"))
}

/// The image after a demand that is followed exactly.
#[allow(non_snake_case)]
fn followed<R: Robot>(
    robot: &R,
    start: &RobotImage<R>,
    now: &RobotImage<R>,
    demand: &Demand<R>,
    dt: f64,
) -> Result<RobotImage<R>, Fault> {
    let RobotState { joints: from, pose, .. } = *now.demanded();
    let displaced = demand.as_displacement().map(|X_EsE| start.demanded().pose * X_EsE);
    let (joints, pose) = match (demand.as_joints(), demand.as_pose().or(displaced)) {
        (Some(joints), _) => (joints, robot.forward(&joints)),
        (None, Some(pose)) => {
            let joints = robot.inverse(&pose, &from);
            (joints.map_err(|cause| Fault::thrown(&cause.to_string()))?, pose)
        }
        (None, None) => (from, pose),
    };
    let state = RobotState { joints, velocity: (joints - from) * (1.0 / dt), pose };
    Ok(RobotImage::new(state, state))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generators::{JointMove, Sleep, StraightLine};
    use crate::line::ToolLimits;
    use crate::profile::ProfileLimits;
    use mrroc_robots::{Irp6, Six};

    fn start() -> Six {
        Irp6::READY
    }

    fn line(height: f64) -> StraightLine<Irp6> {
        let limits = ProfileLimits { velocity: 0.1, acceleration: 0.1 };
        let limits = ToolLimits { translation: limits, rotation: limits };
        StraightLine::by(Pose::translation(0.0, 0.0, height), limits)
    }

    #[test]
    fn a_robot_that_follows_is_where_the_generator_wants_it() {
        let irp6 = Irp6::nominal();
        let mut last = at_rest(&irp6, start());
        let given = |image: &RobotImage<Irp6>| {
            last = *image;
            (Order::new(()), Reading::new(()))
        };
        let demands = rehearse_with(line(0.1), &irp6, start(), 2e-3, given).expect("within reach");
        // D / V + V / A.
        assert_eq!(demands.len(), 1000);
        let goal = irp6.forward(&start()) * Pose::translation(0.0, 0.0, 0.1);
        let reached = last.measured();
        assert!((goal.translation.vector - reached.pose.translation.vector).norm() < 1e-12);
        assert!((irp6.forward(&reached.joints).translation.vector - goal.translation.vector).norm() < 1e-9);
        assert!(reached.velocity.amax() < 1e-3);
    }

    #[test]
    fn what_cannot_be_reached_and_what_does_not_end_are_faults() {
        let irp6 = Irp6::nominal();
        assert!(rehearse(line(9.0), &irp6, start(), 2e-3).is_err());
        assert!(rehearse(Sleep::lasting(f64::INFINITY), &irp6, start(), 2e-3).is_err());
        let nowhere = JointMove::to(start() * f64::NAN, Six::repeat(1.0), Six::repeat(1.0));
        assert!(rehearse(nowhere, &irp6, start(), 2e-3).is_err());
    }
}
