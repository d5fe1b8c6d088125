//! Messages of the Robot Sensor Interface: short texts in XML, one in each direction in every period.
//!
//! In: what the controller says. Out: its axes and its clock; the answer with corrections. Nothing is allocated, and what the
//! controller says besides is left alone.

use core::fmt::{self, Write};
use core::str;

/// Axes of an arm.
pub const AXES: usize = 6;

/// What the controller says at the beginning of a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FromController {
    /// Its clock \[ms\]: it goes on by the period's length.
    pub ipoc: u64,
    /// Where its axes are \[deg\].
    pub axes: [f64; AXES],
    /// Answers so far that came too late or could not be read, if it says so.
    pub late: Option<u64>,
    /// Its word of digital inputs, `DiL`, if it says so.
    pub inputs: Option<u16>,
    /// Its word of digital outputs, `DoutW`, if it says so.
    pub outputs: Option<u16>,
}

impl FromController {
    /// Reads a message: the elements `AIPos`, `IPOC` and, where they are there, `Delay`, `DiL` and `DoutW`.
    ///
    /// `None` if it is no such message, or a number in it is none.
    ///
    /// ```
    /// use mrroc_kuka::FromController;
    ///
    /// let text = br#"<Rob Type="KUKA"><AIPos A1="0.5" A2="-90" A3="90" A4="0" A5="45" A6="-1e-3"/><Delay D="2"/><DiL>5</DiL><IPOC>123460</IPOC></Rob>"#;
    /// let said = FromController::read(text).expect("a message");
    /// assert_eq!((said.ipoc, said.axes[0], said.late), (123_460, 0.5, Some(2)));
    /// assert_eq!((said.inputs, said.outputs), (Some(5), None));
    /// ```
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<FromController> {
        let text = str::from_utf8(bytes).ok()?;
        if !text.trim_start().starts_with("<Rob") {
            return None;
        }
        let ipoc = text.split_once("<IPOC>")?.1.split_once("</IPOC>")?.0;
        let positions = element(text, "AIPos")?;
        let mut axes = [0.0; AXES];
        for (i, axis) in axes.iter_mut().enumerate() {
            let name = [b'A', b'1' + i as u8];
            *axis = attribute(positions, str::from_utf8(&name).ok()?)?
                .parse()
                .ok()
                .filter(|a: &f64| a.is_finite())?;
        }
        let late = element(text, "Delay").and_then(|delay| attribute(delay, "D")?.parse().ok());
        let [inputs, outputs] = ["DiL", "DoutW"].map(|name| word(text, name));
        Some(FromController { ipoc: ipoc.trim().parse().ok()?, axes, late, inputs, outputs })
    }
}

/// The word of 16 bits in the element of this name, of 32 bits with a sign as XML has it.
fn word(text: &str, name: &str) -> Option<u16> {
    let mut rest = text;
    loop {
        rest = rest.split_once('<')?.1;
        if let Some(after) = rest.strip_prefix(name).and_then(|after| after.strip_prefix('>')) {
            let number: i32 = after.split_once('<')?.0.trim().parse().ok()?;
            return Some(number as u16);
        }
    }
}

/// The attributes of the first element of this name.
fn element<'t>(text: &'t str, name: &str) -> Option<&'t str> {
    let mut rest = text;
    loop {
        rest = rest.split_once('<')?.1;
        if let Some(after) = rest.strip_prefix(name)
            && after.starts_with([' ', '\t', '\r', '\n'])
        {
            return after.split_once('>').map(|(attributes, _)| attributes);
        }
    }
}

/// The value of the attribute of this name.
fn attribute<'t>(attributes: &'t str, name: &str) -> Option<&'t str> {
    let mut rest = attributes;
    loop {
        let (before, after) = rest.split_once('=')?;
        let after = after.trim_start();
        let quote = after.chars().next().filter(|quote| matches!(quote, '"' | '\''))?;
        let (value, after) = after[1..].split_once(quote)?;
        if before.trim() == name {
            return Some(value.trim());
        }
        rest = after;
    }
}

/// The answer in a period.
#[derive(Clone, Debug)]
pub struct ToController {
    bytes: [u8; 512],
    len: usize,
}

