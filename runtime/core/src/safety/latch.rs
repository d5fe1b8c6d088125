//! The latch: what keeps a cell from moving between a fault and its reset, as pure functions of states and events.
//!
//! In: faults, standstills, the operator's acknowledgement and reset, epochs of messages. Out: where the cell is, and
//! what a process does with a message. The MP and its operator share a [`Latching`]; an ECP and an EDP have a [`Gate`]
//! each. The model check explores these very functions.
//!
//! ```text
//!             fault               standstill            acknowledge               reset, rising
//!   Clear ───────────▶ Stopping ─────────────▶ Latched ─────────────▶ Acknowledged ─────────────▶ Resetting
//!     ▲                    ▲                            a fault: the cause persists           │   │
//!     │                    └──────────────────────────────────────────────────────────────────┘   │
//!     └────────────────────────────────── restart ────────────────────────────────────────────────┘
//! ```
//!
//! An epoch counts the resets that were tried. Nothing that was sent before one moves a robot after it.

/// What a cell does when a fault has stopped it and its robots stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AfterFault {
    /// The run ends with the first cause, as nobody may be there.
    #[default]
    End,
    /// It stays latched until its [`Operator`](crate::operator::Operator) acknowledges the fault and resets it, or gives it up. Then drives come on
    /// where the robots are, and all programs start again from their first line. Under the virtual clock the time passes
    /// meanwhile as fast as ever.
    AwaitReset,
}

/// Where a cell is between a fault and its restart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Latch {
    /// No fault is latched: programs run, or are over.
    #[default]
    Clear,
    /// Robots are braking to a standstill.
    Stopping,
    /// They stand, or the time in which they should have is over. The first cause waits for an acknowledgement.
    Latched,
    /// Acknowledged: the cell waits for a reset.
    Acknowledged,
    /// Robots are made ready for a restart; nothing moves.
    Resetting,
}

/// Why an acknowledgement or a reset does nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum LatchRefusal {
    /// There is nothing to acknowledge or to reset.
    #[error("no fault is latched")]
    NotLatched,
    /// A stop comes first.
    #[error("robots are still stopping\n help: wait until they stand")]
    Stopping,
    /// A reset comes after the acknowledgement.
    #[error("the fault is not acknowledged\n help: acknowledge it, then reset")]
    NotAcknowledged,
    /// A reset is pressed after the acknowledgement: one that was pressed before it, and is held, does not count.
    #[error("the reset is held\n help: let it go, then press it again")]
    Held,
    /// What the cell stopped for is still there.
    #[error("the cause of the fault persists\n help: remove it, then reset; `Operator::persisting` tells it")]
    CausePersists,
    /// A reset is being carried out.
    #[error("a reset is under way")]
    Resetting,
}

/// What happens to a latch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Event {
    /// A fault, anywhere in the cell.
    Fault,
    /// All robots stand, or the time in which they should is over.
    Standstill,
    /// The operator has read the cause.
    Acknowledge,
    /// The operator's reset is pressed, or let go.
    Reset { pressed: bool },
    /// Whether what the cell stopped for is still there.
    Cause { persists: bool },
    /// All robots are ready: the programs start again.
    Restart,
}

/// The latch, and what decides about a reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Latching {
    pub latch: Latch,
    /// Whether the reset is pressed.
    pub pressed: bool,
    /// Whether what the cell stopped for is still there.
    pub persists: bool,
}

