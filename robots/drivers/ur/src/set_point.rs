//! What the script on the controller is told: in every period eight numbers of 32 bits, as in UR's own drivers.

use core::time::Duration;

use mrroc::robot::Load;
use nalgebra::Matrix3;

use crate::inertia::{elements, inertia};
use crate::models::JOINTS;

/// Bytes of a message.
pub const SET_POINT_BYTES: usize = 32;

/// Parts of a radian that are told: 1 µrad.
const PARTS: f64 = 1e6;

/// What the script is asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Ask {
    /// To come to rest and end.
    End = -2,
    /// To stay at rest.
    Idle = 0,
    /// To drive the joints to this position.
    Servo = 1,
    /// To reckon with a load of this mass and centre, and of the inertia that was told last, from now on, and to go on with what it
    /// does. The number is none of UR's own.
    Load = 101,
    /// To remember this inertia, for the load that is told next.
    Inertia = 102,
}

/// A message to the script, big-endian: the read timeout \[ms\], six joint positions \[µrad\], and what is asked. In the place of positions
/// a load has its mass \[mg\] and its centre in the flange frame \[µm\], and an inertia its elements xx, yy, zz, xy, xz, yz [mg m²].
///
/// ```
/// use core::time::Duration;
/// use mrroc_ur::{Ask, SetPoint};
///
/// let message = SetPoint::to(&[0.1, -1.5, 0.0, 0.0, 0.0, 3.141_592_6], Duration::from_millis(20));
/// let bytes = message.bytes();
/// assert_eq!(bytes[..8], [0, 0, 0, 20, 0, 1, 0x86, 0xa0]); // 20 ms, 100,000 µrad
/// assert_eq!(SetPoint::read(&bytes), Some(message));
/// assert_eq!(message.joints()[5], 3.141593);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetPoint {
    timeout_ms: i32,
    joints: [i32; JOINTS],
    ask: Ask,
}

impl SetPoint {
    /// Drives the joints to `joints` \[rad\]; the next message comes before `timeout` is over.
    #[must_use]
    pub fn to(joints: &[f64; JOINTS], timeout: Duration) -> SetPoint {
        // A float beyond the range becomes its end: 2147 rad, which no arm has.
        let joints = joints.map(|q| (q * PARTS).round() as i32);
        SetPoint { timeout_ms: millis(timeout), joints, ask: Ask::Servo }
    }

    /// The flange carries this from now on: its inertia, and then the load.
    #[must_use]
    pub fn carry(load: &Load, timeout: Duration) -> [SetPoint; 2] {
        let numbers = [load.mass, load.centre.x, load.centre.y, load.centre.z, 0.0, 0.0];
        let inertia = SetPoint::to(&elements(&load.inertia), timeout);
        [
            SetPoint { ask: Ask::Inertia, ..inertia },
            SetPoint { ask: Ask::Load, ..SetPoint::to(&numbers, timeout) },
        ]
    }

    /// The mass \[kg\] and the centre in the flange frame \[m\] of a load, if this is one.
    #[must_use]
    pub fn load(&self) -> Option<(f64, [f64; 3])> {
        let [mass, x, y, z, ..] = self.joints();
        (self.ask == Ask::Load).then_some((mass, [x, y, z]))
    }

    /// The inertia of a load [kg m²], if this is one.
    #[must_use]
    pub fn inertia(&self) -> Option<Matrix3<f64>> {
        (self.ask == Ask::Inertia).then(|| inertia(self.joints()))
    }

    /// Asks for this, without a position.
    #[must_use]
    pub fn only(ask: Ask, timeout: Duration) -> SetPoint {
        SetPoint { timeout_ms: millis(timeout), joints: [0; JOINTS], ask }
    }

