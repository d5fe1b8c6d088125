//! Handles of robots and sensors: what they know, and whose they are.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::fault::FaultKind;
use mrroc::generator::RobotHandle;
use mrroc::prelude::*;
use mrroc_tests::{ExactDrive, Gantry, MS, fault};
use nalgebra::Vector3;

use crate::runtime::kit::x;

/// Holds the robot where it is, and counts how often.
#[derive(Default)]
struct Hold(u32);

#[generator(mp)]
fn hold(c: &mut Hold, _t: Tick) -> Step<(Gantry,)> {
    c.0 += 1;
    if c.0 > 3 { Step::Done } else { Step::Next((x(0.0),)) }
}

fn two(first: f64, second: f64) -> Cell {
    let robot = |name: &str, x: f64| {
        RobotSetup::new(name, Gantry::default(), ExactDrive::new(Vector3::new(x, 0.1, -0.1), MS))
    };
    Cell::new(MS).robot(robot("first", first)).robot(robot("second", second))
}

#[test]
fn fault_84_a_handle_knows_its_robots_state_from_the_start() {
    let report = two(0.25, -0.5)
        .program(|mp| {
            let (second, first) = (mp.robot::<Gantry>("second")?, mp.robot::<Gantry>("first")?);
            assert_eq!(first.measured().joints, Vector3::new(0.25, 0.1, -0.1));
            assert_eq!(second.demanded().joints, Vector3::new(-0.5, 0.1, -0.1));
            assert_eq!(second.demanded().pose.translation.vector, second.demanded().joints);
            Ok(())
        })
        .run()
        .expect("nothing moves");
    // No step is taken for it.
    assert!(report.steps <= 1, "{} steps", report.steps);
}

#[test]
fn fault_84_a_handle_of_another_cell_moves_nothing() {
    let kept: Rc<RefCell<Option<RobotHandle<Gantry>>>> = Rc::default();
    let keeps = Rc::clone(&kept);
    two(0.0, 0.0)
        .program(move |mp| {
            *keeps.borrow_mut() = Some(mp.robot("second")?);
            Ok(())
        })
        .run()
        .expect("nothing moves");
    let told = fault(
        two(0.0, 0.0)
            .program(move |mp| {
                let mut foreign = kept.borrow_mut().take().expect("kept");
                mp.move_robots((&mut foreign,), (), Hold::default()).map(drop)
            })
            .run(),
    );
    assert_eq!(told.kind(), FaultKind::Config, "{told}");
    assert_eq!(
        told.message(),
        "the handle of robot `second` is of another cell or program: ask this one for its own"
    );
}
