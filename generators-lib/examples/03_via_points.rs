//! The tool of an arm goes round a square on straight lines without a stop, past each corner within 5 mm.
//!
//! `cargo run -p mrroc-examples --example 03_via_points`

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::observe::ServoRecord;
use mrroc::prelude::*;
use mrroc_generators::generators::LineVia;
use mrroc_generators::line::SmoothToolLimits;
use mrroc_generators::profile::JerkLimits;
use mrroc_generators::via::PoseDeviation;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use nalgebra::Vector3;

/// Time between two servo periods of the simulated drives \[s\].
pub const PERIOD: f64 = 0.002;

/// How near the tool passes a corner \[m\].
const DEVIATION: f64 = 0.005;

const LIMITS: JerkLimits = JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 };

/// The corners, and the start again at the end, from where the tool starts, in the tool's own axes \[m\].
pub const CORNERS: [Vector3<f64>; 4] = [
    Vector3::new(0.08, 0.0, 0.0),
    Vector3::new(0.08, 0.08, 0.0),
    Vector3::new(0.0, 0.08, 0.0),
    Vector3::new(0.0, 0.0, 0.0),
];

/// Where the tool is demanded to be in every servo period, from where it starts, in the tool's own axes \[m\].
pub fn path() -> Result<Vec<Vector3<f64>>, CellError> {
    let irp6 = Irp6::nominal();
    let joints = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let start = irp6.forward(&joints);
    let poses = CORNERS.map(|p| start * Pose::translation(p.x, p.y, p.z)).to_vec();
    let deviation = PoseDeviation { distance: DEVIATION, angle: 0.05 };
    let limits = SmoothToolLimits { translation: LIMITS, rotation: LIMITS };

    let recorded = Rc::new(RefCell::new(Vec::new()));
    let recorder = Rc::clone(&recorded);
    let robot = RobotSetup::new("irp6", irp6.clone(), SimulatedIrp6::new(irp6.clone(), &joints))
        .observe(move |record: &ServoRecord<Irp6>| {
            let tool = irp6.forward(&record.demanded);
            recorder.borrow_mut().push(start.inv_mul(&tool).translation.vector);
        })
        .program(move |ecp| ecp.move_robot((), LineVia::through(poses.clone(), deviation, limits)).map(drop));
    Cell::new(Duration::from_secs_f64(PERIOD)).robot(robot).run()?;
    Ok(recorded.take())
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault.
pub fn main() -> Result<(), CellError> {
    let path = path()?;
    for corner in &CORNERS[..3] {
        let nearest = path.iter().map(|p| (p - corner).norm()).fold(f64::INFINITY, f64::min);
        println!("passes ({:.2}, {:.2}) at {:.2} mm", corner.x, corner.y, 1e3 * nearest);
        // The corner is cut, but no more than allowed; the encoders count the start to 10 um.
        assert!(nearest > 1e-4 && nearest <= DEVIATION + 1e-5);
    }
    // Sooner than with a stop at each corner: four times D / V + V / A + A / J.
    let moving = path.windows(2).filter(|p| (p[1] - p[0]).norm() > 1e-9).count();
    let JerkLimits { velocity, acceleration, jerk } = LIMITS;
    let with_stops = 4.0 * (0.08 / velocity + velocity / acceleration + acceleration / jerk);
    println!("takes {:.2} s, and {with_stops:.2} s with a stop at each corner", moving as f64 * PERIOD);
    assert!((moving as f64) * PERIOD < with_stops - 0.3);
    assert!(path.windows(2).all(|p| (p[1] - p[0]).norm() / PERIOD <= velocity * (1.0 + 1e-3)));
    Ok(())
}
