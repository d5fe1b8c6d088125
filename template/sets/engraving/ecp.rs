//! The robot: what it does in each phase that the coordinator orders.

use mrroc::prelude::*;
use mrroc_generators::generators::{GuardedApproach, StraightLine};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use nalgebra::Vector3;

use crate::arm::Arm;
use crate::generators::{DEPTH, rosette};
use crate::orders::Phase;
use crate::touch::{Contact, Touch};

/// Gives the robot its program.
pub fn programs(cell: Cell) -> Cell {
    cell.ecp("arm", arm) // named as in cell.toml
}

fn arm(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    let mut plate = Pose::identity();
    ecp.serve_all(|ecp, phase: Phase| match phase {
        Phase::FindPlate => find_plate(ecp).map(|found| plate = found),
        Phase::Engrave => engrave(ecp, &plate),
        Phase::Park => ecp.move_robot((), up(0.05, 0.1)).map(drop),
    })
}

/// FILL IN: how the plate is found; here, by going down until the tool touches it, twice. Returns where.
fn find_plate(ecp: &mut Ecp<Arm>) -> Result<Pose, Fault> {
    let mut touch = ecp.sensor::<Touch>("touch")?;
    let mut plate = Pose::identity();
    for (speed, back) in [(0.01, 0.001), (0.001, 0.002)] {
        let down = -Vector3::z_axis();
        let approach = GuardedApproach::along(down, speed, 0.2, 0.1, |contact: &Contact| contact.made);
        ecp.move_robot((&mut touch,), approach)?;
        plate = ecp.image().demanded().pose;
        ecp.move_robot((), up(back, 0.02))?;
    }
    Ok(plate)
}

/// FILL IN: what is engraved; here, one curve that begins and ends in the middle of the plate.
fn engrave(ecp: &mut Ecp<Arm>, plate: &Pose) -> Result<(), Fault> {
    ecp.move_robot((), up(-0.002 - DEPTH, 0.005))?;
    ecp.move_robot((), rosette(plate)?)?;
    ecp.move_robot((), up(0.002 + DEPTH, 0.02)).map(drop)
}

/// By so many metres at so many metres per second; the tool's z axis points down.
fn up(height: f64, velocity: f64) -> StraightLine<Arm> {
    let limits = ProfileLimits { velocity, acceleration: 0.2 };
    let limits = ToolLimits { translation: limits, rotation: limits };
    StraightLine::by(Pose::translation(0.0, 0.0, -height), limits)
}
