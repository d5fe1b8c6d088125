//! The lines of a program and how its O-words belong together, found before the first line runs.
//!
//! `o.. sub` with its `endsub`, `if` with its branches, loops with their ends: each opener and its ends carry the same
//! label, and they stand within one another as brackets do. What does not is refused here, with its line.

use std::collections::HashMap;

use super::o_word::{Found, Keyword, Label, end_of, name_of, o_word};
use super::stop::{Stop, malformed};

/// What an O-word does. Numbers are those of lines, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// A number alone: the name of a program, and where M98 finds it.
    Number,
    /// Not entered but by a call.
    Sub {
        end: usize,
    },
    EndSub,
    Return,
    Call,
    If {
        next: usize,
    },
    /// Reached after a branch that was taken, it leads to the end; else `next` is the next branch.
    ElseIf {
        next: usize,
        end: usize,
    },
    Else {
        end: usize,
    },
    EndIf,
    While {
        end: usize,
    },
    EndWhile {
        start: usize,
    },
    Do,
    DoWhile {
        start: usize,
    },
    Repeat {
        end: usize,
    },
    EndRepeat {
        start: usize,
    },
    /// Out of the loop, or to its end.
    Break {
        start: usize,
        end: usize,
    },
    Continue {
        start: usize,
        end: usize,
    },
}

/// An O-word's place in its line.
#[derive(Clone, Debug)]
pub struct OWord {
    pub label: Label,
    pub flow: Flow,
    /// Where the label begins, and where the line goes on after the word \[bytes\].
    pub byte: usize,
    pub rest: usize,
    /// Where its line begins in the text \[bytes\].
    start: usize,
}

/// A program: its text, and what its O-words lead to.
pub struct Program<'a> {
    text: &'a str,
    /// O-words by line.
    words: HashMap<usize, OWord>,
    /// First lines of subroutines, and of numbered programs.
    pub subs: HashMap<Label, usize>,
    pub numbers: HashMap<u32, usize>,
    /// Lines that begin with `/` and are left out.
    pub deleted: usize,
    /// What all lines cost together.
    pub cost: usize,
}

/// Where a program goes on.
#[derive(Clone, Copy, Debug)]
pub struct Cursor {
    /// The line, from 0.
    pub line: usize,
    byte: usize,
}

impl Cursor {
    /// What it costs to run the line that has brought the cursor here, with the empty lines before it \[bytes\]: their
    /// length and a little more.
    pub fn cost_since(&self, before: Cursor) -> usize {
        self.byte - before.byte + 48
    }
}

/// The most O-words of a program: more than anybody writes, and few enough to be kept in memory.
const MOST_O_WORDS: usize = 50_000;

/// How many bytes end a line, where they are the next ones: then it is empty.
fn line_end(bytes: &[u8]) -> Option<usize> {
    match bytes {
        [b'\n', ..] => Some(1),
        [b'\r', b'\n', ..] => Some(2),
        _ => None,
    }
}

/// An opener whose end has not come yet.
struct Open {
    keyword: Keyword,
    label: Label,
    line: usize,
    /// `if` and its branches so far; `break` and `continue` of a loop.
    inner: Vec<usize>,
}

/// Whether lines that begin with `/` run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BlockDelete {
    /// They are left out, as with the machine's switch on.
    #[default]
    On,
    /// They run as all others.
    Off,
}

impl BlockDelete {
    /// Whether the line is left out.
    pub fn deletes(self, line: &str) -> bool {
        self == Self::On && line.trim_start().starts_with('/')
    }
}

