//! Outputs of a controller. Digital ones: the channels 0 to 7 are its standard ones, 8 to 15 the configurable ones, 16 and 17 those
//! at the tool. Analog ones: 0 and 1, each as a fraction of its range, 0 to 1. Its analog inputs are 0 and 1, and 2 and 3 at the tool.
//!
//! In: outputs that are told anything. Out: what RTDE writes of them, what a script does with them.

use core::fmt::Write;
use core::ops::RangeInclusive;

use mrroc::robot::{Channel, Channels, Outputs, Value, WhenLost};

use crate::rtde::{Offer, Type};

/// How many digital inputs a controller has, and digital outputs.
const DIGITAL: u8 = 18;

/// Analog outputs of a controller.
pub const ANALOG_OUTPUTS: u8 = 2;

/// What an analog output may be told: a fraction of its range.
pub const FRACTION: RangeInclusive<f64> = 0.0..=1.0;

/// The inputs and outputs of a controller. What outputs take when set-points stay away, its script does.
pub const CHANNELS: Channels = Channels {
    digital_inputs: DIGITAL,
    digital_outputs: DIGITAL,
    analog_inputs: 4,
    analog_outputs: ANALOG_OUTPUTS,
    when_lost: WhenLost::AsDeclared,
};

/// Outputs of one type: the inputs of RTDE by which they are switched, which one program at a time may write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Masks and values of the standard, the configurable and the tool's.
    Digital,
    /// A mask, whether each is a voltage, and two fractions.
    Analog,
}

impl Group {
    /// Both.
    pub const ALL: [Group; 2] = [Group::Digital, Group::Analog];

    /// The inputs of RTDE, separated by commas.
    #[must_use]
    pub const fn names(self) -> &'static str {
        match self {
            Group::Digital => {
                "standard_digital_output_mask,standard_digital_output,configurable_digital_output_mask,\
                 configurable_digital_output,tool_digital_output_mask,tool_digital_output"
            }
            Group::Analog => {
                "standard_analog_output_mask,standard_analog_output_type,standard_analog_output_0,\
                 standard_analog_output_1"
            }
        }
    }

    /// Their types.
    #[must_use]
    pub const fn types(self) -> &'static [Type] {
        match self {
            Group::Digital => &[Type::Uint8; 6],
            Group::Analog => &[Type::Uint8, Type::Uint8, Type::Double, Type::Double],
        }
    }

    /// Whether a controller lets this machine write all of them.
    ///
    /// # Errors
    /// Why not.
    pub fn check(self, offers: &[Offer]) -> Result<(), &'static str> {
        if offers.contains(&Offer::InUse) {
            return Err("another program switches its outputs: end that, or the fieldbus that does it");
        }
        if offers.iter().copied().eq(self.types().iter().map(|of| Offer::Has(*of))) {
            Ok(())
        } else {
            Err("the controller lacks an input of RTDE by which outputs are switched")
        }
    }

    /// Whether any of these outputs are of this type.
    #[must_use]
    pub fn is_in(self, outputs: &Outputs) -> bool {
        outputs.iter().any(|(channel, _)| match channel {
            Channel::Digital(_) => self == Group::Digital,
            Channel::Analog(_) => self == Group::Analog,
        })
    }
}

/// The groups of which a program switches outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Groups {
    digital: bool,
    analog: bool,
}

impl Groups {
    /// None: to look only.
    pub const NONE: Groups = Groups { digital: false, analog: false };

    /// Those of which outputs are named here.
    #[must_use]
    pub fn of(named: &Outputs) -> Groups {
        Groups { digital: Group::Digital.is_in(named), analog: Group::Analog.is_in(named) }
    }

    /// Whether a group is among them.
    #[must_use]
    pub const fn has(self, group: Group) -> bool {
        match group {
            Group::Digital => self.digital,
            Group::Analog => self.analog,
        }
    }
}

/// The digital outputs among these as [`Group::Digital`] writes them.
#[must_use]
pub fn digital_bytes(outputs: &Outputs) -> [u8; 6] {
    let (told, values) = (outputs.digital(), outputs.values().digital());
    let (told, values) = (told.to_le_bytes(), values.to_le_bytes());
    [told[0], values[0], told[1], values[1], told[2], values[2]]
}

/// The analog outputs among these as [`Group::Analog`] writes them. `voltages` says of each by a bit whether it is a voltage, as the
/// controller told: so nothing here changes that. One that is told what is no fraction of its range is left as it is.
#[must_use]
pub fn analog_bytes(outputs: &Outputs, voltages: u8) -> [u8; 18] {
    let mut bytes = [0; 18];
    for (number, value) in analog(outputs).filter(|(_, value)| FRACTION.contains(value)) {
        bytes[0] |= 1 << number;
        let place = 2 + 8 * usize::from(number);
        bytes[place..place + 8].copy_from_slice(&value.to_be_bytes());
    }
    bytes[1] = voltages;
    bytes
}

/// Whether the controller has what the analog outputs are told: fractions of their ranges.
#[must_use]
pub fn are_fractions(outputs: &Outputs) -> bool {
    analog(outputs).all(|(_, value)| FRACTION.contains(&value))
}

/// The fraction of its range that an analog output has: of 10 V, or from 4 to 20 mA \[A\].
#[must_use]
pub fn fraction(value: f64, is_voltage: bool) -> f64 {
    if is_voltage { value / 10.0 } else { (value - 0.004) / 0.016 }
}

