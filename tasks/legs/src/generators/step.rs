//! One footstep, the coordinator's motion of all four legs: tight, in every step.
//!
//! The swinging leg is part of the same Move as those that stand, and no loose order: while it comes down the trunk goes on, so its foot must
//! move in the trunk as the standing ones do, in the same steps, or it would be dragged over the ground from its touch until the next order.
//! All four follow from one motion of the trunk.

use std::rc::Rc;

use mrroc::prelude::*;
use nalgebra::Vector2;

use crate::ground::Ground;
use crate::leg::Leg;
use crate::places::NAMES;
use crate::plant::{FootForces, Level};
use crate::walk::{FootholdPlan, Footstep, Gait, Part, Stance};

/// The machine's legs, in the order of [`NAMES`].
pub type Legs = [Leg; 4];

/// A foot has come to the ground where more than this bears on it \[N\].
const TOUCHED: f64 = 15.0;

/// One footstep: learns how the machine stands, plans, and moves the trunk and one foot.
pub struct Stride {
    gait: Gait,
    part: Part,
    hold: Option<(usize, Vector2<f64>)>,
    legs: Legs,
    ground: Rc<Ground>,
    plan: Option<Footstep>,
    t: f64,
}

impl Stride {
    /// This part of the gait, by this plan, over ground that is told to be so.
    #[must_use]
    pub fn new(gait: Gait, part: Part, plan: &FootholdPlan, legs: Legs, ground: Rc<Ground>) -> Self {
        let hold = match part {
            Part::Footstep(number) => plan.hold(number).map(|hold| (Gait::leg(number), *hold)),
            Part::SetOff | Part::Halt => None,
        };
        Self { gait, part, hold, legs, ground, plan: None, t: 0.0 }
    }

    /// What it did.
    #[must_use]
    pub const fn plan(&self) -> Option<&Footstep> {
        self.plan.as_ref()
    }
}

#[generator(mp)]
impl Stride {
    fn first_step(
        &mut self,
        e: &State<[Leg; 4]>,
        v: &Reading<(FootForces, Level)>,
        t: Tick,
    ) -> Result<Step<[Leg; 4]>, Fault> {
        let feet = e.demanded_poses().map(|foot| foot.translation.vector);
        let lean = v.1.reading().ok_or_else(|| Fault::thrown("the inclinometer tells nothing"))?;
        let q = core::array::from_fn(|i| e[i].demanded().joints);
        let stance = Stance { q, feet, lean: [lean.roll, lean.pitch] };
        let plan = Footstep::plan(&self.gait, self.part, self.hold, &self.legs, &self.ground, &stance);
        self.plan = Some(plan.map_err(|refused| Fault::thrown(&refused.to_string()))?);
        self.t = 0.0;
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<(FootForces, Level)>, t: Tick) -> Result<Step<[Leg; 4]>, Fault> {
        let Some(plan) = &mut self.plan else { return Ok(Step::Done) };
        let over = self.t + 0.5 * t.dt > plan.lasts();
        if let Some((leg, swing)) = plan.swing_mut()
            && !swing.has_touched()
        {
            let bears = v.0.reading().is_some_and(|forces| forces.up[*leg] > TOUCHED);
            if bears && swing.may_touch(self.t) {
                swing.touch(self.t);
            } else if over {
                let (leg, low) = (NAMES[*leg], 1e3 * (swing.to().z - swing.at(self.t).z));
                let text =
                    format!("{leg} found no ground, {low:.0} mm below where it should be: see what is there");
                return Err(Fault::thrown(&text));
            }
        }
        if over {
            return Ok(Step::Done);
        }
        self.t += t.dt;
        Ok(Step::Next(plan.feet(self.t).map(|foot| Demand::pose(Pose::translation(foot.x, foot.y, foot.z)))))
    }
}
