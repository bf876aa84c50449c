//! Zarr version 3: named arrays in chunks, each chunk a file of its own, below one group.
//!
//! Format: *Zarr core specification, version 3* (zarr-specs.readthedocs.io). Written: a group of arrays
//! without sub-groups; regular chunks along the first axis, numbers in little-endian C order, strings as
//! `string` in `vlen-utf8`, each chunk through gzip, whose checksum finds damage. Read: the same, either
//! byte order, `fixed_length_utf32`, and zstd, which zarr-python writes if nobody asks for something else.
//! Chunks must hold all of the other axes, and all of them must be there.
//!
//! Where chunks lie is up to a [`ZarrStore`] and a [`ZarrSink`]: this module knows keys such as
//! `data/c/3`, no files.
//!
//! Arrays are written through [`ArraySink`](crate::numpy::ArraySink), so that what is written to an
//! `.npz` is written to a store by the same lines, one chunk in memory at a time.

mod metadata;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use metadata::ZarrArray;
pub use read::{ZarrError, ZarrGroup};
pub use write::ZarrWriter;

use std::collections::BTreeMap;
use std::io;

/// Where a store is read from.
pub trait ZarrStore: Sync + Send {
    /// Names of the arrays that have metadata (`NAME/zarr.json`), sorted.
    ///
    /// # Errors
    /// Those of listing.
    fn names(&self) -> io::Result<Vec<String>>;

    /// The content of a key such as `data/c/3`; `None` if there is none.
    ///
    /// # Errors
    /// Those of reading, and [`TooLarge`](io::ErrorKind::FileTooLarge) for more than `most` bytes.
    fn get(&self, key: &str, most: u64) -> io::Result<Option<Vec<u8>>>;
}

/// Where a store is written to.
pub trait ZarrSink {
    /// Writes the content of a key such as `data/c/3`; each key is written once.
    ///
    /// # Errors
    /// Those of writing.
    fn put(&mut self, key: &str, content: &[u8]) -> io::Result<()>;
}

/// A store in memory.
impl ZarrStore for BTreeMap<String, Vec<u8>> {
    fn names(&self) -> io::Result<Vec<String>> {
        let names = self.keys().filter_map(|key| key.strip_suffix("/zarr.json"));
        Ok(names.map(str::to_owned).collect())
    }

    fn get(&self, key: &str, most: u64) -> io::Result<Option<Vec<u8>>> {
        match BTreeMap::get(self, key) {
            Some(content) if content.len() as u64 > most => Err(io::ErrorKind::FileTooLarge.into()),
            found => Ok(found.cloned()),
        }
    }
}

impl ZarrSink for BTreeMap<String, Vec<u8>> {
    fn put(&mut self, key: &str, content: &[u8]) -> io::Result<()> {
        self.insert(key.to_owned(), content.to_owned());
        Ok(())
    }
}

/// Bytes that a chunk may have at most, before compression: 256 MiB.
const LARGEST_CHUNK: u64 = 1 << 28;

/// Bytes that metadata may have at most.
const LARGEST_METADATA: u64 = 1 << 20;
