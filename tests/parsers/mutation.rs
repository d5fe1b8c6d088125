//! Makes bad input from good input: seeded mutations of a corpus, as fuzzers make them, but without measuring coverage.

use mrroc::random::Random;

/// Texts that are difficult for readers.
const TOKENS: [&[u8]; 36] = [
    b"0",
    b"-1",
    b"1e308",
    b"-1e308",
    b"1e-320",
    b"NaN",
    b"inf",
    b"1e999",
    b"-0",
    b"99999999999999999999",
    b"2147483648",
    b"4294967295",
    b"0x7f",
    b"1_0",
    b"\"",
    b"'",
    b"<",
    b"</g>",
    b"<g>",
    b"&#x0;",
    b"&a;",
    b"]]>",
    b"[",
    b"]",
    b"{",
    b"}",
    b"(",
    b")",
    b"\n",
    b"\r\n",
    b"\0",
    b"\xff",
    b"\xef\xbb\xbf",
    b"#1=[#1+1]",
    b"\xe2\x80\xae",
    b"  ",
];

/// Longest input that mutations make \[bytes\].
const LONGEST: usize = 8192;

/// Another input of a corpus that is not empty.
pub fn mutate(corpus: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = corpus[random.below(corpus.len())].clone();
    for _ in 0..=random.below(6) {
        let at = random.below(bytes.len() + 1);
        let len = (1 + random.below(32)).min(bytes.len() - at);
        match random.below(9) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            1 if at < bytes.len() => bytes[at] = random.bits() as u8,
            2 => drop(bytes.drain(at..at + len)),
            3 => bytes.truncate(at),
            4 => {
                let copy = bytes[at..at + len].repeat(1 + random.below(8));
                bytes.splice(at..at, copy);
            }
            5 => {
                // A piece of another input.
                let other = &corpus[random.below(corpus.len())];
                let from = random.below(other.len());
                let piece = other[from..(from + len * 4).min(other.len())].to_vec();
                bytes.splice(at..at + len, piece);
            }
            6 => {
                // Digits become others: numbers of every size.
                for byte in bytes[at..at + len].iter_mut().filter(|byte| byte.is_ascii_digit()) {
                    *byte = b'0' + random.below(10) as u8;
                }
            }
            _ => {
                let token = TOKENS[random.below(TOKENS.len())];
                bytes.splice(at..at + len.min(token.len()), token.iter().copied());
            }
        }
        bytes.truncate(LONGEST);
    }
    bytes
}
