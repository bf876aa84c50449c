//! Warnings, each reported once with a count.

use crate::{Position, Warning};

/// Distinct messages kept; later ones are only counted, so that a hostile file
/// cannot fill memory with warnings about itself.
const KEPT: usize = 100;

/// Collects warnings in the order in which they first appear.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    list: Vec<Warning>,
    dropped: usize,
}

impl Warnings {
    /// Counts a warning. `position` is called only for the first of its file and message,
    /// because finding the column in a long line takes time.
    pub fn add(&mut self, file: &str, message: String, position: impl FnOnce() -> Position) {
        self.add_many(file, message, 1, position);
    }

    /// Counts a warning about a whole file.
    pub fn add_whole(&mut self, file: &str, message: impl Into<String>) {
        self.add_many(file, message.into(), 1, || Position::Whole);
    }

    /// Counts a warning `count` times, which may be 0.
    pub fn add_many(
        &mut self,
        file: &str,
        message: String,
        count: usize,
        position: impl FnOnce() -> Position,
    ) {
        let mut known = self.list.iter_mut();
        if let Some(warning) = known.find(|w| w.message == message && w.file == file) {
            warning.count += count;
        } else if self.list.len() == KEPT {
            self.dropped += count;
        } else if count > 0 {
            self.list.push(Warning {
                file: file.to_owned(),
                position: position(),
                message,
                count,
            });
        }
    }

    /// Adds the warnings of another file that this one refers to.
    pub fn extend(&mut self, others: Vec<Warning>) {
        for other in others {
            let position = other.position;
            self.add_many(&other.file, other.message, other.count, || position);
        }
    }

    /// All warnings; the last entry counts those that were not kept.
    pub fn finish(mut self, file: &str) -> Vec<Warning> {
        if self.dropped > 0 {
            self.list.push(Warning {
                file: file.to_owned(),
                position: Position::Whole,
                message: format!(
                    "further warnings after the first {KEPT} distinct ones: not shown"
                ),
                count: self.dropped,
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
            warnings.add("a", format!("kind {}", i % 500), || {
                Position::Line(i + 1, 1)
            });
        }
        let list = warnings.finish("a");
        assert_eq!(list.len(), KEPT + 1);
        assert_eq!((list[7].count, list[7].position), (2, Position::Line(8, 1)));
        assert_eq!(list[KEPT].count, 800);
    }
}
