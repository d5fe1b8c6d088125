//! The times of a cell: its step, how long stops may take, and what its processes ask of the machine.

use core::time::Duration;

use crate::control::interpolation;
use crate::model::pace::ServoPeriod;
use crate::safety::rate::DEFAULT_CHANGE;
use crate::safety::stopping::STOP_TIME;

use super::Realtime;

/// The times of a cell.
pub(super) struct Timing {
    /// Length of a step.
    pub step: Duration,
    /// The longest stop that it takes.
    pub stop_time: Duration,
    /// By how much the rate may change in a second.
    pub rate_change: f64,
    /// What its processes ask of the machine.
    pub realtime: Option<Realtime>,
    /// How long a process may compute on the memory link.
    pub watchdog: Option<Duration>,
    /// Whether a dry run comes before one in real time.
    pub dry_run: bool,
}

impl Timing {
    /// Of a cell of this step that says no more.
    pub const fn of_step(step: Duration) -> Timing {
        Timing {
            step,
            stop_time: STOP_TIME,
            rate_change: DEFAULT_CHANGE,
            realtime: None,
            watchdog: None,
            dry_run: false,
        }
    }

    /// How far drives are behind their demands, of robots with these servo periods; `None`: each takes every demand as it is.
    pub fn delay(&self, servos: impl Iterator<Item = ServoPeriod> + Clone) -> Option<Duration> {
        interpolation::delay(self.step, servos)
    }

    /// Steps in which the rate falls from the planned one to a standstill.
    pub fn rate_steps(&self) -> u64 {
        // `as` saturates: no float is out of range.
        (1.0 / (self.rate_change * self.step.as_secs_f64())).ceil() as u64
    }
}
