//! Faults: what is refused, which process is named, and how the robots come to a standstill. Numbers are faults of
//! docs/safety.

use mrroc::fault::FaultKind;
use mrroc::pose::{AngleAxis, Zyz};
use mrroc::prelude::*;
use mrroc::robot::{Limits, NoInverse};
use mrroc_tests::{ExactDrive, Gantry, MS, Q, Trace, fault, gantry, peaks, traced};
use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::runtime::kit::{Smooth, Twin, x};

/// Moves along x by a smoothstep, and in step `at` demands something else.
struct Misbehave {
    at: u64,
    demand: Demand<Gantry>,
    t: f64,
}

#[generator(ecp)]
fn misbehave(c: &mut Misbehave, t: Tick) -> Step<Gantry> {
    if t.step == c.at {
        return Step::Next(c.demand);
    }
    c.t = (c.t + t.dt).min(0.5);
    let u = c.t / 0.5;
    Step::Next(x(0.3 * u * u * (3.0 - 2.0 * u)))
}

fn refused(at: u64, demand: Demand<Gantry>) -> (Fault, Vec<Q<3>>) {
    let (robot, trace) = gantry("g");
    let robot = robot.program(move |ecp| ecp.move_robot((), Misbehave { at, demand, t: 0.0 }).map(drop));
    (fault(Cell::new(MS).robot(robot).run()), trace.take())
}

fn stops_within_the_limits(trace: &[Q<3>]) {
    assert!(trace.iter().all(|q| q.iter().all(|x| x.is_finite() && x.abs() <= 1.0)));
    let (v, a) = peaks(trace, 1e-3);
    assert!(v <= 1.0 && a <= 10.0 + 1e-6, "{v} m/s, {a} m/s²");
    assert_eq!(trace[trace.len() - 1], trace[trace.len() - 2], "not at standstill");
}

#[test]
fn fault_18_a_number_that_is_not_finite_never_reaches_the_drives() {
    let identity = UnitQuaternion::identity();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for i in 0..3 {
            let mut vector = Vector3::zeros();
            vector[i] = bad;
            let mut matrix = Matrix4::identity();
            matrix[(i, 3)] = bad;
            let mut turned = Matrix4::identity();
            turned[(i, (i + 1) % 3)] = bad;
            let mut angles = [0.0; 3];
            angles[i] = bad;
            let broken = UnitQuaternion::new_unchecked(Quaternion::new(1.0, bad, 0.0, 0.0));
            let demands = [
                Demand::joints(vector),
                Demand::pose(Pose::from_parts(Translation3::from(vector), identity)),
                Demand::pose(Pose::from_parts(Translation3::identity(), broken)),
                Demand::homogeneous(&matrix),
                Demand::homogeneous(&turned),
                Demand::position_zyz(vector, Zyz { alpha: 0.0, beta: 0.0, gamma: 0.0 }),
                Demand::position_zyz(
                    Vector3::zeros(),
                    Zyz { alpha: angles[0], beta: angles[1], gamma: angles[2] },
                ),
                Demand::position_angle_axis(vector, AngleAxis(Vector3::zeros())),
                Demand::position_angle_axis(Vector3::zeros(), AngleAxis(vector)),
                Demand::displacement(Pose::from_parts(Translation3::from(vector), identity)),
                Demand::hold().with_tool(Pose::from_parts(Translation3::from(vector), identity)),
            ];
            for (form, demand) in demands.into_iter().enumerate() {
                let (fault, trace) = refused(200, demand);
                assert_eq!(fault.kind(), FaultKind::DemandNotFinite, "form {form}, {bad} in {i}");
                stops_within_the_limits(&trace);
            }
        }
    }
}

