//! Warnings, each said once with a count.

use crate::{Position, Warning};
use std::collections::HashMap;

/// Different messages kept; what comes after them is only counted, so that a hostile file
/// cannot fill memory with complaints about itself.
const KEPT: usize = 100;

/// Collects warnings in the order in which they first appear.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    list: Vec<Warning>,
    index: HashMap<(String, String), usize>,
    beyond: usize,
}

impl Warnings {
    /// Counts a warning; the first of its file and message gives the position.
    pub fn add(&mut self, file: &str, line: u32, column: u32, message: impl Into<String>) {
        self.add_at(file, Position::Line(line, column), message.into());
    }

    /// Counts a warning about a whole file.
    pub fn add_whole(&mut self, file: &str, message: impl Into<String>) {
        self.add_at(file, Position::Whole, message.into());
    }

    fn add_at(&mut self, file: &str, position: Position, message: String) {
        let key = (file.to_owned(), message);
        if let Some(&known) = self.index.get(&key) {
            self.list[known].count += 1;
        } else if self.list.len() == KEPT {
            self.beyond += 1;
        } else {
            self.list.push(Warning {
                file: key.0.clone(),
                position,
                message: key.1.clone(),
                count: 1,
            });
            self.index.insert(key, self.list.len() - 1);
        }
    }

    /// All of them; the last entry counts those that were too many to keep.
    pub fn finish(mut self, file: &str) -> Vec<Warning> {
        if self.beyond > 0 {
            self.list.push(Warning {
                file: file.to_owned(),
                position: Position::Whole,
                message: format!("more warnings, beyond the first {KEPT} kinds, not shown"),
                count: self.beyond,
            });
        }
        self.list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counted_and_bounded() {
        let mut warnings = Warnings::default();
        for i in 0..1000 {
            warnings.add("a", i + 1, 1, format!("kind {}", i % 500));
        }
        let list = warnings.finish("a");
        assert_eq!(list.len(), KEPT + 1);
        assert_eq!((list[7].count, list[7].position), (2, Position::Line(8, 1)));
        assert_eq!(list[KEPT].count, 800);
    }
}
