//! Files that a command writes together.

use crate::failure::Failure;
use crate::report::bytes;
use crate::session::Session;
use azulejo::output::{Draft, Output, commit};
use std::io::Write;
use std::path::Path;

/// Files that are put in place together.
#[derive(Default)]
pub struct DraftList {
    drafts: Vec<Draft>,
    written: Vec<String>,
}

impl DraftList {
    /// Adds a file of this name.
    ///
    /// # Errors
    /// It cannot be written there.
    pub fn add(&mut self, path: &Path, file: &[u8]) -> Result<(), Failure> {
        self.add_to(&Output::check(path)?, file)
    }

    /// Adds a file.
    ///
    /// # Errors
    /// It cannot be written there.
    pub fn add_to(&mut self, output: &Output, file: &[u8]) -> Result<(), Failure> {
        let mut draft = output.draft()?;
        draft.write_all(file).map_err(|e| draft.error(e))?;
        let size = bytes(file.len() as u64);
        self.written
            .push(format!("{} ({size})", output.path().display()));
        self.drafts.push(draft);
        Ok(())
    }

    /// Puts all in place, and returns their names with their sizes.
    ///
    /// # Errors
    /// One cannot be: then none is.
    pub fn commit(self, session: &Session) -> Result<Vec<String>, Failure> {
        commit(self.drafts, session.progress())?;
        Ok(self.written)
    }
}
