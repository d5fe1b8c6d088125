//! Waits where parts come.

use mrroc::prelude::*;
use mrroc_robots::Irp6;
use nalgebra::Vector3;

use super::Senses;
use super::chase::Chase;
use crate::places::{HIGH, HOME};

/// Goes to where the arm waits, and stays there. The barrier between the fingers must be open meanwhile.
pub struct Wait(pub Chase);

#[generator(ecp)]
impl Wait {
    fn next_step(&mut self, v: &Reading<Senses>, t: Tick) -> Result<Step<Irp6>, Fault> {
        // Up here nothing can be between the fingers.
        if v.2.reading().is_some_and(|fingers| fingers.covered) && self.0.tool.get().at.z > 0.5 * HIGH {
            return Err(Fault::thrown(
                "the barrier between the fingers is covered where nothing can be: clean it, or mend it",
            ));
        }
        Ok(self.0.pursue(Vector3::new(HOME, 0.0, HIGH), 0.0, t.dt))
    }
}
