//! Inputs and outputs of a robot's controller, digital and analog: part of the robot's state, `e` of the paper.
//!
//! In: what the drives read and were told. Out: values in the robot's image, for conditions and generators; and
//! [`Outputs`], what a demand switches. A program knows a signal by its name in the cell, and asks for it once:
//! [`Input`] and [`Output`].

use core::fmt;
use core::marker::PhantomData;

use crate::model::wire::{BadWords, Wire, layout_hash};

/// Digital inputs that a robot may have, and digital outputs.
pub const DIGITAL: usize = 32;

/// Analog inputs that a robot may have, and analog outputs.
pub const ANALOG: usize = 4;

/// One input or output of a controller, counted from 0 among those of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// On or off; below [`DIGITAL`].
    Digital(u8),
    /// A number in the unit that the driver states; below [`ANALOG`].
    Analog(u8),
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Channel::Digital(number) => write!(f, "digital {number}"),
            Channel::Analog(number) => write!(f, "analog {number}"),
        }
    }
}

/// What an input reads, or an output is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Of a digital signal.
    Digital(bool),
    /// Of an analog signal, in the unit that the driver states.
    Analog(f64),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Digital(true) => f.write_str("on"),
            Value::Digital(false) => f.write_str("off"),
            Value::Analog(value) => write!(f, "{value}"),
        }
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for bool {}
    impl Sealed for f64 {}
}

/// The type of a signal's value: `bool` of a digital one, `f64` of an analog one.
pub trait Level: Copy + sealed::Sealed + 'static {
    /// What messages call such a signal.
    #[doc(hidden)]
    const NAME: &'static str;
    /// The value as one of either type.
    fn value(self) -> Value;
    /// The number of such a channel.
    #[doc(hidden)]
    fn number(channel: Channel) -> Option<u8>;
    /// The value of a channel with this number.
    #[doc(hidden)]
    fn of(values: &Values, number: u8) -> Self;
    /// Such a channel.
    #[doc(hidden)]
    fn channel(number: u8) -> Channel;
}

impl Level for bool {
    const NAME: &'static str = "digital";
    fn value(self) -> Value {
        Value::Digital(self)
    }
    fn number(channel: Channel) -> Option<u8> {
        match channel {
            Channel::Digital(number) => Some(number),
            Channel::Analog(_) => None,
        }
    }
    fn of(values: &Values, number: u8) -> bool {
        values.is_on(number)
    }
    fn channel(number: u8) -> Channel {
        Channel::Digital(number)
    }
}

impl Level for f64 {
    const NAME: &'static str = "analog";
    fn value(self) -> Value {
        Value::Analog(self)
    }
    fn number(channel: Channel) -> Option<u8> {
        match channel {
            Channel::Analog(number) => Some(number),
            Channel::Digital(_) => None,
        }
    }
    fn of(values: &Values, number: u8) -> f64 {
        values.analog(number)
    }
    fn channel(number: u8) -> Channel {
        Channel::Analog(number)
    }
}

/// An input of a robot, which a program asks for by its name: `arm.input("part_seen")?`. It belongs to that robot.
pub struct Input<T> {
    number: u8,
    level: PhantomData<T>,
}

/// An output of a robot, which a program asks for by its name: `arm.output("vacuum")?`. It belongs to that robot.
pub struct Output<T> {
    number: u8,
    level: PhantomData<T>,
}

macro_rules! handle {
    ($($handle:ident),*) => {$(
        impl<T: Level> $handle<T> {
            /// The signal of this channel, for calling a step function in a test.
            ///
            /// A channel of the other type gives `None`.
            #[must_use]
            pub fn of(channel: Channel) -> Option<Self> {
                T::number(channel).map(|number| $handle { number, level: PhantomData })
            }

            /// Its channel.
            #[must_use]
            pub fn channel(self) -> Channel {
                T::channel(self.number)
            }
        }
        impl<T> Clone for $handle<T> {
            fn clone(&self) -> Self {
                *self
            }
        }
        impl<T> Copy for $handle<T> {}
        impl<T> PartialEq for $handle<T> {
            fn eq(&self, other: &Self) -> bool {
                self.number == other.number
            }
        }
        impl<T> Eq for $handle<T> {}
        impl<T: Level> fmt::Debug for $handle<T> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!(stringify!($handle), "({})"), self.channel())
            }
        }
        impl<T: Level> sealed::Sealed for $handle<T> {}
    )*};
}

