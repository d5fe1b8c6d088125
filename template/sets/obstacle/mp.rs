//! The coordinator: motions around what stands in the cell, planned while it runs.

use core::f64::consts::PI;

use mrroc::prelude::*;
use mrroc_planning::{HereAll, Planner, goals_at};
use mrroc_robots::clearance::Clearance;
use nalgebra::Vector3;

use crate::arm::Arm; // the kind of robot

/// FILL IN: where the flange goes, one place after the other [m]; a box stands between these two.
pub const PLACES: [[f64; 3]; 2] = [[-0.4, 0.4, 0.2], [-0.4, -0.5, 0.2]];

/// FILL IN: what is done at each place.
pub fn coordinate(mp: &mut Mp, robot: &Arm, clearance: Clearance) -> Result<(), Fault> {
    let mut arm = mp.robot::<Arm>("arm")?; // named as in cell.toml
    let mut planner = Planner::new(clearance)?;
    for [x, y, z] in PLACES {
        let place = Pose::new(Vector3::new(x, y, z), Vector3::x() * PI); // with its z axis downwards
        let here = mp.wait_until((&mut arm,), (), HereAll::<(Arm,)>::default())?.joints();
        let goals = goals_at(robot, &place, &here); // any posture that gets it there
        let plan = mp.recorded("plan", || Ok(planner.plan(&here, &goals)?))?; // a replay does not plan again
        mp.move_robot(&mut arm, (), plan.motion("arm")?)?;
    }
    Ok(())
}
