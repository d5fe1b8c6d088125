//! Two arms carry one body, which turns meanwhile: the pose of one tool relative to the other stays what it was.
//!
//! `cargo run -p mrroc-examples --example 04_two_arms_carry`

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::observe::ServoRecord;
use mrroc::prelude::*;
use mrroc_generators::cooperation::{BodyFrame, StraightBody};
use mrroc_generators::generators::RigidCarry;
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use nalgebra::Vector3;

/// Time between two servo periods of the simulated drives \[s\].
pub const PERIOD: f64 = 0.002;

/// `X_WE` of both tools as they are demanded to be, in every servo period.
pub fn tools() -> Result<[Vec<Pose>; 2], CellError> {
    let joints = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    // They stand 1.8 m apart, face each other, and hold the body between them.
    let facing = Pose::translation(1.8, 0.0, 0.0) * Pose::rotation(Vector3::z() * std::f64::consts::PI);
    let recorded: [Rc<RefCell<Vec<Pose>>>; 2] = Default::default();
    let arm = |name: &str, irp6: Irp6, recorder: &Rc<RefCell<Vec<Pose>>>| {
        let recorder = Rc::clone(recorder);
        RobotSetup::new(name, irp6.clone(), SimulatedIrp6::new(irp6.clone(), &joints)).observe(
            move |record: &ServoRecord<Irp6>| recorder.borrow_mut().push(irp6.forward(&record.demanded)),
        )
    };
    Cell::new(Duration::from_secs_f64(PERIOD))
        .robot(arm("left", Irp6::nominal(), &recorded[0]))
        .robot(arm("right", Irp6::nominal().with_base(facing), &recorded[1]))
        .program(|mp| {
            let mut left = mp.robot::<Irp6>("left")?;
            let mut right = mp.robot::<Irp6>("right")?;
            let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
            let limits = ToolLimits { translation: limits, rotation: limits };
            let path = StraightBody::by(Pose::new(Vector3::new(0.0, 0.05, 0.1), Vector3::z() * 0.2), limits);
            let carry = RigidCarry::along(BodyFrame::Centroid, path);
            mp.move_robots((&mut left, &mut right), (), carry).map(drop)
        })
        .run()?;
    Ok(recorded.map(|tool| tool.take()))
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), CellError> {
    let [left, right] = tools()?;
    assert_eq!(left.len(), right.len());
    let between = left[0].inv_mul(&right[0]);
    let mut farthest: f64 = 0.0;
    for (left, right) in left.iter().zip(&right) {
        let off = between.inv_mul(&left.inv_mul(right));
        farthest = farthest.max(off.translation.vector.norm()).max(off.rotation.angle());
    }
    println!("one tool moves against the other by at most {farthest:.1e} m and rad");
    assert!(farthest < 1e-9);
    // The body, midway between the tools, has gone where it was sent.
    let middle = |i: usize| (left[i].translation.vector + right[i].translation.vector) * 0.5;
    let displacement = middle(left.len() - 1) - middle(0);
    assert!((displacement - Vector3::new(0.0, 0.05, 0.1)).norm() < 1e-9, "{displacement}");
    let turn = left[left.len() - 1].rotation * left[0].rotation.inverse();
    assert!((turn.scaled_axis() - Vector3::z() * 0.2).norm() < 1e-9);
    Ok(())
}