handle!(Input, Output);

/// An [`Input`] or an [`Output`]: what can be looked up in a robot's [`Signals`].
pub trait Signal: Copy + sealed::Sealed {
    /// `bool` or `f64`.
    type Value;
    /// Its value among these.
    #[doc(hidden)]
    fn read(self, signals: &Signals) -> Self::Value;
}

impl<T: Level> Signal for Input<T> {
    type Value = T;
    fn read(self, signals: &Signals) -> T {
        T::of(&signals.inputs, self.number)
    }
}

impl<T: Level> Signal for Output<T> {
    type Value = T;
    fn read(self, signals: &Signals) -> T {
        T::of(&signals.outputs, self.number)
    }
}

/// The values of all inputs of a robot, or of all its outputs: off and 0 where it has none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Values {
    digital: u32,
    analog: [f64; ANALOG],
}

impl Values {
    /// All off, and 0.
    pub const OFF: Values = Values { digital: 0, analog: [0.0; ANALOG] };

    /// These digital values, that of channel 0 in the lowest bit, and these analog ones.
    #[must_use]
    pub const fn new(digital: u32, analog: [f64; ANALOG]) -> Values {
        Values { digital, analog }
    }

    /// The digital values, that of channel 0 in the lowest bit.
    #[must_use]
    pub const fn digital(&self) -> u32 {
        self.digital
    }

    /// Whether a digital signal is on; false beyond [`DIGITAL`].
    #[must_use]
    pub const fn is_on(&self, number: u8) -> bool {
        (number as usize) < DIGITAL && self.digital >> number & 1 == 1
    }

    /// The value of an analog signal, in the unit that the driver states; 0 beyond [`ANALOG`].
    #[must_use]
    pub const fn analog(&self, number: u8) -> f64 {
        if (number as usize) < ANALOG { self.analog[number as usize] } else { 0.0 }
    }

    /// Gives a channel a value. One beyond those that there may be, or of the other type, is ignored.
    pub const fn set(&mut self, channel: Channel, value: Value) {
        match (channel, value) {
            (Channel::Digital(number), Value::Digital(on)) if (number as usize) < DIGITAL => {
                let bit = 1 << number;
                self.digital = if on { self.digital | bit } else { self.digital & !bit };
            }
            (Channel::Analog(number), Value::Analog(value)) if (number as usize) < ANALOG => {
                self.analog[number as usize] = value;
            }
            _ => {}
        }
    }
}

/// What a robot's inputs read and what its outputs are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signals {
    /// What its inputs read.
    pub inputs: Values,
    /// What its outputs are, as far as the controller says; else as they were told.
    pub outputs: Values,
}

/// Words of the signals of a robot.
pub const SIGNAL_WORDS: usize = 1 + 2 * ANALOG;

impl Signals {
    /// No input reads anything, and no output is on.
    pub const OFF: Signals = Signals { inputs: Values::OFF, outputs: Values::OFF };

    /// Whether every signal is off or 0, as of a robot that has none.
    #[must_use]
    pub fn are_off(&self) -> bool {
        *self == Signals::OFF
    }
}

impl Wire for Signals {
    const LEN: usize = SIGNAL_WORDS;
    const LAYOUT: u64 = layout_hash(0, "mrroc::robot::Signals");

    fn put(&self, words: &mut [u64]) {
        words[0] = u64::from(self.inputs.digital) | u64::from(self.outputs.digital) << DIGITAL;
        let analog = self.inputs.analog.iter().chain(&self.outputs.analog);
        words[1..].iter_mut().zip(analog).for_each(|(word, value)| *word = value.to_bits());
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let words = words.get(..SIGNAL_WORDS).ok_or(BadWords)?;
        let analog = |first: usize| core::array::from_fn(|i| f64::from_bits(words[first + i]));
        Ok(Signals {
            inputs: Values { digital: words[0] as u32, analog: analog(1) },
            outputs: Values { digital: (words[0] >> DIGITAL) as u32, analog: analog(1 + ANALOG) },
        })
    }
}

