//! The letters of TEXT, ATTRIB and MTEXT: what their codes stand for, without what only concerns looks.
//!
//! `\U+XXXX` is a letter of Unicode, `\M+nXXXX` one of an East Asian code page, `^J` a control character. `%%c`, `%%d`
//! and `%%p` are diameter, degree and plus-minus, `%%nnn` is a letter by its number. A code that is not known is
//! written as it stands, as CAD programs do.

use encoding_rs::{BIG5, EUC_KR, Encoding, GBK, SHIFT_JIS, WINDOWS_1252};

/// What stands for a letter whose code cannot be read.
const UNREADABLE: char = char::REPLACEMENT_CHARACTER;

/// The letters of a TEXT or an ATTRIB: one line.
pub fn of_line(raw: &str) -> String {
    let raw = with_control_characters(raw);
    let mut letters = String::with_capacity(raw.len());
    let mut rest = raw.as_str();
    while let Some(c) = rest.chars().next() {
        let read = match c {
            '\\' => by_number(rest),
            '%' => percent_code(rest).or_else(|| line_beside(rest)),
            _ => None,
        };
        let (letter, length) = read.unwrap_or((Some(c), c.len_utf8()));
        letters.extend(letter.map(|c| if c == '\t' { ' ' } else { c }).filter(|c| !c.is_control()));
        rest = &rest[length..];
    }
    letters
}

/// The lines of an MTEXT.
pub fn of_paragraphs(raw: &str) -> Vec<String> {
    let raw = with_control_characters(raw);
    let mut lines = vec![String::new()];
    let mut rest = raw.as_str();
    while let Some(c) = rest.chars().next() {
        let (read, length) = match c {
            '\\' => backslash(rest),
            '{' | '}' => (Read::Nothing, 1),
            '%' => match percent_code(rest) {
                Some((letter, length)) => (letter.map_or(Read::Nothing, Read::Letter), length),
                None => (Read::Letter(c), 1),
            },
            '\n' => (Read::Line, 1),
            '\r' => (Read::Nothing, 1),
            c if c.is_control() => (Read::Letter(' '), c.len_utf8()),
            c => (Read::Letter(c), c.len_utf8()),
        };
        rest = rest.get(length..).unwrap_or("");
        match (read, lines.last_mut()) {
            (Read::Line, _) => lines.push(String::new()),
            (Read::Letter(letter), Some(line)) => line.push(letter),
            (Read::Letters(letters), Some(line)) => line.push_str(&letters),
            (Read::Letter(_) | Read::Letters(_), None) | (Read::Nothing, _) => {}
        }
    }
    lines
}

/// What a code of an MTEXT stands for.
enum Read {
    Nothing,
    Letter(char),
    Letters(String),
    Line,
}

/// A code that begins with a backslash, and how long it is \[bytes\].
fn backslash(rest: &str) -> (Read, usize) {
    if let Some((letter, length)) = by_number(rest) {
        return (letter.map_or(Read::Nothing, Read::Letter), length);
    }
    let behind = &rest[1..];
    let Some(command) = behind.chars().next() else { return (Read::Letter('\\'), 1) };
    let value = &behind[command.len_utf8()..];
    let looks = |length: usize| {
        let end = usize::from(value[length..].starts_with(';'));
        (Read::Nothing, 1 + command.len_utf8() + length + end)
    };
    match command {
        '\\' | '{' | '}' => (Read::Letter(command), 2),
        '~' => (Read::Letter(' '), 2),
        'P' | 'N' | 'X' => (Read::Line, 2),
        // Lines under, over and through.
        'L' | 'l' | 'O' | 'o' | 'K' | 'k' => (Read::Nothing, 2),
        // Alignment, colour, height, width, tracking, slant: a value, and a semicolon that may lack.
        'A' => looks(value.chars().next().map_or(0, char::len_utf8)),
        'C' | 'c' => looks(value.bytes().take_while(u8::is_ascii_digit).count()),
        'H' | 'W' | 'T' | 'Q' => looks(number_length(value)),
        // Fonts and paragraphs: up to the semicolon.
        'f' | 'F' | 'p' => looks(value.find(';').unwrap_or(value.len())),
        'S' => {
            let (stacked, length) = stacked(value);
            (Read::Letters(stacked), 2 + length)
        }
        other => (Read::Letters(format!("\\{other}")), 1 + other.len_utf8()),
    }
}

/// How long a number is, with the `x` of a factor \[bytes\].
fn number_length(value: &str) -> usize {
    let bytes = value.as_bytes();
    let digits = |from: usize| from + bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let mut at = digits(usize::from(value.starts_with(['+', '-'])));
    if bytes.get(at) == Some(&b'.') {
        at = digits(at + 1);
    }
    at + usize::from(bytes.get(at) == Some(&b'x'))
}

/// A fraction: what stands above, a slash, what stands below, up to the semicolon; and its length \[bytes\].
fn stacked(value: &str) -> (String, usize) {
    let mut letters = String::new();
    let mut rest = value;
    while let Some(c) = rest.chars().next() {
        rest = &rest[c.len_utf8()..];
        match c {
            ';' => break,
            '\\' => {
                // A letter by number, or one that is meant itself.
                let whole = &value[value.len() - rest.len() - 1..];
                if let Some((letter, length)) = by_number(whole) {
                    letters.extend(letter);
                    rest = &whole[length..];
                } else if let Some(escaped) = rest.chars().next() {
                    letters.push(escaped);
                    rest = &rest[escaped.len_utf8()..];
                }
            }
            '%' => {
                let whole = &value[value.len() - rest.len() - 1..];
                match percent_code(whole) {
                    Some((letter, length)) => {
                        letters.extend(letter);
                        rest = &whole[length..];
                    }
                    None => letters.push('%'),
                }
            }
            '^' | '#' => letters.push('/'),
            c if c.is_control() => letters.push(' '),
            c => letters.push(c),
        }
    }
    (letters, value.len() - rest.len())
}

