//! Move, eq. 6 of the paper, in an ECP and in the MP.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc_tests::{ExactDrive, Gantry, MS, fault, gantry, peaks, traced};

use crate::runtime::kit::{Coast, Counter, Counting, Smooth, Twin, Watch, x};

#[test]
fn a_program_of_an_ecp_alone_is_triggered_and_moves_its_robot() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        ecp.move_robot((), Smooth::to(0.3, 0.5))?;
        ecp.move_robot((), Smooth::to(0.1, 0.5))?;
        Ok(())
    });
    let report = Cell::new(MS).robot(robot).run().expect("the motion keeps the limits");
    let trace = trace.borrow();
    assert_eq!(trace.last().expect("recorded")[0], 0.1);
    // 1000 steps of motion, one before the first, and those in which the MP learns of the end and ends it.
    assert!((1001..=1004).contains(&report.steps), "{}", report.steps);
    let (v, a) = peaks(&trace, 1e-3);
    // Smoothstep: v = 1.5 s / T, a = 6 s / T^2.
    assert!((v - 0.9).abs() < 1e-3 && (a - 7.2).abs() < 0.1, "{v} {a}");
}

#[test]
fn the_mp_moves_two_robots_through_transparent_ecps_in_the_same_step() {
    let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
    Cell::new(MS)
        .robot(left)
        .robot(right)
        .program(|mp| {
            let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
            mp.move_robots((&mut left, &mut right), (), Twin(Smooth::to(0.2, 0.4)))?;
            assert_eq!(left.demanded().joints[0], 0.2);
            assert_eq!(right.demanded().joints[0], -0.2);
            // The drives are exact, and the last tick of the motion is over when the Move returns.
            assert_eq!(right.measured().pose.translation.x, -0.2);
            Ok(())
        })
        .run()
        .expect("the motion keeps the limits");
    let (left, right) = (left_trace.borrow(), right_trace.borrow());
    assert_eq!(left.len(), right.len());
    for (l, r) in left.iter().zip(right.iter()) {
        assert_eq!(l[0], -r[0]);
    }
    assert_eq!(left.last().expect("recorded")[0], 0.2);
}

/// Demands 1 mm, 2 mm, .. and is done when the robot is measured beyond `stop`; keeps what it demanded last.
struct Creep {
    stop: f64,
    last: f64,
}

#[generator(ecp)]
fn creep(c: &mut Creep, e: &State<Gantry>) -> Step<Gantry> {
    if e.measured().joints[0] >= c.stop {
        c.last += 1.0; // computed with the terminal condition: must not be executed
        return Step::Done;
    }
    c.last += 1e-5;
    Step::Next(x(c.last))
}

#[test]
fn the_demand_computed_with_the_terminal_condition_is_not_executed() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        let creep = ecp.move_robot((), Creep { stop: 1e-3 - 1e-9, last: 0.0 })?;
        assert!(creep.last > 1.0);
        Ok(())
    });
    Cell::new(MS).robot(robot).run().expect("the motion keeps the limits");
    let last = trace.borrow().last().expect("recorded")[0];
    // e of a step is what the encoders gave in the step before, so one more demand is on its way.
    assert!((1e-3..=1e-3 + 2.1e-5).contains(&last), "{last}");
}

struct TwoUntils {
    calls: u32,
}

#[generator(ecp, until = enough)]
fn two_untils(c: &mut TwoUntils, _t: Tick) -> Step<Gantry> {
    c.calls += 1;
    Step::Next(Demand::hold())
}

fn enough(c: &mut TwoUntils) -> bool {
    c.calls == 5
}

#[test]
fn until_ends_a_motion_before_its_step_function_is_called_again() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        assert_eq!(ecp.move_robot((), TwoUntils { calls: 0 })?.calls, 5);
        Ok(())
    });
    Cell::new(MS).robot(robot).run().expect("nothing moves");
}

