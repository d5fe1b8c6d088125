//! The coordinator's program: stands, shifts the trunk over one side, walks, stands again.

use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_generators::cooperation::{BodyFrame, StraightBody};
use mrroc_generators::generators::RigidCarry;
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;

use crate::generators::{Legs, Stride};
use crate::ground::Ground;
use crate::leg::Leg;
use crate::places::hip;
use crate::plant::{FootForces, Level};
use crate::walk::{FootholdPlan, Gait};

/// All feet bear.
#[condition(mp)]
fn stands(v: &Reading<(FootForces,)>) -> bool {
    v.0.reading().is_some_and(|forces| forces.up.iter().all(|force| *force > 20.0))
}

/// Walks by this gait over ground that is told to be so.
///
/// # Errors
/// The first fault of the cell; a footstep that would be unstable.
#[allow(non_snake_case)]
pub fn coordinate(mp: &mut Mp, gait: &Gait, ground: &Rc<Ground>) -> Result<(), Fault> {
    let (mut lf, mut rf) = (mp.robot::<Leg>("lf")?, mp.robot::<Leg>("rf")?);
    let (mut lh, mut rh) = (mp.robot::<Leg>("lh")?, mp.robot::<Leg>("rh")?);
    let (mut feet, mut level) = (mp.sensor::<FootForces>("feet")?, mp.sensor::<Level>("level")?);
    let legs: Legs = [0, 1, 2, 3].map(|i| Leg::at(hip(i)));
    let plan =
        FootholdPlan::plan(gait, &legs, ground).map_err(|refused| Fault::thrown(&refused.to_string()))?;
    mp.wait_until([&mut lf, &mut rf, &mut lh, &mut rh], (&mut feet,), stands {})?;
    // The ground is the body that the legs carry: to the right, so that the trunk goes to the left.
    let aside = StraightBody::by(Pose::translation(0.0, -gait.aside(0.0), 0.0), limits());
    let shift = RigidCarry::along(BodyFrame::InWorld(Pose::identity()), aside);
    mp.move_robots([&mut lf, &mut rf, &mut lh, &mut rh], (), shift)?;
    for part in gait.parts() {
        let stride = Stride::new(*gait, part, &plan, legs.clone(), Rc::clone(ground));
        mp.blend_robots([&mut lf, &mut rf, &mut lh, &mut rh], (&mut feet, &mut level), stride)?;
    }
    Ok(())
}

/// How fast the trunk may be shifted.
fn limits() -> ToolLimits {
    let limits = ProfileLimits { velocity: 0.1, acceleration: 0.3 };
    ToolLimits { translation: limits, rotation: limits }
}