/// Caret notation: `^J` is a new line, `^I` a tabulator, `^ ` the caret itself.
fn with_control_characters(raw: &str) -> String {
    let mut letters = String::with_capacity(raw.len());
    let mut rest = raw.chars();
    while let Some(c) = rest.next() {
        if c != '^' {
            letters.push(c);
            continue;
        }
        match rest.next() {
            Some(' ') | None => letters.push('^'),
            Some(control @ '@'..='_') => {
                letters.extend(u32::from(control).checked_sub(64).and_then(char::from_u32));
            }
            // The caret of a fraction, as of a tolerance `+0.1^-0.1`.
            Some(other) => letters.extend(['^', other]),
        }
    }
    letters
}

/// `\U+XXXX` or `\M+nXXXX` at the start of a text, and its length \[bytes\].
fn by_number(rest: &str) -> Option<(Option<char>, usize)> {
    let hexadecimal = |from: usize, digits: usize| {
        let text = rest.get(from..from + digits)?;
        text.bytes().all(|b| b.is_ascii_hexdigit()).then(|| u32::from_str_radix(text, 16).ok())?
    };
    if rest.starts_with("\\U+") {
        let four = hexadecimal(3, 4)?;
        // Letters past U+FFFF have eight digits: no letter that four digits could mean begins with 0000 to 0010.
        if let Some(eight) = hexadecimal(3, 8).filter(|eight| (0x1_0000..=0x10_FFFF).contains(eight)) {
            return Some((Some(char::from_u32(eight).unwrap_or(UNREADABLE)), 11));
        }
        return Some((Some(char::from_u32(four).unwrap_or(UNREADABLE)), 7));
    }
    let code_page = rest.strip_prefix("\\M+")?.chars().next()?;
    let encoding: Option<&Encoding> = match code_page {
        '1' => Some(SHIFT_JIS),
        '2' => Some(BIG5),
        '3' => Some(EUC_KR),
        // Johab, which nobody writes any more.
        '4' => None,
        '5' => Some(GBK),
        _ => return None,
    };
    let [_, _, high, low] = hexadecimal(4, 4)?.to_be_bytes();
    let pair = [high, low];
    let bytes = if high == 0 { &pair[1..] } else { &pair[..] };
    let read = encoding.and_then(|encoding| {
        let letters = encoding.decode_without_bom_handling_and_without_replacement(bytes)?;
        letters.chars().next()
    });
    Some((Some(read.unwrap_or(UNREADABLE)), 8))
}

/// `%%c`, `%%d`, `%%p`, `%%%` or `%%nnn` at the start of a text, and its length \[bytes\].
fn percent_code(rest: &str) -> Option<(Option<char>, usize)> {
    let code = rest.strip_prefix("%%")?;
    let letter = match code.chars().next()?.to_ascii_lowercase() {
        'c' => 'Ø',
        'd' => '°',
        'p' => '±',
        '%' => '%',
        '0'..='9' => {
            let number: u8 = code.get(..3)?.parse().ok()?;
            let letter = WINDOWS_1252.decode_without_bom_handling(&[number]).0.chars().next();
            return Some((letter.filter(|c| !c.is_control()), 5));
        }
        _ => return None,
    };
    Some((Some(letter), 3))
}

/// `%%u`, `%%o`, `%%k`: lines under, over and through a TEXT begin or end.
fn line_beside(rest: &str) -> Option<(Option<char>, usize)> {
    let code = rest.strip_prefix("%%")?.chars().next()?;
    matches!(code.to_ascii_lowercase(), 'u' | 'o' | 'k').then_some((None, 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What ezdxf reads, by `tests/reference/texts.py`; rows in JSON, which has escapes for all letters.
    #[test]
    fn letters_are_those_of_ezdxf() {
        let rows = include_str!("tests/reference/texts.jsonl").lines();
        let mut count = 0;
        for row in rows {
            let row: serde_json::Value = serde_json::from_str(row).unwrap();
            let (kind, raw, expected) =
                (&row["kind"], row["raw"].as_str().unwrap(), row["plain"].as_str().unwrap());
            let found = if kind == "TEXT" { of_line(raw) } else { of_paragraphs(raw).join("\n") };
            assert_eq!(found, expected, "{kind} {raw:?}");
            count += 1;
        }
        assert!(count > 40, "{count}");
    }

    /// AutoCAD's manual (Control Codes and Special Characters): %%nnn is the letter of that number; ezdxf does not read it.
    #[test]
    fn letters_by_number_are_those_of_the_code_page() {
        assert_eq!(of_line("%%065%%176%%2165"), "A°Ø5");
        assert_eq!(of_paragraphs("%%065%%177"), ["A±"]);
        assert_eq!(of_line("%%45"), "%%45");
        assert_eq!(of_line(r"\U+0001F600 \M+41234"), "\u{1F600} \u{FFFD}");
    }

    #[test]
    fn fractions_are_written_in_a_line() {
        assert_eq!(of_paragraphs(r"a\S1/2;b \S+0.1^-0.2; \S3#4;"), ["a1/2b +0.1/-0.2 3/4"]);
        assert_eq!(of_paragraphs(r"\S%%c5^ %%d;"), ["Ø5/°"]);
    }

    proptest::proptest! {
        #[test]
        fn no_text_panics(raw in "([\\\\%^;{}]|[UMSHCAfp+]|[0-9xж]|.){0,20}") {
            let _ = of_line(&raw);
            let _ = of_paragraphs(&raw);
        }
    }
}