/// Values for some outputs of a robot; the others stay as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outputs {
    /// The digital outputs that are told anything, by bits.
    digital: u32,
    /// The analog ones.
    analog: u8,
    /// What they are told; off and 0 elsewhere.
    values: Values,
}

/// Words of outputs.
pub const OUTPUT_WORDS: usize = 2 + ANALOG;

impl Outputs {
    /// All outputs stay as they are.
    pub const NONE: Outputs = Outputs { digital: 0, analog: 0, values: Values::OFF };

    /// The same, with this value for one output. A channel beyond those that there may be, or of the other type, is ignored.
    #[must_use]
    pub const fn with(mut self, channel: Channel, value: Value) -> Outputs {
        match (channel, value) {
            (Channel::Digital(number), Value::Digital(_)) if (number as usize) < DIGITAL => {
                self.digital |= 1 << number;
            }
            (Channel::Analog(number), Value::Analog(_)) if (number as usize) < ANALOG => {
                self.analog |= 1 << number;
            }
            _ => {}
        }
        self.values.set(channel, value);
        self
    }

    /// Whether all outputs stay as they are.
    #[must_use]
    pub const fn is_none(&self) -> bool {
        self.digital == 0 && self.analog == 0
    }

    /// The digital outputs that are told anything, that of channel 0 in the lowest bit.
    #[must_use]
    pub const fn digital(&self) -> u32 {
        self.digital
    }

    /// What they are told; off and 0 for outputs that stay.
    #[must_use]
    pub const fn values(&self) -> &Values {
        &self.values
    }

    /// What an output is told; `None`: it stays.
    #[must_use]
    pub const fn value(&self, channel: Channel) -> Option<Value> {
        match channel {
            Channel::Digital(number) if (number as usize) < DIGITAL && self.digital >> number & 1 == 1 => {
                Some(Value::Digital(self.values.is_on(number)))
            }
            Channel::Analog(number) if (number as usize) < ANALOG && self.analog >> number & 1 == 1 => {
                Some(Value::Analog(self.values.analog(number)))
            }
            Channel::Digital(_) | Channel::Analog(_) => None,
        }
    }

    /// The outputs that are told anything, and what.
    pub fn iter(&self) -> impl Iterator<Item = (Channel, Value)> + '_ {
        let digital = (0..DIGITAL as u8).map(Channel::Digital);
        let channels = digital.chain((0..ANALOG as u8).map(Channel::Analog));
        channels.filter_map(|channel| Some((channel, self.value(channel)?)))
    }

    /// Both: what `later` tells counts.
    #[must_use]
    pub fn and(mut self, later: &Outputs) -> Outputs {
        let Outputs { digital, analog, values } = later;
        self.values.digital = self.values.digital & !digital | values.digital;
        for (i, value) in self.values.analog.iter_mut().enumerate().filter(|(i, _)| analog >> i & 1 == 1) {
            *value = values.analog[i];
        }
        self.digital |= digital;
        self.analog |= analog;
        self
    }

    /// These values, with those that are told here.
    #[must_use]
    pub fn onto(&self, values: &Values) -> Values {
        let all = Outputs { digital: u32::MAX, analog: u8::MAX, values: *values };
        all.and(self).values
    }

    /// Whether nothing is told that `known` does not know.
    #[must_use]
    pub const fn are_among(&self, known: &Outputs) -> bool {
        self.digital & !known.digital == 0 && self.analog & !known.analog == 0
    }

    /// Whether each number is one.
    #[must_use]
    pub fn are_finite(&self) -> bool {
        self.values.analog.iter().all(|value| value.is_finite())
    }
}

impl Wire for Outputs {
    const LEN: usize = OUTPUT_WORDS;
    const LAYOUT: u64 = layout_hash(0, "mrroc::robot::Outputs");