impl<'a> Program<'a> {
    /// The lines up to the second `%`, or all; their O-words matched. An error's line is set.
    pub fn new(text: &'a str, delete: BlockDelete, depth: usize) -> Result<Self, Stop> {
        let (words, subs, numbers) = (HashMap::new(), HashMap::new(), HashMap::new());
        let mut program = Program { text, words, subs, numbers, deleted: 0, cost: 0 };
        let mut open: Vec<Open> = Vec::new();
        let mut percent_signs = 0;
        let mut cursor = Self::begin();
        loop {
            let before = cursor;
            program.skip_empty(&mut cursor);
            let start = cursor.byte;
            let Some((number, line)) = program.next(&mut cursor) else { break };
            program.cost += cursor.cost_since(before);
            if line.trim() == "%" {
                percent_signs += 1;
                if percent_signs == 2 {
                    program.text = &text[..cursor.byte];
                    break;
                }
            } else if delete.deletes(line) {
                program.deleted += 1;
            } else if let Some(found) = o_word(line).map_err(|stop| stop.on(number))? {
                let Found { keyword, label, byte, rest } = found;
                let word = OWord { label, flow: Flow::Number, byte, rest, start };
                program.place(number, keyword, word, &mut open).map_err(|stop| stop.on(number))?;
                if open.len() > depth {
                    return Err(Stop::too_deep(0, "O-words", depth).on(number));
                }
                if program.words.len() > MOST_O_WORDS {
                    let what = format!("more than {MOST_O_WORDS} O-words");
                    return malformed(0, what, "split the program").map_err(|stop: Stop| stop.on(number));
                }
            }
        }
        match open.pop() {
            None => Ok(program),
            Some(Open { keyword, line, .. }) => {
                let what = format!("o.. {} without its end", name_of(keyword));
                malformed(0, what, format!("write o.. {} with the same label", end_of(keyword)))
                    .map_err(|stop: Stop| stop.on(line))
            }
        }
    }

    /// At the first line.
    pub fn begin() -> Cursor {
        Cursor { line: 0, byte: 0 }
    }

    /// Goes on to the next line that is not empty.
    fn skip_empty(&self, cursor: &mut Cursor) {
        while let Some(end) = line_end(self.text.as_bytes().get(cursor.byte..).unwrap_or_default()) {
            cursor.byte += end;
            cursor.line += 1;
        }
    }

    /// The number and the text of the next line that is not empty.
    pub fn next(&self, cursor: &mut Cursor) -> Option<(usize, &'a str)> {
        self.skip_empty(cursor);
        let rest = self.text.get(cursor.byte..).filter(|rest| !rest.is_empty())?;
        let length = rest.find('\n').map_or(rest.len(), |end| end + 1);
        let number = cursor.line;
        cursor.byte += length;
        cursor.line += 1;
        Some((number, rest[..length].trim_end_matches(['\n', '\r'])))
    }

    /// The O-word of a line.
    pub fn word(&self, line: usize) -> Option<&OWord> {
        self.words.get(&line)
    }

    /// At a line with an O-word.
    pub fn at(&self, line: usize) -> Cursor {
        Cursor { line, byte: self.words.get(&line).map_or(self.text.len(), |word| word.start) }
    }

    /// At the line after one with an O-word.
    pub fn after(&self, line: usize) -> Cursor {
        let mut cursor = self.at(line);
        self.next(&mut cursor);
        cursor
    }

