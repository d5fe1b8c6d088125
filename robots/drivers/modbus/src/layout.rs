//! Where a device has its inputs and outputs, and what its numbers mean.

use core::ops::Range;

use mrroc::robot::{ANALOG, Channels, DIGITAL, WhenLost};

/// How the numbers of registers belong to analog values: `value = at_zero + per_count · number`, of registers without sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The value at 0, in the unit of the device, such as V or mA.
    pub at_zero: f64,
    /// What one more is, not 0.
    pub per_count: f64,
}

impl Scale {
    /// The numbers themselves.
    pub const COUNTS: Scale = Scale { at_zero: 0.0, per_count: 1.0 };

    /// The value of a register.
    #[must_use]
    pub fn value(&self, register: u16) -> f64 {
        self.at_zero + self.per_count * f64::from(register)
    }

    /// The register nearest to a value; `None` if it is beyond all.
    #[must_use]
    pub fn register(&self, value: f64) -> Option<u16> {
        let number = ((value - self.at_zero) / self.per_count).round();
        (0.0..=f64::from(u16::MAX)).contains(&number).then_some(number as u16)
    }
}

/// Where a device has its inputs and outputs: `digital 0` of a cell file is the first one of its range, and so on. Bits and registers are
/// counted from 0, as the messages of Modbus count them: what a manual calls coil 00017 is 16, and register 30001 is input register 0.
///
/// ```
/// use mrroc_modbus::{Layout, Scale};
///
/// // 0 to 10 V on 12 bits.
/// let voltage = Scale { at_zero: 0.0, per_count: 10.0 / 4095.0 };
/// let layout = Layout { digital_inputs: 0..6, analog_inputs: 0..2, analog_input: voltage, ..Layout::NONE };
/// assert_eq!(layout.channels().digital_inputs, 6);
/// assert_eq!(voltage.register(5.0), Some(2048));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Discrete inputs, at most 32.
    pub digital_inputs: Range<u16>,
    /// Coils, at most 32.
    pub digital_outputs: Range<u16>,
    /// Input registers, at most 4.
    pub analog_inputs: Range<u16>,
    /// Holding registers, at most 4.
    pub analog_outputs: Range<u16>,
    /// What the numbers of analog inputs mean.
    pub analog_input: Scale,
    /// What those of analog outputs mean.
    pub analog_output: Scale,
    /// What its outputs do when nobody says anything to it any more: its manual tells, under watchdog or safe state. The cell's `--check`
    /// names the outputs that will not do what it declares.
    pub when_lost: WhenLost,
}

impl Layout {
    /// A device that has nothing, and holds it.
    pub const NONE: Layout = Layout {
        digital_inputs: 0..0,
        digital_outputs: 0..0,
        analog_inputs: 0..0,
        analog_outputs: 0..0,
        analog_input: Scale::COUNTS,
        analog_output: Scale::COUNTS,
        when_lost: WhenLost::Hold,
    };

    /// The channels of a robot that it makes. A range that is too long is cut.
    #[must_use]
    pub fn channels(&self) -> Channels {
        let count = |range: &Range<u16>, most: usize| range.len().min(most) as u8;
        Channels {
            digital_inputs: count(&self.digital_inputs, DIGITAL),
            digital_outputs: count(&self.digital_outputs, DIGITAL),
            analog_inputs: count(&self.analog_inputs, ANALOG),
            analog_outputs: count(&self.analog_outputs, ANALOG),
            when_lost: self.when_lost,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_beyond_all_registers_has_none() {
        // 4 to 20 mA on 0 to 65535.
        let current = Scale { at_zero: 4.0, per_count: 16.0 / 65535.0 };
        assert_eq!((current.register(4.0), current.register(20.0)), (Some(0), Some(65535)));
        assert!((current.value(32768) - 12.0).abs() < 2e-4);
        for beyond in [3.9, 20.1, f64::NAN, f64::INFINITY] {
            assert_eq!(current.register(beyond), None);
        }
    }
}
