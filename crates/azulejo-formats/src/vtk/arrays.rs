//! Arrays of XML files: as words, as base64 in place, or after the XML, compressed or not.

use super::values::{VtkType, VtkValues};
use crate::reading::base64::ByteStream;
use crate::reading::text::shortened;
use crate::reading::words::Words;
use crate::{ReadError, ReadOptions};
use flate2::read::ZlibDecoder;
use roxmltree::{Document, Node};
use std::io::Read;

/// The bytes after the XML.
#[derive(Clone, Copy, Debug)]
pub(super) struct AppendedBytes<'a> {
    pub bytes: &'a [u8],
    /// Whether they are bytes, not base64.
    pub is_raw: bool,
}

/// What all arrays of a file have in common.
pub(super) struct XmlArrays<'a> {
    file: &'a str,
    text: &'a str,
    appended: Option<AppendedBytes<'a>>,
    is_big: bool,
    /// Bytes of the numbers before each array: 4 or 8.
    header_bytes: usize,
    is_compressed: bool,
    /// Why arrays of bytes cannot be read; text is never compressed, whatever the header says.
    refusal: Option<ReadError>,
    /// Most bytes of memory that compressed arrays together may still take.
    unpacked_left: u64,
    /// Most bytes after the XML that arrays may still take: several arrays may begin at one byte.
    shared_left: u64,
    /// Bytes that the last array took.
    taken: u64,
}

/// How often arrays may take the bytes after the XML, on average.
const MOST_SHARED: u64 = 4;