    /// Reads a message; `None` if it asks for what is not known here.
    #[must_use]
    pub fn read(bytes: &[u8; SET_POINT_BYTES]) -> Option<SetPoint> {
        let mut words =
            bytes.chunks_exact(4).map(|word| i32::from_be_bytes([word[0], word[1], word[2], word[3]]));
        let timeout_ms = words.next().filter(|timeout| *timeout >= 0)?;
        let mut joints = [0; JOINTS];
        for joint in &mut joints {
            *joint = words.next()?;
        }
        let ask = match words.next()? {
            -2 => Ask::End,
            0 => Ask::Idle,
            1 => Ask::Servo,
            101 => Ask::Load,
            102 => Ask::Inertia,
            _ => return None,
        };
        Some(SetPoint { timeout_ms, joints, ask })
    }

    /// Its bytes.
    #[must_use]
    pub fn bytes(&self) -> [u8; SET_POINT_BYTES] {
        let mut bytes = [0; SET_POINT_BYTES];
        let words = [self.timeout_ms].into_iter().chain(self.joints).chain([self.ask as i32]);
        for (word, place) in words.zip(bytes.chunks_exact_mut(4)) {
            place.copy_from_slice(&word.to_be_bytes());
        }
        bytes
    }

    /// How long the script may wait for the next message; 0: for ever.
    #[must_use]
    pub fn timeout(&self) -> Duration {
        Duration::from_millis(self.timeout_ms.unsigned_abs().into())
    }

    /// The joint positions \[rad\], to the µrad that the message has.
    #[must_use]
    pub fn joints(&self) -> [f64; JOINTS] {
        self.joints.map(|q| f64::from(q) / PARTS)
    }

    /// What is asked.
    #[must_use]
    pub const fn ask(&self) -> Ask {
        self.ask
    }
}

fn millis(timeout: Duration) -> i32 {
    i32::try_from(timeout.as_millis()).unwrap_or(i32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_takes_the_place_of_positions() {
        let inertia = Matrix3::new(2e-3, 1e-4, -2e-4, 1e-4, 3e-3, 5e-5, -2e-4, 5e-5, 4e-3);
        let load = Load { inertia, ..Load::point(1.25, [0.01, -0.02, 0.1].into()) };
        let [first, second] = SetPoint::carry(&load, Duration::from_millis(20));
        let words = |message: &SetPoint| -> Vec<_> {
            let word = |word: &[u8]| i32::from_be_bytes([word[0], word[1], word[2], word[3]]);
            message.bytes().chunks_exact(4).map(word).collect()
        };
        // 20 ms; xx, yy, zz, xy, xz, yz in mg m²; 102.
        assert_eq!(words(&first), [20, 2000, 3000, 4000, 100, -200, 50, 102]);
        // 20 ms; 1.25 kg in mg; 10, -20 and 100 mm in µm; nothing; 101.
        assert_eq!(words(&second), [20, 1_250_000, 10_000, -20_000, 100_000, 0, 0, 101]);
        let read = |message: &SetPoint| SetPoint::read(&message.bytes()).expect("a message");
        assert_eq!(read(&first).inertia(), Some(inertia));
        assert_eq!(read(&second).load(), Some((1.25, [0.01, -0.02, 0.1])));
        assert_eq!((read(&first).load(), read(&second).inertia()), (None, None));
        assert_eq!(SetPoint::only(Ask::Idle, Duration::ZERO).load(), None);
    }

    #[test]
    fn what_asks_for_something_unknown_is_no_message() {
        let timeout = Duration::from_millis(20);
        for ask in [Ask::End, Ask::Idle, Ask::Servo] {
            let message = SetPoint::only(ask, timeout);
            assert_eq!(SetPoint::read(&message.bytes()).map(|read| read.ask()), Some(ask));
        }
        let mut bytes = SetPoint::only(Ask::Idle, timeout).bytes();
        bytes[31] = 9;
        assert_eq!(SetPoint::read(&bytes), None);
        bytes[31] = 0;
        bytes[0] = 0xff;
        assert_eq!(SetPoint::read(&bytes), None, "a negative timeout");
    }
}
