//! Reads what consoles and the console server write to each other, for fuzzing. Not part of the stable interface.

use super::protocol::{ConsoleMessage, MAX_REQUEST};
use mrroc_core::operator::request::Addressed;

/// Reads `bytes` as a request of an operator's console, and as what the console server writes to a console.
///
/// # Panics
/// When a value that was read is written as something else, or an answer is longer than a line.
pub fn operator(bytes: &[u8]) {
    // The console server reads no longer requests.
    for line in bytes.split(|byte| *byte == b'\n').filter(|line| line.len() <= MAX_REQUEST) {
        match Addressed::read(&String::from_utf8_lossy(line)) {
            Ok(request) => assert_eq!(Addressed::read(&request.to_string()), Ok(request)),
            Err(refused) => assert!(!refused.in_a_line().contains('\n'), "{refused}"),
        }
    }
    let mut rest = bytes;
    while let Ok(Some(heard)) = ConsoleMessage::read(&mut rest) {
        if let ConsoleMessage::Picture(picture) = heard {
            let text = picture.to_string();
            let again = ConsoleMessage::read(&mut text.as_bytes());
            let is_same =
                matches!(&again, Ok(Some(ConsoleMessage::Picture(again))) if again.to_string() == text);
            assert!(is_same, "{again:?} of {text}");
        }
    }
}