#[test]
fn a_motion_that_ends_moving_gets_the_braking_tail_and_returns_at_standstill() {
    let (robot, trace) = gantry("g");
    // 10 m/s² and 1 ms: 0.01 m/s a step. Reached at once it is the most that the limit allows.
    let robot = robot.program(|ecp| {
        ecp.move_robot((), Ramp { speed: 0.0 })?;
        assert!(ecp.image().demanded().velocity[0].abs() < 1e-12, "not at standstill");
        Ok(())
    });
    Cell::new(MS).robot(robot).run().expect("the motion keeps the limits");
    let trace = trace.borrow();
    let (v, a) = peaks(&trace, 1e-3);
    assert!((v - 0.5).abs() < 1e-9, "{v}");
    assert!(a <= 10.0 + 1e-6, "{a}");
    // Up: sum of 0.01 k ms for k = 1..50; down from 0.5 m/s at 10 m/s²: v² / 2a.
    let expected = 1e-5 * 1275.0 + 0.5 * 0.5 / 20.0;
    assert!((trace.last().expect("recorded")[0] - expected).abs() < 1e-9);
}

/// Speeds up by 0.01 m/s a step to 0.5 m/s and ends there.
struct Ramp {
    speed: f64,
}

#[generator(ecp)]
fn ramp(c: &mut Ramp, e: &State<Gantry>, t: Tick) -> Step<Gantry> {
    if c.speed > 0.495 {
        return Step::Done;
    }
    c.speed += 0.01;
    Step::Next(x(e.demanded().joints[0] + c.speed * t.dt))
}

#[test]
fn a_blend_hands_the_moving_robot_to_the_next_motion_without_a_step_in_its_velocity() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        ecp.blend_robot((), Ramp { speed: 0.0 })?;
        ecp.blend_robot((), Coast::new(0.5, 100))?;
        ecp.move_robot((), Coast::new(0.5, 100))?;
        Ok(())
    });
    Cell::new(MS).robot(robot).run().expect("the hand-over keeps the limits");
    let trace = trace.borrow();
    let moving = trace.windows(2).filter(|pair| ((pair[1] - pair[0])[0] / 1e-3 - 0.5).abs() < 1e-9).count();
    // The last step of the ramp and the two coasts, with no step between.
    assert_eq!(moving, 201);
    assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6);
}

#[test]
fn a_blend_that_no_motion_takes_over_brakes() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        ecp.blend_robot((), Ramp { speed: 0.0 })?;
        Ok(())
    });
    Cell::new(MS).robot(robot).run().expect("brakes within the limits");
    let trace = trace.borrow();
    assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6);
    assert_eq!(trace[trace.len() - 1], trace[trace.len() - 2]);
}

/// Blends in the MP: up to speed, on, and stop, for a transparent ECP.
struct Speed {
    steps: u32,
    acceleration: f64,
    speed: f64,
    x: f64,
}

#[generator(mp)]
fn speed(c: &mut Speed, t: Tick) -> Step<(Gantry,)> {
    if c.steps == 0 {
        return Step::Done;
    }
    c.steps -= 1;
    c.speed += c.acceleration * t.dt;
    c.x += c.speed * t.dt;
    Step::Next((x(c.x),))
}

#[test]
fn a_blend_of_the_mp_loses_no_step_either() {
    let (robot, trace) = gantry("g");
    Cell::new(MS)
        .robot(robot)
        .program(|mp| {
            let mut g = mp.robot::<Gantry>("g")?;
            let up = Speed { steps: 50, acceleration: 10.0, speed: 0.0, x: 0.0 };
            let up = mp.blend_robots((&mut g,), (), up)?;
            assert!((g.demanded().joints[0] - up.x).abs() < 1e-12);
            let on = mp.blend_robots((&mut g,), (), Speed { steps: 100, acceleration: 0.0, ..up })?;
            mp.move_robots((&mut g,), (), Speed { steps: 50, acceleration: -10.0, ..on })?;
            Ok(())
        })
        .run()
        .expect("the hand-over keeps the limits");
    let trace = trace.borrow();
    assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6, "{:?}", peaks(&trace, 1e-3));
    let moving = trace.windows(2).filter(|pair| ((pair[1] - pair[0])[0] / 1e-3 - 0.5).abs() < 1e-9).count();
    assert_eq!(moving, 101);
}

/// Uses `v` in its first step alone.
#[derive(Default)]
struct Glance {
    first: Option<u64>,
    steps: u32,
}

#[generator(ecp, first = look, sensors = (Counter,))]
fn glance(c: &mut Glance, _t: Tick) -> Step<Gantry> {
    c.steps += 1;
    if c.steps == 20 { Step::Done } else { Step::Next(Demand::hold()) }
}