impl Latching {
    /// The latch after an event, and why what the operator asks for does nothing.
    pub const fn meet(self, event: Event) -> (Latching, Result<(), LatchRefusal>) {
        use LatchRefusal as Why;
        let met = match (event, self.latch) {
            (Event::Fault, Latch::Clear | Latch::Resetting) => Ok(Latch::Stopping),
            (Event::Standstill, Latch::Stopping) => Ok(Latch::Latched),
            (Event::Acknowledge, Latch::Latched | Latch::Acknowledged) => Ok(Latch::Acknowledged),
            (Event::Reset { pressed: true }, Latch::Acknowledged) if self.pressed => Err(Why::Held),
            (Event::Reset { pressed: true }, Latch::Acknowledged) if self.persists => Err(Why::CausePersists),
            (Event::Reset { pressed: true }, Latch::Acknowledged) => Ok(Latch::Resetting),
            (Event::Reset { pressed: true }, Latch::Latched) => Err(Why::NotAcknowledged),
            (Event::Acknowledge | Event::Reset { pressed: true }, Latch::Clear) => Err(Why::NotLatched),
            (Event::Acknowledge | Event::Reset { pressed: true }, Latch::Stopping) => Err(Why::Stopping),
            (Event::Acknowledge | Event::Reset { pressed: true }, Latch::Resetting) => Err(Why::Resetting),
            (Event::Restart, Latch::Resetting) => Ok(Latch::Clear),
            (
                Event::Fault
                | Event::Standstill
                | Event::Restart
                | Event::Reset { pressed: false }
                | Event::Cause { .. },
                latch,
            ) => Ok(latch),
        };
        let mut next = self;
        match event {
            // A level is a level, whatever it does.
            Event::Reset { pressed } => next.pressed = pressed,
            Event::Cause { persists } => next.persists = persists,
            Event::Fault | Event::Standstill | Event::Acknowledge | Event::Restart => {}
        }
        match met {
            Ok(latch) => {
                next.latch = latch;
                (next, Ok(()))
            }
            Err(why) => (next, Err(why)),
        }
    }

    /// In one word, as it is shared between threads.
    pub const fn to_word(self) -> u8 {
        self.latch as u8 | (self.pressed as u8) << 3 | (self.persists as u8) << 4
    }

    /// Back from it.
    pub const fn from_word(word: u8) -> Latching {
        let latch = match word & 7 {
            0 => Latch::Clear,
            1 => Latch::Stopping,
            2 => Latch::Latched,
            3 => Latch::Acknowledged,
            _ => Latch::Resetting,
        };
        Latching { latch, pressed: word & 8 != 0, persists: word & 16 != 0 }
    }
}

/// What a message asks of a process, as far as its gate is concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum GateRequest {
    /// To move, or to open what will move.
    Move,
    /// To tell its state, to come to rest: nothing that could move a robot that stands.
    Look,
    /// To stop and latch.
    Stop,
    /// To leave the latch.
    Reset,
}

/// What becomes of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Admission {
    /// Not taken: it is of an epoch that is over, or of one that has not begun here.
    Ignored,
    /// It is done.
    Done,
    /// It is answered with what is latched.
    Refused,
}

/// What every process of a robot has before it: shut by a stop or a fault, opened by nothing but a reset of a new epoch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Gate {
    /// The epoch of the last reset that came.
    pub epoch: u32,
    shut: bool,
}

impl Gate {
    /// The gate of a process that has met a fault.
    #[must_use]
    pub const fn closed(self) -> Gate {
        Gate { shut: true, ..self }
    }

    /// The gate after a message of an epoch, and what becomes of that; `stands` says whether the robot does.
    #[must_use]
    #[inline]
    pub const fn meet(self, epoch: u32, asked: GateRequest, stands: bool) -> (Gate, Admission) {
        if epoch < self.epoch {
            return (self, Admission::Ignored);
        }
        let newer = epoch > self.epoch;
        match asked {
            // A stop of an epoch whose reset was lost is a stop.
            GateRequest::Stop => (Gate { epoch, shut: true }, Admission::Done),
            GateRequest::Reset if !newer => (self, Admission::Ignored),
            // A robot that was not stopped, or still moves, is not reset.
            GateRequest::Reset if !self.shut || !stands => (Gate { epoch, shut: true }, Admission::Refused),
            GateRequest::Reset => (Gate { epoch, shut: false }, Admission::Done),
            GateRequest::Move | GateRequest::Look if newer => (self, Admission::Ignored),
            GateRequest::Move if self.shut => (self, Admission::Refused),
            GateRequest::Move | GateRequest::Look => (self, Admission::Done),
        }
    }
}

#[cfg(test)]
mod tests;
