//! The tool of an arm goes exactly through four poses on one smooth curve, without a stop.
//!
//! `cargo run -p mrroc-examples --example 02_spline_through_points`

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::observe::ServoRecord;
use mrroc::prelude::*;
use mrroc_generators::generators::PoseSplineMove;
use mrroc_generators::line::SmoothToolLimits;
use mrroc_generators::profile::JerkLimits;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use nalgebra::Vector3;

/// Limits of the tool's velocity [m/s], acceleration [m/s^2] and jerk [m/s^3]; the same numbers in rad for its turns.
const LIMITS: JerkLimits = JerkLimits { velocity: 0.1, acceleration: 0.4, jerk: 4.0 };

/// Time between two servo periods of the simulated drives \[s\].
pub const PERIOD: f64 = 0.002;

/// Where the curve leads, from where the tool starts, in the tool's own axes \[m\].
pub const POINTS: [Vector3<f64>; 4] = [
    Vector3::new(0.06, 0.03, 0.0),
    Vector3::new(0.06, 0.09, -0.02),
    Vector3::new(0.0, 0.09, 0.02),
    Vector3::new(0.0, 0.0, 0.0),
];

/// Where the tool is demanded to be in every servo period, from where it starts, in the tool's own axes \[m\].
pub fn path() -> Result<Vec<Vector3<f64>>, CellError> {
    let irp6 = Irp6::nominal();
    let joints = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let start = irp6.forward(&joints);
    let poses = POINTS.map(|p| start * Pose::translation(p.x, p.y, p.z)).to_vec();
    let limits = SmoothToolLimits { translation: LIMITS, rotation: LIMITS };

    let recorded = Rc::new(RefCell::new(Vec::new()));
    let recorder = Rc::clone(&recorded);
    let robot = RobotSetup::new("irp6", irp6.clone(), SimulatedIrp6::new(irp6.clone(), &joints))
        .observe(move |record: &ServoRecord<Irp6>| {
            let tool = irp6.forward(&record.demanded);
            recorder.borrow_mut().push(start.inv_mul(&tool).translation.vector);
        })
        .program(move |ecp| ecp.move_robot((), PoseSplineMove::through(poses.clone(), limits)).map(drop));
    Cell::new(Duration::from_secs_f64(PERIOD)).robot(robot).run()?;
    Ok(recorded.take())
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), CellError> {
    let path = path()?;
    for point in &POINTS {
        let nearest = path.iter().map(|p| (p - point).norm()).fold(f64::INFINITY, f64::min);
        println!("passes ({:.2}, {:.2}, {:.2}) at {:.3} mm", point.x, point.y, point.z, 1e3 * nearest);
        // A point that is passed between two servo periods is at most half of what the tool moves in one away from the
        // nearer; and the encoders count the start to 10 um.
        assert!(nearest <= 0.5 * LIMITS.velocity * PERIOD + 1e-5);
    }
    // The tool keeps its limits, by differences of what is demanded.
    for p in path.windows(3) {
        assert!((p[1] - p[0]).norm() / PERIOD <= LIMITS.velocity * (1.0 + 1e-3));
        assert!((p[2] - p[1] * 2.0 + p[0]).norm() / (PERIOD * PERIOD) <= LIMITS.acceleration * (1.0 + 1e-2));
    }
    Ok(())
}
