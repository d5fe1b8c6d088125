//! The library's generators, run through whole cells.

use mrroc::fault::FaultKind;
use mrroc::generator::Generator;
use mrroc::prelude::*;
use mrroc_generators::bspline::SplineSettings;
use mrroc_generators::cooperation::{Displacement, StraightBody};
use mrroc_generators::curve::Helix;
use mrroc_generators::feed::FeedLimits;
use mrroc_generators::generators::{
    AwaitOperator, CircularMove, CompliantTransmit, ConstantOrder, CurveMove, Delay, EyeInHand, FollowMaster,
    ForceLaw, GuardedApproach, GuidedBody, Jog, JointMove, JointSpline, JointVia, LineVia, MovingFrame,
    OrderedForce, PoseSplineMove, ReachState, Replay, RigidCarry, Settle, SharedDrive, Sleep,
    SmoothJointMove, SpiralSearch, SplineTrack, SqueezedCarry, StraightLine, TiltSearch, TimeOptimalCurve,
    TimeOptimalJoints, ToolOffset, TransmitDisplacement, WatchedTransmit, YieldingTransmit,
};
use mrroc_generators::jerk::JointLimits;
use mrroc_generators::line::{SmoothToolLimits, ToolLimits};
use mrroc_generators::profile::ProfileLimits;
use mrroc_generators::teach::Jogging;
use mrroc_generators::timing::PathLimits;
use mrroc_robots::{Irp6, Six};
use mrroc_tests::{ExactDrive, Gantry, MS, fault, gantry, peaks, traced};
use nalgebra::{Translation3, UnitQuaternion, UnitVector3, Vector3};

fn limits(v: f64, a: f64) -> ToolLimits {
    let limits = ProfileLimits { velocity: v, acceleration: a };
    ToolLimits { translation: limits, rotation: limits }
}