#[test]
fn fault_19_a_frame_that_is_no_rotation_is_refused() {
    let mirror = Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, 1.0, -1.0));
    let stretched = Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, 1.0 + 1e-5, 1.0));
    let mut sheared = Matrix4::identity();
    sheared[(0, 1)] = 1e-3;
    let mut projective = Matrix4::identity();
    projective[(3, 0)] = 0.1;
    let long = UnitQuaternion::new_unchecked(Quaternion::new(1.0 + 2e-6, 0.0, 0.0, 0.0));
    let demands = [
        Demand::homogeneous(&mirror),
        Demand::homogeneous(&stretched),
        Demand::homogeneous(&sheared),
        Demand::homogeneous(&projective),
        Demand::homogeneous(&Matrix4::zeros()),
        Demand::pose(Pose::from_parts(Translation3::identity(), long)),
    ];
    for (form, demand) in demands.into_iter().enumerate() {
        let (fault, trace) = refused(200, demand);
        assert!(
            matches!(fault.kind(), FaultKind::DemandInvalidFrame | FaultKind::DemandNotFinite),
            "form {form}: {fault}"
        );
        stops_within_the_limits(&trace);
    }
}

#[test]
fn fault_20_a_position_beyond_a_limit_is_refused_while_the_joint_can_still_stop_before_it() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| ecp.move_robot((), Smooth::to(1.2, 2.0)).map(drop));
    let fault = fault(Cell::new(MS).robot(robot).run());
    assert_eq!((fault.kind(), fault.joint()), (FaultKind::DemandOutOfRange, Some(0)));
    let trace = trace.borrow();
    stops_within_the_limits(&trace);
    assert!(trace.iter().all(|q| q[0] <= 1.0));
    assert!(fault.to_string().contains("edp g joint 1: demanded position exceeds the limit"), "{fault}");
}

#[test]
fn fault_21_velocity_acceleration_and_jerk_beyond_a_limit_are_refused_and_nothing_is_clamped() {
    // Smoothstep of 0.4 m: v = 1.5 s/T, a = 6 s/T², jerk 12 s/T³ within and a step of a at its ends.
    for (duration, kind) in [(0.55, FaultKind::DemandedVelocity), (0.47, FaultKind::DemandedAcceleration)] {
        let (robot, trace) = gantry("g");
        let robot = robot.program(move |ecp| ecp.move_robot((), Smooth::to(0.4, duration)).map(drop));
        let fault = fault(Cell::new(MS).robot(robot).run());
        assert_eq!(fault.kind(), kind, "{fault}");
        let excess = fault.excess().expect("says how much");
        assert!(excess.actual > excess.limit);
        stops_within_the_limits(&trace.borrow());
    }
    let drive = ExactDrive::at_origin();
    let (robot, trace) = traced(RobotSetup::new("g", Gantry::with_jerk(1000.0), drive));
    let robot = robot.program(|ecp| ecp.move_robot((), Smooth::to(0.4, 0.7)).map(drop));
    let fault = fault(Cell::new(MS).robot(robot).run());
    assert_eq!(fault.kind(), FaultKind::DemandedJerk, "{fault}");
    stops_within_the_limits(&trace.borrow());
}

#[test]
fn fault_22_a_first_demand_far_from_the_robot_moves_nothing() {
    let (fault, trace) = refused(0, x(0.5));
    assert_eq!(fault.kind(), FaultKind::StartPoseMismatch);
    // Half a metre where 1 m/s leaves 1 mm in a step, and what to write instead.
    let excess = fault.excess().expect("says how far");
    assert!((excess.actual - 0.5).abs() < 1e-12 && (excess.limit - 1e-3).abs() < 1e-12, "{fault}");
    assert!(fault.to_string().contains("first = .."), "{fault}");
    assert!(trace.iter().all(|q| q.norm() == 0.0));
}

