//! A gripper in a world, as who moves it has it.

use core::time::Duration;

use mrroc::fault::Fault;
use mrroc::pose::{Pose, Wrench};

use super::compliance::Grasp;
use super::error::WorldError;
use super::hand::HandState;
use super::motion::nanos;
use super::pads::{Jaw, Pads, Touch};
use super::stepping::Mover;
use super::world::World;

/// A gripper in a world: it closes and opens, and has the wrench of the body on it. All copies are the same gripper.
#[derive(Clone, Debug)]
pub struct Hand {
    world: World,
    index: usize,
}

/// Why a gripper did not close on the body: the grasp frame is not between its fingers.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the gripper does not reach its grasp: {distance:.4} m and {angle:.4} rad off, it reaches {reach:.4} m and {turn:.4} rad"
)]
pub struct OutOfReach {
    /// Distance of the grasp frame from the tool frame \[m\].
    pub distance: f64,
    /// Turn between the two \[rad\].
    pub angle: f64,
    /// The largest distance \[m\].
    pub reach: f64,
    /// The largest turn \[rad\].
    pub turn: f64,
}

impl OutOfReach {
    /// There is no body.
    fn nothing() -> Self {
        Self { distance: f64::INFINITY, angle: 0.0, reach: Grasp::REACH, turn: Grasp::TURN }
    }
}

/// So that programs which close a hand can return it by `?`.
impl From<OutOfReach> for Fault {
    fn from(out: OutOfReach) -> Fault {
        Fault::thrown(&out.to_string())
    }
}

impl Hand {
    /// Closes on the first body: where the two are, or at the stated grasp frame. A closed gripper stays as it is.
    ///
    /// # Errors
    /// [`OutOfReach`] when the stated grasp frame is too far from the tool frame.
    #[allow(non_snake_case)]
    pub fn close(&self) -> Result<(), OutOfReach> {
        let state = &mut *self.world.state_mut();
        let now = state.time;
        let hand = &mut state.hands[self.index];
        if hand.is_closed() {
            return Ok(());
        }
        let Some(body) = state.entries.first().map(|entry| &entry.body) else {
            return Err(OutOfReach::nothing());
        };
        let X_BE = body.state().pose.inverse() * hand.pose();
        let X_BG = hand.grasp.X_BG.unwrap_or(X_BE);
        let X_EG = X_BE.inverse() * X_BG;
        let distance = X_EG.translation.vector.norm();
        let angle = X_EG.rotation.angle();
        let reach = Grasp::REACH;
        let turn = Grasp::TURN;
        let is_there = distance <= reach && angle <= turn;
        if !is_there {
            return Err(OutOfReach { distance, angle, reach, turn });
        }
        hand.close(now, 0, body, &X_BG);
        Ok(())
    }

    /// Lets the body go.
    pub fn open(&self) {
        self.world.state_mut().hands[self.index].open();
    }

    /// Gives it fingers that touch bodies, with this opening \[m\]: see [`Jaws`](super::Jaws).
    ///
    /// # Errors
    /// [`WorldError`] when a figure of the pads is out of range.
    pub(super) fn fit(&self, pads: Pads, opening: f64) -> Result<(), WorldError> {
        pads.check()?;
        self.world.state_mut().hands[self.index].jaw = Some(Jaw::new(pads, opening));
        Ok(())
    }

    /// Moves its fingers: to this opening \[m\], and on at this rate [m/s] for `duration` \[s\].
    pub(super) fn set_opening(&self, opening: f64, rate: f64, duration: f64) {
        if let Some(jaw) = &mut self.world.state_mut().hands[self.index].jaw {
            jaw.set_opening(opening, rate, duration);
        }
    }

    /// Whether its fingers press, or let go of what is between them.
    pub(super) fn set_closing(&self, closing: bool) {
        if let Some(jaw) = &mut self.world.state_mut().hands[self.index].jaw {
            jaw.set_closing(closing);
        }
    }

    /// The body that it holds.
    #[must_use]
    pub fn held(&self) -> Option<usize> {
        self.world.state().hands[self.index].held()
    }

    /// When and where one of its fingers first touched the body that is between them; `None` of a hand without fingers.
    #[must_use]
    pub fn touched(&self) -> Option<Touch> {
        self.world.state().hands[self.index].jaw.and_then(|jaw| jaw.touch)
    }

    /// When and where both fingers last got hold of a body.
    #[must_use]
    pub fn gripped(&self) -> Option<Touch> {
        self.world.state().hands[self.index].jaw.and_then(|jaw| jaw.grip)
    }

    /// How far apart its pads are \[m\], at the world's time; `None` of a hand without fingers.
    #[must_use]
    pub fn opening(&self) -> Option<f64> {
        self.world.state().hands[self.index].jaw.map(|jaw| jaw.opening())
    }

    /// How often a finger has come down on a body.
    #[must_use]
    pub fn crashes(&self) -> u32 {
        self.world.state().hands[self.index].jaw.map_or(0, |jaw| jaw.crashes)
    }

    /// Whether it holds the body.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.world.state().hands[self.index].is_closed()
    }

    /// `F_E`, the wrench of the body on the gripper: at the tool frame's origin and in its axes, mean over the last servo
    /// period that the world went through.
    #[must_use]
    pub fn reaction(&self) -> Wrench {
        let state = self.world.state();
        let hand = &state.hands[self.index];
        let turn = Pose::from_parts(Default::default(), hand.pose().rotation.inverse());
        hand.reaction().moved(&turn)
    }

    /// The part of the gripper's wrench on the body that neither carries nor moves it: at the tool frame's origin, in the
    /// world's axes. The internal wrenches of all closed grippers together are zero.
    #[must_use]
    pub fn internal(&self) -> Wrench {
        let state = self.world.state();
        let hand = &state.hands[self.index];
        hand.held().map_or_else(Wrench::default, |body| state.sharing(body).internal(&hand.applied()))
    }

    /// `X_WE`, where the tool frame truly is at the world's time.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.world.state().hands[self.index].pose()
    }

    /// The world that it is in.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Begins a servo period of the hand's arm; returns the wrench of the body on the gripper in the last period: at E,
    /// along the world's axes.
    pub(super) fn begin(&self) -> Wrench {
        let state = &mut *self.world.state_mut();
        state.begin(Mover::Hand(self.index));
        let hand = &mut state.hands[self.index];
        hand.take_reaction();
        hand.reaction()
    }

    /// Ends the servo period with the tool frame at `X_WE`.
    #[allow(non_snake_case)]
    pub(super) fn end(&self, X_WE: Pose) {
        self.world.state_mut().hands[self.index].motion.end(X_WE);
    }
}

impl World {
    /// Puts a tool frame into the world, at `X_WE`, which moves every `period`.
    #[allow(non_snake_case)]
    pub(super) fn add_hand(&self, grasp: Grasp, period: Duration, X_WE: Pose) -> Result<Hand, WorldError> {
        grasp.check()?;
        let period = nanos(period)?;
        let state = &mut *self.state_mut();
        state.hands.push(HandState::new(grasp, period, state.time, X_WE));
        state.reserve();
        Ok(Hand { world: self.clone(), index: state.hands.len() - 1 })
    }

    /// The gripper of an arm, counted from 0 in the order in which arms came into the world.
    #[must_use]
    pub fn hand(&self, arm: usize) -> Option<Hand> {
        (arm < self.state().hands.len()).then(|| Hand { world: self.clone(), index: arm })
    }
}
