//! NumPy's `.npz`: `.npy` files in a ZIP archive.
//!
//! Members are streamed in one pass, so that nothing is held in memory, and their sizes have 64 bits,
//! because matrices of more than 4 GiB are common. The bytes depend on the content alone: dates
//! are 1 January 1980.

use super::npy::StoredArray;
use std::io::{self, BufWriter, Read, Seek, Write};
use zip::result::ZipError;
use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// Bytes gathered before they are compressed.
const BUFFER: usize = 1 << 16;

/// Level of compression, 1 to 9: the fastest, because higher ones gain little on numbers.
const LEVEL: i64 = 1;

/// Writes archive members one after the other; [`finish`](NpzWriter::finish) writes the directory.
///
/// Writer and [reader](NpzReader) have no type of file as a parameter, so that the code of ZIP is compiled
/// here, and not once more in each crate that has archives.
pub struct NpzWriter<'a> {
    zip: ZipWriter<StreamWriter<&'a mut dyn Write>>,
}

impl<'a> NpzWriter<'a> {
    /// An archive without members.
    pub fn new(out: &'a mut dyn Write) -> NpzWriter<'a> {
        NpzWriter {
            zip: ZipWriter::new_stream(out),
        }
    }

    /// Adds the member `name.npy` with the content that `write` writes, compressed.
    ///
    /// # Errors
    /// Those of writing.
    pub fn add(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut out = self.member(name)?;
        write(&mut out)?;
        out.flush()
    }

    /// Starts the member `name.npy`.
    fn member(&mut self, name: &str) -> io::Result<BufWriter<impl Write>> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(LEVEL))
            .large_file(true);
        self.zip.start_file(format!("{name}.npy"), options)?;
        Ok(BufWriter::with_capacity(BUFFER, &mut self.zip))
    }

    /// Writes the directory.
    ///
    /// # Errors
    /// Those of writing.
    pub fn finish(self) -> io::Result<()> {
        self.zip.finish()?;
        Ok(())
    }
}

/// Reads members of an archive by name.
pub struct NpzReader<'a> {
    zip: ZipArchive<Box<dyn ReadSeek + 'a>>,
    /// Bytes that all members together may still expand to.
    budget: u64,
}

/// A file that can be read at any place.
trait ReadSeek: Read + Seek {}

impl<R: Read + Seek> ReadSeek for R {}

impl<'a> NpzReader<'a> {
    /// Reads the directory. Members may together expand to at most `budget` bytes.
    ///
    /// # Errors
    /// What is wrong with the archive.
    pub fn new(file: impl Read + Seek + 'a, budget: u64) -> Result<NpzReader<'a>, String> {
        NpzReader::open(Box::new(file), budget)
    }

    fn open(file: Box<dyn ReadSeek + 'a>, budget: u64) -> Result<NpzReader<'a>, String> {
        let zip = ZipArchive::new(file).map_err(|e| match e {
            ZipError::InvalidArchive(why) => {
                format!("this is not a complete .npz archive ({why}): was it cut off?")
            }
            other => other.to_string(),
        })?;
        Ok(NpzReader { zip, budget })
    }

    /// Names of the arrays, without `.npy`, in the order of the archive.
    pub fn names(&self) -> Vec<String> {
        let names = self.zip.file_names();
        names
            .map(|n| n.unwrap_or_default())
            .map(|n| n.strip_suffix(".npy").unwrap_or(&n).to_owned())
            .collect()
    }

    /// The array of a name, if there is one.
    ///
    /// # Errors
    /// What is wrong with the member.
    pub fn array(&mut self, name: &str) -> Result<Option<StoredArray>, String> {
        let member = match self.zip.by_name(&format!("{name}.npy")) {
            Ok(member) => member,
            Err(ZipError::FileNotFound) => return Ok(None),
            Err(e) => return Err(format!("{name}.npy: {e}")),
        };
        let mut bytes = Vec::new();
        let read = member.take(self.budget.saturating_add(1));
        let mut read = io::BufReader::with_capacity(BUFFER, read);
        read.read_to_end(&mut bytes)
            .map_err(|e| format!("{name}.npy: {e}"))?;
        if bytes.len() as u64 > self.budget {
            return Err(format!(
                "{name}.npy expands to more than the memory allows ({} bytes)",
                self.budget
            ));
        }
        self.budget -= bytes.len() as u64;
        let array = StoredArray::new(bytes).map_err(|e| format!("{name}.npy: {e}"))?;
        Ok(Some(array))
    }
}

#[cfg(test)]
mod tests {
    use super::super::npy;
    use super::*;
    use std::io::Cursor;

    fn archive() -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut archive = NpzWriter::new(&mut bytes);
        archive
            .add("a", |w| npy::write(&[2, 2], &[1.0, 2.0, 3.0, 4.5], w))
            .unwrap();
        archive
            .add("names", |w| {
                npy::write_texts(&["floor".to_owned(), "wänd".to_owned()], w)
            })
            .unwrap();
        archive
            .add("n", |w| npy::write(&[3], &[7i32; 3], w))
            .unwrap();
        archive.finish().unwrap();
        bytes
    }

    #[test]
    fn arrays_come_back() {
        let bytes = archive();
        let mut read = NpzReader::new(Cursor::new(&bytes), 1 << 20).unwrap();
        assert_eq!(read.names(), ["a", "names", "n"]);
        let a = read.array("a").unwrap().unwrap();
        assert_eq!(
            (a.shape(), a.numbers().unwrap()),
            (&[2, 2][..], vec![1.0, 2.0, 3.0, 4.5])
        );
        let names = read.array("names").unwrap().unwrap();
        assert_eq!(names.texts().unwrap(), ["floor", "wänd"]);
        let n = read.array("n").unwrap().unwrap();
        assert_eq!(n.integers().unwrap(), [7, 7, 7]);
        assert!(read.array("b").unwrap().is_none());
        // The same bytes every time.
        assert_eq!(archive(), bytes);
    }

    #[test]
    fn no_prefix_is_read() {
        let bytes = archive();
        for length in 0..bytes.len() {
            let read = NpzReader::new(Cursor::new(&bytes[..length]), 1 << 20);
            assert!(read.is_err(), "{length} of {} bytes", bytes.len());
        }
    }

    #[test]
    fn damage_is_found_and_the_budget_holds() {
        let whole = archive();
        let mut errors = 0;
        for i in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[i] ^= 0x40;
            let Ok(mut read) = NpzReader::new(Cursor::new(&bytes), 1 << 20) else {
                errors += 1;
                continue;
            };
            let arrays = ["a", "names", "n"].map(|name| read.array(name));
            errors += usize::from(arrays.iter().any(|a| !matches!(a, Ok(Some(_)))));
        }
        // Some bytes do not matter: dates, versions, permissions.
        assert!(errors > whole.len() / 2, "{errors} of {}", whole.len());
        let mut read = NpzReader::new(Cursor::new(&whole), 100).unwrap();
        assert!(read.array("a").unwrap_err().contains("memory"));
    }
}
