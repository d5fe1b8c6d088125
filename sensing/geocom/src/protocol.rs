//! Lines of GeoCOM: `%R1Q,rpc,transaction:parameters` asks, and `%R1P,com,transaction:code,values` answers. Before the colon there may be a further
//! number, the CRC-16 (of ARC) of the line without it.

use core::fmt;

/// A question: a remote procedure call.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// The procedure.
    pub rpc: u32,
    /// By which its answer is told from others, 0 to 7.
    pub transaction: u32,
    /// Whether it has a checksum, and asks for one.
    pub checked: bool,
    /// What it is given.
    pub parameters: Vec<f64>,
}

/// An answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// How the call came through: 0 if it did.
    pub transport: Code,
    /// That of the request.
    pub transaction: u32,
    /// Whether it has a checksum.
    pub checked: bool,
    /// What came of it: 0 if all is well.
    pub code: Code,
    /// What follows, as it was written.
    pub values: Vec<String>,
}

/// A return code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Code(pub u32);

/// Longest line that is one.
pub(crate) const LONGEST: usize = 512;

/// The CRC-16 of ARC: x^16 + x^15 + x^2 + 1, reflected, from 0.
fn crc(text: &str) -> u16 {
    text.bytes().fold(0, |crc, byte| {
        (0..8).fold(crc ^ u16::from(byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xa001 } else { crc >> 1 })
    })
}

/// The numbers between a prefix and the colon, what follows, and whether there was a checksum; `None` of a line that is none, or whose checksum is wrong.
fn parts<'l>(line: &'l str, prefix: &str) -> Option<([u32; 2], &'l str, bool)> {
    let (head, tail) = line.strip_prefix(prefix)?.split_once(':')?;
    let numbers: Option<Vec<u32>> = head.split(',').map(|one| one.parse().ok()).collect();
    match numbers?[..] {
        [first] => Some(([first, 0], tail, false)),
        [first, second] => Some(([first, second], tail, false)),
        [first, second, sum] => {
            let own = crc(&format!("{prefix}{first},{second}:{tail}"));
            (u32::from(own) == sum).then_some(([first, second], tail, true))
        }
        _ => None,
    }
}

fn write(f: &mut fmt::Formatter<'_>, head: &str, tail: &str, checked: bool) -> fmt::Result {
    if checked {
        let sum = crc(&format!("{head}:{tail}"));
        return write!(f, "{head},{sum}:{tail}");
    }
    write!(f, "{head}:{tail}")
}

impl Request {
    /// Reads a line without its end; `None` of what is none.
    #[must_use]
    pub fn parse(line: &str) -> Option<Self> {
        let ([rpc, transaction], tail, checked) = parts(line, "%R1Q,")?;
        let number = |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite());
        let parameters: Option<Vec<f64>> = match tail {
            "" => Some(Vec::new()),
            all => all.split(',').map(number).collect(),
        };
        Some(Self { rpc, transaction, checked, parameters: parameters? })
    }
}

impl fmt::Display for Request {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parameters: Vec<String> = self.parameters.iter().map(f64::to_string).collect();
        let head = format!("%R1Q,{},{}", self.rpc, self.transaction);
        write(f, &head, &parameters.join(","), self.checked)
    }
}

impl Answer {
    /// Reads a line without its end; `None` of what is none.
    #[must_use]
    pub fn parse(line: &str) -> Option<Self> {
        let ([transport, transaction], tail, checked) = parts(line, "%R1P,")?;
        let mut tail = tail.split(',');
        let code = Code(u32::from(tail.next()?.parse::<u16>().ok()?));
        let values = tail.map(str::to_owned).collect();
        Some(Self { transport: Code(transport), transaction, checked, code, values })
    }

    /// A value as a number.
    #[must_use]
    pub fn number(&self, i: usize) -> Option<f64> {
        self.values.get(i)?.parse().ok().filter(|number: &f64| number.is_finite())
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { transport, transaction, checked, code, values } = self;
        let tail: Vec<String> = core::iter::once(code.0.to_string()).chain(values.iter().cloned()).collect();
        write(f, &format!("%R1P,{},{transaction}", transport.0), &tail.join(","), *checked)
    }
}

impl Code {
    pub(crate) const OK: Self = Self(0);
    pub(crate) const NOT_IMPLEMENTED: Self = Self(5);
    pub(crate) const NOT_UNDERSTOOD: Self = Self(3080);
    pub(crate) const NO_TARGET: Self = Self(8710);
    pub(crate) const NOT_COMPENSATED: Self = Self(1288);

    /// Whether a line came through otherwise than it was sent, or this instrument knows no checksums.
    pub(crate) const fn is_of_lines(self) -> bool {
        matches!(self.0, 3072..=3107 | 3110)
    }

    /// Whether the instrument is busy, and may be asked again.
    #[must_use]
    pub const fn is_busy(self) -> bool {
        matches!(self.0, 13 | 1293)
    }

    /// What it says, and what to do.
    #[must_use]
    pub const fn meaning(self) -> &'static str {
        match self.0 {
            0 => "all is well",
            5 | 27 | 3081 => "the instrument cannot do that: is it motorised, with target recognition?",
            13 | 1293 => "the instrument is busy: leave its keyboard alone",
            16 | 18 => "the battery is empty",
            22 | 257 | 258 | 1283 | 1288 | 1392 => "the compensator is out of range: level the instrument",
            259 | 1284 | 1289 => "angles are not as accurate as they should be: keep the instrument still",
            1290 => "no valid angle was measured",
            8704 | 8706 | 8707 | 8716 => {
                "it could not turn to the target: is it held, or is the tolerance too small?"
            }
            8710 => "no target is seen there: is the line of sight free?",
            8711 => "several targets are seen there: cover the others",
            8712 => "the light is not good enough to find a target",
            _ => "see the GeoCOM manual",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHECKED: &str = "%R1Q,2003,5,52118:0";

    #[test]
    fn lines_are_those_of_the_manual() {
        let request =
            Request { rpc: 9027, transaction: 3, checked: false, parameters: vec![1.5, 0.25, 0.0, 1.0, 0.0] };
        assert_eq!(request.to_string(), "%R1Q,9027,3:1.5,0.25,0,1,0");
        assert_eq!(Request::parse("%R1Q,9027,3:1.5,0.25,0,1,0"), Some(request));
        assert_eq!(Request::parse("%R1Q,0:").map(|one| one.transaction), Some(0));
        let answer = Answer::parse("%R1P,0,3:0,0.9973260431694,1.613443448007").expect("an answer");
        assert_eq!((answer.transaction, answer.number(1)), (3, Some(1.613443448007)));
        assert_eq!(answer.to_string(), "%R1P,0,3:0,0.9973260431694,1.613443448007");
        // By crc16_bytewise of GeoComPy.
        assert_eq!(crc("123456789"), 0xbb3d);
        let checked = Request { rpc: 2003, transaction: 5, checked: true, parameters: vec![0.0] };
        assert_eq!(checked.to_string(), CHECKED);
        assert_eq!(Request::parse(CHECKED), Some(checked));
        assert_eq!(Request::parse(&CHECKED.replace(":0", ":1")), None);
        for line in
            ["", "%R1P,0", "%R1P,0,1", "%R1P,x,1:0", "%R1P,0,1:", "%R1Q,1,2", "%R1P,-1,0:0", "%R1P,0,1,1:0,2"]
        {
            assert_eq!((Answer::parse(line), Request::parse(line)), (None, None), "{line}");
        }
    }
}
