//! One line as words: `N` numbers, comments and assignments are gone, every value is computed.
//!
//! A word that the machine carries out is taken; what is left when the line is done, the reader tells.

use std::cell::Cell;

use super::characters::Characters;
use super::expression::Values;
use super::parameters::Parameters;
use super::stop::{Stop, malformed, unsupported};

/// A letter with its value, and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Word {
    pub letter: char,
    pub value: f64,
    pub byte: usize,
    taken: Cell<bool>,
}

/// The words of a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Block {
    pub words: Vec<Word>,
}

impl Block {
    /// The word of a letter that stands at most once, to be carried out.
    pub fn word(&self, letter: char) -> Option<&Word> {
        let word = self.words.iter().find(|word| word.letter == letter)?;
        word.taken.set(true);
        Some(word)
    }

    /// The value of a letter, to be carried out.
    pub fn value(&self, letter: char) -> Option<f64> {
        self.word(letter).map(|word| word.value)
    }

    /// Takes the words of these letters without carrying them out: who calls says so.
    pub fn take(&self, letters: &str) {
        self.words.iter().filter(|word| letters.contains(word.letter)).for_each(|word| word.taken.set(true));
    }

    /// Whether one of the letters stands, which takes none.
    pub fn has(&self, letters: &str) -> bool {
        self.first(letters).is_some()
    }

    /// Where the first of the letters stands.
    pub fn first(&self, letters: &str) -> Option<usize> {
        self.words.iter().find(|word| letters.contains(word.letter)).map(|word| word.byte)
    }

    /// The words of a letter that may stand several times: G and M, which are always carried out or told.
    pub fn all(&self, letter: char) -> impl Iterator<Item = &Word> {
        self.words.iter().filter(move |word| word.letter == letter).inspect(|word| word.taken.set(true))
    }

    /// The words that nothing has taken.
    pub fn untaken(&self) -> impl Iterator<Item = &Word> {
        self.words.iter().filter(|word| !word.taken.get())
    }
}

/// Reads a line, or what an O-word left of it; parameters are set after all its values are read, as RS-274 has it.
pub fn parse(line: &mut Characters<'_>, parameters: &mut Parameters, depth: usize) -> Result<Block, Stop> {
    let mut block = Block::default();
    let mut settings = Vec::new();
    refuse_macro_statements(line)?;
    while let Some(c) = line.peek() {
        let byte = line.byte();
        match c {
            ';' => break,
            '%' => {
                line.take();
            }
            '(' => comment(line)?,
            '#' => {
                let mut values = Values { line, parameters, depth, limit: depth };
                let parameter = values.parameter()?;
                if !values.line.accept('=') {
                    return malformed(byte, "a parameter without a value", "write #n = value");
                }
                if !Parameters::is_free(&parameter) {
                    let help = "positions and offsets are set by G10, G52 and G92, homes by G28.1 and G30.1";
                    return unsupported(byte, "a value for a parameter that the machine keeps", help);
                }
                settings.push((parameter, values.value()?));
            }
            '*' => break, // Marlin's checksum ends the line.
            c if c.is_ascii_alphabetic() || matches!(c, '@' | '^') => {
                line.take();
                let value = Values { line, parameters, depth, limit: depth }.value()?;
                push(&mut block, Word { letter: c, value, byte, taken: Cell::new(false) })?;
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

/// Takes a comment from its parenthesis on.
pub fn comment(line: &mut Characters<'_>) -> Result<(), Stop> {
    let byte = line.byte();
    if line.through(')').is_none() {
        return malformed(byte, "a comment without its )", "close the comment, or begin it with ;");
    }
    Ok(())
}

/// Fanuc's macro statements look like words and are none.
fn refuse_macro_statements(line: &mut Characters<'_>) -> Result<(), Stop> {
    let rest: String = line.rest().chars().take(8).filter(|c| !c.is_whitespace()).collect();
    let rest = rest.to_ascii_lowercase();
    let found =
        ["if[", "while[", "goto", "end1", "end2", "end3"].iter().find(|word| rest.starts_with(**word));
    match found {
        None => Ok(()),
        Some(word) => {
            let word = word.trim_end_matches(['[', '1', '2', '3']).to_ascii_uppercase();
            let help = "write it by O-words: o1 if [..], o1 while [..], o1 repeat [..], o<name> sub";
            unsupported(line.byte(), format!("{word}, a statement of Fanuc's macros"), help)
        }
    }
}

fn push(block: &mut Block, word: Word) -> Result<(), Stop> {
    if word.letter == 'n' {
        return Ok(());
    }
    let repeats = !matches!(word.letter, 'g' | 'm');
    if repeats && block.words.iter().any(|other| other.letter == word.letter) {
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