impl ToController {
    /// Corrections of the axes \[deg\], against where they were when the interface was switched on, for the period of
    /// this clock, and its word of digital outputs, `DiO`, where that is to be told. `sensor` is the name that the controller's configuration
    /// gives this end, its `SENTYPE`.
    ///
    /// # Errors
    /// The name has no room.
    pub fn corrections(
        sensor: &str,
        ipoc: u64,
        axes: &[f64; AXES],
        outputs: Option<u16>,
    ) -> Result<ToController, fmt::Error> {
        let mut answer = ToController { bytes: [0; 512], len: 0 };
        write!(answer, r#"<Sen Type="{sensor}"><AKorr"#)?;
        for (i, axis) in axes.iter().enumerate() {
            // A millionth of a degree is below the resolution of any axis.
            write!(answer, r#" A{}="{axis:.6}""#, i + 1)?;
        }
        answer.write_str("/>")?;
        if let Some(outputs) = outputs {
            write!(answer, "<DiO>{outputs}</DiO>")?;
        }
        write!(answer, "<IPOC>{ipoc}</IPOC></Sen>")?;
        Ok(answer)
    }

    /// The text.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.len]
    }
}

impl Write for ToController {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let end = self.len + text.len();
        self.bytes.get_mut(self.len..end).ok_or(fmt::Error)?.copy_from_slice(text.as_bytes());
        self.len = end;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_controller_says_is_read_in_any_order_and_with_any_blanks() {
        let text = "<Rob Type='KUKA'>\n <RIst X=\"1\" A=\"7\"/><IPOC> 42 </IPOC><AIPosOld A1=\"9\"/>\
                    <AIPos\tA6=\"6.5\" A5 = '5' A4=\"4\" A3=\"3\" A2=\"2\" A1=\"-1.25\"></AIPos></Rob>";
        let said = FromController::read(text.as_bytes()).expect("a message");
        let axes = [-1.25, 2.0, 3.0, 4.0, 5.0, 6.5];
        assert_eq!(said, FromController { ipoc: 42, axes, late: None, inputs: None, outputs: None });
        let words = |words: &str| {
            let text = String::from_utf8_lossy(text.as_bytes()).replace("<IPOC>", &format!("{words}<IPOC>"));
            let said = FromController::read(text.as_bytes()).expect("a message");
            (said.inputs, said.outputs)
        };
        assert_eq!(words("<DiL> 65535 </DiL>\n<DoutW>3</DoutW>"), (Some(0xffff), Some(3)));
        // A LONG has a sign.
        assert_eq!(words("<DoutW>-32768</DoutW><DiLed>1</DiLed>"), (None, Some(0x8000)));
        assert_eq!(words("<DiL>on</DiL><DoutW></DoutW>"), (None, None));
    }

    #[test]
    fn what_is_no_message_is_none() {
        let good =
            r#"<Rob Type="KUKA"><AIPos A1="0" A2="0" A3="0" A4="0" A5="0" A6="0"/><IPOC>1</IPOC></Rob>"#;
        assert!(FromController::read(good.as_bytes()).is_some());
        for (from, to) in [
            ("<Rob", "<Sen"),
            ("A6=\"0\"", "A6=\"nan\""),
            ("A6=\"0\"", "A6=\"inf\""),
            ("A6=\"0\"", ""),
            ("A3=\"0\"", "A3=\"0"),
            ("<IPOC>1", "<IPOC>-1"),
            ("<IPOC>1</IPOC>", ""),
            ("AIPos", "AIPo"),
        ] {
            assert_eq!(FromController::read(good.replace(from, to).as_bytes()), None, "{to} for {from}");
        }
        assert_eq!(FromController::read(&[0xff; 40]), None);
    }

    #[test]
    fn an_answer_has_the_controllers_clock_and_a_name_that_is_too_long_is_refused() {
        let axes = [0.5, -0.000_001_4, 0.0, 12.0, -170.123_456_7, 1e-9];
        let answer = ToController::corrections("ImFree", 123_464, &axes, None).expect("room");
        let expected = r#"<Sen Type="ImFree"><AKorr A1="0.500000" A2="-0.000001" A3="0.000000" A4="12.000000" A5="-170.123457" A6="0.000000"/><IPOC>123464</IPOC></Sen>"#;
        assert_eq!(str::from_utf8(answer.bytes()), Ok(expected));
        let switching = ToController::corrections("ImFree", 123_464, &axes, Some(0x8001)).expect("room");
        let expected = expected.replace("<IPOC>", "<DiO>32769</DiO><IPOC>");
        assert_eq!(str::from_utf8(switching.bytes()), Ok(expected.as_str()));
        assert!(ToController::corrections(&"x".repeat(500), 1, &axes, None).is_err());
    }
}
