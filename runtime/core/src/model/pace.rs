//! Who says when the servo periods of a robot begin: the cell, or the robot.

use core::time::Duration;

/// Who says when the servo periods of some drives begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pace {
    /// The cell: its clock divides the time into periods, and the drives take a position in each of them. The period
    /// divides the step, or the step divides it.
    #[default]
    Cell,
    /// The robot: its controller counts periods on a clock of its own, and each of them begins with a message of it. The
    /// cell measures when, and how fast that clock goes, and gives each period the position for its end. The period may be
    /// of any length.
    Robot {
        /// How long the controller may say nothing before that is a fault of its drives. The other robots of the cell go on
        /// for so long: it is a part of the time that a stop takes, which `stop_ms` bounds.
        timeout: Duration,
    },
}

/// The servo periods of some drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServoPeriod {
    /// Their length; nominal where the robot paces itself.
    pub length: Duration,
    pub pace: Pace,
}

impl From<Duration> for ServoPeriod {
    /// Paced by the cell.
    fn from(length: Duration) -> Self {
        ServoPeriod { length, pace: Pace::Cell }
    }
}

/// The beginning of a servo period that the robot has told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pulse {
    /// The robot's own count of its periods: it goes on by one from period to period. Periods in between were lost in
    /// transit, or told while nobody asked.
    pub count: u64,
    /// How long the message had been here when it was asked for. It is best measured where the message comes in, by the
    /// kernel or a thread that only receives: the less it depends on when the cell asks, the smoother the robot moves.
    pub age: Duration,
}
