//! What takes the place of real drives where nothing real may move.

use core::time::Duration;

use super::RobotSetup;
use crate::cell::CellError;
use crate::control::homing::Drives;
use crate::model::any_kind::AnyKind;
use crate::model::driver::Driver;
use crate::model::robot::Robot;

/// Makes a set-up for a model and a servo period.
type Make<R> = Box<dyn FnOnce(&R, Duration) -> Result<RobotSetup<R>, CellError>>;

/// Simulated drives that a set-up has beside its own.
pub(super) enum StandIn<R: Robot> {
    /// None.
    None,
    /// These.
    Drives(Box<dyn Driver<AnyKind<R::Joints>>>),
    /// Those of a set-up that is yet to be made.
    Made(Make<R>),
    /// They have taken the place of this hardware.
    For(String),
}

impl<R: Robot> StandIn<R> {
    /// The hardware in whose place it is.
    pub fn in_place_of(&self) -> Option<&str> {
        match self {
            StandIn::For(hardware) => Some(hardware),
            StandIn::None | StandIn::Drives(_) | StandIn::Made(_) => None,
        }
    }

    /// The drives for a model whose real ones have this servo period, if there are any.
    ///
    /// # Errors
    /// Why they cannot be made.
    pub fn drives(
        self,
        robot: &R,
        period: Duration,
    ) -> Result<Option<Drives<AnyKind<R::Joints>>>, CellError> {
        match self {
            StandIn::None | StandIn::For(_) => Ok(None),
            StandIn::Drives(driver) => Ok(Some(Drives::Homed(driver))),
            StandIn::Made(make) => Ok(Some(make(robot, period)?.processes.drives)),
        }
    }
}
