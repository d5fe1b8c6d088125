//! Joint states, one after another, as one trajectory.
//!
//! In: messages of a topic. Out: a trajectory whose points are the positions at the times of their stamps, the first one at 0. Messages of one stamp
//! are one point, such as those of several robots; stamps at which not all joints were told are left out.

use std::collections::BTreeMap;

use mrroc_core::console::complain;

use crate::messages::{Header, JointState};
use crate::trajectories::{Duration, Point, Trajectory};

/// The most joints that the messages of a topic may name.
const MOST_JOINTS: usize = 256;

/// What was told so far.
#[derive(Debug, Default)]
pub struct Series {
    names: Vec<String>,
    /// The joints and positions of each stamp \[ns\].
    told: BTreeMap<i64, Vec<(usize, f64)>>,
}

impl Series {
    /// Takes a message that was logged at a date \[ns\].
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn take(&mut self, date: u64, state: &JointState) -> Result<(), String> {
        if state.name.len() != state.position.len() {
            return Err(format!("{} positions for {} joints", state.position.len(), state.name.len()));
        }
        if state.name.len() > MOST_JOINTS {
            return Err(too_many());
        }
        let stamp = state.header.stamp;
        let stamp = match (stamp.sec, stamp.nanosec) {
            (0, 0) => date.cast_signed(),
            (sec, nanosec) => i64::from(sec) * 1_000_000_000 + i64::from(nanosec),
        };
        let at = self.told.entry(stamp).or_default();
        for (name, &position) in state.name.iter().zip(&state.position) {
            let known = self.names.iter().position(|known| known == name);
            let joint = match known {
                Some(joint) => joint,
                None if self.names.len() == MOST_JOINTS => return Err(too_many()),
                None => {
                    self.names.push(name.clone());
                    self.names.len() - 1
                }
            };
            match at.iter_mut().find(|(told, _)| *told == joint) {
                Some(told) => told.1 = position,
                None => at.push((joint, position)),
            }
        }
        Ok(())
    }

    /// The trajectory, with points that are at least so far apart \[s\]; the last one is always there.
    ///
    /// # Errors
    /// It has no points: at no stamp all joints are told.
    pub fn trajectory(self, every: f64) -> Result<Trajectory, String> {
        let joints = self.names.len();
        let stamps = self.told.len();
        let left_out = self.told.values().filter(|told| told.len() != joints).count();
        if left_out > 0 {
            let often =
                |joint: usize| self.told.values().flatten().filter(|(told, _)| *told == joint).count();
            let rarest = (0..joints).min_by_key(|&joint| often(joint)).unwrap_or_default();
            let (name, often) = (&self.names[rarest], often(rarest));
            let what =
                format!("{left_out} of {stamps} stamps lack a joint: `{name}` is told at {often} of them");
            if left_out == stamps {
                return Err(format!("{what}\n help: name a topic that tells all of its joints at one stamp"));
            }
            complain(&format!("note: {what}; they are left out"));
        }
        let mut whole = self.told.into_iter().filter(|(_, told)| told.len() == joints).peekable();
        let &(first, _) = whole.peek().ok_or("it has no message")?;
        let every = (every * 1e9).round() as i64;
        let mut points: Vec<(i64, Point)> = Vec::new();
        while let Some((stamp, mut told)) = whole.next() {
            let time = stamp.saturating_sub(first);
            let is_last = whole.peek().is_none();
            let is_near = points.last().is_some_and(|(last, _)| time - last < every);
            if is_near && !is_last {
                continue;
            }
            if is_near && points.len() > 1 {
                points.pop();
            }
            told.sort_unstable_by_key(|(joint, _)| *joint);
            let time_from_start = Duration::of(time).ok_or("its stamps are too far apart")?;
            let positions = told.into_iter().map(|(_, position)| position).collect();
            points.push((time, Point { positions, time_from_start, ..Point::default() }));
        }
        let points = points.into_iter().map(|(_, point)| point).collect();
        Ok(Trajectory { header: Header::default(), joint_names: self.names, points })
    }
}

fn too_many() -> String {
    format!("the messages name more than {MOST_JOINTS} joints")
}
