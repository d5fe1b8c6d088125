//! What a program does, as observers of servo periods see it: in the same process or, where the cell runs as processes, in
//! the plant.
//!
//! In: instructions of the MP's program or of an ECP's, as they begin and end. Out: plain numbers. Nothing in a cell acts
//! on them.

use crate::model::type_name::TypeName;
use crate::model::wire::{BadWords, Wire, layout_hash};
use crate::operator::state::InstructionKind;

/// Bytes of a name.
const NAME: usize = 48;

/// What a program does: its present instruction, or the last one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Activity {
    /// How many instructions have begun.
    pub instructions: u64,
    /// What is done now.
    pub doing: InstructionKind,
    /// Whether the operator has suspended the cell; always false of an ECP.
    pub suspended: bool,
    name: [u8; NAME],
}

impl Default for Activity {
    fn default() -> Self {
        Activity { instructions: 0, doing: InstructionKind::Nothing, suspended: false, name: [0; NAME] }
    }
}

impl Activity {
    /// The same when one more instruction has begun, of this generator or condition.
    #[must_use]
    pub fn begun(self, doing: InstructionKind, by: TypeName) -> Activity {
        Activity { instructions: self.instructions + 1, doing, name: by.bytes().0, ..self }
    }

    /// The same when it is over.
    #[must_use]
    pub fn over(self) -> Activity {
        Activity { doing: InstructionKind::Nothing, ..self }
    }

    /// The same when an instruction has begun, or is over where nothing is done from now on.
    pub(crate) fn changed(self, doing: InstructionKind, by: TypeName) -> Activity {
        if doing == InstructionKind::Nothing { self.over() } else { self.begun(doing, by) }
    }

    /// The generator or condition of the last instruction, or the first 48 bytes of its name; empty where there is none.
    #[must_use]
    pub fn by(&self) -> &str {
        let length = self.name.iter().position(|byte| *byte == 0).unwrap_or(NAME);
        let valid = core::str::from_utf8(&self.name[..length]);
        // A letter of several bytes may have been cut.
        valid.unwrap_or_else(|cut| core::str::from_utf8(&self.name[..cut.valid_up_to()]).unwrap_or_default())
    }
}

impl Wire for Activity {
    const LEN: usize = 3 + NAME / 8;
    const LAYOUT: u64 = layout_hash(0, "activity");

    fn put(&self, words: &mut [u64]) {
        words[..3].copy_from_slice(&[self.instructions, self.doing as u64, u64::from(self.suspended)]);
        for (word, chunk) in words[3..].iter_mut().zip(self.name.as_chunks::<8>().0) {
            *word = u64::from_le_bytes(*chunk);
        }
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let words = words.get(..Self::LEN).ok_or(BadWords)?;
        let doing = InstructionKind::from_word(words[1]).ok_or(BadWords)?;
        let mut name = [0; NAME];
        for (chunk, word) in name.as_chunks_mut::<8>().0.iter_mut().zip(&words[3..]) {
            *chunk = word.to_le_bytes();
        }
        Ok(Activity { instructions: words[0], doing, suspended: bool::get(&words[2..])?, name })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Dwell;
    struct ŻAConditionWithANameThatHasMoreThanFortyEightBytesż;

    #[test]
    fn an_activity_comes_back_from_its_words() {
        let begun = Activity::default().begun(InstructionKind::Wait, TypeName::of::<Dwell>());
        for activity in [Activity::default(), begun, begun.over(), Activity { suspended: true, ..begun }] {
            let mut words = [0; Activity::LEN];
            activity.put(&mut words);
            assert_eq!(Activity::get(&words), Ok(activity));
        }
        assert_eq!((begun.instructions, begun.doing, begun.by()), (1, InstructionKind::Wait, "Dwell"));
        assert_eq!((begun.over().instructions, begun.over().by()), (1, "Dwell"));
        assert_eq!(Activity::get(&[0, 99, 0]), Err(BadWords));
        assert_eq!(Activity::get(&[u64::MAX; Activity::LEN]), Err(BadWords));
        let long = begun.begun(
            InstructionKind::Move,
            TypeName::of::<ŻAConditionWithANameThatHasMoreThanFortyEightBytesż>(),
        );
        assert!(long.by().starts_with("ŻACondition") && long.by().len() <= NAME);
    }
}
