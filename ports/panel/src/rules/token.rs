//! The token: who knows it may watch the cell, and take authority over it.
//!
//! In: random numbers of the system. Out: a secret of 128 bits, one for each start of the panel, and whether a text is it.

use core::fmt;
use std::fs::File;
use std::io::{self, Read};

/// A secret of 128 bits.
#[derive(Clone, Copy)]
pub struct Token([u8; 16]);

impl Token {
    /// A new one.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub fn draw() -> io::Result<Token> {
        let mut bytes = [0; 16];
        File::open("/dev/urandom")?.read_exact(&mut bytes)?;
        Ok(Token(bytes))
    }

    /// Whether a text is this token, in a time that does not tell how much of it is right.
    #[must_use]
    pub fn is(&self, text: &str) -> bool {
        let own = self.to_string();
        own.len() == text.len()
            && own.bytes().zip(text.bytes()).fold(0, |differ, (a, b)| differ | (a ^ b)) == 0
    }
}

/// 32 hexadecimal digits.
impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// Without the secret, so that no message tells it.
impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fault_200_a_token_is_known_by_all_of_its_digits_and_by_nothing_else() {
        let (token, other) = (Token::draw().expect("random numbers"), Token::draw().expect("random numbers"));
        let text = token.to_string();
        assert!(text.len() == 32 && text.bytes().all(|digit| digit.is_ascii_hexdigit()));
        assert!(token.is(&text) && !token.is(&other.to_string()));
        for wrong in
            ["", &text[..31], &format!("{text}0"), &text.to_uppercase().replace(char::is_numeric, "x")]
        {
            assert!(!token.is(wrong), "{wrong}");
        }
        for place in 0..32 {
            let digit = if text.as_bytes()[place] == b'0' { "1" } else { "0" };
            let mut wrong = text.clone();
            wrong.replace_range(place..=place, digit);
            assert!(!token.is(&wrong), "digit {place}");
        }
        assert!(!format!("{token:?}").contains(&text[..4]));
    }
}
