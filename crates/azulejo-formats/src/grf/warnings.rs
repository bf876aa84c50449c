//! Warnings, each listed once with a count.

use super::document::{GrfSources, SourcePosition};
use crate::{Position, Warning};

/// Maximum number of distinct messages.
const MOST: usize = 100;

/// The warnings so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Warnings(Vec<Warning>);

impl Warnings {
    /// Counts a repeated message; `false` if it is new.
    pub fn counts(&mut self, message: &str) -> bool {
        self.counts_many(message, 1)
    }

    fn counts_many(&mut self, message: &str, count: usize) -> bool {
        let known = self.0.iter_mut().find(|w| w.message == message);
        if let Some(warning) = known {
            warning.count += count;
            return true;
        }
        self.0.len() > MOST
    }

    /// Adds a warning.
    pub fn add(&mut self, sources: &GrfSources, place: SourcePosition, message: String) {
        self.add_many(sources, place, message, 1);
    }

    /// Adds a warning with a count, which may be 0.
    pub fn add_many(
        &mut self,
        sources: &GrfSources,
        place: SourcePosition,
        message: String,
        count: usize,
    ) {
        if count == 0 || self.counts_many(&message, count) {
            return;
        }
        let message = if self.0.len() == MOST {
            "further warnings, not listed".to_owned()
        } else {
            message
        };
        self.0.push(Warning {
            file: sources
                .get(place.file)
                .map_or_else(String::new, |s| s.shown.clone()),
            position: match place.line {
                0 => Position::Whole,
                line => Position::Line(line, place.column),
            },
            message,
            count,
        });
    }

    pub fn into_vec(self) -> Vec<Warning> {
        self.0
    }
}
