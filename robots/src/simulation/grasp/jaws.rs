//! A gripper that is a robot of its own, and whose fingers touch whatever is between them.

use mrroc::robot::{Driver, Robot};

use super::error::WorldError;
use super::grip::Hand;
use super::pads::Pads;
use crate::models::{Driven, One};
use crate::simulation::simulated::Simulated;
use crate::simulation::surroundings::{Surrounded, Surroundings};

/// The drive of a gripper of one joint, its opening, on an arm's hand. Its pads push a body that comes between them, and hold it when
/// both press; then the drive stands, as if blocked. Fingers that are demanded to open by more than [`Jaws::SLACK`] let it go.
pub type Jaws<R> = Surrounded<R, 1, Pressed>;

/// What comes between pads.
#[derive(Debug)]
pub struct Pressed {
    hand: Hand,
    /// The opening at which they hold a body \[m\].
    holding: Option<f64>,
    /// The opening at which the servo period began \[m\].
    from: f64,
}

impl<R: Driven<1> + Robot<Joints = One>> Jaws<R> {
    /// A demanded opening that exceeds the one at which a body is held by more than this lets it go \[m\].
    pub const SLACK: f64 = 1e-3;

    /// The fingers of `hand`, with these pads.
    ///
    /// # Errors
    /// [`WorldError`] when a figure of the pads is out of range.
    pub fn new(drive: Simulated<R, 1>, hand: Hand, pads: Pads) -> Result<Self, WorldError> {
        let from = drive.state().position[0];
        hand.fit(pads, from)?;
        Ok(Surrounded::by(drive, Pressed { hand, holding: None, from }))
    }

    /// Its hand in the world.
    #[must_use]
    pub fn hand(&self) -> Hand {
        self.around().hand.clone()
    }
}

impl<R: Driven<1> + Robot<Joints = One>> Surroundings<R, 1> for Pressed {
    fn demanded(&mut self, drive: &mut Simulated<R, 1>, demand: &One) {
        if self.holding.is_some_and(|opening| demand[0] > opening + Jaws::<R>::SLACK) {
            self.holding = None;
            self.hand.open();
            drive.unblock(0);
        }
        self.hand.set_closing(demand[0] < drive.state().position[0]);
    }

    fn begin(&mut self, drive: &mut Simulated<R, 1>) {
        self.from = drive.state().position[0];
        // Where its body was taken away, nothing is between the pads any more.
        if !self.hand.is_closed() && self.holding.take().is_some() {
            drive.unblock(0);
        }
        if self.hand.is_closed() && self.holding.is_none() {
            self.holding = Some(self.from);
            drive.block(0);
        }
    }

    fn end(&mut self, drive: &Simulated<R, 1>) {
        let duration = drive.period().as_secs_f64();
        let rate = (drive.state().position[0] - self.from) / duration;
        self.hand.set_opening(self.from, rate, duration);
    }
}
