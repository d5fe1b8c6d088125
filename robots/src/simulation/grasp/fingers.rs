//! A gripper that is a robot of its own, and whose fingers close on the world's body.

use super::error::{WorldError, positive};
use super::grip::Hand;
use crate::models::{Gripper, One};
use crate::simulation::simulated::Simulated;
use crate::simulation::surroundings::{Surrounded, Surroundings};

/// The drive of a [`Gripper`] on an arm's hand. Fingers that are demanded to close beyond the body's width stop at it and
/// hold it, if it is between them; a grasp without a frame of its own (`Grasp::at`) assumes that it is. Fingers that are
/// demanded to open let the body go.
pub type Fingers = Surrounded<Gripper, 1, Enclosed>;

/// The body between fingers.
#[derive(Debug)]
pub struct Enclosed {
    hand: Hand,
    width: f64,
}

impl Fingers {
    /// The fingers of `hand`; the body is `width` \[m\] wide between them.
    ///
    /// # Errors
    /// [`WorldError`] when the width is not above 0.
    pub fn new(drive: Simulated<Gripper, 1>, hand: Hand, width: f64) -> Result<Self, WorldError> {
        let width = positive("the body's width", width, "m")?;
        Ok(Surrounded::by(drive, Enclosed { hand, width }))
    }
}

impl Surroundings<Gripper, 1> for Enclosed {
    fn demanded(&mut self, drive: &mut Simulated<Gripper, 1>, demand: &One) {
        let closing = demand[0] < self.width;
        if !closing && self.hand.is_closed() {
            self.hand.open();
            drive.unblock(0);
        }
        // Where the grasp has a frame on the body and the body is elsewhere, the fingers close on nothing.
        let touching = closing && drive.state().position[0] <= self.width;
        if touching && !self.hand.is_closed() && self.hand.close().is_ok() {
            drive.block(0);
        }
    }
}
