//! Stops near a limit: no joint passes its limit, whatever stops the robots.

use mrroc::cell::Cell;
use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc_tests::{ExactDrive, Gantry, MS, Q, fault, gantry, peaks, traced};
use nalgebra::Vector3;

/// x speeds up to 0.9 m/s while y creeps towards its limit at `creep` \[m/s\]; in step `breaks_at` it demands NaN.
struct Drift {
    x: f64,
    y: f64,
    v: f64,
    creep: f64,
    breaks_at: u64,
}

#[generator(ecp)]
fn drift(c: &mut Drift, t: Tick) -> Step<Gantry> {
    if t.step == c.breaks_at {
        return Step::Next(Demand::joints(Vector3::repeat(f64::NAN)));
    }
    let up = (c.v + 9.0 * t.dt).min(0.9);
    c.v = if t.step < 100 { (c.v + 9.0 * t.dt).min(0.2) } else { up };
    let y = if t.step < 100 { 0.0 } else { c.creep };
    c.x += c.v * t.dt;
    c.y += y.min(9.0 * t.dt * (t.step.saturating_sub(99)) as f64) * t.dt;
    Step::Next(Demand::joints(Vector3::new(c.x - 1.0, c.y + 0.9, 0.0)))
}

#[test]
fn fault_20_a_slow_joint_that_brakes_along_with_a_fast_one_stays_within_its_limit() {
    let mut refused = 0;
    for breaks_at in (1000..1400).step_by(5) {
        let drive = ExactDrive::new(Q::<3>::new(-1.0, 0.9, 0.0), MS);
        let (robot, trace) = traced(RobotSetup::new("g", Gantry::default(), drive));
        let robot = robot.program(move |ecp| {
            ecp.move_robot((), Drift { x: 0.0, y: 0.0, v: 0.0, creep: 0.08, breaks_at }).map(drop)
        });
        let fault = fault(Cell::new(MS).robot(robot).run());
        refused += u32::from(fault.kind() == FaultKind::DemandOutOfRange);
        let trace = trace.borrow();
        let highest = trace.iter().map(|q| q[1]).fold(0.0, f64::max);
        assert!(highest <= 1.0, "broken at {breaks_at}: y reaches {highest} m after {fault}");
        assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6);
    }
    assert!(refused > 0, "the limit was never near");
}

/// Velocity, acceleration and jerk of x of a trace by differences: the largest of each.
fn derivatives(trace: &[Q<3>]) -> [f64; 3] {
    let mut values: Vec<f64> = trace.iter().map(|q| q[0]).collect();
    [0; 3].map(|_| {
        values = values.windows(2).map(|pair| (pair[1] - pair[0]) / 1e-3).collect();
        values.iter().fold(0.0, |peak, x| x.abs().max(peak))
    })
}

/// A quintic, x = s (10 u³ - 15 u⁴ + 6 u⁵), which keeps a jerk limit; in step `breaks_at` it demands NaN.
struct Quintic {
    t: f64,
    breaks_at: u64,
}

#[generator(ecp)]
fn quintic(c: &mut Quintic, t: Tick) -> Step<Gantry> {
    if t.step == c.breaks_at {
        return Step::Next(Demand::joints(Vector3::repeat(f64::NAN)));
    }
    if c.t >= 0.6 {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(0.6);
    let u = c.t / 0.6;
    Step::Next(Demand::joints(Vector3::new(0.25 * u * u * u * (10.0 + u * (6.0 * u - 15.0)), 0.0, 0.0)))
}

#[test]
fn fault_21_a_stop_keeps_the_jerk_limit_in_every_step_of_a_motion() {
    // 60 s / T³ = 69 m/s³ and 5.77 s / T² = 4 m/s².
    let jerk = 200.0;
    for breaks_at in 1..600 {
        let drive = ExactDrive::at_origin();
        let (robot, trace) = traced(RobotSetup::new("g", Gantry::with_jerk(jerk), drive));
        let robot = robot.program(move |ecp| ecp.move_robot((), Quintic { t: 0.0, breaks_at }).map(drop));
        let fault = fault(Cell::new(MS).robot(robot).run());
        assert_eq!(fault.kind(), FaultKind::DemandNotFinite, "{fault}");
        let [v, a, j] = derivatives(&trace.borrow());
        assert!(v <= 1.0 && a <= 10.0 * (1.0 + 1e-9) + 1e-6, "broken at {breaks_at}: {v} m/s, {a} m/s²");
        assert!(j <= jerk * (1.0 + 1e-9) + 1e-3, "broken at {breaks_at}: {j} m/s³");
    }
}

/// Joints first, then a displacement by the same distance from the start of the instruction.
struct Mixed {
    t: f64,
    tool_at: Option<u64>,
}

#[generator(ecp)]
fn mixed(c: &mut Mixed, t: Tick) -> Step<Gantry> {
    if c.t >= 0.4 {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(0.4);
    let u = c.t / 0.4;
    let distance = 0.1 * u * u * (3.0 - 2.0 * u);
    let demand = if t.step < 100 {
        Demand::joints(Vector3::new(0.2 + distance, 0.0, 0.0))
    } else {
        Demand::displacement(Pose::translation(distance, 0.0, 0.0))
    };
    Step::Next(match c.tool_at {
        Some(step) if t.step == step => demand.with_tool(Pose::translation(0.0, 0.0, 0.3)),
        _ => demand,
    })
}

#[test]
fn a_displacement_counts_from_the_start_of_the_instruction_whatever_came_before_it_and_whatever_the_tool() {
    for tool_at in [None, Some(0), Some(50), Some(100), Some(200)] {
        let drive = ExactDrive::new(Q::<3>::new(0.2, 0.0, 0.0), MS);
        let (robot, trace) = traced(RobotSetup::new("g", Gantry::default(), drive));
        let robot = robot.program(move |ecp| ecp.move_robot((), Mixed { t: 0.0, tool_at }).map(drop));
        Cell::new(MS).robot(robot).run().unwrap_or_else(|error| panic!("tool at {tool_at:?}: {error}"));
        let end = trace.borrow().last().expect("recorded")[0];
        assert!((end - 0.3).abs() < 1e-12, "tool at {tool_at:?}: {end}");
    }
}

#[test]
fn holding_in_the_middle_of_a_motion_is_a_demand_like_any_other() {
    // At 0.009 m/s one step takes the velocity away within 10 m/s²; at 0.011 m/s it does not.
    for (speed, keeps) in [(0.009, true), (0.011, false)] {
        let (robot, trace) = gantry("g");
        let robot = robot.program(move |ecp| ecp.move_robot((), Pausing { speed, x: 0.0 }).map(drop));
        let result = Cell::new(MS).robot(robot).run();
        assert_eq!(result.is_ok(), keeps, "{result:?}");
        if !keeps {
            assert_eq!(fault(result).kind(), FaultKind::DemandedAcceleration);
        }
        assert!(peaks(&trace.borrow(), 1e-3).1 <= 10.0 + 1e-6);
    }
}

struct Pausing {
    speed: f64,
    x: f64,
}

#[generator(ecp)]
fn pausing(c: &mut Pausing, t: Tick) -> Step<Gantry> {
    match t.step {
        0 => c.x += 0.5 * c.speed * t.dt,
        1..50 => c.x += c.speed * t.dt,
        50..100 => return Step::Next(Demand::hold()),
        _ => return Step::Done,
    }
    Step::Next(Demand::joints(Vector3::new(c.x, 0.0, 0.0)))
}
