//! Objects of an input file, whether IDF or epJSON.

use super::classes::ClassLayout;
use crate::ReadError;
use crate::reading::cursor::{TextCursor, position};
use crate::reading::number;
use crate::reading::text::shortened;
use crate::reading::warnings::Warnings;
use glam::DVec3;
use std::borrow::Cow;

/// The text of a file, for messages with positions.
#[derive(Clone, Copy)]
pub(super) struct InputText<'a> {
    pub text: &'a str,
    /// The name of the file.
    pub name: &'a str,
}

impl InputText<'_> {
    /// An error at a byte.
    #[cold]
    pub fn error(
        &self,
        at: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        let cursor = TextCursor::<[u8]>::new(self.text.as_bytes());
        cursor.error(self.name, at, found, expected)
    }

    /// Counts a warning about something at a byte.
    pub fn warn(&self, warnings: &mut Warnings, at: usize, message: &str) {
        warnings.add(self.name, message.to_owned(), || {
            position(self.text.as_bytes(), at)
        });
    }
}

/// The text of a field and its place.
#[derive(Clone, Debug, Default)]
pub(super) struct InputValue<'a> {
    pub text: Cow<'a, str>,
    /// The offset of its first byte.
    pub at: usize,
}

impl InputValue<'_> {
    /// The value as a finite number.
    ///
    /// # Errors
    /// Other text.
    pub fn number(&self, file: InputText<'_>, what: &str) -> Result<f64, ReadError> {
        let bytes = self.text.as_bytes();
        let parsed = number::parse(bytes).filter(|n| n.length == bytes.len());
        let value = parsed.map(|n| n.value).filter(|x| x.is_finite());
        value.ok_or_else(|| {
            let found = match &*self.text {
                "" => "nothing".to_owned(),
                text => format!("\"{}\"", shortened(text)),
            };
            file.error(self.at, found, what)
        })
    }
}

/// An object of one of the known classes.
#[derive(Debug)]
pub(super) struct InputObject<'a> {
    pub layout: ClassLayout,
    /// The offset of its first byte.
    pub at: usize,
    pub name: Cow<'a, str>,
    /// Fields that are not blank.
    pub fields: Vec<(&'static str, InputValue<'a>)>,
    pub vertices: Vec<DVec3>,
}

impl InputObject<'_> {
    fn field(&self, name: &str) -> Option<&InputValue<'_>> {
        let mut fields = self.fields.iter();
        fields
            .find(|(field, _)| *field == name)
            .map(|(_, value)| value)
    }

    /// The text of a field; empty if it is missing.
    pub fn text(&self, field: &str) -> &str {
        self.field(field).map_or("", |value| &value.text)
    }

    /// The text of a field as a key: names differ in more than case.
    pub fn key(&self, field: &str) -> String {
        key(self.text(field))
    }

    /// A number that may be missing.
    ///
    /// # Errors
    /// Other text.
    pub fn number_or(
        &self,
        field: &str,
        missing: f64,
        file: InputText<'_>,
    ) -> Result<f64, ReadError> {
        match self.field(field) {
            Some(value) if !is_automatic(&value.text) => value.number(file, "a number"),
            _ => Ok(missing),
        }
    }

    /// A number that is needed.
    ///
    /// # Errors
    /// Other text, or none.
    pub fn number(&self, field: &str, file: InputText<'_>) -> Result<f64, ReadError> {
        match self.field(field) {
            Some(value) => value.number(file, "a number"),
            None => {
                let found = format!("{} without {}", self.layout.name, field.replace('_', " "));
                Err(file.error(self.at, found, "a number"))
            }
        }
    }
}

/// A name as a key.
pub(super) fn key(name: &str) -> String {
    name.trim().to_lowercase()
}

/// Whether a field leaves its number to EnergyPlus.
pub(super) fn is_automatic(text: &str) -> bool {
    ["autocalculate", "autosize"]
        .iter()
        .any(|word| word.eq_ignore_ascii_case(text))
}
