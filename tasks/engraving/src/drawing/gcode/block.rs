//! One line as words: `N` numbers, comments and assignments are gone, every value is computed.

use super::characters::Characters;
use super::expression::Values;
use super::parameters::Parameters;
use super::{Stop, malformed, unsupported};

/// A letter with its value, and where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Word {
    pub letter: char,
    pub value: f64,
    pub byte: usize,
}

/// The words of a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Block {
    pub words: Vec<Word>,
}

impl Block {
    /// The word of a letter that stands at most once.
    pub fn word(&self, letter: char) -> Option<&Word> {
        self.words.iter().find(|word| word.letter == letter)
    }

    /// The value of a letter.
    pub fn value(&self, letter: char) -> Option<f64> {
        self.word(letter).map(|word| word.value)
    }
}

/// Reads a line; parameters are set after all its values are read, as RS-274 has it.
pub fn parse(line: &mut Characters<'_>, parameters: &mut Parameters, depth: usize) -> Result<Block, Stop> {
    let mut block = Block::default();
    let mut settings = Vec::new();
    // Block delete: a line that starts with / is skipped, as with the machine's switch on.
    if line.peek() == Some('/') {
        return Ok(block);
    }
    while let Some(c) = line.peek() {
        let byte = line.byte();
        match c {
            ';' => break,
            '%' => {
                line.take();
            }
            '(' => {
                if line.through(')').is_none() {
                    return malformed(
                        byte,
                        "a comment without its )",
                        "close the comment, or begin it with ;",
                    );
                }
            }
            '#' => {
                let mut values = Values { line, parameters, depth, limit: depth };
                let parameter = values.parameter()?;
                if !values.line.accept('=') {
                    return malformed(byte, "a parameter without a value", "write #n = value");
                }
                settings.push((parameter, values.value()?));
            }
            'o' => {
                return unsupported(
                    byte,
                    "an O-word (subroutine, loop or condition)",
                    "write the program out without O-words; CAM programs have a setting for it",
                );
            }
            '*' => break, // Marlin's checksum ends the line.
            c if c.is_ascii_alphabetic() => {
                line.take();
                let value = Values { line, parameters, depth, limit: depth }.value()?;
                push(&mut block, Word { letter: c, value, byte })?;
            }
            c => {
                return malformed(
                    byte,
                    format!("{c:?} where a word should begin"),
                    "a word is a letter and a number, as X12.5",
                );
            }
        }
    }
    for (parameter, value) in settings {
        parameters.set(parameter, value);
    }
    Ok(block)
}

fn push(block: &mut Block, word: Word) -> Result<(), Stop> {
    if word.letter == 'n' {
        return Ok(());
    }
    let repeats = !matches!(word.letter, 'g' | 'm');
    if repeats && block.word(word.letter).is_some() {
        let letter = word.letter.to_ascii_uppercase();
        return malformed(
            word.byte,
            format!("a second {letter} word in one line"),
            "give each letter once a line",
        );
    }
    block.words.push(word);
    Ok(())
}
