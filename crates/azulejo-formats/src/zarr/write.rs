//! Writing stores.

use super::ZarrSink;
use crate::numpy::npy::{ElementKind, header_of};
use crate::numpy::{ArrayCompression, ArraySink, LEVEL};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};
use std::io::{self, BufWriter, Write};

/// Rows of a chunk of numbers: 8 MiB of 64-bit numbers.
const CHUNK: usize = 1 << 20;

/// Strings of a chunk.
const TEXTS: usize = 1 << 16;

/// Bytes gathered before they are divided into chunks.
const BUFFER: usize = 1 << 16;

/// Writes arrays one after the other, chunk by chunk; [`finish`](ZarrWriter::finish) writes the metadata of
/// the group, without which there is no store. The bytes depend on the content alone.
pub struct ZarrWriter<'a> {
    sink: &'a mut dyn ZarrSink,
    compression: ArrayCompression,
    chunk: usize,
}

impl<'a> ZarrWriter<'a> {
    /// A group without arrays. Chunks that are not compressed go through gzip, too, for its checksum.
    pub fn new(compression: ArrayCompression, sink: &'a mut dyn ZarrSink) -> ZarrWriter<'a> {
        ZarrWriter {
            sink,
            compression,
            chunk: CHUNK,
        }
    }

    /// The same with chunks of at most `rows` ≥ 1 elements of the first axis, instead of 1,048,576.
    pub fn with_chunks(self, rows: usize) -> ZarrWriter<'a> {
        ZarrWriter {
            chunk: rows.max(1),
            ..self
        }
    }

    /// Writes the group's metadata with its attributes, as the last of all files.
    ///
    /// # Errors
    /// Those of writing.
    pub fn finish(self, attributes: &[(&str, u64)]) -> io::Result<()> {
        let attributes = attributes
            .iter()
            .map(|&(name, value)| (name.to_owned(), json!(value)));
        let attributes = Value::Object(attributes.collect());
        let group = json!({ "zarr_format": 3, "node_type": "group", "attributes": attributes });
        self.sink.put("zarr.json", &pretty(&group)?)
    }
}

impl ArraySink for ZarrWriter<'_> {
    fn add_array(
        &mut self,
        name: &str,
        write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        let chunks = ChunkedArray {
            name,
            level: match self.compression {
                ArrayCompression::None => 0,
                ArrayCompression::Fast => LEVEL,
            },
            chunk: self.chunk,
            sink: &mut *self.sink,
            header: Vec::new(),
            layout: None,
            buffer: Vec::new(),
            written: 0,
        };
        let mut out = BufWriter::with_capacity(BUFFER, chunks);
        write(&mut out)?;
        let chunks = out.into_inner().map_err(io::IntoInnerError::into_error)?;
        chunks.finish()
    }
}

/// How an array is divided.
struct ChunkLayout {
    shape: Vec<usize>,
    kind: ElementKind,
    data_type: &'static str,
    /// Bytes of a row in the incoming file.
    row: usize,
    /// Rows of a chunk.
    rows: usize,
}

impl ChunkLayout {
    fn new(descr: &str, shape: Vec<usize>, chunk: usize) -> Option<ChunkLayout> {
        let kind = ElementKind::new(descr)?;
        let (data_type, most) = match descr {
            "<f4" => ("float32", chunk),
            "<f8" => ("float64", chunk),
            "<i4" => ("int32", chunk),
            "<i8" => ("int64", chunk),
            "<u4" => ("uint32", chunk),
            _ => match kind {
                ElementKind::Unicode(_) | ElementKind::Bytes(_) => ("string", chunk.min(TEXTS)),
                _ => return None,
            },
        };
        let elements: usize = shape.iter().skip(1).product();
        Some(ChunkLayout {
            row: elements * kind.width()?,
            rows: shape.first().map_or(1, |&first| first.clamp(1, most)),
            shape,
            kind,
            data_type,
        })
    }

    fn is_text(&self) -> bool {
        self.data_type == "string"
    }

    fn metadata(&self, level: u32) -> Value {
        let mut chunk_shape = self.shape.clone();
        if let Some(first) = chunk_shape.first_mut() {
            *first = self.rows;
        }
        let serializer = if self.is_text() {
            json!({ "name": "vlen-utf8" })
        } else {
            json!({ "name": "bytes", "configuration": { "endian": "little" } })
        };
        let fill = match self.kind {
            ElementKind::Float(_) => json!(0.0),
            _ if self.is_text() => json!(""),
            _ => json!(0),
        };
        json!({
            "zarr_format": 3,
            "node_type": "array",
            "shape": self.shape,
            "data_type": self.data_type,
            "chunk_grid": { "name": "regular", "configuration": { "chunk_shape": chunk_shape } },
            "chunk_key_encoding": { "name": "default", "configuration": { "separator": "/" } },
            "fill_value": fill,
            "codecs": [serializer, { "name": "gzip", "configuration": { "level": level } }],
            "attributes": {},
        })
    }

