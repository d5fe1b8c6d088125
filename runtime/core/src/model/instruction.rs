//! Which instruction of a program something belongs to: its ordinal, its kind, and its generator or condition.

use core::fmt;

use crate::model::type_name::TypeName;
use crate::model::wire::{BadWords, Wire, layout_hash};

/// What kind of instruction an MP or an ECP carries out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InstructionKind {
    /// No instruction: its program computes, or is over.
    #[default]
    Nothing,
    /// The drives look for their reference marks.
    Homing,
    /// A Move.
    Move,
    /// A Wait.
    Wait,
}

impl InstructionKind {
    /// All of them; one travels as its place in this list.
    pub const ALL: [InstructionKind; 4] =
        [InstructionKind::Nothing, InstructionKind::Homing, InstructionKind::Move, InstructionKind::Wait];

    /// Their words, in the same order.
    pub const WORDS: [&'static str; InstructionKind::ALL.len()] = ["nothing", "homing", "move", "wait"];

    /// Its word.
    pub const fn word(self) -> &'static str {
        InstructionKind::WORDS[self as usize]
    }

    /// The one that travels as this; `None` if there is none.
    pub fn from_word(word: u64) -> Option<InstructionKind> {
        InstructionKind::ALL.get(usize::try_from(word).ok()?).copied()
    }
}

/// Whose program an instruction is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// The coordinator's.
    Mp,
    /// That of a robot's own ECP.
    Ecp,
}

/// Bytes of a name.
const NAME: usize = 40;

/// An instruction of a program, as a fault names it: `Move 7 (StraightLine)`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Instruction {
    ordinal: u32,
    doing: InstructionKind,
    level: Level,
    by: [u8; NAME],
}

impl Instruction {
    /// The instruction `ordinal`, counted from 1 since the program began, by this generator or condition, of which the first
    /// 40 bytes of the name are kept. None where nothing is done.
    pub(crate) fn new(
        ordinal: u64,
        doing: InstructionKind,
        level: Level,
        by: TypeName,
    ) -> Option<Instruction> {
        let ordinal = u32::try_from(ordinal).unwrap_or(u32::MAX);
        (doing != InstructionKind::Nothing).then(|| Instruction { ordinal, doing, level, by: by.bytes().0 })
    }

    /// Its place among the Moves and Waits of its program, counted from 1 since the program began; 0 of the search for
    /// reference marks, which comes before them.
    #[must_use]
    pub const fn ordinal(&self) -> u32 {
        self.ordinal
    }

    /// Its kind.
    #[must_use]
    pub const fn doing(&self) -> InstructionKind {
        self.doing
    }

    /// Whether it is of the program of a robot's own ECP; else it is the coordinator's.
    #[must_use]
    pub fn is_of_ecp(&self) -> bool {
        self.level == Level::Ecp
    }

    /// The name of its generator or condition, or the first 40 bytes of it; empty where it has none.
    #[must_use]
    pub fn by(&self) -> &str {
        let length = self.by.iter().position(|byte| *byte == 0).unwrap_or(NAME);
        let valid = core::str::from_utf8(&self.by[..length]);
        // A letter of several bytes may have been cut.
        valid.unwrap_or_else(|cut| core::str::from_utf8(&self.by[..cut.valid_up_to()]).unwrap_or_default())
    }
}

/// `Move 7 (StraightLine)`.
impl fmt::Display for Instruction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.doing {
            InstructionKind::Nothing => return f.write_str("no instruction"),
            InstructionKind::Homing => return f.write_str("homing"),
            InstructionKind::Move => write!(f, "Move {}", self.ordinal)?,
            InstructionKind::Wait => write!(f, "Wait {}", self.ordinal)?,
        }
        match self.by() {
            "" => Ok(()),
            by => write!(f, " ({})", crate::console::quoted(by, NAME)),
        }
    }
}

impl fmt::Debug for Instruction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Instruction({self})")
    }
}

/// The bit that says that an instruction is of an ECP's program, beside its kind.
const OF_ECP: u64 = 1 << 40;

impl Wire for Instruction {
    const LEN: usize = 1 + NAME / 8;
    const LAYOUT: u64 = layout_hash(0, "instruction");

    fn put(&self, words: &mut [u64]) {
        let level = if self.is_of_ecp() { OF_ECP } else { 0 };
        words[0] = u64::from(self.ordinal) | (self.doing as u64) << 32 | level;
        for (word, chunk) in words[1..].iter_mut().zip(self.by.as_chunks::<8>().0) {
            *word = u64::from_le_bytes(*chunk);
        }
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let words = words.get(..Self::LEN).ok_or(BadWords)?;
        let level = if words[0] & OF_ECP != 0 { Level::Ecp } else { Level::Mp };
        let doing = InstructionKind::from_word((words[0] & !OF_ECP) >> 32).ok_or(BadWords)?;
        let mut by = [0; NAME];
        for (chunk, word) in by.as_chunks_mut::<8>().0.iter_mut().zip(&words[1..]) {
            *chunk = word.to_le_bytes();
        }
        Ok(Instruction { ordinal: words[0] as u32, doing, level, by })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Dwell;

    #[test]
    fn an_instruction_comes_back_from_its_words_and_is_shown_as_the_program_counts_it() {
        let by = TypeName::of::<Dwell>();
        for (doing, level, by, shown) in [
            (InstructionKind::Move, Level::Mp, by, "Move 7 (Dwell)"),
            (InstructionKind::Wait, Level::Ecp, by, "Wait 7 (Dwell)"),
            (InstructionKind::Move, Level::Mp, TypeName::NONE, "Move 7"),
            (InstructionKind::Homing, Level::Mp, TypeName::NONE, "homing"),
        ] {
            let one = Instruction::new(7, doing, level, by).expect("something is done");
            let mut words = [0; Instruction::LEN];
            one.put(&mut words);
            assert_eq!(Instruction::get(&words), Ok(one));
            assert_eq!(one.to_string(), shown);
            assert_eq!((one.ordinal(), one.is_of_ecp()), (7, level == Level::Ecp));
        }
        assert_eq!(Instruction::new(7, InstructionKind::Nothing, Level::Mp, by), None);
        assert_eq!(Instruction::get(&[u64::MAX; Instruction::LEN]), Err(BadWords));
        assert_eq!(Instruction::get(&[0]), Err(BadWords));
    }
}