    fn place(
        &mut self,
        line: usize,
        keyword: Keyword,
        word: OWord,
        open: &mut Vec<Open>,
    ) -> Result<(), Stop> {
        let OWord { label, byte, .. } = word.clone();
        let opener = |keyword| Open { keyword, label: label.clone(), line, inner: Vec::new() };
        let no_match = || {
            let name = name_of(keyword);
            malformed(
                byte,
                format!("o.. {name} that ends nothing"),
                "give it the label of what it belongs to",
            )
        };
        if label == Label::Computed && keyword != Keyword::Call {
            return malformed(byte, "a computed label", "only o[..] call may compute its label");
        }
        let flow = match keyword {
            Keyword::Number => {
                if let Label::Number(n) = label {
                    self.numbers.entry(n).or_insert(line);
                }
                Flow::Number
            }
            Keyword::Sub => {
                if !open.is_empty() {
                    return malformed(byte, "a subroutine inside something else", "define it outside");
                }
                if self.subs.insert(label.clone(), line).is_some() {
                    return malformed(byte, "a second subroutine of this label", "give each its own label");
                }
                open.push(opener(keyword));
                Flow::Sub { end: line }
            }
            Keyword::If | Keyword::While | Keyword::Do | Keyword::Repeat => {
                let closes = open.last().is_some_and(|o| o.keyword == Keyword::Do && o.label == label);
                if keyword == Keyword::While && closes {
                    let Some(begun) = open.pop() else { return no_match() };
                    self.close_loop(&begun, line);
                    self.words.insert(line, OWord { flow: Flow::DoWhile { start: begun.line }, ..word });
                    return Ok(());
                }
                open.push(opener(keyword));
                match keyword {
                    Keyword::If => Flow::If { next: line },
                    Keyword::While => Flow::While { end: line },
                    Keyword::Do => Flow::Do,
                    _ => Flow::Repeat { end: line },
                }
            }
            Keyword::ElseIf | Keyword::Else => match open.last_mut() {
                Some(o) if o.keyword == Keyword::If && o.label == label => {
                    o.inner.push(line);
                    if keyword == Keyword::Else {
                        Flow::Else { end: line }
                    } else {
                        Flow::ElseIf { next: line, end: line }
                    }
                }
                _ => return no_match(),
            },
            Keyword::EndSub | Keyword::EndIf | Keyword::EndWhile | Keyword::EndRepeat => {
                let begins = match keyword {
                    Keyword::EndSub => Keyword::Sub,
                    Keyword::EndIf => Keyword::If,
                    Keyword::EndWhile => Keyword::While,
                    _ => Keyword::Repeat,
                };
                let begun = match open.pop() {
                    Some(o) if o.keyword == begins && o.label == label => o,
                    _ => return no_match(),
                };
                let start = begun.line;
                match keyword {
                    Keyword::EndSub => self.reflow(start, |_| Flow::Sub { end: line }),
                    Keyword::EndIf => self.close_if(&begun, line),
                    _ => self.close_loop(&begun, line),
                }
                match keyword {
                    Keyword::EndSub => Flow::EndSub,
                    Keyword::EndIf => Flow::EndIf,
                    Keyword::EndWhile => Flow::EndWhile { start },
                    _ => Flow::EndRepeat { start },
                }
            }
            Keyword::Break | Keyword::Continue => {
                let around = open.iter_mut().rev().find(|o| {
                    matches!(o.keyword, Keyword::While | Keyword::Do | Keyword::Repeat) && o.label == label
                });
                let Some(around) = around else { return no_match() };
                around.inner.push(line);
                let start = around.line;
                if keyword == Keyword::Break {
                    Flow::Break { start, end: line }
                } else {
                    Flow::Continue { start, end: line }
                }
            }
            Keyword::Return => match open.first() {
                Some(o) if o.keyword == Keyword::Sub && o.label == label => Flow::Return,
                _ => return no_match(),
            },
            Keyword::Call => Flow::Call,
        };
        self.words.insert(line, OWord { flow, ..word });
        Ok(())
    }

    fn reflow(&mut self, line: usize, flow: impl Fn(Flow) -> Flow) {
        if let Some(word) = self.words.get_mut(&line) {
            word.flow = flow(word.flow);
        }
    }

    fn close_if(&mut self, begun: &Open, end: usize) {
        let mut branches = vec![begun.line];
        branches.extend(&begun.inner);
        branches.push(end);
        for pair in branches.windows(2) {
            self.reflow(pair[0], |flow| match flow {
                Flow::If { .. } => Flow::If { next: pair[1] },
                Flow::ElseIf { .. } => Flow::ElseIf { next: pair[1], end },
                Flow::Else { .. } => Flow::Else { end },
                other => other,
            });
        }
    }

    fn close_loop(&mut self, begun: &Open, end: usize) {
        for line in begun.inner.iter().chain([&begun.line]) {
            self.reflow(*line, |flow| match flow {
                Flow::While { .. } => Flow::While { end },
                Flow::Repeat { .. } => Flow::Repeat { end },
                Flow::Break { start, .. } => Flow::Break { start, end },
                Flow::Continue { start, .. } => Flow::Continue { start, end },
                other => other,
            });
        }
    }
}