    fn put(&self, words: &mut [u64]) {
        words[0] = u64::from(self.digital) | u64::from(self.values.digital) << DIGITAL;
        words[1] = u64::from(self.analog);
        for (word, value) in words[2..].iter_mut().zip(&self.values.analog) {
            *word = value.to_bits();
        }
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let words = words.get(..OUTPUT_WORDS).ok_or(BadWords)?;
        let (digital, values) = (words[0] as u32, (words[0] >> DIGITAL) as u32);
        let analog = u8::try_from(words[1]).ok().filter(|told| *told < 1 << ANALOG).ok_or(BadWords)?;
        let value = |i: usize| if analog >> i & 1 == 1 { f64::from_bits(words[2 + i]) } else { 0.0 };
        let values = Values { digital: values & digital, analog: core::array::from_fn(value) };
        Ok(Outputs { digital, analog, values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VACUUM: Channel = Channel::Digital(31);
    const FLOW: Channel = Channel::Analog(3);

    #[test]
    fn outputs_that_are_told_nothing_stay() {
        let before = Values::new(0b101, [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(Outputs::NONE.onto(&before), before);
        let told = Outputs::NONE.with(Channel::Digital(0), Value::Digital(false));
        assert_eq!(told.onto(&before), Values::new(0b100, [1.0, 2.0, 3.0, 4.0]));
        let told = told.with(FLOW, Value::Analog(-1.0)).with(VACUUM, Value::Digital(true));
        assert_eq!(told.onto(&before), Values::new(1 << 31 | 0b100, [1.0, 2.0, 3.0, -1.0]));
        assert_eq!(told.iter().count(), 3);
    }

    #[test]
    fn of_two_values_for_an_output_the_later_counts() {
        let first = Outputs::NONE.with(VACUUM, Value::Digital(true)).with(FLOW, Value::Analog(0.5));
        let later = Outputs::NONE.with(VACUUM, Value::Digital(false));
        let both = first.and(&later);
        assert_eq!(both.value(VACUUM), Some(Value::Digital(false)));
        assert_eq!(both.value(FLOW), Some(Value::Analog(0.5)));
        assert_eq!(both.value(Channel::Digital(0)), None);
        assert_eq!(later.and(&first), first);
    }

    #[test]
    fn channels_that_cannot_be_and_values_of_the_other_type_are_ignored() {
        let odd = [
            (Channel::Digital(32), Value::Digital(true)),
            (Channel::Digital(255), Value::Digital(true)),
            (Channel::Analog(4), Value::Analog(1.0)),
            (Channel::Digital(0), Value::Analog(1.0)),
            (Channel::Analog(0), Value::Digital(true)),
        ];
        for (channel, value) in odd {
            assert_eq!(Outputs::NONE.with(channel, value), Outputs::NONE, "{channel} {value}");
        }
        assert_eq!(Values::default().analog(200), 0.0);
        assert!(Input::<bool>::of(FLOW).is_none());
    }

    #[test]
    fn the_words_of_signals_and_outputs_say_them() {
        let signals = Signals {
            inputs: Values::new(0x8000_0001, [0.5, -0.0, 3.0, f64::MAX]),
            outputs: Values::new(0x7fff_fffe, [f64::MIN, 1.0, 0.0, 2.0]),
        };
        let mut words = [u64::MAX; SIGNAL_WORDS];
        signals.put(&mut words);
        assert_eq!(Signals::get(&words), Ok(signals));
        assert_eq!(Signals::get(&words[1..]), Err(BadWords));

        let told = Outputs::NONE
            .with(VACUUM, Value::Digital(true))
            .with(Channel::Digital(2), Value::Digital(false))
            .with(Channel::Analog(0), Value::Analog(0.0));
        let mut words = [7; OUTPUT_WORDS];
        told.put(&mut words);
        assert_eq!(Outputs::get(&words), Ok(told));
        assert_eq!(Outputs::get(&words[1..]), Err(BadWords));
        words[1] = 1 << ANALOG;
        assert_eq!(Outputs::get(&words), Err(BadWords), "a channel that cannot be");
    }
}
