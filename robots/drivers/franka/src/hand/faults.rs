//! Why an exchange with the hand ends.

use mrroc::robot::{DriveFault, RobotStop, StopCause};

pub(crate) const fn stop(cause: StopCause, name: &'static str) -> DriveFault {
    DriveFault::Stopped(RobotStop::new(cause).named(name))
}

pub(crate) const CLOSED: DriveFault = DriveFault::Other("the hand is not connected");
pub(crate) const NOT_HOMED: DriveFault = DriveFault::Other(
    "the hand is not homed: take out what it holds, then home it in Desk or write homed = false: its fingers will move",
);
pub(crate) const OTHER_VERSION: DriveFault =
    DriveFault::Other("the hand speaks another version of its interface than 3");
pub(crate) const NO_PORT: DriveFault = DriveFault::Other("this machine has no port for the hand's states");
pub(crate) const UNREACHABLE: DriveFault =
    stop(StopCause::CommunicationLost, "nothing accepts a connection at its address: is the hand mounted?");
pub(crate) const HUNG_UP: DriveFault = stop(StopCause::CommunicationLost, "connection closed by the robot");
pub(crate) const SILENT: DriveFault = stop(StopCause::CommunicationLost, "no state came in time");
pub(crate) const NO_HAND: DriveFault = stop(StopCause::CommunicationLost, "what answers is no Franka Hand");
pub(crate) const ENDLESS: DriveFault =
    stop(StopCause::ProtectiveStop, "its motion does not end: is something in its way?");
pub(crate) const SHORT: DriveFault =
    stop(StopCause::ProtectiveStop, "it did not come to the opening: is something in its way?");
pub(crate) const BY_OTHERS: DriveFault =
    stop(StopCause::PendantInControl, "somebody else has ended its motion");
pub(crate) const MOVED_BY_OTHERS: DriveFault =
    stop(StopCause::PendantInControl, "somebody else moves its fingers");
