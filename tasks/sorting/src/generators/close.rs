//! Goes with the part at its middle while the hand closes.

use mrroc::prelude::*;
use mrroc_robots::Irp6;
use nalgebra::Vector3;

use super::Senses;
use super::chase::{Chase, Missed, Part};
use super::follow::Follow;
use crate::places::{BEAM, END, HIGH, LOW};

/// From the moment in which the part has come between the fingers: corrects its place by where its leading edge met the beam, and goes with
/// its middle until the hand has closed. What comes between the fingers elsewhere than expected is let pass.
pub struct Close {
    chase: Chase,
    age: f64,
}

impl Close {
    /// How long the hand takes: it waits, so that a part that is let pass is out of the fingers before; it closes \[s\].
    pub const WAITING: f64 = 0.3;
    /// See [`WAITING`](Self::WAITING).
    pub const CLOSING: f64 = 0.8;

    /// With the part that is followed.
    #[must_use]
    pub fn new(chase: Chase) -> Self {
        Self { chase, age: 0.0 }
    }
}

#[generator(ecp)]
impl Close {
    fn first_step(&mut self, v: &Reading<Senses>, t: Tick) -> Result<Step<Irp6>, Fault> {
        let tool = self.chase.tool.get();
        if tool.at.z > 0.5 * HIGH {
            return Err(Fault::thrown(
                "the barrier between the fingers is covered where nothing can be: clean it, or mend it",
            ));
        }
        let (Some(part), Some(fingers)) = (self.chase.part.get(), v.2.reading()) else {
            return Ok(self.chase.miss(Missed::Elsewhere));
        };
        if self.chase.open.is_none() {
            // How long before the demand of the last step is attained the edge met the beam: both moved evenly since then.
            let since = fingers.since + f64::from(v.2.age()) * t.duration + Part::DELAY - t.duration;
            let met = tool.at.x + BEAM - tool.velocity.x * since;
            let expected = part.s - part.speed * since + 0.5 * part.length;
            if (met - expected).abs() > Follow::TOLERANCE {
                return Ok(self.chase.miss(Missed::Elsewhere));
            }
            self.chase.part.set(Some(Part { s: part.s + met - expected, ..part }));
        }
        self.age = 0.0;
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<Senses>, t: Tick) -> Result<Step<Irp6>, Fault> {
        let Some(part) = self.chase.part.get() else { return Ok(self.chase.miss(Missed::Lost)) };
        if !v.2.reading().is_some_and(|fingers| fingers.covered) {
            return Ok(self.chase.lose());
        }
        if self.age >= Self::WAITING + Self::CLOSING {
            return Ok(Step::Done);
        }
        let part = part.after(t.dt);
        if part.s > END {
            return Ok(self.chase.miss(Missed::TooFar));
        }
        self.chase.part.set(Some(part));
        self.age += t.dt;
        Ok(self.chase.pursue(Vector3::new(part.s, part.across, LOW), part.speed, t.dt))
    }
}
