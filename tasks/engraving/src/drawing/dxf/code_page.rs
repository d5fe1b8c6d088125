//! The 8-bit code page of a file before 2007, which its header names.

use encoding_rs::{Encoding, WINDOWS_1252};

/// The text of a file that is not UTF-8, by the code page that `$DWGCODEPAGE` names; else by that of Western Europe.
#[must_use]
pub fn decoded(bytes: &[u8]) -> String {
    let encoding = named(bytes).unwrap_or(WINDOWS_1252);
    encoding.decode_without_bom_handling(bytes).0.into_owned()
}

fn named(bytes: &[u8]) -> Option<&'static Encoding> {
    const VARIABLE: &[u8] = b"$DWGCODEPAGE";
    /// The variable stands among the first of the header.
    const HEAD: usize = 20_000;
    let head = &bytes[..bytes.len().min(HEAD)];
    let at = head.windows(VARIABLE.len()).position(|window| window == VARIABLE)?;
    // Its group code 3, then the name, as ANSI_1250.
    let text: String = head[at + VARIABLE.len()..].iter().take(100).map(|b| char::from(*b)).collect();
    let name = text.split_ascii_whitespace().nth(1)?.to_ascii_lowercase();
    let number = name.strip_prefix("ansi_").or_else(|| name.strip_prefix("dos"))?;
    let label = match number {
        "932" => "shift_jis",
        "936" => "gbk",
        "949" | "1361" => "euc-kr",
        "950" => "big5",
        "866" => "ibm866",
        number => return Encoding::for_label(format!("windows-{number}").as_bytes()),
    };
    Encoding::for_label(label.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By Unicode's tables of the code pages: B9 is ą in 1250 and ¹ in 1252.
    #[test]
    fn the_header_names_the_code_page() {
        let file = |name: &str| {
            let mut bytes = format!("0\nSECTION\n2\nHEADER\n9\n$DWGCODEPAGE\n3\n{name}\n1\n").into_bytes();
            bytes.push(0xB9);
            bytes
        };
        assert!(decoded(&file("ANSI_1250")).ends_with('ą'));
        assert!(decoded(&file("ansi_1252")).ends_with('¹'));
        assert!(decoded(&file("ANSI_1251")).ends_with('№'));
        assert!(decoded(&file("whatever")).ends_with('¹'));
        assert!(decoded(b"\xB9").ends_with('¹'));
    }
}
