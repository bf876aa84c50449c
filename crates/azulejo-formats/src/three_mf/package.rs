//! The parts of a package: a ZIP archive by the Open Packaging Conventions.

use crate::{ReadError, ReadOptions};
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// Reads parts by name.
pub(super) struct Package<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// Bytes to which all parts together may still expand.
    budget: u64,
    most: u64,
    file: &'a str,
}

impl<'a> Package<'a> {
    /// Opens a package.
    ///
    /// # Errors
    /// Bytes that are no complete ZIP archive.
    pub fn new(
        bytes: &'a [u8],
        file: &'a str,
        options: &ReadOptions,
    ) -> Result<Package<'a>, ReadError> {
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(|e| {
            let found = format!("a damaged ZIP archive ({e})");
            ReadError::whole(file, found, "a complete 3MF package")
        })?;
        Ok(Package {
            zip,
            budget: options.most_unpacked,
            most: options.most_unpacked,
            file,
        })
    }

    /// The bytes of a part, if it is there; names do not depend on case, and begin with a slash or not.
    ///
    /// # Errors
    /// Damaged data, and more bytes than the options allow.
    pub fn part(&mut self, name: &str) -> Result<Option<Vec<u8>>, ReadError> {
        let wanted = name.trim_start_matches('/');
        let is_it = |known: &str| {
            let known = known.trim_start_matches('/');
            known.eq_ignore_ascii_case(wanted)
        };
        let names = self.zip.file_names().map(|n| n.unwrap_or_default());
        let Some(index) = names.into_iter().position(|known| is_it(&known)) else {
            return Ok(None);
        };
        let damaged = |e: &dyn std::fmt::Display| {
            let found = format!("a damaged part \"{wanted}\" ({e})");
            ReadError::whole(self.file, found, "a complete 3MF package")
        };
        let member = self.zip.by_index(index).map_err(|e| damaged(&e))?;
        let mut bytes = Vec::new();
        let read = member
            .take(self.budget.saturating_add(1))
            .read_to_end(&mut bytes);
        read.map_err(|e| damaged(&e))?;
        match self.budget.checked_sub(bytes.len() as u64) {
            Some(left) => self.budget = left,
            None => {
                let found = format!("parts that decompress to more than {} bytes", self.most);
                let expected = "a smaller package, or a higher limit (ReadOptions::most_unpacked)";
                return Err(ReadError::whole(self.file, found, expected));
            }
        }
        Ok(Some(bytes))
    }

    /// The first part with this ending.
    pub fn ending(&self, end: &str) -> Option<String> {
        let names = self.zip.file_names().map(|n| n.unwrap_or_default());
        let mut names = names
            .into_iter()
            .filter(|n| n.to_ascii_lowercase().ends_with(end));
        names.next().map(|n| n.to_string())
    }
}
