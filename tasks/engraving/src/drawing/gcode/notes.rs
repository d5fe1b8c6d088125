//! What a program is told about: each kind once, with its first line and how often it came.

use std::collections::BTreeMap;

/// The most kinds that are kept.
const MOST_KINDS: usize = 40;

/// Sentences by kind, in the order of their first lines.
#[derive(Debug, Default)]
pub struct Notes {
    kinds: BTreeMap<String, usize>,
    notes: Vec<Note>,
}

#[derive(Debug)]
struct Note {
    /// From 0.
    line: usize,
    what: String,
    count: usize,
}

impl Notes {
    /// A sentence about a line, from 0; later ones of its kind are only counted.
    pub fn add(&mut self, kind: &str, line: usize, what: impl FnOnce() -> String) {
        if let Some(note) = self.kinds.get(kind).and_then(|at| self.notes.get_mut(*at)) {
            note.count += 1;
        } else if self.notes.len() < MOST_KINDS {
            self.kinds.insert(kind.to_owned(), self.notes.len());
            self.notes.push(Note { line, what: what(), count: 1 });
        }
    }

    /// One sentence for each kind.
    pub fn sentences(self) -> Vec<String> {
        let sentence = |Note { line, what, count }: Note| match count {
            1 => format!("line {}: {what}", line + 1),
            _ => format!("line {}: {what} ({count} times, first here)", line + 1),
        };
        self.notes.into_iter().map(sentence).collect()
    }
}
