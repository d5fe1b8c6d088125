//! A rigid body in several grippers: relative poses over whole transfers, with every suspension.

use std::cell::Cell as Shared;
use std::rc::Rc;

use mrroc::fault::FaultKind;
use mrroc::generator::RobotHandle;
use mrroc::operator::Operator;
use mrroc::prelude::*;
use mrroc_generators::bspline::SplineSettings;
use mrroc_generators::cooperation::{BodyFrame, Displacement, SplineBody, StraightBody, TimedBody};
use mrroc_generators::feed::FeedLimits;
use mrroc_generators::generators::{RigidCarry, TransmitDisplacement};
use mrroc_generators::line::LinePath;
use mrroc_robots::{Irp6, Polycrank, Rnt, Seven, Six};
use nalgebra::Vector3;

use super::kit::{STEP, Trace, apart, arm, irp6_facing, irp6_start, limits, relative_error};

/// 45 mm and 0.1 rad: the turn takes D / V + V / A = 1 s.
fn by() -> Pose {
    Pose::new(Vector3::new(0.03, -0.015, 0.03), Vector3::new(0.0, 0.06, 0.08))
}

fn rnt_and_polycrank() -> (Cell, Trace, Trace) {
    let polycrank = Polycrank::new().with_base(Pose::translation(1.5, 0.4, 0.0));
    let (rnt, left, _) = arm("rnt", &Rnt::new(), &Six::new(0.1, 0.5, 0.55, 0.2, 1.3, 0.3));
    let (polycrank, right, _) =
        arm("polycrank", &polycrank, &Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]));
    (Cell::new(STEP).robot(rnt).robot(polycrank), left, right)
}

fn transfer(mp: &mut Mp) -> Result<(), mrroc::fault::Fault> {
    transfer_by(&mut mp.robot("rnt")?, &mut mp.robot("polycrank")?, mp)
}

fn transfer_by(
    rnt: &mut RobotHandle<Rnt>,
    polycrank: &mut RobotHandle<Polycrank>,
    mp: &mut Mp,
) -> Result<(), mrroc::fault::Fault> {
    let path = StraightBody::by(by(), limits());
    mp.move_robots((rnt, polycrank), (), RigidCarry::along(BodyFrame::Centroid, path)).map(drop)
}

/// What a run of the transfer keeps: relative poses to 1e-9, and the body on its line. Returns where the body ends.
fn check(left: &Trace, right: &Trace, what: &str) -> Pose {
    let (left, right) = (left.demanded.borrow(), right.demanded.borrow());
    let (rnt, polycrank) = (left[0], right[0]);
    let error = relative_error(&left, &right, &rnt.inv_mul(&polycrank));
    assert!(error.0 <= 1e-9 && error.1 <= 1e-9, "{what}: {error:?}");
    let start = BodyFrame::Centroid.pose(&[rnt, polycrank]);
    let line = LinePath::new(start, start * by());
    let held = start.inv_mul(&rnt);
    let displacement = (start * by()).translation.vector - start.translation.vector;
    let body = |tool: &Pose| tool * held.inverse();
    for tool in left.iter() {
        let moved = body(tool).translation.vector - start.translation.vector;
        let error = apart(&body(tool), &line.pose(moved.dot(&displacement) / displacement.norm_squared()));
        assert!(error.0 <= 1e-9 && error.1 <= 1e-8, "{what}: off the line by {error:?}");
    }
    body(left.last().expect("recorded"))
}

fn run(act: impl FnMut(u64, &Operator) + 'static, what: &str) -> (Pose, Pose) {
    let (cell, left, right) = rnt_and_polycrank();
    cell.program(transfer).on_step(act).run().unwrap_or_else(|error| panic!("{what}: {error}"));
    let end = check(&left, &right, what);
    let start = BodyFrame::Centroid.pose(&[left.demanded.borrow()[0], right.demanded.borrow()[0]]);
    (start, end)
}

#[test]
fn two_arms_of_different_kinds_keep_their_relative_pose_in_a_suspension_at_every_step() {
    let (start, end) = run(|_, _| {}, "undisturbed");
    let error = apart(&end, &(start * by()));
    assert!(error.0 <= 1e-9 && error.1 <= 1e-9, "{error:?}");
    // 500 steps; the last suspensions come after the end.
    for at in 1..520 {
        let what = format!("suspended at {at}");
        let act = move |step, operator: &Operator| {
            if step == at || step == at + 300 {
                operator.suspend();
            }
            // Once at standstill, once while it brakes.
            if step == at + 250 || step == at + 320 {
                operator.resume();
            }
        };
        let (_, disturbed) = run(act, &what);
        let error = apart(&disturbed, &end);
        assert!(error.0 <= 1e-9 && error.1 <= 1e-9, "{what}: {error:?}");
    }
}

