//! One O-word: its label, its keyword, and where they stand in their line.

use super::characters::Characters;
use super::stop::{Stop, malformed};

/// What stands after `O`: a number or a name, in lower case.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Label {
    Number(u32),
    Name(String),
    /// `o[..]` or `o#..`: known only when it runs.
    Computed,
}

/// An O-word as it stands.
pub struct Found {
    pub keyword: Keyword,
    pub label: Label,
    /// Where the O stands, and where the line goes on after the keyword \[bytes\].
    pub byte: usize,
    pub rest: usize,
}

/// Keywords of O-words; `Number` is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keyword {
    Number,
    Sub,
    EndSub,
    Return,
    Call,
    If,
    ElseIf,
    Else,
    EndIf,
    While,
    EndWhile,
    Do,
    Repeat,
    EndRepeat,
    Break,
    Continue,
}

const KEYWORDS: [(&str, Keyword); 15] = [
    ("sub", Keyword::Sub),
    ("endsub", Keyword::EndSub),
    ("return", Keyword::Return),
    ("call", Keyword::Call),
    ("if", Keyword::If),
    ("elseif", Keyword::ElseIf),
    ("else", Keyword::Else),
    ("endif", Keyword::EndIf),
    ("while", Keyword::While),
    ("endwhile", Keyword::EndWhile),
    ("do", Keyword::Do),
    ("repeat", Keyword::Repeat),
    ("endrepeat", Keyword::EndRepeat),
    ("break", Keyword::Break),
    ("continue", Keyword::Continue),
];

/// How a keyword is written.
pub fn name_of(keyword: Keyword) -> &'static str {
    KEYWORDS.iter().find(|(_, known)| *known == keyword).map_or("", |(name, _)| name)
}

/// What ends what a keyword opens.
pub fn end_of(keyword: Keyword) -> &'static str {
    match keyword {
        Keyword::Sub => "endsub",
        Keyword::If => "endif",
        Keyword::While => "endwhile",
        Keyword::Do => "while [..]",
        _ => "endrepeat",
    }
}

/// The O-word with which a line begins, if it does; after block delete and a line number.
pub fn o_word(line: &str) -> Result<Option<Found>, Stop> {
    let mut at = Characters::new(line);
    at.accept('/');
    if at.accept('n') {
        while at.peek().is_some_and(|c| c.is_ascii_digit() || c == '.') {
            at.take();
        }
    }
    let byte = at.byte();
    // Some controls write the number of a program after a colon.
    if !at.accept('o') && !at.accept(':') {
        return Ok(None);
    }
    let label = label(&mut at, byte)?;
    let name = at.name();
    let keyword = match KEYWORDS.iter().find(|(known, _)| *known == name) {
        Some((_, keyword)) => *keyword,
        None if matches!(label, Label::Number(_)) && name.is_empty() => Keyword::Number,
        None => {
            let help = "known are sub endsub call return if elseif else endif while endwhile do repeat endrepeat break continue";
            return malformed(byte, format!("the O-word {name:?}"), help);
        }
    };
    let rest = at.byte();
    Ok(Some(Found { keyword, label, byte, rest }))
}

fn label(at: &mut Characters<'_>, byte: usize) -> Result<Label, Stop> {
    if at.accept('<') {
        return match at.through('>') {
            Some(name) => {
                let name: String = name.chars().filter(|c| !c.is_whitespace()).collect();
                Ok(Label::Name(name.to_ascii_lowercase()))
            }
            None => malformed(byte, "an O-word's name without its >", "write o<name>"),
        };
    }
    if matches!(at.peek(), Some('[' | '#')) {
        // Its value needs parameters: skip to the keyword, which is the first letter outside brackets.
        skip_value(at, byte)?;
        return Ok(Label::Computed);
    }
    let mut digits = String::new();
    while let Some(c) = at.peek().filter(char::is_ascii_digit) {
        digits.push(c);
        at.take();
    }
    match digits.parse() {
        Ok(number) => Ok(Label::Number(number)),
        Err(_) => malformed(byte, "an O-word without a number", "write o100, or o<name>"),
    }
}

/// Skips `[..]`, `#n`, `#<name>`, `##n`.
fn skip_value(at: &mut Characters<'_>, byte: usize) -> Result<(), Stop> {
    while at.accept('#') {}
    if at.accept('<') {
        at.through('>');
        return Ok(());
    }
    let mut depth = 0usize;
    while let Some(c) = at.peek() {
        match c {
            '[' => depth += 1,
            ']' => depth = depth.saturating_sub(1),
            c if depth == 0 && !c.is_ascii_digit() => return Ok(()),
            _ => {}
        }
        at.take();
    }
    malformed(byte, "an O-word without its keyword", "write o[..] call")
}
