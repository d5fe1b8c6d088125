//! What an acceptor takes and refuses, state by state. Expected values are the equations of SAFETY.md and of the docs here.

use nalgebra::{SVector, Vector3};

use crate::model::excess::Excess;
use crate::model::robot::{CoupledLimit, Limits, NoInverse};

use super::*;

mod bounds;
mod goals;
mod late;
mod out_of_step;
mod rates;
mod words;

type Two = SVector<f64, 2>;

const T: f64 = 1e-3;
/// `(L + 1) Ts` at 1 ms.
const REACTION: f64 = 0.021;

/// A slide along x and a turn about z on it: `X_WF = Trans(q1, 0, 0) Rot(z, q2)`.
#[derive(Clone, Debug)]
struct Turntable {
    limits: Limits<Two>,
    /// What `inverse` gives too much of x \[m\].
    off: f64,
    no_inverse: Option<NoInverse>,
    singular: Option<&'static str>,
    /// Largest q1 + q2.
    sum: f64,
}

impl Turntable {
    fn new() -> Turntable {
        let limits = Limits {
            lower: Two::repeat(-1.0),
            upper: Two::repeat(1.0),
            velocity: Two::repeat(1.0),
            acceleration: Two::new(10.0, 20.0),
            jerk: None,
        };
        Turntable { limits, off: 0.0, no_inverse: None, singular: None, sum: 9.0 }
    }

    fn with(change: impl FnOnce(&mut Limits<Two>)) -> Turntable {
        let mut robot = Turntable::new();
        change(&mut robot.limits);
        robot
    }

    fn with_jerk(first: f64, second: f64) -> Turntable {
        Turntable::with(|limits| limits.jerk = Some(Two::new(first, second)))
    }
}

impl Robot for Turntable {
    const KIND: &'static str = "turntable";
    type Joints = Two;

    fn joint(&self, i: usize) -> crate::model::robot::JointKind {
        [crate::model::robot::JointKind::Prismatic, crate::model::robot::JointKind::Revolute][i]
    }

    fn limits(&self) -> &Limits<Two> {
        &self.limits
    }

    fn check_coupled(&self, _: &Two, to: &Two, duration: f64) -> Result<(), CoupledLimit> {
        assert!(duration > 0.0, "a displacement in no time");
        let sum = to[0] + to[1];
        if sum > self.sum {
            return Err(CoupledLimit { joint: 1, what: "sum", excess: Excess::new(sum, self.sum, "") });
        }
        Ok(())
    }

    fn near_singularity(&self, _: &Two) -> Option<&'static str> {
        self.singular
    }

    fn forward(&self, q: &Two) -> Pose {
        Pose::new(Vector3::new(q[0], 0.0, 0.0), Vector3::new(0.0, 0.0, q[1]))
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, _: &Two) -> Result<Two, NoInverse> {
        match self.no_inverse {
            Some(error) => Err(error),
            None => Ok(Two::new(X_WF.translation.x + self.off, X_WF.rotation.scaled_axis().z)),
        }
    }

    #[allow(non_snake_case)]
    fn inverse_at(&self, X_WF: &Pose, redundancy: f64, near: &Two) -> Result<Two, NoInverse> {
        Ok(self.inverse(X_WF, near)? + Two::new(redundancy, 0.0))
    }
}

/// At rest at the origin, with a tool 0.1 m off the axis of the turn and 0.2 m above.
fn acceptor(robot: Turntable) -> Acceptor<Turntable> {
    Acceptor::new(robot, Pose::translation(0.1, 0.0, 0.2), Two::zeros(), REACTION)
}

fn joints(first: f64, second: f64) -> Demand<Turntable> {
    Demand::joints(Two::new(first, second))
}

