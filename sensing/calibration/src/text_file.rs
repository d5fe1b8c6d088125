//! Texts that users wrote: tables of measurements, headers, calibration files. All commands read them here, so that what one takes the others take, too.
//!
//! In: a file, as an editor or a spreadsheet program has saved it. Out: its text, without a byte-order mark and with lines that end by `\n`. UTF-8 and, if a
//! byte-order mark says so, UTF-16 ("Unicode text" of spreadsheet programs) are read.

use std::io::{self, Read};
use std::path::Path;

use mrroc_launch::files;

/// The most bytes of a text.
const MOST: u64 = 64 << 20;

/// Reads a text.
///
/// # Errors
/// What is wrong, and what to do: two texts, neither with the file's name.
pub fn read(path: &Path) -> Result<String, [String; 2]> {
    let mut bytes = Vec::new();
    let opened = files::open(path).and_then(|file| file.take(MOST + 1).read_to_end(&mut bytes));
    opened.map_err(|why: io::Error| {
        [format!("cannot be read: {why}"), "see its name, and that it is a file that may be read".to_owned()]
    })?;
    if bytes.len() as u64 > MOST {
        return Err([format!("has more than {} MB", MOST >> 20), "leave out rows or columns".to_owned()]);
    }
    parse(&bytes)
}

/// The text in some bytes.
///
/// # Errors
/// What is wrong with them, and what to do.
pub fn parse(bytes: &[u8]) -> Result<String, [String; 2]> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
        String::from_utf16(&units).ok()
    };
    let text = match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8(rest.to_vec()).ok(),
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        _ => String::from_utf8(bytes.to_vec()).ok(),
    };
    let text = text.ok_or_else(|| {
        let what = "is no text in UTF-8".to_owned();
        [what, "save it as plain text (CSV) in UTF-8".to_owned()]
    })?;
    Ok(text.replace("\r\n", "\n").replace('\r', "\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_the_same_whatever_program_has_saved_it() {
        let plain = "x_mm,y_mm\n1,2\n";
        let utf16 = |unit: fn(u16) -> [u8; 2]| plain.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
        let saved = [
            plain.as_bytes().to_vec(),
            [b"\xef\xbb\xbf", plain.as_bytes()].concat(),
            b"\xef\xbb\xbfx_mm,y_mm\r\n1,2\r\n".to_vec(),
            b"x_mm,y_mm\r1,2\r".to_vec(),
            [vec![0xff, 0xfe], utf16(u16::to_le_bytes)].concat(),
            [vec![0xfe, 0xff], utf16(u16::to_be_bytes)].concat(),
        ];
        for bytes in saved {
            assert_eq!(parse(&bytes).as_deref(), Ok(plain), "{bytes:?}");
        }
        assert!(parse(b"x_mm\xff\n").is_err());
    }
}