#[test]
fn one_transfer_is_suspended_and_resumed_at_every_stage() {
    let act = |step, operator: &Operator| match step % 11 {
        3 => operator.suspend(),
        8 => operator.resume(),
        _ => {}
    };
    let (start, end) = run(act, "suspended and resumed");
    let error = apart(&end, &(start * by()));
    assert!(error.0 <= 1e-9 && error.1 <= 1e-9, "{error:?}");
}

#[test]
fn an_abort_brings_both_arms_to_rest_on_the_bodys_path() {
    for at in (2..490).step_by(11) {
        let (cell, left, right) = rnt_and_polycrank();
        let aborted = Rc::new(Shared::new(false));
        let seen = Rc::clone(&aborted);
        let cell = cell.program(move |mp| {
            let (mut rnt, mut polycrank) = (mp.robot::<Rnt>("rnt")?, mp.robot::<Polycrank>("polycrank")?);
            let ended = transfer_by(&mut rnt, &mut polycrank, mp);
            seen.set(ended.is_err_and(|fault| fault.kind() == FaultKind::Aborted));
            let rest = TimedBody::new(0.01, |_| Pose::identity());
            let rest = RigidCarry::along(BodyFrame::Centroid, rest);
            mp.move_robots((&mut rnt, &mut polycrank), (), rest).map(drop)
        });
        let cell = cell.on_step(move |step, operator| {
            if step == at {
                operator.abort();
            }
        });
        cell.run().unwrap_or_else(|error| panic!("aborted at {at}: {error}"));
        assert!(aborted.get(), "aborted at {at}");
        check(&left, &right, &format!("aborted at {at}"));
        let left = left.demanded.borrow();
        // Held for five steps, the last of which are all at one place.
        let (last, before) = (left[left.len() - 1], left[left.len() - 4]);
        assert!(apart(&last, &before).0 <= 1e-12, "aborted at {at}");
    }
}

#[test]
fn arms_as_measured_are_apart_by_what_their_drives_lag() {
    let (cell, left, right) = rnt_and_polycrank();
    cell.program(transfer).run().expect("within the limits");
    let relation = left.demanded.borrow()[0].inv_mul(&right.demanded.borrow()[0]);
    let error = relative_error(&left.measured.borrow(), &right.measured.borrow(), &relation);
    // Encoders' counts and the regulators' errors in acceleration, no accumulated drift.
    assert!(error.0 < 1e-3 && error.1 < 5e-3, "{error:?}");
}

/// Four arms around one body.
fn four(act: impl FnMut(u64, &Operator) + 'static) -> [Trace; 4] {
    let arms = [0, 1, 2, 3].map(|i| {
        let robot = irp6_facing(1.1, f64::from(i) * std::f64::consts::FRAC_PI_2);
        arm(["north", "west", "south", "east"][i as usize], &robot, &irp6_start())
    });
    let traces = arms.each_ref().map(|(_, trace, _)| trace.clone());
    let cell = arms.into_iter().fold(Cell::new(STEP), |cell, (setup, ..)| cell.robot(setup));
    let cell = cell.on_step(act).program(|mp| {
        let mut arms = [mp.robot("north")?, mp.robot("west")?, mp.robot("south")?, mp.robot("east")?];
        let path = StraightBody::by(by(), limits());
        let carry = RigidCarry::<[Irp6; 4], _>::along(BodyFrame::Centroid, path);
        mp.move_robots(arms.each_mut(), (), carry).map(drop)
    });
    cell.run().expect("within the limits");
    traces
}

#[test]
fn four_arms_hold_one_body_without_a_change() {
    for at in (1..510).step_by(31) {
        let traces = four(move |step, operator| match step {
            _ if step == at => operator.suspend(),
            _ if step == at + 250 => operator.resume(),
            _ => {}
        });
        let first = traces[0].demanded.borrow();
        for trace in &traces[1..] {
            let other = trace.demanded.borrow();
            let error = relative_error(&first, &other, &first[0].inv_mul(&other[0]));
            assert!(error.0 <= 1e-9 && error.1 <= 1e-9, "suspended at {at}: {error:?}");
        }
        let starts = traces.each_ref().map(|trace| trace.demanded.borrow()[0]);
        let ends = traces.each_ref().map(|trace| *trace.demanded.borrow().last().expect("recorded"));
        let (start, end) = (BodyFrame::Centroid.pose(&starts), BodyFrame::Centroid.pose(&ends));
        let error = end.translation.vector - start.translation.vector - by().translation.vector;
        assert!(error.norm() <= 1e-9, "suspended at {at}: {error}");
    }
}

