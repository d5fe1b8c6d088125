//! Why a robot does not move: what its states and its answers say, as faults of its drives.
//!
//! In: a state of the robot. Out: the fault, with its cause and the name that the robot gives it.

use mrroc::robot::{DriveFault, RobotStop, StopCause};

use crate::message::{COMMUNICATION, Mode, State};

pub(crate) const CLOSED: DriveFault = DriveFault::Other("the robot is not connected");
pub(crate) const ABSENT: DriveFault =
    DriveFault::Other("the robot does not answer: switch it on, and activate FCI in Desk, then reset");
pub(crate) const OTHER_VERSION: DriveFault = DriveFault::Other(
    "the robot speaks another version of FCI than 10, that of an FR3 with system 5.7 or newer",
);
/// The connection has ended: FCI was deactivated in Desk, or somebody else has connected.
pub(crate) const CUT_OFF: DriveFault = stop(StopCause::CommunicationLost, "connection closed by the robot");
pub(crate) const NETWORK: DriveFault =
    DriveFault::Other("the network takes nothing: is the cable plugged in?");
pub(crate) const TOO_FAR: DriveFault =
    DriveFault::Other("the demanded position is farther than 0.1 rad from where the robot is held");
pub(crate) const REFUSED: DriveFault = stop(StopCause::ProtectiveStop, "motion refused");
pub(crate) const ENDED: DriveFault = stop(StopCause::ProtectiveStop, "motion ended");

/// A stop by the robot, and the name that it gives it.
pub(crate) const fn stop(cause: StopCause, name: &'static str) -> DriveFault {
    DriveFault::Stopped(RobotStop::new(cause).named(name))
}

/// Why a robot in this state does not move; `None` if it does.
pub(crate) fn stopped(said: &State) -> Option<DriveFault> {
    let name = said.reason.or(said.error).unwrap_or("");
    match said.mode {
        Mode::Idle | Mode::Move => None,
        Mode::Reflex if name == COMMUNICATION => Some(stop(StopCause::CommunicationLost, name)),
        Mode::Reflex => Some(stop(StopCause::Reflex, name)),
        // It does not say whether the external activation device, a safety function or an emergency stop has done it.
        Mode::UserStopped => Some(stop(StopCause::Safeguard, "user stop")),
        Mode::Guiding => Some(stop(StopCause::HandGuiding, "")),
        Mode::Recovering => Some(stop(StopCause::Reflex, "it recovers")),
        // Desk is where its brakes are opened.
        Mode::Other => Some(stop(StopCause::PowerOff, "brakes closed")),
    }
}
