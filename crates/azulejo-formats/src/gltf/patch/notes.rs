//! What an edit skips or changes beside what was asked for, each counted.

/// Notes in the order in which they first occurred.
#[derive(Debug, Default)]
pub struct Notes(Vec<(String, usize)>);

impl Notes {
    /// Counts a note.
    pub fn add(&mut self, note: &str) {
        match self.0.iter_mut().find(|(known, _)| known == note) {
            Some((_, count)) => *count += 1,
            None => self.0.push((note.to_owned(), 1)),
        }
    }

    /// All notes, with the number of their occurrences.
    pub fn finish(self) -> Vec<String> {
        let shown = |(note, count): (String, usize)| match count {
            1 => note,
            _ => format!("{note} ({count} times)"),
        };
        self.0.into_iter().map(shown).collect()
    }
}
