//! The messages of the hand's interface, version 3, as bytes.
//!
//! In: the hand's state, a datagram some 60 times a second, and its answers to requests, over TCP. Out: requests. All numbers are
//! little-endian, and nothing is padded. Laid out as in libfranka's `research_interface/gripper/types.h`.

use mrroc_driver_kit::Cutting;

/// The version of the interface.
pub const VERSION: u16 = 3;

/// The port at which a hand takes requests.
pub const PORT: u16 = 1338;

/// Bytes of a state.
pub const STATE: usize = 23;

/// Bytes before what a request or its answer says.
const HEADER: usize = 10;

/// The most bytes that an answer may have.
const LONGEST_ANSWER: usize = 64;

/// What the hand is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// To send its states to this port.
    Connect {
        /// The port.
        port: u16,
    },
    /// To measure how far it opens: **its fingers move**.
    Homing,
    /// To close until something stops the fingers, and to press on it.
    Grasp {
        /// The opening at which something is expected \[m\].
        width: f64,
        /// How much narrower \[m\] and how much wider \[m\] it may be to count as grasped.
        band: (f64, f64),
        /// The speed of the opening [m/s], > 0.
        speed: f64,
        /// The force \[N\], > 0.
        force: f64,
    },
    /// To move the fingers to an opening.
    Move {
        /// The opening \[m\].
        width: f64,
        /// Its speed [m/s], > 0.
        speed: f64,
    },
    /// To end the motion that goes on, or to let go.
    Stop,
}

impl Request {
    const fn number(self) -> u16 {
        match self {
            Request::Connect { .. } => 0,
            Request::Homing => 1,
            Request::Grasp { .. } => 2,
            Request::Move { .. } => 3,
            Request::Stop => 4,
        }
    }

    /// Its bytes with this number of its own.
    #[must_use]
    pub fn bytes(self, id: u32) -> Vec<u8> {
        let doubles = |numbers: &[f64]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let says: Vec<u8> = match self {
            Request::Connect { port } => [VERSION.to_le_bytes(), port.to_le_bytes()].concat(),
            Request::Homing | Request::Stop => Vec::new(),
            Request::Grasp { width, band: (inner, outer), speed, force } => {
                doubles(&[width, inner, outer, speed, force])
            }
            Request::Move { width, speed } => doubles(&[width, speed]),
        };
        let size = (HEADER + says.len()) as u32;
        [self.number().to_le_bytes().as_slice(), &id.to_le_bytes(), &size.to_le_bytes(), &says].concat()
    }
}

/// What became of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It was done.
    Done,
    /// It could not be done, or not begun.
    Failed,
    /// It was tried in vain: nothing was grasped.
    Unsuccessful,
    /// It was ended by a stop.
    Aborted,
}

/// An answer of the hand to a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The request's number.
    pub id: u32,
    /// What it says: 0 is success.
    pub status: u16,
    /// Its version, where it answers a connection; 0 where it says none.
    pub version: u16,
}

impl Answer {
    /// Where the answer at the front of these bytes ends.
    #[must_use]
    pub fn cut(bytes: &[u8]) -> Cutting {
        let Some(&[a, b, c, d]) = bytes.get(6..HEADER) else { return Cutting::More };
        let size = u32::from_le_bytes([a, b, c, d]) as usize;
        if (HEADER + 2..=LONGEST_ANSWER).contains(&size) { Cutting::Frame(size) } else { Cutting::Bad }
    }

    /// What such a frame says; `None` if it is none.
    #[must_use]
    pub fn read(frame: &[u8]) -> Option<Answer> {
        let word = |at: usize| Some(u16::from_le_bytes(frame.get(at..at + 2)?.try_into().ok()?));
        let id = u32::from_le_bytes(frame.get(2..6)?.try_into().ok()?);
        Some(Answer { id, status: word(HEADER)?, version: word(HEADER + 2).unwrap_or(0) })
    }

    /// What became of a request that is no connection; `None` if the answer has no such meaning.
    #[must_use]
    pub const fn outcome(&self) -> Option<Outcome> {
        match self.status {
            0 => Some(Outcome::Done),
            1 => Some(Outcome::Failed),
            2 => Some(Outcome::Unsuccessful),
            3 => Some(Outcome::Aborted),
            _ => None,
        }
    }
}

