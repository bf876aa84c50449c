//! Warnings with their positions.

use super::document::FltDocument;
use crate::Position;
use crate::reading::warnings::Warnings;

/// Adds warnings about one record.
pub(super) struct RecordWarnings<'a> {
    pub warnings: &'a mut Warnings,
    pub file: &'a str,
    pub at: u32,
}

impl<'a> RecordWarnings<'a> {
    /// A collector for warnings about a node.
    pub fn new(
        warnings: &'a mut Warnings,
        document: &'a FltDocument,
        node: u32,
    ) -> RecordWarnings<'a> {
        RecordWarnings {
            warnings,
            file: &document.file,
            at: document.nodes[node as usize].at,
        }
    }

    #[cold]
    pub fn add(&mut self, message: impl Into<String>) {
        self.add_many(message, 1);
    }

    /// Adds a warning with a count, which may be 0.
    #[cold]
    pub fn add_many(&mut self, message: impl Into<String>, count: usize) {
        let at = u64::from(self.at);
        self.warnings
            .add_many(self.file, message.into(), count, || Position::Byte(at));
    }
}
