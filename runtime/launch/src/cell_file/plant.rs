//! What `plant = { port = ".." }` says of a robot that moves in a simulator that others wrote.

use core::ops::Range;
use core::time::Duration;
use std::rc::Rc;

use mrroc_core::cell::{CellError, NoSimulator};

use super::error::Source;

/// A robot in a simulator of others, as the cell file describes it.
#[derive(Clone, Debug)]
pub struct PlantEntry {
    pub(super) source: Rc<Source>,
    pub(super) robot: String,
    pub(super) port: String,
    pub(super) span: Range<usize>,
    pub(super) timeout: Duration,
    /// The robots of this port, this one among them, in the order of the file.
    pub(super) robots: Vec<String>,
}

impl PlantEntry {
    /// How long a simulator is waited for if the file does not say it.
    pub(super) const TIMEOUT: Duration = Duration::from_secs(10);

    /// The robot's name.
    #[must_use]
    pub fn robot(&self) -> &str {
        &self.robot
    }

    /// `port`: the name by which the simulator finds the robot. Robots with the same one are in one simulator.
    #[must_use]
    pub fn port(&self) -> &str {
        &self.port
    }

    /// The robots of the cell that are in this simulator, in the order of the file.
    #[must_use]
    pub fn robots(&self) -> &[String] {
        &self.robots
    }

    /// `timeout_ms`: how long the simulator is waited for, when the cell begins and, under the virtual clock, in each servo
    /// period.
    #[must_use]
    pub const fn timeout(&self) -> Duration {
        self.timeout
    }

    /// Refuses a robot whose own drives are real, or do not know where it is.
    pub(super) fn refuse_drives(&self, why: &NoSimulator, kind: &str) -> CellError {
        let robot = &self.robot;
        let (what, help) = match why {
            NoSimulator::Real(hardware) => (
                format!("robot `{robot}` has real drives, {hardware}, and a simulator"),
                format!("leave `plant` out, or give it a kind that is simulated in the place of `{kind}`"),
            ),
            NoSimulator::Unhomed => (
                format!("robot `{robot}` looks for its reference marks, and is in a simulator"),
                "leave `plant` out, or leave homed = false out".to_owned(),
            ),
        };
        self.source.complain(&self.span, what, help).into()
    }

    /// Refuses a robot in a simulator, of which the program knows nothing.
    pub(super) fn refuse_unknown(&self) -> CellError {
        let what = format!("robot `{}` is in a simulator, and this program has no port for one", self.robot);
        let help = "write `simulated().plants(mrroc_external::plant)` for the kinds in the program, or leave `plant` out";
        self.source.complain(&self.span, what, help.to_owned()).into()
    }

    /// Refuses robots of one simulator with different servo periods.
    pub(super) fn refuse_period(&self, period: Duration, other: &str, theirs: Duration) -> CellError {
        let ms = |period: Duration| period.as_secs_f64() * 1e3;
        let what = format!(
            "robots `{other}` and `{}` share a simulator and have servo periods of {} ms and {} ms",
            self.robot,
            ms(theirs),
            ms(period)
        );
        let help = "give one of them another `port`".to_owned();
        self.source.complain(&self.span, what, help).into()
    }
}
