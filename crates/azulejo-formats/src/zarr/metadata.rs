//! What `zarr.json` says of an array.

use super::LARGEST_CHUNK;
use serde_json::{Value, json};

/// How the chunks of an array are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChunkCodec {
    Plain,
    Gzip,
    Zstd,
}

/// What the elements of an array are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ChunkElements {
    /// Numbers, or strings of one width: their type as NumPy calls it, and their bytes.
    Fixed { descr: String, width: u64 },
    /// Strings, each after its length.
    Texts,
}

/// An array of a store, as its metadata describes it: checked, so that nothing in it is too large.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ZarrArray {
    pub(super) name: String,
    pub(super) shape: Vec<u64>,
    /// Rows, elements of the first axis, of one chunk; 1 of an array without axes.
    pub(super) chunk_rows: u64,
    pub(super) elements: ChunkElements,
    pub(super) codec: ChunkCodec,
    /// Between the parts of a key, and whether keys begin with `c`.
    separator: char,
    has_prefix: bool,
}

impl ZarrArray {
    /// Length along each axis.
    pub fn shape(&self) -> &[u64] {
        &self.shape
    }

    /// Elements of the first axis; 1 of an array without axes.
    pub fn rows(&self) -> u64 {
        self.shape.first().copied().unwrap_or(1)
    }

    /// Elements of the first axis in one chunk; the last chunk may have fewer.
    pub fn chunk_rows(&self) -> u64 {
        self.chunk_rows
    }

    /// Number of chunks.
    pub fn chunks(&self) -> u64 {
        self.rows().div_ceil(self.chunk_rows)
    }

    /// Elements of one row: the product of the other axes.
    pub(super) fn row_elements(&self) -> u64 {
        // `new` has checked the product of all axes.
        self.shape.iter().skip(1).product()
    }

    /// The key of a chunk.
    pub(super) fn key(&self, chunk: u64) -> String {
        let mut parts: Vec<String> = Vec::new();
        if self.has_prefix {
            parts.push("c".to_owned());
        }
        let axes = self.shape.len();
        parts.extend((0..axes).map(|axis| if axis == 0 { chunk } else { 0 }.to_string()));
        if parts.is_empty() {
            parts.push("0".to_owned());
        }
        let key = parts.join(&self.separator.to_string());
        format!("{}/{key}", self.name)
    }

    /// The array that metadata describe.
    pub(super) fn new(name: &str, metadata: &Value) -> Result<ZarrArray, String> {
        expect(metadata, "zarr_format", &json!(3))?;
        expect(metadata, "node_type", &json!("array"))?;
        let shape = lengths(metadata, "shape", "/shape")?;
        let (grid, _) = named(metadata, "chunk_grid")?;
        if grid != "regular" {
            return Err(format!("chunk_grid: \"{grid}\", expected \"regular\""));
        }
        let chunk = lengths(
            metadata,
            "chunk_shape",
            "/chunk_grid/configuration/chunk_shape",
        )?;
        let covers = chunk.len() == shape.len()
            && chunk.iter().all(|&c| c > 0)
            && chunk.iter().zip(&shape).skip(1).all(|(c, s)| c == s);
        if !covers {
            return Err(format!(
                "chunks of {chunk:?} for an array of {shape:?}, expected chunks along the first axis that \
                 have all of the others (chunks=(1048576, 3) in zarr-python)"
            ));
        }
        let (elements, codec) = codecs(metadata)?;
        let width = match elements {
            ChunkElements::Fixed { width, .. } => width,
            // Each string takes four bytes at least.
            ChunkElements::Texts => 4,
        };
        let product = |lengths: &[u64]| {
            let count = lengths.iter().try_fold(1u64, |n, &s| n.checked_mul(s));
            count.and_then(|n| n.checked_mul(width))
        };
        if product(&shape).is_none_or(|bytes| bytes > 1 << 60) {
            return Err(format!("shape: {shape:?} is more than any memory holds"));
        }
        if product(&chunk).is_none_or(|bytes| bytes > LARGEST_CHUNK) {
            return Err(format!(
                "chunks of {chunk:?} elements are too large, expected at most {LARGEST_CHUNK} bytes each"
            ));
        }
        let (separator, has_prefix) = keys(metadata)?;
        Ok(ZarrArray {
            name: name.to_owned(),
            chunk_rows: chunk.first().copied().unwrap_or(1),
            shape,
            elements,
            codec,
            separator,
            has_prefix,
        })
    }
}

fn expect(metadata: &Value, key: &str, expected: &Value) -> Result<(), String> {
    match metadata.get(key) {
        Some(found) if found == expected => Ok(()),
        Some(found) => Err(format!("{key}: {}, expected {expected}", excerpt(found))),
        None => Err(format!("there is no \"{key}\", expected {expected}")),
    }
}

