//! Reading stores.

use super::metadata::{ChunkCodec, ChunkElements, ZarrArray};
use super::{LARGEST_CHUNK, LARGEST_METADATA, ZarrStore};
use crate::numpy::npy::StoredArray;
use flate2::read::GzDecoder;
use ruzstd::decoding::StreamingDecoder;
use serde_json::{Value, json};
use std::fmt;
use std::io::{self, Read};

/// What is wrong with a store: the key within it, what was found and what was expected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ZarrError(String);

impl fmt::Display for ZarrError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for ZarrError {}

impl From<ZarrError> for String {
    fn from(error: ZarrError) -> String {
        error.0
    }
}

fn at(key: &str, what: impl fmt::Display) -> ZarrError {
    ZarrError(format!("{key}: {what}"))
}

/// A group of arrays.
pub struct ZarrGroup {
    store: Box<dyn ZarrStore>,
    attributes: Value,
}

impl ZarrGroup {
    /// Reads the group's metadata.
    ///
    /// # Errors
    /// What is wrong with `zarr.json`, or that there is none.
    pub fn open(store: impl ZarrStore + 'static) -> Result<ZarrGroup, ZarrError> {
        let Some(metadata) = json_of(&store, "zarr.json")? else {
            return Err(at(
                "zarr.json",
                "there is no such file, expected a group of Zarr version 3, which is written last: is the \
                 store whole? (zarr-python writes version 3 with zarr_format=3)",
            ));
        };
        for (key, expected) in [("zarr_format", json!(3)), ("node_type", json!("group"))] {
            if metadata.get(key) != Some(&expected) {
                return Err(at("zarr.json", format!("expected \"{key}\": {expected}")));
            }
        }
        let attributes = metadata.get("attributes").cloned().unwrap_or_default();
        Ok(ZarrGroup {
            store: Box::new(store),
            attributes,
        })
    }

    /// A whole number among the attributes of the group.
    pub fn attribute(&self, name: &str) -> Option<u64> {
        self.attributes.get(name).and_then(Value::as_u64)
    }

    /// Names of the arrays, sorted.
    ///
    /// # Errors
    /// Those of listing.
    pub fn names(&self) -> Result<Vec<String>, ZarrError> {
        let names = self.store.names();
        names.map_err(|e| at("zarr.json", format!("the arrays beside it: {e}")))
    }

