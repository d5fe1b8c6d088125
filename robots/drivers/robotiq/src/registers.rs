//! The registers of a Robotiq two-finger gripper: what it is asked, what it says.
//!
//! In: a position of the fingers, or that it is to be activated; the three registers of its status. Out: the three
//! registers to write; whether it is active, where its fingers are, what stops them.
//!
//! Source: the manufacturer's manual of the 2F-85 and 2F-140, section 4.

use mrroc::robot::{RobotStop, StopCause};

/// Where its requests begin.
pub const REQUEST: u16 = 0x03e8;
/// Where its status begins.
pub const STATUS: u16 = 0x07d0;

/// What the gripper is asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// To be inactive, and to forget its faults: the fingers stop where they are.
    Rest,
    /// To activate itself: **the fingers open and close as far as they can**.
    Activate,
    /// To go to a position.
    GoTo {
        /// 0, open, to 255, closed.
        position: u8,
        /// 0, the slowest, to 255.
        speed: u8,
        /// The current that the motor may take: 0, the least, to 255.
        force: u8,
    },
}

impl Request {
    /// The registers to write from [`REQUEST`] on.
    #[must_use]
    pub const fn registers(self) -> [u16; 3] {
        // rACT is bit 0 of the upper byte, rGTO bit 3.
        match self {
            Request::Rest => [0, 0, 0],
            Request::Activate => [0x0100, 0, 0],
            Request::GoTo { position, speed, force } => {
                [0x0900, position as u16, (speed as u16) << 8 | force as u16]
            }
        }
    }
}

/// What the gripper says of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status([u8; 6]);

/// What its fingers do while they go to a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fingers {
    /// They move.
    Moving,
    /// Something has stopped them while they opened.
    HeldOpening,
    /// Something has stopped them while they closed: they hold it.
    HeldClosing,
    /// They are where they were told to be.
    There,
}

impl Status {
    /// Of the registers from [`STATUS`] on.
    #[must_use]
    pub const fn new(registers: [u16; 3]) -> Status {
        let [a, b, c] = registers;
        Status([(a >> 8) as u8, a as u8, (b >> 8) as u8, b as u8, (c >> 8) as u8, c as u8])
    }

    /// In one word, which is never 0.
    pub(crate) fn to_word(self) -> u64 {
        let [a, b, c, d, e, f] = self.0;
        u64::from_le_bytes([a, b, c, d, e, f, 0, 1])
    }

    /// Back from it; `None` for 0.
    pub(crate) fn from_word(word: u64) -> Option<Status> {
        let [a, b, c, d, e, f, _, there] = word.to_le_bytes();
        (there == 1).then_some(Status([a, b, c, d, e, f]))
    }

    /// Whether it is activated: gACT is set, and gSTA says that this is done.
    #[must_use]
    pub const fn is_active(self) -> bool {
        self.0[0] & 0x31 == 0x31
    }

    /// Whether it is reset: gACT and gSTA are 0.
    #[must_use]
    pub const fn is_reset(self) -> bool {
        self.0[0] & 0x31 == 0
    }

    /// Whether it goes to, or holds at, a position that it was told: gGTO.
    #[must_use]
    pub const fn goes(self) -> bool {
        self.0[0] & 0x08 != 0
    }

    /// What its fingers do: gOBJ, which says something only while it [goes](Status::goes) to a position.
    #[must_use]
    pub const fn fingers(self) -> Fingers {
        match self.0[0] >> 6 {
            0 => Fingers::Moving,
            1 => Fingers::HeldOpening,
            2 => Fingers::HeldClosing,
            _ => Fingers::There,
        }
    }

    /// The position that it was told last: gPR.
    #[must_use]
    pub const fn told(self) -> u8 {
        self.0[3]
    }

    /// Where its fingers are: gPO, 0, open, to 255, closed.
    #[must_use]
    pub const fn position(self) -> u8 {
        self.0[4]
    }

    /// What its motor takes \[A\]: gCU.
    #[must_use]
    pub fn current(self) -> f64 {
        f64::from(self.0[5]) * 0.01
    }