fn excerpt(value: &Value) -> String {
    let text = value.to_string();
    text.chars().take(60).collect()
}

fn lengths(metadata: &Value, what: &str, pointer: &str) -> Result<Vec<u64>, String> {
    let found = metadata.pointer(pointer);
    let lengths = found.and_then(Value::as_array);
    let lengths = lengths.and_then(|l| l.iter().map(Value::as_u64).collect::<Option<Vec<_>>>());
    lengths.filter(|l| l.len() <= 4).ok_or_else(|| {
        let found = found.map_or("nothing".to_owned(), excerpt);
        format!("{what}: {found}, expected a list of lengths")
    })
}

/// The name and configuration of an extension, which may be the name alone.
fn extension(value: &Value) -> Option<(&str, Option<&Value>)> {
    match value {
        Value::String(name) => Some((name, None)),
        other => Some((
            other.get("name").and_then(Value::as_str)?,
            other.get("configuration"),
        )),
    }
}

fn named<'a>(metadata: &'a Value, key: &str) -> Result<(&'a str, Option<&'a Value>), String> {
    let found = metadata.get(key).and_then(extension);
    found.ok_or_else(|| format!("there is no \"{key}\" with a name"))
}

/// What elements are, and how chunks are compressed.
fn codecs(metadata: &Value) -> Result<(ChunkElements, ChunkCodec), String> {
    let listed = metadata.get("codecs").and_then(Value::as_array);
    let listed = listed.map(|codecs| codecs.iter().map(extension).collect::<Option<Vec<_>>>());
    let listed = listed.flatten().unwrap_or_default();
    let names: Vec<&str> = listed.iter().map(|(name, _)| *name).collect();
    let refused = || {
        format!(
            "codecs: {}, expected bytes or vlen-utf8, and then nothing, gzip or zstd \
             (compressors=zarr.codecs.GzipCodec() in zarr-python)",
            names.join(", ")
        )
    };
    let (serializer, compressors) = names.split_first().ok_or_else(refused)?;
    let codec = match compressors {
        [] => ChunkCodec::Plain,
        ["gzip"] => ChunkCodec::Gzip,
        ["zstd"] => ChunkCodec::Zstd,
        _ => return Err(refused()),
    };
    let (kind, configuration) = named(metadata, "data_type")?;
    let elements = match (kind, *serializer) {
        ("string", "vlen-utf8") => ChunkElements::Texts,
        (_, "bytes") => {
            let endian = listed[0].1.and_then(|c| c.get("endian"));
            let order = match endian.and_then(Value::as_str) {
                Some("big") => '>',
                _ => '<',
            };
            let (letter, width) = fixed(kind, configuration).ok_or_else(|| {
                format!("data_type: \"{kind}\", expected integers, real numbers or strings")
            })?;
            let size = if letter == 'U' { width / 4 } else { width };
            ChunkElements::Fixed {
                descr: format!("{order}{letter}{size}"),
                width,
            }
        }
        _ => return Err(refused()),
    };
    Ok((elements, codec))
}

/// NumPy's letter for a type, and the bytes of an element.
fn fixed(kind: &str, configuration: Option<&Value>) -> Option<(char, u64)> {
    Some(match kind {
        "bool" => ('b', 1),
        "int8" => ('i', 1),
        "int16" => ('i', 2),
        "int32" => ('i', 4),
        "int64" => ('i', 8),
        "uint8" => ('u', 1),
        "uint16" => ('u', 2),
        "uint32" => ('u', 4),
        "uint64" => ('u', 8),
        "float16" => ('f', 2),
        "float32" => ('f', 4),
        "float64" => ('f', 8),
        "fixed_length_utf32" => {
            let bytes = configuration?.get("length_bytes")?.as_u64()?;
            (
                'U',
                (bytes % 4 == 0 && bytes <= LARGEST_CHUNK).then_some(bytes)?,
            )
        }
        _ => return None,
    })
}

/// The separator of keys, and whether they begin with `c`.
fn keys(metadata: &Value) -> Result<(char, bool), String> {
    let (name, configuration) = named(metadata, "chunk_key_encoding")?;
    let separator = configuration.and_then(|c| c.get("separator"));
    let usual = if name == "v2" { "." } else { "/" };
    let separator = separator.map_or(Some(usual), Value::as_str);
    match (name, separator) {
        ("default" | "v2", Some("/")) => Ok(('/', name == "default")),
        ("default" | "v2", Some(".")) => Ok(('.', name == "default")),
        _ => Err(format!(
            "chunk_key_encoding: \"{name}\", expected \"default\" with / or . between numbers"
        )),
    }
}
