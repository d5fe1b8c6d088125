//! Feed rate: speed, suspend, resume, abort.

use std::time::Duration;

use mrroc::cell::{Cell, RobotSetup};
use mrroc::fault::FaultKind;
use mrroc::operator::Operator;
use mrroc::robot::{DriveFault, Driver, Measured};
use mrroc_tests::{ExactDrive, Gantry, MS, Q, fault, gantry, peaks, traced};

use crate::runtime::kit::{Smooth, Twin};

fn run(act: impl FnMut(u64, &Operator) + 'static) -> (u64, Vec<Q<3>>) {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| ecp.move_robot((), Smooth::to(0.3, 0.5)).map(drop));
    let report = Cell::new(MS).robot(robot).on_step(act).run().expect("keeps the limits");
    (report.steps, trace.take())
}

#[test]
fn at_half_speed_the_same_path_takes_twice_as_long() {
    let (full, full_trace) = run(|_, _| {});
    let (half, half_trace) = run(|step, operator| {
        if step == 1 {
            operator.set_speed(0.5).expect("a share");
        }
    });
    assert!((half - full).abs_diff(500) <= 1, "{full} {half}");
    for (i, q) in full_trace[..full_trace.len() - 3].iter().enumerate().skip(2) {
        let near = (q - half_trace[2 * i - 1]).norm().min((q - half_trace[2 * i]).norm());
        assert!(near < 1e-12, "step {i}: {near}");
    }
    assert!((peaks(&half_trace, 1e-3).0 - peaks(&full_trace, 1e-3).0 / 2.0).abs() < 1e-5);
}

#[test]
fn a_speed_that_is_no_share_is_refused() {
    let operator = Cell::new(MS).operator();
    for speed in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        assert!(operator.set_speed(speed).is_err());
        assert_eq!(operator.speed(), 1.0);
    }
}

#[test]
fn fault_37_suspensions_anywhere_leave_the_end_pose_as_it_was_and_keep_the_limits() {
    let (_, undisturbed) = run(|_, _| {});
    let end = undisturbed.last().expect("recorded");
    for first in (5..500).step_by(7) {
        let (steps, trace) = run(move |step, operator| {
            if step == first || step == first + 400 {
                operator.suspend();
            }
            if step == first + 300 || step == first + 800 {
                operator.resume();
            }
        });
        assert!((trace.last().expect("recorded") - end).norm() < 1e-9, "suspended at {first}");
        let (v, a) = peaks(&trace, 1e-3);
        assert!(v <= 1.0 && a <= 10.0 + 1e-6, "suspended at {first}: {v} m/s, {a} m/s²");
        assert!(steps > 502, "suspended at {first}: {steps} steps");
    }
}

#[test]
fn a_suspended_robot_stands_still() {
    let (_, trace) = run(|step, operator| match step {
        200 => operator.suspend(),
        1200 => operator.resume(),
        _ => {}
    });
    // The rate falls by 5 a second at most: 0.2 s.
    assert!(trace[600..1190].windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn all_robots_of_a_motion_slow_down_in_the_same_step() {
    let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
    Cell::new(MS)
        .robot(left)
        .robot(right)
        .on_step(|step, operator| match step {
            150 => operator.suspend(),
            600 => operator.resume(),
            _ => {}
        })
        .program(|mp| {
            let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
            mp.move_robots((&mut left, &mut right), (), Twin(Smooth::to(0.3, 2.0))).map(drop)
        })
        .run()
        .expect("keeps the limits");
    let (left, right) = (left_trace.borrow(), right_trace.borrow());
    assert!(left.iter().zip(right.iter()).all(|(l, r)| l[0] == -r[0]));
    assert_eq!(left.last().expect("recorded")[0], 0.3);
}

#[test]
fn abort_stops_on_the_path_and_ends_the_instruction_with_a_fault() {
    for at in [30, 200, 430] {
        let (robot, trace) = gantry("g");
        let robot = robot.program(|ecp| ecp.move_robot((), Smooth::to(0.3, 0.5)).map(drop));
        let cell = Cell::new(MS).robot(robot).on_step(move |step, operator| {
            if step == at {
                operator.abort();
            }
        });
        let fault = fault(cell.run());
        assert_eq!(fault.kind(), FaultKind::Aborted);
        let trace = trace.borrow();
        let (_, a) = peaks(&trace, 1e-3);
        assert!(a <= 10.0 + 1e-6, "{a}");
        let last = trace.last().expect("recorded")[0];
        // What the last step moved, the next one may not have to take away in more than the limit: a T².
        assert!((at > 400 || last < 0.3) && (trace[trace.len() - 2][0] - last).abs() <= 1e-5);
    }
}

/// Drives that a person at the robot's pendant slows down in some of their periods.
struct Slowed {
    drives: ExactDrive<3>,
    periods: u64,
    scaling: fn(u64) -> f64,
}

impl Driver<Gantry> for Slowed {
    fn period(&self) -> Duration {
        MS
    }

    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Driver::<Gantry>::measured(&self.drives)
    }

    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        self.periods += 1;
        Driver::<Gantry>::tick(&mut self.drives, demanded)
    }

    fn speed_scaling(&self) -> f64 {
        (self.scaling)(self.periods)
    }
}

/// The demands of a robot that is slowed down, and of one that moves together with it.
fn slowed(scaling: fn(u64) -> f64) -> [Vec<Q<3>>; 2] {
    let drives = Slowed { drives: ExactDrive::at_origin(), periods: 0, scaling };
    let (first, first_trace) = traced(RobotSetup::new("g", Gantry::default(), drives));
    let (second, second_trace) = gantry("h");
    let cell = Cell::new(MS).robot(first).robot(second).program(|mp| {
        let (mut g, mut h) = (mp.robot::<Gantry>("g")?, mp.robot::<Gantry>("h")?);
        mp.move_robots((&mut g, &mut h), (), Twin(Smooth::to(0.3, 2.0))).map(drop)
    });
    cell.run().expect("keeps the limits");
    [first_trace.take(), second_trace.take()]
}

#[test]
fn a_robot_that_is_slowed_down_at_its_pendant_slows_the_path_of_all() {
    let [full, _] = slowed(|_| 1.0);
    // Half as fast for a while, then stopped, then as planned.
    let [first, second] = slowed(|period| match period {
        300..900 => 0.5,
        900..1500 => 0.0,
        _ => 1.0,
    });
    let mirrored: Vec<_> = second.iter().map(|q| -q).collect();
    assert_eq!(first, mirrored, "both at one place of the path at one time");
    let speed = |trace: &[Q<3>], from: usize, to: usize| peaks(&trace[from..to], 1e-3).0;
    let fastest = speed(&full, 0, full.len());
    // It comes to half the rate within a tenth of a second, and to a standstill in another one.
    assert!(speed(&first, 450, 890) <= 0.5 * fastest + 1e-6);
    assert!(speed(&first, 1050, 1490) == 0.0 && speed(&first, 450, 890) > 0.0);
    let (v, a) = peaks(&first, 1e-3);
    assert!(v <= 1.0 && a <= 10.0 + 1e-6, "{v} m/s, {a} m/s²");
    assert!((first[first.len() - 1] - full[full.len() - 1]).norm() < 1e-12);
    // What no share of a speed is says nothing.
    let [odd, _] = slowed(|period| if period % 2 == 0 { f64::NAN } else { 7.0 });
    assert_eq!(odd, full);
}