/// What the hand says of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Its count of states, or its time \[ms\]: it grows.
    pub count: u32,
    /// The opening between its fingers \[m\].
    pub width: f64,
    /// The widest opening \[m\], as the homing has measured it; 0 before.
    pub max_width: f64,
    /// Whether something is grasped.
    pub is_grasped: bool,
    /// Its temperature \[°C\].
    pub temperature: u16,
}

impl State {
    /// What a datagram says; `None` if it is no state, or has numbers that are none.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<State> {
        let bytes: &[u8; STATE] = bytes.try_into().ok()?;
        let double = |at: usize| {
            let eight = bytes[at..at + 8].try_into().ok()?;
            Some(f64::from_le_bytes(eight)).filter(|number| number.is_finite())
        };
        Some(State {
            count: u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
            width: double(4)?,
            max_width: double(12)?,
            is_grasped: bytes[20] != 0,
            temperature: u16::from_le_bytes([bytes[21], bytes[22]]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_have_the_sizes_and_numbers_of_the_interface() {
        assert_eq!(
            Request::Connect { port: 0x1234 }.bytes(7),
            [0, 0, 7, 0, 0, 0, 14, 0, 0, 0, 3, 0, 0x34, 0x12]
        );
        assert_eq!(Request::Homing.bytes(8), [1, 0, 8, 0, 0, 0, 10, 0, 0, 0]);
        assert_eq!(Request::Stop.bytes(9), [4, 0, 9, 0, 0, 0, 10, 0, 0, 0]);
        let told = Request::Move { width: 0.5, speed: 0.25 }.bytes(1);
        assert_eq!((told[0], told[6], told.len()), (3, 26, 26));
        assert_eq!(told[10..], [0.5_f64.to_le_bytes(), 0.25_f64.to_le_bytes()].concat());
        // The opening, what it may be narrower and wider by, the speed, the force.
        let told = Request::Grasp { width: 0.5, band: (0.25, 2.0), speed: 4.0, force: 40.0 }.bytes(2);
        assert_eq!((told[0], told[6], told.len()), (2, 50, 50));
        let numbers = [0.5_f64, 0.25, 2.0, 4.0, 40.0].map(f64::to_le_bytes).concat();
        assert_eq!(told[10..], numbers);
    }

    #[test]
    fn an_answer_is_cut_where_it_ends_and_a_size_that_none_has_is_refused() {
        let connected = [0, 0, 7, 0, 0, 0, 14, 0, 0, 0, 1, 0, 2, 0];
        for len in 0..10 {
            assert_eq!(Answer::cut(&connected[..len]), Cutting::More, "{len} bytes");
        }
        assert_eq!(Answer::cut(&connected), Cutting::Frame(14));
        assert_eq!(Answer::read(&connected), Some(Answer { id: 7, status: 1, version: 2 }));
        let moved = [3, 0, 9, 0, 0, 0, 12, 0, 0, 0, 3, 0];
        let answer = Answer::read(&moved).expect("whole");
        assert_eq!((answer.id, answer.outcome()), (9, Some(Outcome::Aborted)));
        assert_eq!(Answer { status: 4, ..answer }.outcome(), None);
        assert_eq!(Answer::read(&moved[..11]), None);
        for size in [0, 11, 65, u32::MAX] {
            let mut bad = moved;
            bad[6..10].copy_from_slice(&size.to_le_bytes());
            assert_eq!(Answer::cut(&bad), Cutting::Bad, "{size}");
        }
    }

    #[test]
    fn a_state_is_read_from_its_23_bytes_and_from_no_others() {
        let mut bytes = [0; STATE];
        bytes[..4].copy_from_slice(&77_u32.to_le_bytes());
        bytes[4..12].copy_from_slice(&0.0625_f64.to_le_bytes());
        bytes[12..20].copy_from_slice(&0.08_f64.to_le_bytes());
        bytes[20..].copy_from_slice(&[1, 31, 0]);
        let state = State { count: 77, width: 0.0625, max_width: 0.08, is_grasped: true, temperature: 31 };
        assert_eq!(State::read(&bytes), Some(state));
        assert_eq!(State::read(&bytes[1..]), None);
        assert_eq!(State::read(&[bytes.as_slice(), &[0]].concat()), None);
        for at in [4, 12] {
            let mut bad = bytes;
            bad[at..at + 8].copy_from_slice(&f64::NAN.to_le_bytes());
            assert_eq!(State::read(&bad), None);
        }
    }
}
