//! Words of the editor of reflection models.

use super::Entry;

pub const TABLE: &[Entry] = &[];
