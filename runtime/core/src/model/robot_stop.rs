//! Why a robot stands although nobody here has stopped it: what its controller or a person beside it has done, and who may
//! clear that.

use core::fmt;

/// What has stopped a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopCause {
    /// Its controller has stopped it to protect it or what is around it: a collision, a demand that it does not take.
    ProtectiveStop = 1,
    /// It has refused a demand, or met a force, that is beyond its limits: a reflex.
    Reflex,
    /// It has not been told anything in time, or has not been heard.
    CommunicationLost,
    /// The program on its controller that takes demands does not run.
    ProgramNotRunning,
    /// Its drives have no power, or its brakes are applied.
    PowerOff,
    /// A guard has stopped it: a door, a light curtain, a scanner.
    Safeguard,
    /// An emergency stop.
    EmergencyStop,
    /// It was beyond a limit that its safety configuration monitors.
    Violation,
    /// A person guides it by hand.
    HandGuiding,
    /// It is operated from its pendant, which does not leave it to other programs.
    PendantInControl,
    /// Its controller has failed.
    Failure,
}

/// Who may clear what has stopped a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClearedBy {
    /// The operator of the cell: a reset does what the robot needs.
    Operator = 1,
    /// Whoever is at its pendant; then a reset.
    Pendant,
    /// A person at the robot, who sees that nobody is in danger; then a reset.
    PersonAtRobot,
}

impl StopCause {
    const ALL: [StopCause; 11] = [
        StopCause::ProtectiveStop,
        StopCause::Reflex,
        StopCause::CommunicationLost,
        StopCause::ProgramNotRunning,
        StopCause::PowerOff,
        StopCause::Safeguard,
        StopCause::EmergencyStop,
        StopCause::Violation,
        StopCause::HandGuiding,
        StopCause::PendantInControl,
        StopCause::Failure,
    ];

    /// In words, for messages.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            StopCause::ProtectiveStop => "protective stop",
            StopCause::Reflex => "reflex",
            StopCause::CommunicationLost => "communication lost",
            StopCause::ProgramNotRunning => "its program does not run",
            StopCause::PowerOff => "drives without power",
            StopCause::Safeguard => "safeguard",
            StopCause::EmergencyStop => "emergency stop",
            StopCause::Violation => "safety violation",
            StopCause::HandGuiding => "guided by hand",
            StopCause::PendantInControl => "operated from its pendant",
            StopCause::Failure => "failure of its controller",
        }
    }

    /// Whether a person must be at the robot to clear it, whatever its driver could do.
    #[must_use]
    pub const fn needs_a_person(self) -> bool {
        match self {
            StopCause::Safeguard
            | StopCause::EmergencyStop
            | StopCause::Violation
            | StopCause::HandGuiding
            | StopCause::Failure => true,
            StopCause::ProtectiveStop
            | StopCause::Reflex
            | StopCause::CommunicationLost
            | StopCause::ProgramNotRunning
            | StopCause::PowerOff
            | StopCause::PendantInControl => false,
        }
    }
}

impl ClearedBy {
    const ALL: [ClearedBy; 3] = [ClearedBy::Operator, ClearedBy::Pendant, ClearedBy::PersonAtRobot];
}

/// A stop that did not come from this cell, as a driver tells it.
///
/// ```
/// use mrroc_core::robot::{ClearedBy, RobotStop, StopCause};
///
/// let stop = RobotStop::new(StopCause::Reflex).named("joint_velocity_violation");
/// assert_eq!(stop.to_string(), "reflex: joint_velocity_violation");
/// assert_eq!(stop.cleared_by(), ClearedBy::Operator);
///
/// // A program that is started at the pendant, because this robot takes none over the network.
/// assert_eq!(RobotStop::new(StopCause::ProgramNotRunning).at_pendant().cleared_by(), ClearedBy::Pendant);
///
/// // Nothing but a person at the robot clears an emergency stop.
/// assert_eq!(RobotStop::new(StopCause::EmergencyStop).cleared_by(), ClearedBy::PersonAtRobot);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RobotStop {
    cause: StopCause,
    cleared_by: ClearedBy,
    name: &'static str,
}