/// The name of a digital channel in URScript, and its number there.
const fn in_script(number: u8) -> (&'static str, u8) {
    match number {
        0..8 => ("standard", number),
        8..16 => ("configurable", number - 8),
        _ => ("tool", number - 16),
    }
}

/// The digital outputs that are told anything.
fn digital(outputs: &Outputs) -> impl Iterator<Item = (u8, bool)> + '_ {
    outputs.iter().filter_map(|told| match told {
        (Channel::Digital(number), Value::Digital(on)) if number < DIGITAL => Some((number, on)),
        _ => None,
    })
}

/// The analog ones.
fn analog(outputs: &Outputs) -> impl Iterator<Item = (u8, f64)> + '_ {
    outputs.iter().filter_map(|told| match told {
        (Channel::Analog(number), Value::Analog(value)) if number < ANALOG_OUTPUTS => Some((number, value)),
        _ => None,
    })
}

/// The outputs as the first lines of a script name them: ` 1 off 9 on analog0 0.5`.
pub(crate) fn written(outputs: &Outputs) -> String {
    let mut text = String::new();
    // Writing to a text cannot fail.
    for (number, on) in digital(outputs) {
        let _ = write!(text, " {number} {}", if on { "on" } else { "off" });
    }
    for (number, value) in analog(outputs) {
        let _ = write!(text, " analog{number} {value}");
    }
    text
}

/// The outputs of such words; `None` where they are none.
pub(crate) fn read(words: &[&str]) -> Option<Outputs> {
    let (pairs, rest) = words.as_chunks::<2>();
    let with = |outputs: Outputs, [name, value]: &[&str; 2]| {
        let told = match name.strip_prefix("analog") {
            Some(number) => {
                let number = number.parse().ok().filter(|number| *number < ANALOG_OUTPUTS)?;
                let value = value.parse().ok().filter(|value| FRACTION.contains(value))?;
                (Channel::Analog(number), Value::Analog(value))
            }
            None => {
                let number = name.parse().ok().filter(|number| *number < DIGITAL)?;
                let on = match *value {
                    "on" => true,
                    "off" => false,
                    _ => return None,
                };
                (Channel::Digital(number), Value::Digital(on))
            }
        };
        Some(outputs.with(told.0, told.1))
    };
    rest.is_empty().then(|| pairs.iter().try_fold(Outputs::NONE, with))?
}

/// The lines of a script that switch them when no set-point has come in time; none where there is nothing to switch.
pub(crate) fn switched(outputs: &Outputs) -> String {
    let mut text = String::new();
    // Writing to a text cannot fail.
    for (number, on) in digital(outputs) {
        let (name, number) = in_script(number);
        let value = if on { "True" } else { "False" };
        let _ = writeln!(text, "    set_{name}_digital_out({number}, {value})");
    }
    for (number, value) in analog(outputs) {
        let _ = writeln!(text, "    set_standard_analog_out({number}, {value})");
    }
    if text.is_empty() { text } else { format!("  if reason == REASON_TIMEOUT:\n{text}  end\n") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bytes_are_masks_and_values_of_the_three_groups() {
        let told =
            |outputs: Outputs, (number, on)| outputs.with(Channel::Digital(number), Value::Digital(on));
        let outputs = [(0, true), (7, false), (8, false), (15, true), (16, true), (17, false)];
        let outputs = outputs.into_iter().fold(Outputs::NONE, told);
        assert_eq!(digital_bytes(&outputs), [0x81, 0x01, 0x81, 0x80, 0x03, 0x01]);
        assert_eq!(digital_bytes(&Outputs::NONE), [0; 6]);
        assert!(Group::Digital.is_in(&outputs) && !Group::Analog.is_in(&outputs));
    }

    #[test]
    fn analog_outputs_are_a_mask_the_domains_and_two_fractions() {
        let outputs = Outputs::NONE.with(Channel::Analog(1), Value::Analog(0.5));
        let bytes = analog_bytes(&outputs, 0b10);
        assert_eq!((bytes[0], bytes[1]), (0b10, 0b10));
        assert_eq!(
            (bytes[2..10].to_vec(), bytes[10..].to_vec()),
            (vec![0; 8], 0.5_f64.to_be_bytes().to_vec())
        );
        // What is no fraction of a range is left as it is, and takes nothing else along.
        let beside = outputs.with(Channel::Analog(0), Value::Analog(5.0));
        assert_eq!(analog_bytes(&beside, 0b10), bytes);
        let of_types: usize = Group::Analog.types().iter().map(|of| of.size()).sum();
        assert_eq!(of_types, bytes.len());
        assert_eq!(Group::Analog.names().split(',').count(), Group::Analog.types().len());
        // The ends of 0 to 10 V, and of 4 to 20 mA.
        for (value, is_voltage, expected) in [
            (0.0, true, 0.0),
            (10.0, true, 1.0),
            (0.004, false, 0.0),
            (0.012, false, 0.5),
            (0.02, false, 1.0),
        ] {
            assert!((fraction(value, is_voltage) - expected).abs() < 1e-12);
        }
        let beyond = |value| Outputs::NONE.with(Channel::Analog(0), Value::Analog(value));
        assert!(are_fractions(&beyond(0.0)) && are_fractions(&beyond(1.0)) && are_fractions(&Outputs::NONE));
        assert!(![-1e-9, 1.0 + 1e-9, 5.0, f64::NAN].iter().any(|value| are_fractions(&beyond(*value))));
    }
}