#[test]
fn classes_are_those_of_the_paper() {
    type Points = std::vec::IntoIter<Vector3<f64>>;
    assert_eq!(JointMove::<Gantry>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(StraightLine::<Gantry>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(SmoothJointMove::<Gantry>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(
        StraightLine::<Gantry, SmoothToolLimits>::CLASS.to_string(),
        "ECP f*0(c), first step f*2(c, e)"
    );
    assert_eq!(CircularMove::<Gantry>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(CurveMove::<Gantry, Helix>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(JointSpline::<Gantry>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(TimeOptimalJoints::<Gantry>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(TimeOptimalCurve::<Gantry, Helix>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(JointVia::<Gantry>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(LineVia::<Gantry>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(PoseSplineMove::<Gantry>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(ReachState::<Gantry>::CLASS.to_string(), "ECP f*4(c0, c), first step f*6(c0, c, e)");
    assert_eq!(SpiralSearch::<Gantry>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(TiltSearch::<Gantry>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(SplineTrack::<Gantry, Points>::CLASS.to_string(), "ECP f*0(c)");
    assert_eq!(GuardedApproach::<Gantry, Probe>::CLASS.to_string(), "ECP f*1(c, v), first step f*3(c, e, v)");
    type Mixed = (Gantry, Irp6);
    let carried = "MP f*0(c0), first step f*2(c0, e)";
    assert_eq!(RigidCarry::<Mixed, StraightBody>::CLASS.to_string(), carried);
    assert_eq!(RigidCarry::<[Irp6; 4], StraightBody, Displacement>::CLASS.to_string(), carried);
    assert_eq!(SharedDrive::<Mixed, StraightBody>::CLASS.to_string(), carried);
    assert_eq!(FollowMaster::<Mixed, StraightBody>::CLASS.to_string(), "MP f*2(c0, e)");
    type Squeezed = SqueezedCarry<Mixed, (Wrist, Wrist), StraightBody>;
    assert_eq!(Squeezed::CLASS.to_string(), "MP f*1(c0, v), first step f*3(c0, e, v)");
    assert_eq!(TransmitDisplacement::<Gantry>::CLASS.to_string(), "ECP f*4(c0, c)");
    assert_eq!(YieldingTransmit::<Gantry>::CLASS.to_string(), "ECP f*4(c0, c), first step f*6(c0, c, e)");
    assert_eq!(ConstantOrder::<Mixed>::CLASS.to_string(), "MP f**() = const");
    assert_eq!(GuidedBody::<Mixed, (Wrist, Wrist)>::CLASS.to_string(), "MP f*3(c0, e, v)");
    assert_eq!(MovingFrame::<Gantry, Pose>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(ToolOffset::<Gantry>::CLASS.to_string(), "ECP f*0(c)");
    assert_eq!(Replay::<Gantry>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(Jog::<Gantry, fn() -> Jogging>::CLASS.to_string(), "ECP f*0(c), first step f*2(c, e)");
    assert_eq!(AwaitOperator::<Gantry, fn() -> bool>::CLASS.to_string(), "ECP f*0(c)");
    assert_eq!(Delay::<Gantry>::CLASS.to_string(), "ECP f*0(c)");
    assert_eq!(Sleep::<Gantry>::CLASS.to_string(), "ECP f*0(c)");
    assert_eq!(ForceLaw::<Gantry, Wrist>::CLASS.to_string(), "ECP f*1(c, v), first step f*3(c, e, v)");
    assert_eq!(Settle::<Gantry>::CLASS.to_string(), "ECP f*2(c, e)");
    assert_eq!(EyeInHand::<Gantry, Probe>::CLASS.to_string(), "ECP f*3(c, e, v)");
    assert_eq!(CompliantTransmit::<Gantry, Wrist>::CLASS.to_string(), "ECP f*5(c0, c, v)");
    assert_eq!(WatchedTransmit::<Gantry>::CLASS.to_string(), "ECP f*6(c0, c, e)");
    assert_eq!(OrderedForce::<Gantry, Wrist>::CLASS.to_string(), "ECP f*7(c0, c, e, v)");
}

struct Wrist;

impl Sensor for Wrist {
    const KIND: &'static str = "wrist";
    type Reading = mrroc::pose::Wrench;
    type Configuration = ();
}

#[test]
fn a_joint_move_takes_the_closed_form_time_and_ends_exactly() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        let (velocity, acceleration) = (Vector3::repeat(0.5), Vector3::repeat(5.0));
        ecp.move_robot((), JointMove::to(Vector3::new(0.4, -0.2, 0.1), velocity, acceleration)).map(drop)
    });
    let report = Cell::new(MS).robot(robot).run().expect("within the limits");
    // D / V + V / A = 0.9 s.
    assert!((901..=904).contains(&report.steps), "{}", report.steps);
    let trace = trace.borrow();
    assert_eq!(*trace.last().expect("recorded"), Vector3::new(0.4, -0.2, 0.1));
    let (v, a) = peaks(&trace, 1e-3);
    assert!((v - 0.5).abs() < 1e-9 && a <= 5.0 + 1e-6, "{v} {a}");
    // All joints are on the line between the ends.
    assert!(trace.iter().all(|q| (q[1] + 0.5 * q[0]).abs() < 1e-12 && (q[2] - 0.25 * q[0]).abs() < 1e-12));
}

#[test]
fn a_smooth_joint_move_takes_the_closed_form_time_and_keeps_its_jerk() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        let limits = JointLimits {
            velocity: Vector3::repeat(0.5),
            acceleration: Vector3::repeat(5.0),
            jerk: Vector3::repeat(50.0),
        };
        ecp.move_robot((), SmoothJointMove::to(Vector3::new(0.4, -0.2, 0.1), limits)).map(drop)
    });
    let report = Cell::new(MS).robot(robot).run().expect("within the limits");
    // D / V + V / A + A / J = 1.0 s.
    assert!((1001..=1004).contains(&report.steps), "{}", report.steps);
    let trace = trace.borrow();
    assert_eq!(*trace.last().expect("recorded"), Vector3::new(0.4, -0.2, 0.1));
    let (v, a) = peaks(&trace, 1e-3);
    assert!((v - 0.5).abs() < 1e-9 && a <= 5.0 + 1e-6, "{v} {a}");
    for q in trace.windows(4) {
        let jerk = (q[3] - q[2] * 3.0 + q[1] * 3.0 - q[0]) / 1e-9;
        assert!(jerk.amax() < 50.0 + 1e-3, "{jerk}");
    }
    assert!(trace.iter().all(|q| (q[1] + 0.5 * q[0]).abs() < 1e-12 && (q[2] - 0.25 * q[0]).abs() < 1e-12));
}

fn irp6_at(position: [f64; 3]) -> (Irp6, Six) {
    let robot = Irp6::nominal();
    let q = robot.inverse(&flange(position), &Irp6::READY).expect("within reach");
    (robot, q)
}

fn flange([x, y, z]: [f64; 3]) -> Pose {
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    Pose::from_parts(Translation3::new(x, y, z), down)
}

#[test]
fn a_straight_line_of_a_six_joint_arm_is_straight_in_space() {
    let (robot, q) = irp6_at([0.85, 0.0, 0.35]);
    let drive = ExactDrive::new(q, MS);
    let (setup, trace) = traced(RobotSetup::new("irp6", robot.clone(), drive));
    let setup = setup.program(|ecp| {
        ecp.move_robot((), StraightLine::to(flange([0.90, 0.08, 0.38]), limits(0.1, 0.5)))?;
        ecp.move_robot((), StraightLine::by(Pose::translation(0.0, 0.0, 0.03), limits(0.1, 0.5))).map(drop)
    });
    Cell::new(MS).robot(setup).run().expect("within the limits");
    let trace = trace.borrow();
    let (from, to) = (Vector3::new(0.85, 0.0, 0.35), Vector3::new(0.90, 0.08, 0.38));
    let along = (to - from).normalize();
    // The tool points down, so 30 mm along its z is 30 mm down.
    let end = robot.forward(trace.last().expect("recorded")).translation.vector;
    assert!((end - Vector3::new(0.90, 0.08, 0.35)).norm() < 1e-12);
    let corner =
        trace.iter().map(|q| robot.forward(q).translation.vector).position(|p| (p - to).norm() < 1e-12);
    for q in &trace[..corner.expect("passed the end of the first line")] {
        let p = robot.forward(q).translation.vector - from;
        assert!((p - along * along.dot(&p)).norm() < 1e-12);
    }
}

#[test]
fn a_spline_track_leads_the_tool_through_its_points() {
    let (robot, q) = irp6_at([0.85, 0.0, 0.35]);
    let (setup, trace) = traced(RobotSetup::new("irp6", robot.clone(), ExactDrive::new(q, MS)));
    // A circle of 10 mm through 48 points, in a frame on the plate.
    let points: Vec<_> = (0..=48)
        .map(|i| f64::from(i) * std::f64::consts::TAU / 48.0)
        .map(|angle| Vector3::new(0.01 * (1.0 - angle.cos()), 0.01 * angle.sin(), 0.0))
        .collect();
    let feed = FeedLimits {
        feed: 0.02,
        tangential: 0.2,
        normal: 0.2,
        step: 1e-3,
        chord_error: f64::INFINITY,
        jerk: f64::INFINITY,
    };
    let mut track = Some(SplineTrack::through(
        points,
        SplineSettings::default(),
        feed,
        Pose::translation(0.85, 0.0, 0.35),
        flange([0.0; 3]).rotation,
    ));
    let mut track = move || track.take().expect("one run").expect("settings in range");
    let setup = setup.program(move |ecp| ecp.move_robot((), track()).map(drop));
    Cell::new(MS).robot(setup).run().expect("within the limits");
    let trace = trace.borrow();
    let centre = Vector3::new(0.86, 0.0, 0.35);
    for q in trace.iter() {
        let radius = (robot.forward(q).translation.vector - centre).norm();
        // A natural end has no curvature where the circle has k: with spans of h the first one is off by at
        // most 0.05 h² k, and later ones by 0.27 of the one before.
        let span = 0.01 * std::f64::consts::TAU / 48.0;
        assert!((radius - 0.01).abs() < 0.05 * span * span / 0.01, "{radius}");
    }
    assert!(
        (robot.forward(trace.last().expect("recorded")).translation.vector
            - flange([0.85, 0.0, 0.35]).translation.vector)
            .norm()
            < 1e-9
    );
}

#[test]
fn fault_23_a_straight_line_through_the_wrist_singularity_passes_or_names_it_before_a_limit_is_broken() {
    let robot = Irp6::nominal();
    let near = Six::new(0.0, -1.57, 0.16, -0.16, 0.6, 0.0);
    // With joint 4 turned by d between the ends the line passes the singularity at about 0.3 sin(d/2) rad.
    for offset in [0.0, 1e-12, 1e-6, 1e-3, 0.05, 0.3] {
        let start = robot.inverse(&wrist_at(0.3, 0.0), &near).expect("within reach");
        let (setup, trace) = traced(RobotSetup::new("irp6", robot.clone(), ExactDrive::new(start, MS)));
        let goal = wrist_at(-0.3, offset);
        let setup =
            setup.program(move |ecp| ecp.move_robot((), StraightLine::to(goal, limits(0.05, 0.2))).map(drop));
        let ended = Cell::new(MS).robot(setup).run();
        let trace = trace.borrow();
        let (v, a) = (robot.limits().velocity, robot.limits().acceleration);
        for window in trace.windows(3) {
            let (v0, v1) = ((window[1] - window[0]) / 1e-3, (window[2] - window[1]) / 1e-3);
            for i in 0..6 {
                assert!(v1[i].abs() <= v[i] * (1.0 + 1e-9), "joint {i} at {} rad/s, offset {offset}", v1[i]);
                assert!(
                    (v1[i] - v0[i]).abs() / 1e-3 <= a[i] * (1.0 + 1e-9) + 1e-5,
                    "joint {i}, offset {offset}"
                );
            }
        }
        match ended {
            Ok(_) => {
                let end = robot.forward(trace.last().expect("recorded"));
                assert!((end.translation.vector - goal.translation.vector).norm() < 1e-9, "offset {offset}");
                assert!(end.rotation.angle_to(&goal.rotation) < 1e-7, "offset {offset}");
            }
            Err(mrroc::cell::CellError::Fault(fault)) => {
                // Beside the singularity the wrist would have to turn faster than it can.
                assert!(offset > 0.0, "straight through: {fault}");
                let kinds = [
                    FaultKind::DemandedVelocity,
                    FaultKind::DemandedAcceleration,
                    FaultKind::NoInverseKinematics,
                    FaultKind::DemandOutOfRange,
                ];
                assert!(kinds.contains(&fault.kind()), "{fault}");
                assert!(fault.to_string().contains("wrist singularity"), "{fault}");
            }
            Err(other) => panic!("{other}"),
        }
    }
}

/// A pose whose wrist is turned by `angle` from its singularity, with joint 4 at `elbow`.
fn wrist_at(angle: f64, elbow: f64) -> Pose {
    Irp6::nominal().forward(&Six::new(0.0, -1.57, 0.16, elbow, angle, 0.3))
}

struct Probe;

impl Sensor for Probe {
    const KIND: &'static str = "probe";
    type Reading = Contact;
    type Configuration = ();
}

#[derive(Clone, Copy, Payload)]
struct Contact {
    made: bool,
}

/// A surface at this height \[m\].
struct Surface(f64);

impl VirtualSensor for Surface {
    type Kind = Probe;
    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Contact, Fault> {
        let tool = order.robot.ok_or_else(|| Fault::thrown("the probe is on no robot"))?;
        Ok(Contact { made: tool.pose.translation.z <= self.0 })
    }
}

fn approach(surface: f64) -> (Result<mrroc::cell::RunReport, mrroc::cell::CellError>, f64) {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        let mut probe = ecp.sensor::<Probe>("probe")?;
        let down: UnitVector3<f64> = -Vector3::z_axis();
        let guarded = GuardedApproach::along(down, 0.02, 0.5, 0.1, |contact: &Contact| contact.made);
        ecp.move_robot((&mut probe,), guarded).map(drop)
    });
    let report = Cell::new(MS).robot(robot).sensor(SensorSetup::new("probe", Surface(surface)).of("g")).run();
    let z = trace.borrow().last().expect("recorded")[2];
    (report, z)
}

#[test]
fn a_guarded_approach_ends_at_the_contact() {
    let (report, z) = approach(-0.05);
    report.expect("there is contact");
    // Two steps from the touch to the last demand, and the braking from 20 mm/s.
    assert!((-0.05 - 5.0 * 0.02 * 1e-3..=-0.05).contains(&z), "{z}");
}

#[test]
fn a_guarded_approach_without_contact_is_a_fault_and_goes_no_farther_than_told() {
    let (report, z) = approach(-0.2);
    let fault = fault(report);
    assert_eq!(fault.kind(), FaultKind::Program);
    assert!(fault.message().contains("no contact"), "{fault}");
    assert!((-0.1001..=-0.0999).contains(&z), "{z}");
}

#[test]
fn a_time_optimal_path_of_a_six_joint_arm_passes_the_limits_at_full_speed() {
    let (robot, q) = irp6_at([0.85, 0.0, 0.35]);
    let limits = *robot.limits();
    let limits =
        PathLimits { velocity: limits.velocity, acceleration: limits.acceleration, speed: f64::INFINITY };
    let points =
        vec![q + Six::new(0.3, 0.1, -0.1, 0.05, 0.4, -0.6), q + Six::new(0.1, 0.2, 0.1, 0.1, -0.3, 0.5), q];
    let (setup, trace) = traced(RobotSetup::new("irp6", robot, ExactDrive::new(q, MS)));
    let path = points.clone();
    let setup = setup
        .program(move |ecp| ecp.move_robot((), TimeOptimalJoints::through(path.clone(), limits)).map(drop));
    let report = Cell::new(MS).robot(setup).run().expect("within the limits, at every step");
    let trace = trace.borrow();
    assert_eq!(*trace.last().expect("recorded"), q);
    let nearest = |point: &Six| trace.iter().map(|at| (at - point).norm()).fold(f64::INFINITY, f64::min);
    assert!(points.iter().all(|point| nearest(point) < 5e-3), "{}", report.steps);
}

#[test]
fn via_points_are_passed_on_the_robots_limits_without_a_stop() {
    let (robot, trace) = gantry("g");
    let limits = JointLimits {
        velocity: Vector3::repeat(0.5),
        acceleration: Vector3::repeat(5.0),
        jerk: Vector3::repeat(f64::INFINITY),
    };
    let points =
        vec![Vector3::new(0.4, 0.0, 0.0), Vector3::new(0.4, -0.4, 0.0), Vector3::new(0.0, -0.4, 0.1)];
    let path = points.clone();
    let robot = robot.program(move |ecp| {
        ecp.move_robot((), JointVia::through(path.clone(), Vector3::repeat(0.01), limits)).map(drop)
    });
    let report = Cell::new(MS).robot(robot).run().expect("within the limits");
    // 1.2 m at 0.5 m/s and a ramp of 0.1 s; corners within 0.01 m, where V^2 / 8 A = 0.006, cost nothing.
    assert!((2500..2504).contains(&report.steps), "{}", report.steps);
    let trace = trace.borrow();
    assert_eq!(trace.last(), points.last());
    let (v, a) = peaks(&trace, 1e-3);
    assert!(v < 0.5 + 1e-9 && a < 5.0 + 1e-6, "{v} {a}");
}
