//! The primary interface: messages of the controller to whoever calls its port 30001, of which one part is read here.
//!
//! In: bytes. Out: the arm's [`Calibration`]; and back, for a controller in tests. All numbers are big-endian. A message is its
//! length with all of this (32 bits), its type (8 bits), and, in the one of type 16, parts with a length and a type of the same
//! form. Part 5 has the kinematics: six checksums (32 bits), then theta, a, d, alpha of six joints each (64 bits), and a
//! status (32 bits).

use crate::calibration::Calibration;
use crate::models::JOINTS;

/// Bytes of the head of a message, and of a part.
const HEAD: usize = 5;

/// The type of the message with the state of the robot.
const ROBOT_STATE: u8 = 16;

/// The type of its part with the kinematics.
pub const KINEMATICS: u8 = 5;

/// The most bytes that a message of the controller may have.
pub const MAX_MESSAGE: usize = 4096;

/// The length of the message at the front of these bytes; `None` before that is known.
///
/// # Errors
/// They are no message: they say that they are shorter than a head, or longer than [`MAX_MESSAGE`].
pub fn message_length(bytes: &[u8]) -> Result<Option<usize>, NoMessage> {
    let Some(length) = bytes.first_chunk().map(|length| u32::from_be_bytes(*length) as usize) else {
        return Ok(None);
    };
    if (HEAD..=MAX_MESSAGE).contains(&length) { Ok(Some(length)) } else { Err(NoMessage) }
}

/// Bytes that are no message of the primary interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoMessage;

/// The calibration in a message, if it has one.
///
/// ```
/// use mrroc_ur::{Calibration, UrModel, primary};
///
/// let calibration = Calibration::nominal(UrModel::Ur5e);
/// let message = primary::with_kinematics(&calibration);
/// assert_eq!(primary::message_length(&message), Ok(Some(message.len())));
/// assert_eq!(primary::calibration(&message), Some(calibration));
/// ```
#[must_use]
pub fn calibration(message: &[u8]) -> Option<Calibration> {
    let (of, mut rest) = part(message)?.0.split_first()?;
    if *of != ROBOT_STATE {
        return None;
    }
    while let Some((content, after)) = part(rest) {
        if let Some((&KINEMATICS, bytes)) = content.split_first() {
            return read(bytes);
        }
        rest = after;
    }
    None
}

/// What follows the length of the message or part at the front, and what follows that.
fn part(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let length = u32::from_be_bytes(*bytes.first_chunk()?) as usize;
    if length < HEAD {
        return None;
    }
    let (part, after) = bytes.split_at_checked(length)?;
    Some((part.get(4..)?, after))
}

fn read(bytes: &[u8]) -> Option<Calibration> {
    let (checksums, doubles) = bytes.split_at_checked(4 * JOINTS)?;
    let mut checksums =
        checksums.chunks_exact(4).map(|four| u32::from_be_bytes([four[0], four[1], four[2], four[3]]));
    let mut doubles = doubles.chunks_exact(8).map(|eight| {
        let mut bytes = [0; 8];
        bytes.copy_from_slice(eight);
        f64::from_be_bytes(bytes)
    });
    let mut checksum = [0; JOINTS];
    for one in &mut checksum {
        *one = checksums.next()?;
    }
    let mut six = || {
        let mut six = [0.0; JOINTS];
        for one in &mut six {
            *one = doubles.next().filter(|number| number.is_finite())?;
        }
        Some(six)
    };
    let (theta, a, d, alpha) = (six()?, six()?, six()?, six()?);
    Calibration { theta, a, d, alpha, checksum }.is_sane()
}

/// A message of a controller with these kinematics, behind a part that a driver skips.
#[must_use]
pub fn with_kinematics(calibration: &Calibration) -> Vec<u8> {
    // The masterboard's voltages and currents, as zeros.
    message(&[(3, vec![0; 72]), (KINEMATICS, kinematics(calibration))])
}

/// A message with the state of a robot, of parts with these types and contents.
#[must_use]
pub fn message(parts: &[(u8, Vec<u8>)]) -> Vec<u8> {
    let mut contents = Vec::new();
    for (of, content) in parts {
        put(&mut contents, *of, content);
    }
    let mut message = Vec::new();
    put(&mut message, ROBOT_STATE, &contents);
    message
}

/// The content of the part with the kinematics, of type [`KINEMATICS`].
#[must_use]
pub fn kinematics(calibration: &Calibration) -> Vec<u8> {
    let mut kinematics = Vec::new();
    kinematics.extend(calibration.checksum.iter().flat_map(|one| one.to_be_bytes()));
    let Calibration { theta, a, d, alpha, .. } = calibration;
    kinematics.extend([theta, a, d, alpha].into_iter().flatten().flat_map(|one| one.to_be_bytes()));
    // Linearised, as a calibrated arm is.
    kinematics.extend(2_u32.to_be_bytes());
    kinematics
}

/// Appends a message or a part with its head.
pub fn put(to: &mut Vec<u8>, of: u8, content: &[u8]) {
    to.extend(((HEAD + content.len()) as u32).to_be_bytes());
    to.push(of);
    to.extend(content);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::UrModel;

    #[test]
    fn the_part_has_the_bytes_of_the_guide_and_what_is_none_is_not_read() {
        let calibration = Calibration::nominal(UrModel::Ur10e);
        let message = with_kinematics(&calibration);
        // 225 bytes: 5 of the head, 24 of checksums, 4 times 48, and the status.
        let at = message.len() - 225;
        assert_eq!(message[at..at + 5], [0, 0, 0, 225, 5]);
        assert_eq!(super::calibration(&message), Some(calibration));
        // Another message, a part that is longer than its message, one that ends early, and a number that is none.
        let with = |place: usize, byte: u8| {
            let mut bytes = message.clone();
            bytes[place] = byte;
            super::calibration(&bytes)
        };
        assert_eq!(with(4, 20), None);
        assert_eq!(with(at + 3, 226), None);
        assert_eq!(super::calibration(&message[..message.len() - 1]), None);
        assert_eq!(with(8, 1), None, "a part without a head");
        let nan = f64::NAN.to_be_bytes();
        let mut bytes = message.clone();
        bytes[at + 29..at + 37].copy_from_slice(&nan);
        assert_eq!(super::calibration(&bytes), None);
        assert_eq!((message_length(&[0, 0, 0]), message_length(&[0, 0, 0, 4])), (Ok(None), Err(NoMessage)));
        assert_eq!(message_length(&[0, 1, 0, 0]), Err(NoMessage));
    }
}
