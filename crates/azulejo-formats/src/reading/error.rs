//! Results of readers: scenes with warnings, and errors.

use azulejo_scene::Scene;
use std::fmt;

/// A scene and the warnings of its reader.
#[derive(Clone, Debug, Default)]
pub struct Loaded {
    /// Valid in the sense of [`Scene::validate`].
    pub scene: Scene,
    /// What was skipped, repaired or guessed.
    pub warnings: Vec<Warning>,
}

/// Something in a file that was skipped, repaired or guessed, reported once with a count.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// File name as given to the reader.
    pub file: String,
    /// Position of the first occurrence.
    pub position: Position,
    /// What was found and what was done about it.
    pub message: String,
    /// Number of occurrences.
    pub count: usize,
}

/// A position in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Position {
    /// The file as a whole.
    #[default]
    Whole,
    /// Text: line and column, both from 1; the column counts characters.
    Line(u32, u32),
    /// Binary: offset of the byte, from 0.
    Byte(u64),
}

/// Why a file could not be read.
///
/// `Display` shows all of it: file, position, what was found, what was expected, the
/// source line with a mark under the position, and how the file was reached if it was included.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadError {
    /// File name as given to the reader.
    pub file: String,
    /// Position in the file.
    pub position: Position,
    /// What was found there.
    pub found: Box<str>,
    /// What was expected there, or what the user can do.
    pub expected: Box<str>,
    /// The source line, for text files.
    pub source_line: Option<String>,
    /// The files that included this one, outermost first, each with the line of its include.
    pub included_from: Vec<(String, u32)>,
}

impl ReadError {
    /// An error about a whole file.
    pub fn whole(
        file: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        ReadError {
            file: file.into(),
            position: Position::Whole,
            found: found.into().into(),
            expected: expected.into().into(),
            source_line: None,
            included_from: Vec::new(),
        }
    }

    /// An error at a line and column of a text file; `text` is the whole file, from which the
    /// source line is taken.
    pub fn at_line(
        file: impl Into<String>,
        text: &str,
        line: u32,
        column: u32,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        let source_line = text
            .lines()
            .nth(line.saturating_sub(1) as usize)
            .map(str::to_owned);
        ReadError {
            position: Position::Line(line, column),
            source_line,
            ..ReadError::whole(file, found, expected)
        }
    }

    /// An error at a byte of a binary file.
    pub fn at_byte(
        file: impl Into<String>,
        offset: u64,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        ReadError {
            position: Position::Byte(offset),
            ..ReadError::whole(file, found, expected)
        }
    }
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Position::Whole => Ok(()),
            Position::Line(line, column) => write!(f, ":{line}:{column}"),
            Position::Byte(offset) => write!(f, ": byte {offset} (0x{offset:x})"),
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}: {}", self.file, self.position, self.message)?;
        if self.count > 1 {
            write!(f, " ({} times)", self.count)
        } else {
            Ok(())
        }
    }
}

/// Longest piece of a source line that an error shows; longer lines are cut around the mark.
const SHOWN: usize = 100;

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}{}: found {}, expected {}",
            self.file, self.position, self.found, self.expected
        )?;
        if let (Some(text), Position::Line(line, column)) = (&self.source_line, self.position) {
            let column = column.saturating_sub(1) as usize;
            let start = column.saturating_sub(SHOWN / 2);
            let shown: String = text
                .chars()
                .skip(start)
                .take(SHOWN)
                .map(|c| if c.is_control() { ' ' } else { c })
                .collect();
            let number = line.to_string();
            let margin = " ".repeat(number.len());
            write!(
                f,
                "\n {margin} |\n {number} | {shown}\n {margin} | {}^",
                " ".repeat(column - start)
            )?;
        }
        for (file, line) in self.included_from.iter().rev() {
            write!(f, "\n  included from {file}:{line}")?;
        }
        Ok(())
    }
}

impl std::error::Error for ReadError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_shows_its_line() {
        let text = "begin mesh\n  begin vertices\n    (1, x, 2)\n";
        let mut e = ReadError::at_line("cube.grf", text, 3, 9, "the word \"x\"", "a number");
        e.included_from.push(("room.grf".into(), 12));
        let drawn = e.to_string();
        assert_eq!(
            drawn,
            "cube.grf:3:9: found the word \"x\", expected a number\n   |\n 3 |     (1, x, 2)\n   |         ^\n  included from room.grf:12"
        );
    }
}
