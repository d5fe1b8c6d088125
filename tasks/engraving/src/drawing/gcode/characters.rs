//! The characters of one line without blanks: outside comments RS-274 gives them no meaning, not even in numbers.

/// A cursor over a line.
pub struct Characters<'a> {
    line: &'a str,
    byte: usize,
}

impl<'a> Characters<'a> {
    /// At the start of a line.
    pub fn new(line: &'a str) -> Self {
        Self { line, byte: 0 }
    }

    /// The next character that is not blank, in lower case, without taking it.
    pub fn peek(&mut self) -> Option<char> {
        let rest = &self.line[self.byte..];
        let trimmed = rest.trim_start_matches(|c: char| c.is_whitespace() || c.is_control());
        self.byte += rest.len() - trimmed.len();
        trimmed.chars().next().map(|c| c.to_ascii_lowercase())
    }

    /// Takes the next character.
    pub fn take(&mut self) -> Option<char> {
        let c = self.peek()?;
        self.byte += c.len_utf8();
        Some(c)
    }

    /// Takes the character if it is the next.
    pub fn accept(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        if found {
            self.byte += wanted.len_utf8();
        }
        found
    }

    /// Where the cursor is \[bytes from the start of the line\].
    pub fn byte(&mut self) -> usize {
        self.peek();
        self.byte
    }

    /// Goes to a place that was read before \[bytes from the start of the line\].
    pub fn skip_to(&mut self, byte: usize) {
        self.byte = byte;
    }

    /// What follows, blanks inside it included.
    pub fn rest(&mut self) -> &'a str {
        self.peek();
        &self.line[self.byte..]
    }

    /// Takes everything up to the character and the character itself; `None` if it does not come.
    pub fn through(&mut self, end: char) -> Option<&'a str> {
        let rest = &self.line[self.byte..];
        let at = rest.find(end)?;
        self.byte += at + end.len_utf8();
        Some(&rest[..at])
    }

    /// Takes the letters that follow.
    pub fn name(&mut self) -> String {
        let mut name = String::new();
        while let Some(c) = self.peek().filter(char::is_ascii_alphabetic) {
            name.push(c);
            self.take();
        }
        name
    }
}
