//! Packages of the Open Packaging Conventions: ZIP archives of a few compressed parts.

use flate2::write::DeflateEncoder;
use flate2::{Compression, Crc};
use std::io::{self, Write};

/// "Version needed": 2.0, the first with DEFLATE.
const VERSION: u16 = 20;
/// The method DEFLATE.
const DEFLATE: u16 = 8;
/// 1 January 1980: a package depends on its content alone.
const DATE: u16 = 0x21;

/// Writes parts one after the other (*PKWARE APPNOTE* 6.3, sections 4.3 and 4.4); each is compressed in
/// memory, because its size precedes it.
pub(super) struct OpcPackage<'a> {
    out: &'a mut dyn Write,
    position: u64,
    directory: Vec<u8>,
    parts: u16,
}

/// Compresses what is written to it, and measures what it was.
struct MeasuredDeflate {
    packed: DeflateEncoder<Vec<u8>>,
    crc: Crc,
}

impl Write for MeasuredDeflate {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.packed.write(bytes)?;
        self.crc.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.packed.flush()
    }
}

impl<'a> OpcPackage<'a> {
    /// A package without parts.
    pub fn new(out: &'a mut dyn Write) -> OpcPackage<'a> {
        OpcPackage {
            out,
            position: 0,
            directory: Vec::new(),
            parts: 0,
        }
    }

    /// Adds a part with the content that `write` writes.
    ///
    /// # Errors
    /// Those of the output; parts and packages of 4 GiB and more.
    pub fn add(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut measured = MeasuredDeflate {
            packed: DeflateEncoder::new(Vec::new(), Compression::default()),
            crc: Crc::new(),
        };
        let mut length = LengthCounter {
            out: &mut measured,
            length: 0,
        };
        write(&mut length)?;
        let length = short(length.length)?;
        let (data, crc) = (measured.packed.finish()?, measured.crc.sum());
        let mut common = [VERSION, 0, DEFLATE, 0, DATE]
            .map(u16::to_le_bytes)
            .concat();
        let sizes = [crc, short(data.len() as u64)?, length];
        common.extend(sizes.map(u32::to_le_bytes).concat());
        common.extend([name.len() as u16, 0].map(u16::to_le_bytes).concat());
        let at = short(self.position)?;
        self.put(&[b"PK\x03\x04", &*common, name.as_bytes(), &data].concat())?;
        self.directory.extend(b"PK\x01\x02");
        self.directory.extend(VERSION.to_le_bytes());
        self.directory.extend(common);
        // Comment, disk, internal and external attributes.
        self.directory.extend([0; 10]);
        self.directory.extend(at.to_le_bytes());
        self.directory.extend(name.as_bytes());
        self.parts += 1;
        Ok(())
    }

    /// Writes the directory.
    ///
    /// # Errors
    /// Those of the output.
    pub fn finish(mut self) -> io::Result<()> {
        let (start, directory) = (short(self.position)?, std::mem::take(&mut self.directory));
        self.put(&directory)?;
        let mut end = b"PK\x05\x06\0\0\0\0".to_vec();
        end.extend([self.parts; 2].map(u16::to_le_bytes).concat());
        end.extend(
            [directory.len() as u32, start]
                .map(u32::to_le_bytes)
                .concat(),
        );
        end.extend([0, 0]);
        self.put(&end)?;
        self.out.flush()
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.position += bytes.len() as u64;
        self.out.write_all(bytes)
    }
}

/// Counts the bytes that pass through it.
struct LengthCounter<'a> {
    out: &'a mut dyn Write,
    length: u64,
}

impl Write for LengthCounter<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.length += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// A size in 32 bits.
fn short(size: u64) -> io::Result<u32> {
    let message = "a package of 4 GiB or more, which ZIP without extensions cannot hold";
    let invalid = |_| io::Error::new(io::ErrorKind::InvalidData, message);
    u32::try_from(size).map_err(invalid)
}