#[track_caller]
fn near(actual: f64, expected: f64) {
    assert!((actual - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{actual}, expected {expected}");
}

#[track_caller]
fn both(actual: &Two, expected: [f64; 2]) {
    near(actual[0], expected[0]);
    near(actual[1], expected[1]);
}

#[test]
fn an_accepted_demand_is_the_next_state() {
    let mut acceptor = acceptor(Turntable::new());
    assert!(acceptor.is_at_rest());
    acceptor.begin();
    let accepted = acceptor.accept(&joints(4e-6, -6e-6), 0.5 * T, T).expect("slow");
    both(accepted.joints(), [4e-6, -6e-6]);
    both(&acceptor.state.velocity, [4e-3, -6e-3]);
    both(&acceptor.state.acceleration, [4.0, -6.0]);
    // At half the rate a path has twice this speed as planned.
    both(&acceptor.pace.path_speed, [8e-3, 12e-3]);
    assert!(
        (acceptor.pace.rate, acceptor.pace.period, acceptor.pace.bridged) == (0.5, T, 0.0)
            && !acceptor.is_at_rest()
    );
    // The second difference is the acceleration: 1e-6 m more in 1 ms than in the step before.
    acceptor.accept(&joints(9e-6, -6e-6), T, T).expect("slow");
    both(&acceptor.state.velocity, [5e-3, 0.0]);
    both(&acceptor.state.acceleration, [1.0, 6.0]);
    // A robot that is suspended is to be resumed into the speed that it had: the quotient of two zeros is none.
    acceptor.accept(&joints(9e-6, -6e-6), 0.0, T).expect("stands");
    both(&acceptor.pace.path_speed, [5e-3, 0.0]);
}

#[test]
fn the_path_velocity_after_lost_demands_is_the_mean_of_all_their_steps() {
    let mut acceptor = acceptor(Turntable::new());
    acceptor.accept(&joints(5e-6, 0.0), T, T).expect("slow");
    acceptor.extrapolate(T);
    acceptor.extrapolate(T);
    both(&acceptor.state.position, [15e-6, 0.0]);
    near(acceptor.track.path.missing, 2.0 * T);
    // 8 mm/s for three steps, at 5 mm/s for two of which it went on: 14 mm/s now.
    acceptor.accept(&joints(29e-6, 0.0), T, T).expect("slow");
    near(acceptor.track.path.velocity[0], 8e-3);
    near(acceptor.state.velocity[0], 14e-3);
    near(acceptor.pace.bridged, 2.0);
    assert_eq!(acceptor.track.path.missing, 0.0);
    // Back to the path's velocity at once, which is what its acceleration is.
    acceptor.extrapolate(T);
    near(acceptor.state.velocity[0], 8e-3);
    near(acceptor.state.acceleration[0], -6.0);
    near(acceptor.state.position[0], 37e-6);
}

#[test]
fn an_acceleration_fades_by_the_jerk_limit_when_demands_are_lost() {
    let mut acceptor = acceptor(Turntable::with_jerk(2000.0, 2000.0));
    (acceptor.state.velocity, acceptor.state.acceleration) = (Two::new(0.1, 0.2), Two::new(5.0, -1.5));
    acceptor.extrapolate(T);
    // By 2 m/s² in a millisecond, and not beyond zero.
    both(&acceptor.state.acceleration, [3.0, 0.0]);
    both(&acceptor.state.velocity, [0.103, 0.2]);
    both(&acceptor.state.position, [0.103e-3, 0.2e-3]);
    assert_eq!((acceptor.track.path.missing, acceptor.pace.period), (T, T));
    acceptor.state.acceleration = Two::new(-5.0, 0.0);
    acceptor.extrapolate(T);
    both(&acceptor.state.acceleration, [-3.0, 0.0]);
}

#[test]
fn to_hold_takes_the_velocity_away_in_one_step() {
    let mut acceptor = acceptor(Turntable::new());
    acceptor.state.velocity = Two::new(0.009, -0.019);
    assert!(acceptor.can_hold(T));
    acceptor.hold(T).unwrap();
    both(&acceptor.state.acceleration, [-9.0, 19.0]);
    assert!(acceptor.is_at_rest() && acceptor.state.position == Two::zeros());
    // 11 m/s² is more than 10.
    acceptor.state.velocity[0] = 0.011;
    assert!(!acceptor.can_hold(T));
}

#[test]
fn to_hold_is_the_end_of_a_deceleration_and_no_change_of_it() {
    // The last step of a ramp: from -4 m/s² on to -2 m/s², by 2000 m/s³.
    let mut acceptor = acceptor(Turntable::with_jerk(2500.0, 2500.0));
    (acceptor.state.velocity, acceptor.state.acceleration) = (Two::new(2e-3, 0.0), Two::new(-4.0, 0.0));
    assert!(acceptor.can_hold(T));
    // From -7 m/s² to -5 m/s² it could as well, but then it would have 5 m/s² to let go in one step.
    (acceptor.state.velocity, acceptor.state.acceleration) = (Two::new(5e-3, 0.0), Two::new(-7.0, 0.0));
    assert!(!acceptor.can_hold(T));
    (acceptor.state.velocity, acceptor.state.acceleration) = (Two::new(2e-3, 0.0), Two::new(-4.0, 0.0));
    // From 4 m/s² it would be 6000 m/s³.
    acceptor.state.acceleration[0] = 4.0;
    assert!(!acceptor.can_hold(T));
}

#[test]
fn a_robot_with_a_jerk_limit_brakes_on_from_the_acceleration_that_it_has() {
    // At -10 m/s² already: on with it until what is left goes with it, 9 + 8 + .. + 1 = 45 mm/s: from 0.5 m/s in 46 steps
    // of 10 mm/s less each, and 9 in which 5 mm/s more are shared.
    let mut acceptor = acceptor(Turntable::with_jerk(1000.0, 1000.0));
    (acceptor.state.velocity, acceptor.state.acceleration) = (Two::new(0.5, 0.0), Two::new(-10.0, 0.0));
    let mut braking = acceptor.braking();
    acceptor.brake(&mut braking, T);
    near(acceptor.state.velocity[0], 0.49);
    near(acceptor.state.acceleration[0], -10.0);
    let mut steps = 1;
    while !braking.is_over() {
        acceptor.brake(&mut braking, T);
        steps += 1;
    }
    assert_eq!((steps, acceptor.state.velocity[0]), (55, 0.0));
}

#[test]
fn a_robot_without_a_jerk_limit_brakes_from_its_velocity_at_once() {
    // 10 m/s² from the next step on.
    let mut acceptor = acceptor(Turntable::new());
    (acceptor.state.velocity, acceptor.state.acceleration, acceptor.pace.period) =
        (Two::new(1.0, 0.0), Two::new(10.0, 0.0), T);
    let mut braking = acceptor.braking();
    acceptor.brake(&mut braking, T);
    near(acceptor.state.velocity[0], 0.99);
    near(acceptor.state.acceleration[0], -10.0);
    near(acceptor.state.position[0], 0.995e-3);
}

#[test]
fn poses_are_of_the_tool_and_displacements_from_where_the_tool_was_in_its_own_axes() {
    let slow = Turntable::with(|l| {
        l.acceleration = Two::repeat(1e9);
        l.velocity = Two::repeat(1e6);
        (l.lower, l.upper) = (Two::repeat(-1e6), Two::repeat(1e6));
    });
    let mut acceptor = acceptor(slow);
    acceptor.checks.reaction = 0.0;
    acceptor.state.position = Two::new(0.3, 0.5);
    let tool = acceptor.tool_pose(&Two::new(0.3, 0.5));
    near(tool.translation.x, 0.3 + 0.1 * 0.5_f64.cos());
    near(tool.translation.y, 0.1 * 0.5_f64.sin());
    near(tool.translation.z, 0.2);
    acceptor.begin();
    acceptor.accept(&Demand::pose(tool), T, T).expect("where it is");
    both(&acceptor.state.position, [0.3, 0.5]);
    // The flange under a tool that is displaced by Rot(z, 0.4), Trans(0.02, 0, 0) in its own axes:
    // x = 0.3 + 0.1 cos 0.5 + (0.02 - 0.1) cos 0.9.
    let by = Pose::new(Vector3::zeros(), Vector3::new(0.0, 0.0, 0.4)) * Pose::translation(0.02, 0.0, 0.0);
    acceptor.accept(&Demand::displacement(by), T, T).expect("fast");
    both(&acceptor.state.position, [0.3 + 0.1 * 0.5_f64.cos() - 0.08 * 0.9_f64.cos(), 0.9]);
    // Still from the pose at the start of the motion.
    acceptor.accept(&Demand::displacement(Pose::identity()), T, T).expect("fast");
    both(&acceptor.state.position, [0.3, 0.5]);
    // Another motion starts elsewhere.
    acceptor.state.position = Two::new(0.7, 0.0);
    acceptor.begin();
    acceptor.accept(&Demand::displacement(Pose::identity()), T, T).expect("fast");
    both(&acceptor.state.position, [0.7, 0.0]);
    // A tool stays in force, from a demand that came too late as well.
    let longer = Pose::translation(0.2, 0.0, 0.0);
    acceptor.note_late(&Demand::hold().with_tool(longer)).expect("a frame");
    assert_eq!(*acceptor.tool(), longer);
    acceptor.accept(&Demand::pose(Pose::translation(1.0, 0.0, 0.0)), T, T).expect("fast");
    both(&acceptor.state.position, [0.8, 0.0]);
}

#[test]
fn a_redundancy_is_for_poses_and_a_number() {
    let mut acceptor = acceptor(Turntable::with(|l| l.acceleration = Two::repeat(1e6)));
    let here = Demand::pose(acceptor.tool_pose(&Two::zeros()));
    acceptor.accept(&here.with_redundancy(1e-6), T, T).expect("slow");
    near(acceptor.state.position[0], 1e-6);
    let kind = |result: Result<AcceptedDemand<Turntable>, Fault>| result.map(|_| ()).map_err(|f| f.kind());
    let fault = acceptor.accept(&here.with_redundancy(f64::NAN), T, T).expect_err("no number");
    assert_eq!((fault.kind(), fault.message()), (FaultKind::DemandNotFinite, "the redundancy"));
    assert_eq!(kind(acceptor.accept(&joints(0.0, 0.0).with_redundancy(0.0), T, T)), Err(FaultKind::Program));
    assert_eq!(kind(acceptor.accept(&Demand::hold().with_redundancy(0.0), T, T)), Err(FaultKind::Program));
}

#[test]
fn a_twist_is_that_of_the_last_step_in_the_world_and_is_gone_on_along() {
    let mut acceptor = acceptor(Turntable::new());
    (acceptor.state.position, acceptor.state.velocity) = (Two::new(0.2, 0.1), Two::new(0.3, 0.4));
    (acceptor.track.path.position, acceptor.track.path.velocity) =
        (acceptor.state.position, Two::new(0.2, 0.5));
    let before = Pose::new(Vector3::new(0.2 - 0.2e-3, 0.0, 0.0), Vector3::new(0.0, 0.0, 0.1 - 0.5e-3));
    let after = Pose::new(Vector3::new(0.2, 0.0, 0.0), Vector3::new(0.0, 0.0, 0.1));
    let off = acceptor.bridging(T).twist.part(1.0).inv_mul(&(after * before.inverse()));
    assert!(off.translation.vector.norm() + off.rotation.imag().norm() < 1e-14, "{off}");

    // 0.305 m/s and 0.39 rad/s from 0.3 m/s and 0.4 rad/s; the turn is about z of the world.
    let turn = 0.39e-3_f64;
    let distance = 0.2 + 0.305e-3 - 0.2 * turn.cos();
    let by = Pose::new(Vector3::new(distance, 0.0, 0.0), Vector3::new(0.0, 0.0, turn));
    acceptor.go_on(&by, T).expect("within the limits");
    both(&acceptor.state.position, [0.200305, 0.10039]);
    assert!((acceptor.state.velocity - Two::new(0.305, 0.39)).amax() < 1e-9);
    assert!((acceptor.state.acceleration - Two::new(5.0, -10.0)).amax() < 1e-6);
    assert_eq!(acceptor.pace.period, T);
    // A demand is awaited still, from where the path was.
    near(acceptor.track.path.missing, T);
    acceptor.go_on(&Pose::identity(), T).expect_err("305 m/s²");
    near(acceptor.track.path.missing, T);
    acceptor.go_on(&by, T).expect("5 m/s² less");
    near(acceptor.track.path.missing, 2.0 * T);
}

#[test]
fn what_slows_down_has_no_demand_to_make_up_for() {
    let mut acceptor = acceptor(Turntable::new());
    (acceptor.track.path.missing, acceptor.track.path.position) = (0.005, Two::new(0.7, 0.7));
    acceptor.slow_down(&Pose::translation(5e-6, 0.0, 0.0), T).expect("slow");
    assert_eq!((acceptor.track.path.missing, acceptor.track.path.position), (0.0, acceptor.state.position));
    near(acceptor.track.path.velocity[0], 5e-3);
    // Off the twist for want of numbers.
    acceptor.checks.robot.off = f64::NAN;
    let fault = acceptor.go_on(&Pose::identity(), T).expect_err("no number");
    assert_eq!((fault.kind(), fault.joint()), (FaultKind::DemandNotFinite, Some(0)));
}
