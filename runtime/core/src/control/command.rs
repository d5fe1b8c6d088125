//! What goes between an EDP and the plant, as words: a command for a servo period, and what the encoders read.

use crate::link::message::{Kind, Message};
use crate::model::driver::{Driver, Measured, Regulators};
use crate::model::joints::{JointVector, MAX_JOINTS};
use crate::model::load::{LOAD_WORDS, Load};
use crate::model::pose::Pose;
use crate::model::signals::{OUTPUT_WORDS, Outputs, SIGNAL_WORDS, Signals};
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
    /// The tool in force, `X_FE`: for observers.
    pub tool: Pose,
    pub told: DriveSettings,
}

/// What drives are told beside where to be: it stays so until they are told something else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DriveSettings {
    /// The last value of each output that has been told one.
    pub outputs: Outputs,
    /// How often they were told what the robot carries, and what they were told last.
    pub loads: u64,
    pub load: Load,
}

impl Default for DriveSettings {
    fn default() -> Self {
        DriveSettings { outputs: Outputs::NONE, loads: 0, load: Load::NONE }
    }
}

impl DriveSettings {
    const LEN: usize = OUTPUT_WORDS + 1 + LOAD_WORDS;

    fn is_nothing(&self) -> bool {
        self.outputs.is_none() && self.loads == 0
    }

    fn put(&self, words: &mut [u64]) {
        let (outputs, load) = words.split_at_mut(OUTPUT_WORDS);
        self.outputs.put(outputs);
        load[0] = self.loads;
        self.load.put(&mut load[1..]);
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let outputs = Outputs::get(words)?;
        let load = words.get(OUTPUT_WORDS..DriveSettings::LEN).ok_or(BadWords)?;
        Ok(DriveSettings { outputs, loads: load[0], load: Load::get(&load[1..])? })
    }
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
    /// What the robot's inputs read then, and what its outputs are.
    pub signals: Signals,
}

const TOOL: usize = 3 + MAX_JOINTS;
const COMMAND_WORDS: usize = TOOL + Pose::LEN;
/// The same with what drives are told beside.
const LONG_COMMAND_WORDS: usize = COMMAND_WORDS + DriveSettings::LEN;
const READING_WORDS: usize = 3 * MAX_JOINTS;
/// The same with currents, and with signals.
const WITH_CURRENTS: usize = 4 * MAX_JOINTS;
const LONG_READING_WORDS: usize = WITH_CURRENTS + SIGNAL_WORDS;
const SWITCH_WORDS: usize = 1;
const _: () = assert!(LONG_COMMAND_WORDS <= WORDS && LONG_READING_WORDS <= WORDS);

/// What a reading with signals has in the place of currents that nobody measures: no current has these bits.
const UNMEASURED: u64 = u64::MAX;

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
        if !self.told.is_nothing() {
            message.header.len = LONG_COMMAND_WORDS as u32;
            self.told.put(&mut message.body[COMMAND_WORDS..LONG_COMMAND_WORDS]);
        }
    }

    /// # Errors
    /// [`BadWords`] when the message is no command.
    pub fn get(message: &Message) -> Result<Self, BadWords> {
        let words = message.words();
        if message.header.kind != Kind::Command {
            return Err(BadWords);
        }
        let told = match words.len() {
            COMMAND_WORDS => DriveSettings::default(),
            LONG_COMMAND_WORDS => DriveSettings::get(&words[COMMAND_WORDS..])?,
            _ => return Err(BadWords),
        };
        Ok(Command {
            period: message.header.step,
            switched: words[0],
            choice: words[1],
            regulators: Regulators::from_word(words[2]),
            demanded: get(&words[3..TOOL]),
            tool: Pose::get(&words[TOOL..])?,
            told,
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
        let (currents, signals) = words[READING_WORDS..].split_at_mut(WITH_CURRENTS - READING_WORDS);
        match &self.currents {
            Some(measured) => {
                message.header.len = WITH_CURRENTS as u32;
                put(measured, currents);
            }
            None => currents[0] = UNMEASURED,
        }
        if !self.signals.are_off() {
            message.header.len = LONG_READING_WORDS as u32;
            self.signals.put(signals);
        }
    }

    /// # Errors
    /// [`BadWords`] when the message is no reading.
    pub fn get(message: &Message) -> Result<Self, BadWords> {
        let words = message.words();
        let known = [READING_WORDS, WITH_CURRENTS, LONG_READING_WORDS].contains(&words.len());
        if message.header.kind != Kind::Reply || !known {
            return Err(BadWords);
        }
        let is_measured = words.get(READING_WORDS).is_some_and(|&word| word != UNMEASURED);
        let signals = words.get(WITH_CURRENTS..).filter(|signals| !signals.is_empty());
        let measured = Measured { position: get(words), velocity: get(&words[MAX_JOINTS..]) };
        Ok(Reading {
            period: message.header.step,
            measured,
            demanded: get(&words[2 * MAX_JOINTS..]),
            currents: is_measured.then(|| get(&words[READING_WORDS..])),
            signals: signals.map_or(Ok(Signals::OFF), Signals::get)?,
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
