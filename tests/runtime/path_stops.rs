//! Protective stops of robots whose jerk limits make a stop on the path long.

use std::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::robot::Limits;
use mrroc_tests::{ExactDrive, Gantry, MS, fault, peaks, traced};
use nalgebra::Vector3;

/// Along x from -0.9 m by at most 0.9 m/s², up to 0.8 m/s, which it keeps.
struct Cruise {
    x: f64,
    v: f64,
    a: f64,
}

#[generator(ecp)]
fn cruise(c: &mut Cruise, t: Tick) -> Step<Gantry> {
    // A third of its jerk limit.
    let wanted = ((0.8 - c.v) / 0.2).clamp(0.0, 0.9);
    c.a += (wanted - c.a).clamp(-20.0 * t.dt, 20.0 * t.dt);
    c.v += c.a * t.dt;
    c.x += c.v * t.dt;
    Step::Next(Demand::joints(Vector3::new(c.x, 0.0, 0.0)))
}

/// The positions along x from the step of an operator's protective stop on, and the fault.
fn stopped(stop_time: Duration) -> (Vec<f64>, Fault) {
    const STOPPED: u64 = 1500;
    let drive = ExactDrive::new(Vector3::new(-0.9, 0.0, 0.0), MS);
    let (robot, trace) = traced(RobotSetup::new("g", Gantry::with_jerk(60.0), drive));
    let robot = robot.program(|ecp| {
        let cruise = Cruise { x: -0.9, v: 0.0, a: 0.0 };
        ecp.move_robot((), cruise).map(drop)
    });
    let cell = Cell::new(MS).stop_time(stop_time).robot(robot).on_step(|step, operator| {
        if step == STOPPED {
            operator.protective_stop();
        }
    });
    let fault = fault(cell.run());
    assert_eq!(fault.kind(), FaultKind::ProtectiveStop, "{fault}");
    let trace = trace.take();
    let (v, a) = peaks(&trace, 1e-3);
    assert!(v <= 1.0 && a <= 10.0, "{v} m/s, {a} m/s²");
    (trace[STOPPED as usize..].iter().map(|q| q[0]).collect(), fault)
}

/// Steps until it stands.
fn moving(x: &[f64]) -> usize {
    let end = x[x.len() - 1];
    x.iter().rposition(|x| *x != end).expect("it moved")
}

#[test]
fn fault_81_a_protective_stop_that_takes_too_long_on_the_path_becomes_a_fault_stop_in_time() {
    // On the path it takes about a second, by the joints 1/10 + 2.5 * 10/60 = 0.52 s; all in 0.75 s of steps of 1 ms.
    let (x, fault) = stopped(Duration::from_millis(750));
    let steps = moving(&x);
    assert!(steps <= 750, "{steps} steps");
    assert_eq!(fault.message(), "by the operator; left the path");
    // Where there is time, it keeps the path.
    let (x, fault) = stopped(Duration::from_secs(3));
    let steps = moving(&x);
    assert!((750..3000).contains(&steps), "{steps} steps");
    assert_eq!(fault.message(), "by the operator");
}

/// A robot with a slow belt beside it, which may take 2.5 s to stop: a fault, or a protective stop, at 1500 ms. For each of
/// the two, until when it moved after the cause.
fn beside_a_belt(
    arm: Duration,
    belt: Duration,
    cause: fn(&mrroc::operator::Operator),
) -> ([usize; 2], Fault) {
    const STOPPED: u64 = 1500;
    let at = |x: f64| ExactDrive::new(Vector3::new(x, 0.0, 0.0), MS);
    let (robot, trace) = traced(RobotSetup::new("g", Gantry::with_jerk(60.0), at(-0.9)));
    let robot = robot.stop_time(arm).program(|ecp| {
        let cruise = Cruise { x: -0.9, v: 0.0, a: 0.0 };
        ecp.move_robot((), cruise).map(drop)
    });
    let limits = Limits { acceleration: Vector3::repeat(0.4), ..*Gantry::default().limits() };
    let (slow, slow_trace) = traced(RobotSetup::new("belt", Gantry::with_limits(limits), at(-0.9)));
    let slow = slow.stop_time(belt).program(|ecp| ecp.move_robot((), Creep { x: -0.9, v: 0.0 }).map(drop));
    // The cell allows neither of them its stop.
    let cell = Cell::new(MS).stop_time(Duration::from_millis(100)).robot(robot).robot(slow);
    let fault = fault(
        cell.on_step(move |step, operator| {
            if step == STOPPED {
                cause(operator);
            }
        })
        .run(),
    );
    let ends = [trace.take(), slow_trace.take()]
        .map(|trace| moving(&trace[STOPPED as usize..].iter().map(|q| q[0]).collect::<Vec<_>>()));
    (ends, fault)
}

/// Along x by 0.3 m/s².
struct Creep {
    x: f64,
    v: f64,
}

#[generator(ecp)]
fn creep(c: &mut Creep, t: Tick) -> Step<Gantry> {
    c.v = (c.v + 0.3 * t.dt).min(0.45);
    c.x += c.v * t.dt;
    Step::Next(Demand::joints(Vector3::new(c.x, 0.0, 0.0)))
}

#[test]
fn fault_81_each_robot_s_stop_keeps_its_own_time() {
    // 1 m/s: the arm stands 1/10 + 2.5 * 10/60 = 0.52 s after the cause at most, the belt (0.45 m/s) 0.45/0.4 = 1.13 s.
    let (millis, long) = (Duration::from_millis, Duration::from_millis(5000));
    let ([arm, belt], fault) = beside_a_belt(millis(750), long, mrroc::operator::Operator::protective_stop);
    println!("protective stop: the arm moves for {arm} ms, the belt for {belt} ms: {fault}");
    assert!(arm <= 750 && (1000..=5000).contains(&belt), "{arm} {belt}");
    assert_eq!(fault.message(), "by the operator; left the path");
    // The belt's time alone would leave both on the path.
    let ([arm, belt], fault) = beside_a_belt(long, long, mrroc::operator::Operator::protective_stop);
    println!("with time: the arm moves for {arm} ms, the belt for {belt} ms: {fault}");
    assert!((750..=5000).contains(&arm) && belt <= 5000, "{arm} {belt}");
    assert_eq!(fault.message(), "by the operator");
}