#[test]
fn displacements_that_ecps_transmit_are_the_poses_that_transparent_ones_take() {
    let (cell, left, right) = rnt_and_polycrank();
    cell.program(transfer).run().expect("within the limits");
    let (poses, others) = (left.demanded.take(), right.demanded.take());
    let (cell, left, right) = rnt_and_polycrank();
    let cell = cell
        .ecp("rnt", |ecp: &mut mrroc::program::Ecp<Rnt>| {
            ecp.serve_all(|ecp, _: Displacement| ecp.move_robot((), TransmitDisplacement::new()).map(drop))
        })
        .ecp("polycrank", |ecp: &mut mrroc::program::Ecp<Polycrank>| {
            ecp.serve_all(|ecp, _: Displacement| ecp.move_robot((), TransmitDisplacement::new()).map(drop))
        });
    let cell = cell.program(|mp| {
        let (mut rnt, mut polycrank) = (mp.robot::<Rnt>("rnt")?, mp.robot::<Polycrank>("polycrank")?);
        let path = StraightBody::by(by(), limits());
        let carry = RigidCarry::along(BodyFrame::Centroid, path).by_displacements();
        mp.move_robots((&mut rnt, &mut polycrank), (), carry).map(drop)
    });
    cell.run().expect("within the limits");
    for (transmitted, transparent) in [(left, poses), (right, others)] {
        let transmitted = transmitted.demanded.borrow();
        let moving = |trace: &[Pose]| trace.iter().position(|pose| *pose != trace[0]).expect("it moves");
        let (a, b) = (&transmitted[moving(&transmitted)..], &transparent[moving(&transparent)..]);
        assert!(a.len().abs_diff(b.len()) <= 3);
        for (a, b) in a.iter().zip(b) {
            let error = apart(a, b);
            assert!(error.0 <= 1e-12 * 10.0 && error.1 <= 1e-12 * 10.0, "{error:?}");
        }
    }
}

#[test]
fn a_body_follows_a_spline_and_any_function_of_path_time() {
    let feed = FeedLimits {
        feed: 0.05,
        tangential: 0.25,
        normal: 0.25,
        step: 2e-3,
        chord_error: f64::INFINITY,
        jerk: f64::INFINITY,
    };
    let points = (0..=24).map(|i| f64::from(i) * 2e-3).map(|x| Vector3::new(x, 0.01 * (x * 60.0).sin(), 0.0));
    let points: Vec<_> = points.collect();
    let end = *points.last().expect("points");
    let spline = SplineBody::through(points, SplineSettings::default(), feed).expect("in range");
    // A smooth turn (of fifth order) about the body's z, with a heave.
    let turn = TimedBody::new(1.2, |t: f64| {
        let u = t / 1.2;
        let s = u * u * u * (10.0 - u * (15.0 - 6.0 * u));
        Pose::new(Vector3::z() * 0.02 * s, Vector3::z() * 0.1 * s)
    });
    let (cell, left, right) = rnt_and_polycrank();
    let cell = cell.program(move |mp| {
        let (mut rnt, mut polycrank) = (mp.robot::<Rnt>("rnt")?, mp.robot::<Polycrank>("polycrank")?);
        mp.move_robots(
            (&mut rnt, &mut polycrank),
            (),
            RigidCarry::along(BodyFrame::Centroid, spline.clone()),
        )?;
        mp.move_robots((&mut rnt, &mut polycrank), (), RigidCarry::along(BodyFrame::Centroid, turn))?;
        Ok(())
    });
    cell.run().expect("within the limits");
    let (left, right) = (left.demanded.borrow(), right.demanded.borrow());
    let error = relative_error(&left, &right, &left[0].inv_mul(&right[0]));
    assert!(error.0 <= 1e-9 && error.1 <= 1e-9, "{error:?}");
    let body = |i: usize| BodyFrame::Centroid.pose(&[left[i], right[i]]);
    let displacement = body(left.len() - 1).translation.vector - body(0).translation.vector;
    assert!((displacement - end - Vector3::z() * 0.02).norm() < 1e-9, "{displacement}");
    assert!((left[0].rotation.angle_to(&left[left.len() - 1].rotation) - 0.1).abs() < 1e-9);
}
