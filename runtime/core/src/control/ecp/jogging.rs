//! The robot of an ECP that a person jogs.
//!
//! In: what the MP's orders say of jogging. Out: the same in the seat of the program's panel, while a Move is at work; and in the
//! replies, whether that Move asks the panel.

use std::rc::Rc;

use crate::link::message::flag;
use crate::model::robot::Robot;
use crate::operator::jog::{JogNow, JogPanel, JogSeat, JogStop};
use crate::operator::state::{EcpState, InstructionKind};

use super::Ecp;

/// What an ECP keeps of it.
pub(super) struct Jogging<R> {
    model: Rc<R>,
    seat: JogSeat,
    /// Whether a program had a panel when the Move at work began.
    is_offered: bool,
    /// Whether its generator asks that panel.
    asks: bool,
    /// Whether something is asked for.
    said: bool,
    /// Why the robot stands, as it was shown last.
    shown: JogStop,
}

impl<R: Robot> Jogging<R> {
    pub fn of(model: Rc<R>) -> Self {
        Jogging {
            model,
            seat: JogSeat::default(),
            is_offered: false,
            asks: false,
            said: false,
            shown: JogStop::None,
        }
    }

    /// The robot.
    pub fn model(&self) -> &R {
        &self.model
    }

    /// A Move begins.
    pub fn begin_move(&mut self) {
        // Its generator has not been asked yet: a panel that the program has is taken for one that it asks.
        self.is_offered = self.seat.is_taken(1);
        self.asks = self.is_offered;
    }

    /// The Move is over.
    pub fn end_move(&mut self) {
        (self.is_offered, self.asks) = (false, false);
        self.seat.forget();
    }

    /// What is asked of the robot in this step, as the order says it.
    #[inline]
    pub fn hear(&mut self, now: Option<&JogNow>) {
        if now.is_some() || self.said {
            self.said = now.is_some();
            self.seat.say(now.copied().unwrap_or_default());
        }
    }
}

impl<R: Robot> Ecp<'_, R> {
    /// A panel of the robot for a person who jogs it: for a generator that moves the robot as the panel says. While that is at
    /// work, the operator may jog the robot.
    #[must_use]
    pub fn jog_panel(&mut self) -> JogPanel<R> {
        let jogging = &self.jogging;
        jogging.seat.panel(Rc::clone(&jogging.model), Rc::clone(&self.named), Rc::clone(&self.signals))
    }

    /// What its replies say: whether the operator may jog the robot, or its program moves it.
    #[inline]
    pub(super) const fn jog_flags(&self) -> u32 {
        match self.at_work.doing {
            InstructionKind::Move if self.jogging.asks => flag::JOGS,
            InstructionKind::Move => flag::OWN_MOTION,
            InstructionKind::Nothing | InstructionKind::Homing | InstructionKind::Wait => 0,
        }
    }

    /// The generator was asked for its demand: whether it asked the panel, and what it says of the robot.
    #[inline]
    pub(super) fn see_who_asks(&mut self) {
        if self.jogging.is_offered {
            self.show_jogging();
        }
    }

    #[cold]
    fn show_jogging(&mut self) {
        self.jogging.asks = self.jogging.seat.take_read();
        let stop = self.jogging.seat.stop();
        if core::mem::replace(&mut self.jogging.shown, stop) != stop {
            self.host.console.show_ecp(&self.shown_state());
        }
    }

    /// What consoles are shown of its program.
    pub(super) const fn shown_state(&self) -> EcpState {
        EcpState { doing: self.at_work.doing, by: self.at_work.by, stop: self.jogging.shown }
    }
}
