//! Protective stops of robots whose jerk limits make a stop on the path long.

use std::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
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