    /// The strings of a chunk, each after its length, after their number.
    fn texts(&self, data: &[u8], count: usize) -> io::Result<Vec<u8>> {
        let width = self.kind.width().unwrap_or(0).max(1);
        let mut out = (count as u32).to_le_bytes().to_vec();
        let mut elements = data.chunks_exact(width);
        for _ in 0..count {
            let element = elements.next().unwrap_or_default();
            let text = match self.kind {
                ElementKind::Unicode(_) => {
                    let letters = element.as_chunks::<4>().0.iter();
                    let letters = letters.map(|l| u32::from_le_bytes(*l));
                    letters.filter_map(char::from_u32).collect()
                }
                _ => String::from_utf8_lossy(element).into_owned(),
            };
            let text = text.trim_end_matches('\0');
            out.extend((text.len() as u32).to_le_bytes());
            out.extend(text.as_bytes());
        }
        Ok(out)
    }
}

/// Takes the bytes of an `.npy` file and puts chunks.
struct ChunkedArray<'a> {
    name: &'a str,
    level: u32,
    chunk: usize,
    sink: &'a mut dyn ZarrSink,
    /// The beginning of the file, until its header is whole.
    header: Vec<u8>,
    layout: Option<ChunkLayout>,
    /// Bytes of the next chunk.
    buffer: Vec<u8>,
    /// Chunks that were put.
    written: usize,
}

impl ChunkedArray<'_> {
    /// Puts the chunk in the buffer, filled up to its full size.
    fn flush_chunk(&mut self, layout: &ChunkLayout) -> io::Result<()> {
        let elements: usize = layout.rows * layout.shape.iter().skip(1).product::<usize>();
        let content;
        let content = if layout.is_text() {
            content = layout.texts(&self.buffer, elements)?;
            &content
        } else {
            self.buffer.resize(layout.rows * layout.row, 0);
            &self.buffer
        };
        let mut encoder = GzEncoder::new(Vec::new(), Compression::new(self.level));
        encoder.write_all(content)?;
        let mut key = format!("{}/c", self.name);
        for axis in 0..layout.shape.len() {
            key += &format!("/{}", if axis == 0 { self.written } else { 0 });
        }
        self.sink.put(&key, &encoder.finish()?)?;
        self.written += 1;
        self.buffer.clear();
        Ok(())
    }

    fn take(&mut self, layout: &ChunkLayout, mut bytes: &[u8]) -> io::Result<()> {
        let full = layout.rows * layout.row;
        while !bytes.is_empty() && full > 0 {
            let part = bytes.len().min(full - self.buffer.len());
            self.buffer.extend_from_slice(&bytes[..part]);
            bytes = &bytes[part..];
            if self.buffer.len() == full {
                self.flush_chunk(layout)?;
            }
        }
        Ok(())
    }

    /// Puts the last chunk and the metadata.
    fn finish(mut self) -> io::Result<()> {
        let layout = self.layout.take().ok_or_else(|| {
            let message = format!("{}: expected the content of an .npy file", self.name);
            io::Error::new(io::ErrorKind::InvalidInput, message)
        })?;
        if !self.buffer.is_empty() {
            self.flush_chunk(&layout)?;
        }
        let rows = layout.shape.first().map_or(1, |&first| first);
        if self.written != rows.div_ceil(layout.rows) {
            let message = format!("{}: fewer rows than its shape says", self.name);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        let key = format!("{}/zarr.json", self.name);
        self.sink.put(&key, &pretty(&layout.metadata(self.level))?)
    }
}

impl Write for ChunkedArray<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(layout) = self.layout.take() {
            self.take(&layout, bytes)?;
            self.layout = Some(layout);
            return Ok(bytes.len());
        }
        self.header.extend_from_slice(bytes);
        if let Some((descr, shape, start)) = header_of(&self.header) {
            let layout = ChunkLayout::new(&descr, shape, self.chunk).ok_or_else(|| {
                let message = format!("{}: elements are \"{descr}\"", self.name);
                io::Error::new(io::ErrorKind::InvalidInput, message)
            })?;
            let data = self.header.split_off(start);
            self.take(&layout, &data)?;
            self.layout = Some(layout);
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Metadata as text.
fn pretty(metadata: &Value) -> io::Result<Vec<u8>> {
    Ok(serde_json::to_vec_pretty(metadata)?)
}