    /// What the metadata of an array say; `None` if there is no such array.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn array(&self, name: &str) -> Result<Option<ZarrArray>, ZarrError> {
        let key = format!("{name}/zarr.json");
        let Some(metadata) = json_of(&*self.store, &key)? else {
            return Ok(None);
        };
        let array = ZarrArray::new(name, &metadata).map_err(|e| at(&key, e))?;
        Ok(Some(array))
    }

    /// One chunk: its rows, along the first axis, without what only fills the last chunk up.
    ///
    /// # Errors
    /// That the chunk is missing, damaged, or of another size.
    pub fn chunk(&self, array: &ZarrArray, chunk: u64) -> Result<StoredArray, ZarrError> {
        self.limited_chunk(array, chunk, LARGEST_CHUNK)
    }

    /// A chunk whose strings may take at most `most` bytes.
    fn limited_chunk(
        &self,
        array: &ZarrArray,
        chunk: u64,
        most: u64,
    ) -> Result<StoredArray, ZarrError> {
        let key = array.key(chunk);
        let start = chunk.saturating_mul(array.chunk_rows);
        let rows = array.chunk_rows.min(array.rows().saturating_sub(start));
        let full = array.chunk_rows * array.row_elements();
        let kept = rows * array.row_elements();
        let mut shape: Vec<usize> = array.shape.iter().map(|&s| s as usize).collect();
        if let Some(first) = shape.first_mut() {
            *first = rows as usize;
        }
        match &array.elements {
            ChunkElements::Fixed { descr, width } => {
                let expected = full * width;
                let mut data = self.content(&key, array.codec, expected)?;
                if data.len() as u64 != expected {
                    return Err(at(
                        &key,
                        format!(
                            "{} bytes, expected {expected} of {full} elements of {descr}: the file is cut off, \
                             or of another store",
                            data.len()
                        ),
                    ));
                }
                data.truncate((kept * width) as usize);
                StoredArray::from_data(descr, shape, data).map_err(|e| at(&key, e))
            }
            ChunkElements::Texts => {
                let data = self.content(&key, array.codec, most.min(LARGEST_CHUNK))?;
                let mut texts = texts(&data, full).ok_or_else(|| {
                    at(
                        &key,
                        format!("expected {full} strings in UTF-8, each after its length"),
                    )
                })?;
                texts.truncate(kept as usize);
                StoredArray::from_texts(shape, texts).map_err(|e| at(&key, e))
            }
        }
    }

    /// The bytes of a chunk, at most `most`.
    fn content(&self, key: &str, codec: ChunkCodec, most: u64) -> Result<Vec<u8>, ZarrError> {
        // What does not compress becomes a little larger.
        let stored = self.store.get(key, most + most / 8 + 4096);
        let stored = stored.map_err(|e| at(key, e))?.ok_or_else(|| {
            at(
                key,
                "this chunk is missing: is the store whole? (zarr-python leaves out chunks of zeros, unless \
                 zarr.config.set({'array.write_empty_chunks': True}))",
            )
        })?;
        let limited = |reader: &mut dyn Read| -> io::Result<Vec<u8>> {
            let mut content = Vec::new();
            reader.take(most + 1).read_to_end(&mut content)?;
            Ok(content)
        };
        let content = match codec {
            ChunkCodec::Plain => Ok(stored),
            ChunkCodec::Gzip => limited(&mut GzDecoder::new(&stored[..])),
            ChunkCodec::Zstd => match StreamingDecoder::new(&stored[..]) {
                Ok(mut decoder) => limited(&mut decoder),
                Err(e) => Err(io::Error::other(e.to_string())),
            },
        };
        let content = content.map_err(|e| {
            at(
                key,
                format!("{e}: the file is damaged or cut off, copy the store once more"),
            )
        })?;
        if content.len() as u64 > most {
            return Err(at(
                key,
                format!("it expands to more than {most} bytes, which its array has no room for"),
            ));
        }
        Ok(content)
    }

    /// A whole array, whose bytes are subtracted from `budget`; `None` if there is no such array.
    ///
    /// # Errors
    /// What is wrong with the array, or that it exceeds the budget.
    pub fn whole(&self, name: &str, budget: &mut u64) -> Result<Option<StoredArray>, ZarrError> {
        let Some(array) = self.array(name)? else {
            return Ok(None);
        };
        let exceeds = |budget: u64| {
            at(
                name,
                format!("the array takes more than the memory allows ({budget} bytes)"),
            )
        };
        let shape: Vec<usize> = array.shape.iter().map(|&s| s as usize).collect();
        match &array.elements {
            ChunkElements::Fixed { descr, width } => {
                let bytes = array.rows() * array.row_elements() * width;
                *budget = budget.checked_sub(bytes).ok_or_else(|| exceeds(*budget))?;
                let mut data = Vec::new();
                for chunk in 0..array.chunks() {
                    data.extend_from_slice(self.chunk(&array, chunk)?.data());
                }
                let whole = StoredArray::from_data(descr, shape, data);
                whole.map(Some).map_err(|e| at(name, e))
            }
            ChunkElements::Texts => {
                let mut texts = Vec::new();
                for chunk in 0..array.chunks() {
                    let few = self.limited_chunk(&array, chunk, *budget)?.texts();
                    let few = few.unwrap_or_default();
                    let bytes = few
                        .iter()
                        .map(|t| t.len() + size_of::<String>())
                        .sum::<usize>();
                    *budget = budget
                        .checked_sub(bytes as u64)
                        .ok_or_else(|| exceeds(*budget))?;
                    texts.extend(few);
                }
                let whole = StoredArray::from_texts(shape, texts);
                whole.map(Some).map_err(|e| at(name, e))
            }
        }
    }
}

fn json_of(store: &dyn ZarrStore, key: &str) -> Result<Option<Value>, ZarrError> {
    let content = store.get(key, LARGEST_METADATA).map_err(|e| at(key, e))?;
    let parsed = content.map(|content| serde_json::from_slice(&content));
    let parsed = parsed.transpose();
    parsed.map_err(|e| {
        at(
            key,
            format!("{e}: expected metadata of Zarr version 3 as JSON"),
        )
    })
}

/// Strings, each after its length, after their number.
fn texts(data: &[u8], expected: u64) -> Option<Vec<String>> {
    let (count, mut rest) = data.split_first_chunk::<4>()?;
    if u64::from(u32::from_le_bytes(*count)) != expected {
        return None;
    }
    let mut texts = Vec::new();
    for _ in 0..expected {
        let (length, after) = rest.split_first_chunk::<4>()?;
        let (text, after) = after.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        texts.push(std::str::from_utf8(text).ok()?.to_owned());
        rest = after;
    }
    rest.is_empty().then_some(texts)
}
