//! What goes between an EDP and the plant, as words: a command for a servo period, and what the encoders read.

use crate::link::message::{Kind, Message};
use crate::model::driver::{Driver, Measured, Regulators};
use crate::model::joints::{JointVector, MAX_JOINTS};
use crate::model::pose::Pose;
use crate::model::wire::{BadWords, WORDS, Wire};

/// What drives are to do in a servo period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Command<J> {
    /// Ordinal of the period, counted from the start of the cell.
    pub period: u64,
    /// How often power was switched before: the newest message is all that the plant may see.
    pub switched: u64,
    /// How often regulators have been chosen: a choice is acted on once.
    pub choice: u64,
    pub regulators: Regulators,
    /// The position for the period's end [rad or m].
    pub demanded: J,
    /// The tool in force, `X_FE`: for those who look on.
    pub tool: Pose,
}

/// Power for drives that have none, or none for drives that stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Switch {
    /// Ordinal of the order, counted from 1: each is acted on once.
    pub ordinal: u64,
    pub on: bool,
}

/// What drives did in a servo period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading<J> {
    /// Ordinal of the period.
    pub period: u64,
    /// What the encoders read at its end.
    pub measured: Measured<J>,
    /// The position that the drives were told for that.
    pub demanded: J,
    /// The currents of the motors then \[A\], if the drives measure them.
    pub currents: Option<J>,
}

const TOOL: usize = 3 + MAX_JOINTS;
const COMMAND_WORDS: usize = TOOL + Pose::LEN;
const READING_WORDS: usize = 3 * MAX_JOINTS;
/// The same with currents.
const LONG_READING_WORDS: usize = 4 * MAX_JOINTS;
const SWITCH_WORDS: usize = 1;
const _: () = assert!(COMMAND_WORDS <= WORDS && LONG_READING_WORDS <= WORDS);

fn put<J: JointVector>(joints: &J, words: &mut [u64]) {
    for (word, x) in words.iter_mut().zip(joints.as_slice()) {
        *word = x.to_bits();
    }
}

fn get<J: JointVector>(words: &[u64]) -> J {
    J::from_joints(|i| f64::from_bits(words[i]))
}

impl<J: JointVector> Command<J> {
    pub fn put(&self, message: &mut Message) {
        message.header.kind = Kind::Command;
        message.header.step = self.period;
        message.header.len = COMMAND_WORDS as u32;
        message.body[..3].copy_from_slice(&[self.switched, self.choice, self.regulators.to_word()]);
        put(&self.demanded, &mut message.body[3..TOOL]);
        self.tool.put(&mut message.body[TOOL..COMMAND_WORDS]);
    }

    /// # Errors
    /// [`BadWords`] when the message is no command.
    pub fn get(message: &Message) -> Result<Self, BadWords> {
        let words = message.words();
        if message.header.kind != Kind::Command || words.len() != COMMAND_WORDS {
            return Err(BadWords);
        }
        Ok(Command {
            period: message.header.step,
            switched: words[0],
            choice: words[1],
            regulators: Regulators::from_word(words[2]),
            demanded: get(&words[3..TOOL]),
            tool: Pose::get(&words[TOOL..])?,
        })
    }
}

impl Switch {
    pub fn put(&self, message: &mut Message) {
        message.header.kind = Kind::Command;
        message.header.step = self.ordinal;
        message.header.len = SWITCH_WORDS as u32;
        message.body[0] = u64::from(self.on);
    }

    /// # Errors
    /// [`BadWords`] when the message is no switch.
    pub fn get(message: &Message) -> Result<Self, BadWords> {
        match message.words() {
            &[on @ (0 | 1)] if message.header.kind == Kind::Command => {
                Ok(Switch { ordinal: message.header.step, on: on == 1 })
            }
            _ => Err(BadWords),
        }
    }
}

impl<J: JointVector> Reading<J> {
    pub fn put(&self, message: &mut Message) {
        message.header.kind = Kind::Reply;
        message.header.step = self.period;
        message.header.len = READING_WORDS as u32;
        let words = &mut message.body;
        put(&self.measured.position, &mut words[..MAX_JOINTS]);
        put(&self.measured.velocity, &mut words[MAX_JOINTS..2 * MAX_JOINTS]);
        put(&self.demanded, &mut words[2 * MAX_JOINTS..]);
        if let Some(currents) = &self.currents {
            message.header.len = LONG_READING_WORDS as u32;
            put(currents, &mut words[READING_WORDS..]);
        }
    }

    /// # Errors
    /// [`BadWords`] when the message is no reading.
    pub fn get(message: &Message) -> Result<Self, BadWords> {
        let words = message.words();
        let is_long = words.len() == LONG_READING_WORDS;
        if message.header.kind != Kind::Reply || !(is_long || words.len() == READING_WORDS) {
            return Err(BadWords);
        }
        let measured = Measured { position: get(words), velocity: get(&words[MAX_JOINTS..]) };
        Ok(Reading {
            period: message.header.step,
            measured,
            demanded: get(&words[2 * MAX_JOINTS..]),
            currents: is_long.then(|| get(&words[READING_WORDS..])),
        })
    }
}

/// Which parameter sets the regulators of a robot have, one bit each: an EDP knows it without asking the plant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RegulatorSets([[u64; 4]; MAX_JOINTS]);

impl RegulatorSets {
    /// Those of these drives.
    pub fn of<R: crate::model::robot::Robot>(driver: &dyn Driver<R>) -> RegulatorSets {
        let mut sets = [[0; 4]; MAX_JOINTS];
        for (joint, words) in sets.iter_mut().enumerate().take(R::Joints::LEN) {
            for set in (0..=u8::MAX).filter(|&set| driver.has_regulator(joint, set)) {
                words[usize::from(set) / 64] |= 1 << (set % 64);
            }
        }
        RegulatorSets(sets)
    }

    /// Whether the regulator of `joint` has a parameter set of this number.
    pub fn has(&self, joint: usize, set: u8) -> bool {
        self.0.get(joint).is_some_and(|words| words[usize::from(set) / 64] >> (set % 64) & 1 == 1)
    }
}