#[test]
fn fault_22_a_jump_of_a_robot_that_has_come_to_rest_within_a_motion_is_too_fast_and_no_wrong_start() {
    // The smoothstep of 0.5 s is over, its generator not: the robot stands in its motion.
    let (fault, trace) = refused(600, x(0.5));
    assert_eq!(fault.kind(), FaultKind::DemandedVelocity, "{fault}");
    // From 0.3 m to 0.5 m in 1 ms.
    assert!((fault.excess().expect("says how much").actual - 200.0).abs() < 1e-6, "{fault}");
    assert!(trace.iter().all(|q| q[0] <= 0.3));
}

#[test]
fn fault_23_a_pose_without_joint_positions_is_named() {
    let (fault, trace) = refused(200, Demand::pose(Pose::translation(9.0, 0.0, 0.0)));
    assert_eq!(fault.kind(), FaultKind::NoInverseKinematics);
    stops_within_the_limits(&trace);
    let (fault, _) = refused(200, Demand::pose(Pose::rotation(Vector3::x())));
    assert!(fault.to_string().contains("cannot turn"), "{fault}");
}

struct Panics;

#[generator(mp)]
fn panics(_c: &mut Panics, t: Tick) -> Step<(Gantry,)> {
    assert!(t.step < 100, "the map has no such place");
    let u = (t.step + 1) as f64;
    Step::Next((x(4e-6 * u * u),))
}

struct PanicsAlone;

#[generator(ecp)]
fn panics_alone(_c: &mut PanicsAlone, t: Tick) -> Step<Gantry> {
    assert!(t.step < 100, "the map has no such place");
    let u = (t.step + 1) as f64;
    Step::Next(x(4e-6 * u * u))
}

#[test]
fn fault_08_a_panic_in_a_generator_is_caught_and_the_robots_stop() {
    let (robot, trace) = gantry("g");
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.move_robots((&mut g,), (), Panics).map(drop)
    });
    let by_mp = fault(cell.run());
    assert_eq!(by_mp.kind(), FaultKind::Panicked);
    assert!(by_mp.message().contains("no such place"), "{by_mp}");
    stops_within_the_limits(&trace.borrow());

    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| ecp.move_robot((), PanicsAlone).map(drop));
    let by_ecp = fault(Cell::new(MS).robot(robot).run());
    assert_eq!(by_ecp.kind(), FaultKind::Panicked);
    assert_eq!(by_ecp.process().expect("named").to_string(), "ecp g");
    stops_within_the_limits(&trace.borrow());
}

fn pair(sticks_at: Option<u64>, trips_at: Option<u64>) -> (Fault, Trace<3>, Trace<3>) {
    let mut drive = ExactDrive::at_origin();
    (drive.sticks_at, drive.trips_at) = (sticks_at, trips_at);
    let (left, left_trace) = traced(RobotSetup::new("left", Gantry::default(), drive));
    let (right, right_trace) = gantry("right");
    let cell = Cell::new(MS).robot(left).robot(right).program(|mp| {
        let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
        mp.move_robots((&mut left, &mut right), (), Twin(Smooth::to(0.3, 0.5))).map(drop)
    });
    (fault(cell.run()), left_trace, right_trace)
}

#[test]
fn fault_26_a_blocked_joint_stops_both_robots() {
    let (fault, left, right) = pair(Some(200), None);
    assert_eq!(fault.kind(), FaultKind::FollowingError);
    assert_eq!(fault.process().expect("named").to_string(), "edp left");
    stops_within_the_limits(&left.borrow());
    stops_within_the_limits(&right.borrow());
    assert!(right.borrow().last().expect("recorded")[0] > -0.3);
}

#[test]
fn a_drive_that_trips_stops_both_robots() {
    let (fault, _, right) = pair(None, Some(200));
    assert_eq!(fault.kind(), FaultKind::DriveFault);
    assert_eq!(fault.excess().expect("says how much").unit, "A");
    stops_within_the_limits(&right.borrow());
}

#[test]
fn a_program_that_ignores_a_latched_fault_is_ended() {
    let (robot, _) = gantry("g");
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        loop {
            let _ = mp.move_robots((&mut g,), (), Panics2);
        }
    });
    let fault = fault(cell.run());
    assert!(fault.to_string().contains("no such place"), "{fault}");
}