impl<'a> XmlArrays<'a> {
    pub fn new(
        document: &'a Document,
        file: &'a str,
        appended: Option<AppendedBytes<'a>>,
        options: &ReadOptions,
    ) -> Result<XmlArrays<'a>, ReadError> {
        let root = document.root_element();
        let mut arrays = XmlArrays {
            file,
            text: document.input_text(),
            appended,
            is_big: root.attribute("byte_order") == Some("BigEndian"),
            header_bytes: 4,
            is_compressed: false,
            refusal: None,
            unpacked_left: options.most_unpacked,
            shared_left: appended.map_or(0, |a| MOST_SHARED * a.bytes.len() as u64),
            taken: 0,
        };
        match root.attribute("header_type") {
            None | Some("UInt32") => {}
            Some("UInt64") => arrays.header_bytes = 8,
            Some(other) => {
                let found = format!("header_type \"{}\"", shortened(other));
                return Err(arrays.error(root, found, "UInt32 or UInt64"));
            }
        }
        match root.attribute("compressor") {
            None | Some("") => {}
            Some("vtkZLibDataCompressor") => arrays.is_compressed = true,
            Some(other) => {
                let found = format!("data compressed by {}", shortened(other));
                let expected = "vtkZLibDataCompressor or none: save the file again with ZLib (ParaView: \
                                Compressor Type; VTK: SetCompressorTypeToZLib; meshio: compression=\"zlib\")";
                arrays.refusal = Some(arrays.error(root, found, expected));
            }
        }
        Ok(arrays)
    }

    /// The values of an array.
    ///
    /// # Errors
    /// An unknown type or format, fewer bytes than the array states, and damaged compression.
    pub fn values(&mut self, array: Node) -> Result<VtkValues, ReadError> {
        let name = array.attribute("type").unwrap_or_default();
        let Some(kind) = VtkType::of_xml(name) else {
            let found = format!("the type \"{}\"", shortened(name));
            return Err(self.error(array, found, "a type of numbers, as Float64"));
        };
        let content = array.text().unwrap_or_default();
        let mut stream = match array.attribute("format").unwrap_or("ascii") {
            "ascii" => return self.words(array, kind, content),
            "binary" => ByteStream::base64(content.trim().as_bytes()),
            "appended" => self.appended(array)?,
            other => {
                let found = format!("the format \"{}\"", shortened(other));
                return Err(self.error(array, found, "ascii, binary or appended"));
            }
        };
        // Memory is for numbers of eight bytes, whatever they have in the file.
        let weight = match kind {
            VtkType::Bit => 64,
            _ => 8 / kind.bytes(1).unwrap_or(1).max(1) as u64,
        };
        let bytes = self.block(array, &mut stream, weight)?;
        if array.attribute("format") == Some("appended") {
            let left = self.shared_left.checked_sub(self.taken);
            self.shared_left = left.ok_or_else(|| {
                let found = format!("arrays that share their bytes more than {MOST_SHARED} times");
                self.error(array, found, "arrays with bytes of their own")
            })?;
        }
        if let Some(one) = kind.bytes(1).filter(|one| bytes.len() % one != 0) {
            let found = format!("{} bytes of {name}", bytes.len());
            return Err(self.error(array, found, format!("a multiple of {one}")));
        }
        Ok(VtkValues::decode(kind, &bytes, usize::MAX, self.is_big))
    }

    fn words(&self, array: Node, kind: VtkType, content: &str) -> Result<VtkValues, ReadError> {
        let mut words = Words::new(content.as_bytes(), self.file);
        VtkValues::parse(kind, &mut words).map_err(|at| {
            let word = words.from(at).word().unwrap_or_default();
            let found = crate::reading::text::quoted(word);
            // Where entities stand in the text the place is only near.
            let start = array
                .first_child()
                .map_or(array.range().start, |t| t.range().start);
            self.error_at(start + at, found, "a number")
        })
    }

    /// The bytes from the offset of an array on.
    fn appended(&self, array: Node) -> Result<ByteStream<'a>, ReadError> {
        let offset = array
            .attribute("offset")
            .and_then(|o| o.trim().parse().ok());
        let Some(offset) = offset else {
            return Err(self.error(array, "an appended array without offset", "an offset"));
        };
        let Some(appended) = self.appended else {
            return Err(self.error(array, "an appended array", "the element AppendedData"));
        };
        let Some(rest) = appended.bytes.get(offset..) else {
            let found = format!("the offset {offset}");
            let expected = format!("less than {}, as there are bytes", appended.bytes.len());
            return Err(self.error(array, found, expected));
        };
        Ok(if appended.is_raw {
            ByteStream::Plain(rest)
        } else {
            ByteStream::base64(rest)
        })
    }

    /// The bytes of an array, behind their number.
    fn block(
        &mut self,
        array: Node,
        stream: &mut ByteStream,
        weight: u64,
    ) -> Result<Vec<u8>, ReadError> {
        if let Some(refusal) = &self.refusal {
            return Err(refusal.clone());
        }
        let short = |arrays: &XmlArrays| {
            let found = "fewer bytes than an array states, or characters that are not base64";
            arrays.error(array, found, "a complete file")
        };
        if !self.is_compressed {
            let count = self.header(stream).ok_or_else(|| short(self))?;
            self.taken = count as u64;
            let bytes = stream.take(count).ok_or_else(|| short(self))?;
            return Ok(bytes.into_owned());
        }
        let sizes = self.block_sizes(stream).ok_or_else(|| short(self))?;
        self.taken = sizes
            .iter()
            .map(|&size| size as u64)
            .fold(0, u64::saturating_add);
        let mut bytes = Vec::new();
        for size in sizes {
            let packed = stream.take(size).ok_or_else(|| short(self))?;
            self.unpack(array, &packed, weight, &mut bytes)?;
        }
        Ok(bytes)
    }

    /// The sizes of compressed blocks: their number, two sizes of the content, and then one of each.
    fn block_sizes(&self, stream: &mut ByteStream) -> Option<Vec<usize>> {
        let count = self.header(stream)?;
        self.header(stream)?;
        self.header(stream)?;
        let mut sizes = Vec::new();
        for _ in 0..count {
            sizes.push(self.header(stream)?);
        }
        Some(sizes)
    }

    /// The next number before an array.
    fn header(&self, stream: &mut ByteStream) -> Option<usize> {
        let bytes = stream.take(self.header_bytes)?;
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        let number = if self.is_big {
            bytes.iter().fold(0, add)
        } else {
            bytes.iter().rev().fold(0, add)
        };
        usize::try_from(number).ok()
    }

    /// Decompresses a block, each of whose bytes takes `weight` bytes of memory.
    fn unpack(
        &mut self,
        array: Node,
        packed: &[u8],
        weight: u64,
        to: &mut Vec<u8>,
    ) -> Result<(), ReadError> {
        let before = to.len();
        ZlibDecoder::new(packed)
            .take((self.unpacked_left / weight).saturating_add(1))
            .read_to_end(to)
            .map_err(|e| {
                let found = format!("damaged compression ({e})");
                self.error(array, found, "a complete file")
            })?;
        let taken = weight * (to.len() - before) as u64;
        let left = self.unpacked_left.checked_sub(taken);
        self.unpacked_left = left.ok_or_else(|| {
            let expected = "a smaller file, or a higher limit (ReadOptions::most_unpacked)";
            self.error(
                array,
                "arrays that decompress to more bytes than allowed",
                expected,
            )
        })?;
        Ok(())
    }

    /// An error at an element.
    #[cold]
    pub fn error(
        &self,
        node: Node,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        self.error_at(node.range().start, found, expected)
    }

    /// An error at a byte of the XML.
    fn error_at(
        &self,
        at: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        let (text, words) = (
            self.text.as_bytes(),
            Words::new(self.text.as_bytes(), self.file),
        );
        words.error_with(at.min(text.len()), found, expected)
    }
}
