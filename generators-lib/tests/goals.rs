//! Goals out of reach, which generators name in their first steps.

use core::cell::Cell as Shared;
use std::rc::Rc;
use std::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::generator::{Generator, Motion};
use mrroc::observe::ServoRecord;
use mrroc::prelude::*;
use mrroc_generators::curve::Helix;
use mrroc_generators::generators::{
    CircularMove, CurveMove, JointMove, JointSpline, JointVia, LineVia, PoseSplineMove, Replay,
    SmoothJointMove, StraightLine, TimeOptimalJoints, ToolOffset,
};
use mrroc_generators::jerk::JointLimits;
use mrroc_generators::line::{SmoothToolLimits, ToolLimits};
use mrroc_generators::profile::{JerkLimits, ProfileLimits};
use mrroc_generators::teach::{Reference, Space, Taught, TaughtPose};
use mrroc_generators::timing::PathLimits;
use mrroc_generators::via::PoseDeviation;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use nalgebra::Vector3;

fn start() -> Six {
    Irp6::READY
}

/// The fault of a Move by the MP, and how far any joint was demanded to go meanwhile \[rad\].
fn moved(
    generator: impl Generator<Robots = Irp6, Language = Motion, Sensors = (), Order = ()> + 'static,
) -> (Fault, f64) {
    let irp6 = Irp6::nominal();
    let farthest = Rc::new(Shared::new(0.0_f64));
    let seen = Rc::clone(&farthest);
    let arm = RobotSetup::new("arm", irp6.clone(), SimulatedIrp6::new(irp6, &start())).observe(
        move |record: &ServoRecord<Irp6>| seen.set(seen.get().max((record.demanded - start()).amax())),
    );
    let mut generator = Some(generator);
    let cell = Cell::new(Duration::from_millis(2)).robot(arm).program(move |mp| {
        let mut arm = mp.robot::<Irp6>("arm")?;
        let there_and_back = |goal| JointMove::to(goal, Six::repeat(0.4), Six::repeat(0.8));
        mp.move_robot(&mut arm, (), there_and_back(start() + Six::x() * 0.001))?;
        mp.move_robot(&mut arm, (), there_and_back(start()))?;
        let generator = generator.take().ok_or_else(|| Fault::thrown("once"))?;
        mp.move_robot(&mut arm, (), generator).map(drop)
    });
    match cell.run() {
        Err(mrroc::cell::CellError::Fault(fault)) => (fault, farthest.get()),
        other => panic!("it is out of reach: {other:?}"),
    }
}

/// It is refused for its goal, in the third Move, before anything has moved that a person would see.
#[track_caller]
fn refused(
    name: &str,
    kind: FaultKind,
    generator: impl Generator<Robots = Irp6, Language = Motion, Sensors = (), Order = ()> + 'static,
) {
    let (fault, farthest) = moved(generator);
    let told = fault.to_string();
    assert_eq!(fault.kind(), kind, "{told}");
    assert!(told.contains("its goal") && told.contains(&format!("in Move 3 ({name}) at step")), "{told}");
    assert!(fault.help().is_some_and(|help| help.contains("goal")), "{told}");
    // The two Moves before go 1 mrad.
    assert!(farthest < 1.1e-3, "{name}: {farthest} rad");
}

#[test]
fn fault_130_a_goal_out_of_reach_is_refused_in_the_first_steps_by_every_generator_that_knows_it() {
    use FaultKind::{DemandOutOfRange, NoInverseKinematics};
    let here = Irp6::nominal().forward(&start());
    let at = |x: f64, y: f64| here * Pose::translation(x, y, 0.0);
    let far = at(3.0, 0.0);
    let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
    let tool = ToolLimits { translation: limits, rotation: limits };
    let jerk = JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 };
    let smooth = SmoothToolLimits { translation: jerk, rotation: jerk };
    let beyond = start() + Six::x() * 9.0;
    let near = start() + Six::x() * 0.1;
    let (v, a) = (Six::repeat(0.2), Six::repeat(0.4));
    let all = JointLimits { velocity: v, acceleration: a, jerk: Six::repeat(8.0) };

    refused("StraightLine", NoInverseKinematics, StraightLine::to(far, tool));
    refused("StraightLine", NoInverseKinematics, StraightLine::by(Pose::translation(3.0, 0.0, 0.0), smooth));
    refused("ToolOffset", NoInverseKinematics, ToolOffset::by(Pose::translation(3.0, 0.0, 0.0), tool));
    refused("JointMove", DemandOutOfRange, JointMove::to(beyond, v, a));
    refused("SmoothJointMove", DemandOutOfRange, SmoothJointMove::to(beyond, all));
    // The points between are out of reach, and the end is not.
    let deviation = PoseDeviation { distance: 0.01, angle: 0.1 };
    refused("LineVia", NoInverseKinematics, LineVia::through(vec![far, at(0.05, 0.0)], deviation, smooth));
    refused("JointVia", DemandOutOfRange, JointVia::through(vec![beyond, near], Six::repeat(0.01), all));
    refused("PoseSplineMove", NoInverseKinematics, PoseSplineMove::through(vec![far, at(0.05, 0.0)], smooth));
    refused("JointSpline", DemandOutOfRange, JointSpline::through(vec![beyond, near], v, a, 0.1));
    let path = PathLimits { velocity: v, acceleration: a, speed: f64::INFINITY };
    refused("TimeOptimalJoints", DemandOutOfRange, TimeOptimalJoints::through(vec![beyond, near], path));
    let via = at(3.0, 1.5).translation.vector;
    refused("CircularMove", NoInverseKinematics, CircularMove::through(via, at(0.0, 0.1), smooth));
    // Once round, with the far side at 4 m; the end is where it begins.
    let round =
        Helix::about(Vector3::zeros(), Vector3::x() * 2.0, Vector3::z_axis(), std::f64::consts::TAU, 0.0);
    refused("CurveMove", NoInverseKinematics, CurveMove::along(round.expect("a helix"), jerk));
    let legs = [0.05, 9.0].map(|q| TaughtPose::new(1.0, 1.0, &[q, 0.0, 0.0, 0.0, 0.0, 0.0]));
    let poses = legs.into_iter().flatten().collect();
    let taught = Taught { space: Space::Joint, reference: Reference::Relative, poses };
    refused("Replay", DemandOutOfRange, Replay::of(taught, v, a, tool));
}

#[test]
fn a_motion_names_its_goal_once_and_its_demands_are_the_same() {
    let goal = start() + Six::x() * 0.1;
    let motion = JointMove::to(goal, Six::repeat(0.2), Six::repeat(0.4));
    let demands = mrroc_generators::rehearsal::rehearse(motion, &Irp6::nominal(), start(), 0.002);
    for (i, demand) in demands.expect("in reach").iter().enumerate() {
        let bare = Demand::<Irp6>::joints(demand.as_joints().expect("joints"));
        assert_eq!(*demand, if i == 0 { bare.with_goal(Demand::joints(goal)) } else { bare }, "{i}");
    }
}
