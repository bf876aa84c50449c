//! What an edit skips or changes beside what was asked for, each counted.

use std::collections::HashMap;

/// Notes in the order in which they first occurred.
#[derive(Debug, Default)]
pub struct Notes {
    list: Vec<(String, usize)>,
    known: HashMap<String, usize>,
}

impl Notes {
    /// Counts a note.
    pub fn add(&mut self, note: &str) {
        match self.known.get(note) {
            Some(&known) => self.list[known].1 += 1,
            None => {
                self.known.insert(note.to_owned(), self.list.len());
                self.list.push((note.to_owned(), 1));
            }
        }
    }

    /// All notes, with the number of their occurrences.
    pub fn finish(self) -> Vec<String> {
        let shown = |(note, count): (String, usize)| match count {
            1 => note,
            _ => format!("{note} ({count} times)"),
        };
        self.list.into_iter().map(shown).collect()
    }
}