impl RobotStop {
    /// A stop for this cause. Where a [person must be there](StopCause::needs_a_person), a person at the robot clears it;
    /// what the pendant has done, the pendant; all else the operator's reset.
    #[must_use]
    pub const fn new(cause: StopCause) -> RobotStop {
        let cleared_by = match cause {
            _ if cause.needs_a_person() => ClearedBy::PersonAtRobot,
            StopCause::PendantInControl | StopCause::PowerOff => ClearedBy::Pendant,
            _ => ClearedBy::Operator,
        };
        RobotStop { cause, cleared_by, name: "" }
    }

    /// The same, with what the robot itself calls it: the name of a reflex, the code of a message.
    #[must_use]
    pub const fn named(mut self, name: &'static str) -> RobotStop {
        self.name = name;
        self
    }

    /// The same, to be cleared at the pendant, because this robot does not let its driver do it. A stop that needs a person
    /// at the robot goes on needing one.
    #[must_use]
    pub const fn at_pendant(mut self) -> RobotStop {
        if !self.cause.needs_a_person() {
            self.cleared_by = ClearedBy::Pendant;
        }
        self
    }

    /// What has stopped it.
    #[must_use]
    pub const fn cause(&self) -> StopCause {
        self.cause
    }

    /// Who may clear it.
    #[must_use]
    pub const fn cleared_by(&self) -> ClearedBy {
        self.cleared_by
    }

    /// What the robot itself calls it; empty if it has no name for it.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }
}

/// `reflex: joint_velocity_violation`.
impl fmt::Display for RobotStop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.cause.text())?;
        if self.name.is_empty() { Ok(()) } else { write!(f, ": {}", self.name) }
    }
}

/// What a fault knows of such a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stopped {
    pub cause: StopCause,
    pub cleared_by: ClearedBy,
}

impl From<&RobotStop> for Stopped {
    fn from(stop: &RobotStop) -> Self {
        Stopped { cause: stop.cause, cleared_by: stop.cleared_by }
    }
}

impl Stopped {
    /// In 16 bits of a message, of which none is 0.
    pub const fn to_bits(self) -> u16 {
        (self.cause as u16) << 8 | self.cleared_by as u16
    }

    /// Back from them; `None` for bits that no process in its senses sends.
    pub fn from_bits(bits: u16) -> Option<Stopped> {
        let cause = StopCause::ALL.into_iter().find(|&cause| cause as u16 == bits >> 8)?;
        let cleared_by = ClearedBy::ALL.into_iter().find(|&by| by as u16 == bits & 0xff)?;
        (!cause.needs_a_person() || cleared_by == ClearedBy::PersonAtRobot)
            .then_some(Stopped { cause, cleared_by })
    }

    /// What to do about it.
    pub const fn help(self) -> &'static str {
        match (self.cleared_by, self.cause) {
            (ClearedBy::Operator, StopCause::CommunicationLost) => {
                "look at the cable and at `doctor`, then reset: the robot begins where it stands"
            }
            (ClearedBy::Operator, _) => {
                "see why the robot stopped, then reset: that clears it, moves nothing, and begins where the robot stands"
            }
            (ClearedBy::Pendant, StopCause::PowerOff) => "switch the drives on at the pendant, then reset",
            (ClearedBy::Pendant, StopCause::PendantInControl) => {
                "give the robot back to remote control at its pendant, then reset"
            }
            (ClearedBy::Pendant, _) => "start the robot's program at its pendant, then reset",
            (ClearedBy::PersonAtRobot, StopCause::HandGuiding) => {
                "wait until nobody guides the robot any more, then reset"
            }
            (ClearedBy::PersonAtRobot, _) => {
                "go to the robot: see that nobody is in danger, clear the stop there and switch the drives on, then reset"
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_survives_its_bits_and_bits_that_let_a_reset_clear_what_needs_a_person_are_refused() {
        for cause in StopCause::ALL {
            let stops = [RobotStop::new(cause), RobotStop::new(cause).at_pendant()];
            for stopped in stops.iter().map(Stopped::from) {
                assert_eq!(Stopped::from_bits(stopped.to_bits()), Some(stopped));
            }
            let by_operator = Stopped { cause, cleared_by: ClearedBy::Operator };
            assert_eq!(Stopped::from_bits(by_operator.to_bits()).is_some(), !cause.needs_a_person());
        }
        for bits in [0, 1, 0x0100, 0x0104, 0x0c01, 0xffff] {
            assert_eq!(Stopped::from_bits(bits), None);
        }
    }
}
