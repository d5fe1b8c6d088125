//! Arms that carry a body, of which one has no demand that can be followed: both stay together until they stand.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use nalgebra::Vector3;

use super::arms_without_mp::{Arm, DURATION, Exact, Six, apart, displacement, slides_and_turns};
use crate::cell::{Cell, CellError, RobotSetup};
use crate::control::mp::Mp;
use crate::generator;
use crate::model::demand::Demand;
use crate::model::fault::{Fault, FaultKind};
use crate::model::list::State;
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::model::step::{Step, Tick};
use crate::observe::servo::ServoRecord;

/// What is wrong with the demand of the right arm.
#[derive(Clone, Copy, Debug)]
enum Wrong {
    /// It is 1 cm off.
    Off,
    NoNumber,
    /// There is none, because the generator throws.
    Thrown,
}

/// Carries a body in both hands, until what it demands of the right one is wrong.
struct Carry {
    t: f64,
    step: u64,
    wrong: (Wrong, u64),
    from: [Pose; 2],
}

#[generator(mp, first = grasp)]
#[allow(non_snake_case)]
fn carry(c: &mut Carry, t: Tick) -> Result<Step<(Arm, Arm)>, Fault> {
    if c.t >= DURATION {
        return Ok(Step::Done);
    }
    c.t = (c.t + t.dt).min(DURATION);
    c.step += 1;
    let X = displacement(c.t);
    let mut right = X * c.from[1];
    if c.step == c.wrong.1 {
        match c.wrong.0 {
            Wrong::Off => right.translation.x += 0.01,
            Wrong::NoNumber => right.translation.x = f64::NAN,
            Wrong::Thrown => return Err(Fault::thrown("no demand")),
        }
    }
    Ok(Step::Next((Demand::pose(X * c.from[0]), Demand::pose(right))))
}

fn grasp(c: &mut Carry, e: &State<(Arm, Arm)>, t: Tick) -> Result<Step<(Arm, Arm)>, Fault> {
    c.from = [e.0.demanded().pose, e.1.demanded().pose];
    carry(c, t)
}

/// The poses of both flanges, step by step, and the fault.
fn run(step: Duration, wrong: Wrong, at: u64) -> ([Vec<Pose>; 2], Fault) {
    let traces: [Rc<RefCell<Vec<Pose>>>; 2] = Default::default();
    let turned = Pose::new(Vector3::new(1.0, 0.8, 0.3), Vector3::new(0.3, -0.4, 2.0));
    let mut cell = Cell::new(step).program(move |mp: &mut Mp| {
        let (mut left, mut right) = (mp.robot::<Arm>("left")?, mp.robot::<Arm>("right")?);
        let carry = Carry { t: 0.0, step: 0, wrong: (wrong, at), from: [Pose::identity(); 2] };
        mp.move_robots((&mut left, &mut right), (), carry).map(drop)
    });
    for ((name, base), trace) in [("left", Pose::identity()), ("right", turned)].into_iter().zip(&traces) {
        let arm = Arm::on(base, slides_and_turns(10.0, 20.0));
        let (trace, model) = (Rc::clone(trace), arm.clone());
        let start = Six::new(0.1, 0.2, 0.3, 0.1, -0.2, 0.3);
        let keep = move |record: &ServoRecord<Arm>| trace.borrow_mut().push(model.forward(&record.demanded));
        cell = cell.robot(RobotSetup::new(name, arm, Exact(start, step)).observe(keep));
    }
    match cell.run() {
        Err(CellError::Fault(fault)) => (traces.map(|trace| trace.take()), fault),
        other => panic!("{step:?}, {wrong:?} at {at}: {other:?}"),
    }
}

#[test]
fn fault_82_arms_of_which_one_is_refused_a_demand_in_any_step_keep_their_relative_pose() {
    let (mut worst, mut moved) = (0.0_f64, 0.0_f64);
    for millis in [1, 2, 4, 10] {
        let step = Duration::from_millis(millis);
        let steps = (DURATION * 1e3) as u64 / millis;
        for at in (2..steps).step_by(if millis == 1 { 17 } else { 7 }) {
            for (wrong, kind) in [
                (Wrong::Off, None),
                (Wrong::NoNumber, Some(FaultKind::DemandNotFinite)),
                (Wrong::Thrown, Some(FaultKind::Program)),
            ] {
                let (traces, fault) = run(step, wrong, at);
                assert!(kind.is_none_or(|kind| fault.kind() == kind), "{wrong:?} at {at}: {fault}");
                let relative = traces[0][0].inv_mul(&traces[1][0]);
                for (a, b) in traces[0].iter().zip(&traces[1]) {
                    worst = worst.max(apart(&a.inv_mul(b), &relative));
                }
                assert!(worst <= 1e-9, "{step:?}, {wrong:?} at {at}: {worst}");
                moved = moved.max(apart(&traces[0][0], &traces[0][traces[0].len() - 1]));
            }
        }
    }
    println!("worst relative pose error {worst:.1e} m or rad");
    assert!(moved > 0.1, "nothing moved");
}