struct Panics2;

#[generator(mp)]
fn panics_2(_c: &mut Panics2, t: Tick) -> Result<Step<(Gantry,)>, Fault> {
    let _ = t;
    Err(Fault::thrown("no such place"))
}

#[test]
fn a_cell_that_is_put_together_wrongly_says_so_before_it_runs() {
    let same = Cell::new(MS).robot(gantry("g").0).robot(gantry("g").0).program(|_| Ok(())).run();
    assert!(matches!(same, Err(CellError::Twice(_))));
    assert!(matches!(
        Cell::new(MS).robot(gantry("a b").0).program(|_| Ok(())).run(),
        Err(CellError::Name(_))
    ));
    assert_eq!(Cell::new(MS).robot(gantry("g").0).run(), Err(CellError::NoProgram));
    let odd = ExactDrive::new(Vector3::zeros(), std::time::Duration::from_micros(300));
    let odd = RobotSetup::new("g", Gantry::default(), odd).program(|_| Ok(()));
    assert!(matches!(Cell::new(MS).robot(odd).run(), Err(CellError::Period { .. })));
}

/// A gantry without inverse kinematics.
#[derive(Clone)]
struct Without(Gantry, NoInverse);

impl Robot for Without {
    const KIND: &'static str = "without";
    type Joints = Q<3>;

    fn limits(&self) -> &Limits<Q<3>> {
        self.0.limits()
    }

    fn forward(&self, q: &Q<3>) -> Pose {
        self.0.forward(q)
    }

    #[allow(non_snake_case)]
    fn inverse(&self, _: &Pose, _: &Q<3>) -> Result<Q<3>, NoInverse> {
        Err(self.1)
    }
}

#[generator(ecp)]
fn to_the_corner(_c: &mut Corner, t: Tick) -> Step<Without> {
    let corner = Pose::translation(-10.0, -10.0, -10.0);
    Step::Next(if t.step < 2 { Demand::joints(Q::zeros()) } else { Demand::pose(corner) })
}

struct Corner;

#[test]
fn fault_23_each_cause_of_a_pose_without_joint_positions_has_its_figures_and_its_help() {
    let cases = [
        (
            NoInverse::NotAttainable {
                what: "lean out of the arm's plane",
                actual: 0.25,
                tolerance: 1e-6,
                unit: "rad",
            },
            "not attainable, tool demanded at (-10.0000, -10.0000, -10.0000) m: lean out of the arm's plane: \
             0.250000 rad, at most 0.000001 rad",
            "the message names the direction",
        ),
        (
            NoInverse::NotConverged { error: 0.125, tolerance: 1e-10 },
            "no joints found from here, tool demanded at (-10.0000, -10.0000, -10.0000) m: off by 1.2e-1, at most 1e-10",
            "demand poses close to each other",
        ),
        (
            NoInverse::Singular { name: "wrist" },
            "at a singularity (wrist), tool demanded at (-10.0000, -10.0000, -10.0000) m",
            "go round the singularity",
        ),
        (
            NoInverse::OutOfReach { distance: 2.0, min: 0.5, max: 1.0 },
            "out of reach, tool demanded at (-10.0000, -10.0000, -10.0000) m: wrist to shoulder: 2.000000 m, \
             at most 1.000000 m",
            "demand a pose that the arm reaches",
        ),
    ];
    for (why, told, help) in cases {
        let robot = RobotSetup::new("g", Without(Gantry::default(), why), ExactDrive::new(Q::zeros(), MS))
            .program(|ecp| ecp.move_robot((), Corner).map(drop));
        let fault = fault(Cell::new(MS).robot(robot).run());
        assert!(fault.to_string().contains(told), "{fault}");
        let given = fault.help().expect("there is help");
        assert!(given.contains(help), "{given}");
    }
}
