//! What a controller's state means for the cell: why the arm stands, and who may clear that.

use mrroc::robot::{RobotStop, StopCause};

use crate::script::Ended;
use crate::state::{Program, RobotMode, Safety, State};

/// Where the script on the controller is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connected {
    /// It has called, and takes set-points.
    Yes,
    /// It has not called.
    NotYet,
    /// It has ended, and said why if it could.
    Ended(Option<Ended>),
}

/// What has stopped the arm; `None` while it may move. Safety comes first, then power, then the program.
pub(crate) fn of(state: &State, script: Connected) -> Option<RobotStop> {
    of_safety(state).or_else(|| of_power(state)).or_else(|| of_script(state, script))
}

/// What does not let the arm move, whatever runs on its controller.
pub(crate) fn of_safety(state: &State) -> Option<RobotStop> {
    let stop = |cause, name| Some(RobotStop::new(cause).named(name));
    match state.safety {
        Safety::Fault => stop(StopCause::Failure, "its safety system reports a fault"),
        Safety::Violation => stop(StopCause::Violation, "beyond a limit of its safety configuration"),
        Safety::EmergencyStop => stop(StopCause::EmergencyStop, ""),
        Safety::EnablingStop => stop(StopCause::Safeguard, "the enabling device was let go"),
        Safety::SafeguardStop => stop(StopCause::Safeguard, "safeguard stop"),
        Safety::Recovery => stop(StopCause::Violation, "recovery mode"),
        Safety::ProtectiveStop => stop(StopCause::ProtectiveStop, ""),
        Safety::Normal | Safety::Reduced if state.is_guided => {
            stop(StopCause::HandGuiding, "freedrive button")
        }
        Safety::Normal | Safety::Reduced => None,
    }
}

pub(crate) fn of_power(state: &State) -> Option<RobotStop> {
    let off = |name| Some(RobotStop::new(StopCause::PowerOff).named(name));
    match state.robot_mode {
        RobotMode::Running => None,
        RobotMode::Backdrive => Some(RobotStop::new(StopCause::HandGuiding).named("backdrive")),
        RobotMode::Idle => off("brakes applied"),
        RobotMode::PowerOff => off("power off"),
        RobotMode::PowerOn => off("powering on"),
        RobotMode::Booting => off("booting"),
        RobotMode::ConfirmSafety => off("its safety configuration is to be confirmed"),
        RobotMode::Disconnected | RobotMode::NoController => {
            off("the arm is not connected to its controller")
        }
        RobotMode::UpdatingFirmware => off("updating its firmware"),
    }
}

fn of_script(state: &State, script: Connected) -> Option<RobotStop> {
    match script {
        Connected::Yes if state.program == Program::Paused => {
            Some(RobotStop::new(StopCause::ProgramNotRunning).named("the script was paused at the robot"))
        }
        Connected::Yes => None,
        Connected::Ended(Some(Ended::Timeout)) => {
            Some(RobotStop::new(StopCause::CommunicationLost).named("set-points did not come in time"))
        }
        Connected::Ended(Some(Ended::Asked)) | Connected::NotYet => {
            Some(RobotStop::new(StopCause::ProgramNotRunning))
        }
        Connected::Ended(None) => {
            Some(RobotStop::new(StopCause::ProgramNotRunning).named("the script was ended at the robot"))
        }
    }
}