    /// What has stopped it: gFLT of the gripper, kFLT of a controller before it, or that it is not activated.
    #[must_use]
    pub const fn stop(self) -> Option<RobotStop> {
        let (cause, name) = match (self.0[2] & 0x0f, self.0[2] >> 4) {
            (0, 0) if self.is_active() => return None,
            (0, 0) | (5 | 7, _) => return Some(INACTIVE),
            (0x08, _) => (StopCause::ProtectiveStop, "fault 8: it is too hot, let it cool down"),
            (0x09, _) => (StopCause::CommunicationLost, "fault 9: it was told nothing for a second"),
            (0x0a, _) => (StopCause::PowerOff, "fault 10: its voltage is too low"),
            (0x0b, _) => (StopCause::EmergencyStop, "fault 11: its automatic release is going on"),
            (0x0c, _) => (StopCause::Failure, "fault 12: an internal fault"),
            (0x0d, _) => {
                (StopCause::Failure, "fault 13: its activation has failed, is something in its way?")
            }
            (0x0e, _) => (StopCause::Failure, "fault 14: too much current"),
            (0x0f, _) => (StopCause::EmergencyStop, "fault 15: its automatic release is over"),
            (1..=4 | 6, _) => (StopCause::Failure, "a fault with a code that is none"),
            (_, 4) => (StopCause::PowerOff, "controller's fault 4: it has no 24 V"),
            (_, 5) => (StopCause::CommunicationLost, "controller's fault 5: it finds no gripper"),
            (_, 9) => (StopCause::CommunicationLost, "controller's fault 9: its network is not ready"),
            (_, 0x0c) => (StopCause::EmergencyStop, "controller's fault 12: an emergency stop"),
            (_, 0x0e) => (StopCause::Failure, "controller's fault 14: too much current"),
            (_, _) => (StopCause::Failure, "a fault of its controller"),
        };
        Some(RobotStop::new(cause).named(name))
    }

    /// Whether it was told nothing for a second, which it forgets when it is told something.
    #[must_use]
    pub const fn is_idle(self) -> bool {
        self.0[2] == 0x09
    }

    /// Whether only a new activation clears its fault: the major ones, 10 and above.
    #[must_use]
    pub const fn must_be_activated_anew(self) -> bool {
        self.0[2] & 0x0f >= 0x0a
    }
}

/// It is not activated, as after every loss of its power.
pub(crate) const INACTIVE: RobotStop = RobotStop::new(StopCause::PowerOff)
    .named("not activated: take out what it holds, then write homed = false: its fingers will move");

#[cfg(test)]
mod tests {
    use mrroc::robot::ClearedBy;

    use super::*;

    /// Registers that the manual prints, section 4.7: activation, closing, closed on an object, opened.
    #[test]
    fn requests_and_states_are_those_of_the_manufacturers_manual() {
        assert_eq!(Request::Rest.registers(), [0, 0, 0]);
        assert_eq!(Request::Activate.registers(), [0x0100, 0, 0]);
        let close = Request::GoTo { position: 255, speed: 255, force: 255 };
        assert_eq!(close.registers(), [0x0900, 0x00ff, 0xffff]);

        let activating = Status::new([0x1100, 0, 0]);
        assert!(!activating.is_active() && !activating.is_reset() && activating.stop() == Some(INACTIVE));
        let active = Status::new([0x3100, 0, 0]);
        assert!(active.is_active() && !active.goes() && active.stop().is_none());
        let closing = Status::new([0x3900, 0x00ff, 0x0e0a]);
        assert!(closing.goes() && closing.fingers() == Fingers::Moving && closing.told() == 255);
        assert!((closing.current() - 0.1).abs() < 1e-12);
        let held = Status::new([0xb900, 0x00ff, 0xbd00]);
        assert_eq!((held.fingers(), held.position()), (Fingers::HeldClosing, 189));
        let opened = Status::new([0xf900, 0, 0x0d00]);
        assert_eq!((opened.fingers(), opened.position(), opened.told()), (Fingers::There, 13, 0));
    }

    #[test]
    fn a_state_survives_its_word() {
        let status = Status::new([0xb9ff, 0x00ff, 0xbd01]);
        assert_eq!(Status::from_word(status.to_word()), Some(status));
        assert_eq!(Status::from_word(0), None);
        assert!(Status::from_word(Status::new([0, 0, 0]).to_word()).is_some());
    }

    #[test]
    fn fault_103_every_fault_has_its_cause_and_none_that_needs_a_person_is_cleared_by_a_reset() {
        let stop = |fault: u16| Status::new([0x3100, fault << 8, 0]).stop().map(|stop| stop.cause());
        for (fault, cause) in [
            (0x05, StopCause::PowerOff),
            (0x07, StopCause::PowerOff),
            (0x08, StopCause::ProtectiveStop),
            (0x09, StopCause::CommunicationLost),
            (0x0a, StopCause::PowerOff),
            (0x0b, StopCause::EmergencyStop),
            (0x0c, StopCause::Failure),
            (0x0d, StopCause::Failure),
            (0x0e, StopCause::Failure),
            (0x0f, StopCause::EmergencyStop),
            (0x40, StopCause::PowerOff),
            (0xc0, StopCause::EmergencyStop),
            (0xc8, StopCause::ProtectiveStop),
        ] {
            assert_eq!(stop(fault), Some(cause), "{fault:#x}");
        }
        for fault in 1..=0xff {
            let status = Status::new([0x3100, fault << 8, 0]);
            let stop = status.stop().expect("a fault");
            // A fault has room for 120 bytes.
            assert!(!stop.name().is_empty() && stop.to_string().len() <= 120, "{stop}");
            // What only an activation clears, which moves the fingers, is not for the operator alone.
            let by_operator = stop.cleared_by() == ClearedBy::Operator;
            assert!(!(status.must_be_activated_anew() && by_operator), "{fault:#x}");
        }
    }
}
