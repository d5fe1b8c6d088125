//! Follows the extrapolated place of a part until it comes between the fingers.

use mrroc::prelude::*;
use mrroc_robots::Irp6;
use nalgebra::Vector3;

use super::Senses;
use super::chase::{Chase, Missed, Part};
use crate::places::{BEAM, END, HIGH, LOW};

/// Follows a part: so that the beam between the fingers is ahead of its leading edge, and free; down; and then slower than the belt, so
/// that the part comes into the beam. Where it does is where it is: the error of the extrapolation is gone. A part that does not
/// come where it is expected, as after a belt has stopped, is let pass.
///
/// In open loop it goes down at the middle instead, and stays there.
pub struct Follow {
    chase: Chase,
    /// For how long it has waited for the part, down there \[s\].
    meeting: Option<f64>,
}

impl Follow {
    /// How far ahead of the part the beam goes down \[m\] ..
    pub const AHEAD: f64 = 0.012;
    /// .. how much slower than the belt it then is [m/s] ..
    pub const SLOWER: f64 = 0.04;
    /// .. and by how much the part may be off where it is expected \[m\].
    pub const TOLERANCE: f64 = 0.009;

    /// Follows the part that gate and range finder tell when it begins.
    #[must_use]
    pub fn new(chase: Chase) -> Self {
        Self { chase, meeting: None }
    }

    /// Where the tool is to be ahead of the part's middle, and how fast beside it.
    fn ahead(&self, part: &Part) -> (f64, f64) {
        let front = 0.5 * part.length + Self::AHEAD - BEAM;
        match (self.chase.open, self.meeting) {
            (Some(_), _) => (0.0, 0.0),
            (None, None) => (front, 0.0),
            (None, Some(time)) => (front - Self::SLOWER * time, -Self::SLOWER),
        }
    }
}

#[generator(ecp)]
impl Follow {
    fn first_step(&mut self, v: &Reading<Senses>, t: Tick) -> Result<Step<Irp6>, Fault> {
        let (Some(gate), Some(range)) = (v.0.reading(), v.1.reading()) else {
            return Err(Fault::thrown("a part is followed only once gate and range finder have told it"));
        };
        // Both are brought to the same time: that of the gate.
        let age = f64::from(v.0.age()) * t.duration;
        self.chase.part.set(Some(Part::seen(&gate, &range, age, self.chase.open)));
        self.chase.missed.set(None);
        self.meeting = None;
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<Senses>, t: Tick) -> Result<Step<Irp6>, Fault> {
        let Some(part) = self.chase.part.get() else { return Ok(self.chase.miss(Missed::Lost)) };
        let part = part.after(t.dt);
        self.chase.part.set(Some(part));
        let (ahead, slower) = self.ahead(&part);
        if part.s + ahead > END {
            return Ok(self.chase.miss(Missed::TooFar));
        }
        let beyond = 0.5 * part.length - BEAM - Self::TOLERANCE - Self::SLOWER * 0.02;
        if ahead < beyond && self.chase.open.is_none() {
            // The beam is beyond where the edge was expected, and the reading of that is old enough.
            return Ok(self.chase.miss(Missed::NotThere));
        }
        let tool = self.chase.tool.get();
        let off = (tool.at.x - part.s - ahead).hypot(tool.at.y - part.across);
        let drifting = (tool.velocity.x - part.speed - slower).abs();
        // Down only where it is over the place and goes with it; once down it stays down.
        let down = tool.at.z < 0.5 * HIGH || (off < 0.004 && drifting < 0.02);
        if let Some(time) = &mut self.meeting {
            *time += t.dt;
        } else if tool.at.z < LOW + 0.002 && off < 0.002 {
            self.meeting = Some(0.0);
        }
        let _ = v;
        let over = if down { LOW } else { HIGH };
        Ok(self.chase.pursue(Vector3::new(part.s + ahead, part.across, over), part.speed + slower, t.dt))
    }
}