fn look(c: &mut Glance, v: &Reading<(Counter,)>) -> Step<Gantry> {
    c.first = v.0.reading().map(|reading| reading.count);
    Step::Next(Demand::hold())
}

#[test]
fn a_first_step_that_uses_v_has_a_reading_of_its_own_step() {
    let (robot, _) = gantry("g");
    let counting = Counting::default();
    let count = Rc::clone(&counting.count);
    let robot = robot.program(|ecp| {
        let mut counter = ecp.sensor::<Counter>("counter")?;
        assert_eq!(ecp.move_robot((&mut counter,), Glance::default())?.first, Some(1));
        Ok(())
    });
    Cell::new(MS)
        .robot(robot)
        .sensor(SensorSetup::new("counter", counting).of("g"))
        .run()
        .expect("nothing moves");
    assert!(count.get() >= 1);
}

#[test]
fn readings_of_a_step_come_after_its_demand_and_serve_the_next_one() {
    let (robot, _) = gantry("g");
    let robot = robot.program(|ecp| {
        let mut counter = ecp.sensor::<Counter>("counter")?;
        let watch = ecp.move_robot((&mut counter,), Watch { steps: 4, ..Watch::default() })?;
        // Wait-style exchange before the first step, then one reading per executed step.
        assert_eq!(watch.seen, [Some((1, 0)), Some((1, 0)), Some((2, 0)), Some((3, 0))]);
        Ok(())
    });
    let counting = Counting::default();
    Cell::new(MS)
        .robot(robot)
        .sensor(SensorSetup::new("counter", counting).of("g"))
        .run()
        .expect("nothing moves");
}

struct Thrower(u32);

#[generator(ecp)]
fn thrower(c: &mut Thrower, t: Tick) -> Result<Step<Gantry>, Fault> {
    c.0 += 1;
    if c.0 > 30 {
        return Err(Fault::thrown("the chip basket is full"));
    }
    let u = (t.step + 1) as f64;
    Ok(Step::Next(x(5e-6 * u * u)))
}

#[test]
fn a_fault_that_a_step_function_throws_stops_the_robot_and_ends_every_program() {
    let (robot, trace) = gantry("g");
    let seen = Rc::new(RefCell::new(None));
    let keep = Rc::clone(&seen);
    let robot = robot.program(move |ecp| {
        let end = ecp.move_robot((), Thrower(0)).map(drop);
        *keep.borrow_mut() = end.clone().err();
        assert!(ecp.move_robot((), Smooth::to(0.5, 1.0)).is_err(), "a latched fault lets nothing move");
        end
    });
    let fault = fault(Cell::new(MS).robot(robot).run());
    assert_eq!(fault.kind(), FaultKind::Program);
    assert_eq!(fault.message(), "the chip basket is full");
    assert_eq!(fault.robot().expect("named").as_str(), "g");
    assert_eq!(seen.borrow().as_ref().expect("returned to the program").kind(), FaultKind::Program);
    let trace = trace.borrow();
    assert_eq!(trace[trace.len() - 1], trace[trace.len() - 2]);
    assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6);
}

#[test]
fn a_robot_with_four_servo_periods_in_a_step_follows_half_a_step_behind_with_no_more_acceleration() {
    let quarter = std::time::Duration::from_micros(250);
    let drive = ExactDrive::new(nalgebra::Vector3::zeros(), quarter);
    let (robot, trace) = traced(RobotSetup::new("g", Gantry::default(), drive));
    let robot = robot.program(|ecp| ecp.move_robot((), Smooth::to(0.3, 0.5)).map(drop));
    Cell::new(MS).robot(robot).run().expect("the motion keeps the limits");
    let (coarse_robot, coarse) = gantry("g");
    let coarse_robot = coarse_robot.program(|ecp| ecp.move_robot((), Smooth::to(0.3, 0.5)).map(drop));
    Cell::new(MS).robot(coarse_robot).run().expect("the motion keeps the limits");
    let (fine, coarse) = (trace.borrow(), coarse.borrow());
    // Between two demands at the end of the later one's step: the quadratic B-spline's value at a knot.
    for (step, pair) in coarse.windows(2).enumerate() {
        assert!((fine[4 * (step + 1) + 3] - (pair[0] + pair[1]) * 0.5).norm() < 1e-12, "step {step}");
    }
    assert!(peaks(&fine, 0.25e-3).1 <= peaks(&coarse, 1e-3).1 + 1e-6);
}
