//! Blocks in a file that only grows: records behind a header, each with its length and checksums of its
//! head and its content.
//!
//! However the process ends, earlier records are complete, and an incomplete record at the end is
//! detected and cut off.

use azulejo_trace::RunStage;
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// Stage, block, length, checksum of the content, checksum of the fields before.
pub const HEAD: usize = 4 + 8 + 8 + 4 + 4;

/// The stage of the record behind which nothing follows.
const END: u32 = u32::MAX;

/// The stages by their numbers in files; [`RunStage::Loop`] is behind [`STEPS`].
const STAGES: [RunStage; 4] = [
    RunStage::Rows,
    RunStage::Pairs,
    RunStage::Points,
    RunStage::Formulas,
];

/// The number of the first step.
const STEPS: u32 = 1 << 8;

/// A stage and the number of a block.
pub type BlockId = (RunStage, usize);

/// The blocks of a file.
#[derive(Debug)]
pub struct RecordFile {
    file: File,
    stored: BTreeMap<BlockId, StoredBlock>,
    /// Position of the next record.
    end: u64,
    /// Whether the record at the end says that this is all.
    is_ended: bool,
}

#[derive(Clone, Copy, Debug)]
struct StoredBlock {
    start: u64,
    length: u64,
    checksum: u32,
}

/// What a record is.
enum Recorded {
    Block(BlockId, StoredBlock),
    End,
}

impl RecordFile {
    /// A new file of a header alone, locked.
    ///
    /// # Errors
    /// There is such a file, or it cannot be written.
    pub fn create(path: &Path, header: &[u8]) -> io::Result<RecordFile> {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).create_new(true).open(path)?;
        file.try_lock().map_err(io::Error::from)?;
        RecordFile::begun(file, header)
    }

    /// An open file that becomes a header alone.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn begun(mut file: File, header: &[u8]) -> io::Result<RecordFile> {
        file.set_len(0)?;
        file.rewind()?;
        file.write_all(header)?;
        Ok(RecordFile {
            file,
            stored: BTreeMap::new(),
            end: header.len() as u64,
            is_ended: false,
        })
    }

    /// The complete records after the first `header` bytes.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn scan(file: File, header: u64) -> io::Result<RecordFile> {
        let mut records = RecordFile {
            file,
            stored: BTreeMap::new(),
            end: header,
            is_ended: false,
        };
        let length = records.file.metadata()?.len();
        while !records.is_ended && records.scan_next(length)? {}
        Ok(records)
    }

    /// Takes the next record; whether there was one.
    fn scan_next(&mut self, length: u64) -> io::Result<bool> {
        let mut head = [0; HEAD];
        self.file.seek(SeekFrom::Start(self.end))?;
        if read_up_to(&mut self.file, &mut head)? < HEAD {
            return Ok(false);
        }
        let start = self.end + HEAD as u64;
        match parse_head(&head, start) {
            Some(Recorded::End) => {
                self.is_ended = true;
                self.end = start;
            }
            Some(Recorded::Block(id, place)) => {
                let end = start.checked_add(place.length).filter(|&e| e <= length);
                let Some(end) = end else {
                    return Ok(false);
                };
                self.stored.insert(id, place);
                self.end = end;
            }
            None => return Ok(false),
        }
        Ok(true)
    }

    /// Bytes after the last complete record.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn rest(&self) -> io::Result<u64> {
        Ok(self.file.metadata()?.len().saturating_sub(self.end))
    }

    /// Cuts off what follows the last complete record.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn cut(&self) -> io::Result<()> {
        self.file.set_len(self.end)
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.stored.len()
    }

    /// All blocks, in the order of stages and numbers.
    pub fn blocks(&self) -> impl Iterator<Item = BlockId> + '_ {
        self.stored.keys().copied()
    }

    /// Whether nothing will be added.
    pub fn is_ended(&self) -> bool {
        self.is_ended
    }

    /// Whether it holds a block, damaged or not.
    pub fn has(&self, id: BlockId) -> bool {
        self.stored.contains_key(&id)
    }

    /// The content of a block; `None` if there is no such block, or its checksum is wrong.
    pub fn read(&mut self, id: BlockId) -> Option<Vec<u8>> {
        let place = *self.stored.get(&id)?;
        self.file.seek(SeekFrom::Start(place.start)).ok()?;
        // The scan has checked that the file is long enough.
        let mut bytes = vec![0; usize::try_from(place.length).ok()?];
        self.file.read_exact(&mut bytes).ok()?;
        (crc32fast::hash(&bytes) == place.checksum).then_some(bytes)
    }

    /// Adds a block, or replaces it.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn append(&mut self, id: BlockId, bytes: &[u8]) -> io::Result<()> {
        let head = record_head(number_of(id.0), id.1, bytes);
        self.file.seek(SeekFrom::Start(self.end))?;
        self.file.write_all(&head)?;
        self.file.write_all(bytes)?;
        let place = StoredBlock {
            start: self.end + HEAD as u64,
            length: bytes.len() as u64,
            checksum: crc32fast::hash(bytes),
        };
        self.stored.insert(id, place);
        self.end = place.start + place.length;
        Ok(())
    }

    /// Says that this is all, once all of it is on the disk.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(&mut self) -> io::Result<()> {
        self.file.sync_all()?;
        self.file.seek(SeekFrom::Start(self.end))?;
        self.file.write_all(&record_head(END, self.len(), &[]))?;
        self.file.sync_all()?;
        self.end += HEAD as u64;
        self.is_ended = true;
        Ok(())
    }
}

/// Whether nobody else has locked a file; it is locked then. Some file systems have no locks.
pub fn is_free(file: &File) -> bool {
    !matches!(file.try_lock(), Err(TryLockError::WouldBlock))
}

/// Reads until `bytes` are full or the file ends.
///
/// # Errors
/// It cannot be read.
pub fn read_up_to(file: &mut File, bytes: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < bytes.len() {
        match file.read(&mut bytes[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(filled)
}

fn record_head(stage: u32, block: usize, bytes: &[u8]) -> Vec<u8> {
    let mut head = stage.to_le_bytes().to_vec();
    head.extend((block as u64).to_le_bytes());
    head.extend((bytes.len() as u64).to_le_bytes());
    head.extend(crc32fast::hash(bytes).to_le_bytes());
    head.extend(crc32fast::hash(&head).to_le_bytes());
    head
}

/// Parses the head of a record, if it is intact.
fn parse_head(head: &[u8; HEAD], start: u64) -> Option<Recorded> {
    let (fields, checksum) = head.split_last_chunk::<4>()?;
    if crc32fast::hash(fields) != u32::from_le_bytes(*checksum) {
        return None;
    }
    let (stage, rest) = fields.split_first_chunk::<4>()?;
    let (block, rest) = rest.split_first_chunk::<8>()?;
    let (length, checksum) = rest.split_first_chunk::<8>()?;
    let stage = u32::from_le_bytes(*stage);
    if stage == END {
        return Some(Recorded::End);
    }
    let place = StoredBlock {
        start,
        length: u64::from_le_bytes(*length),
        checksum: u32::from_le_bytes(*checksum.first_chunk()?),
    };
    let stage = stage_of(stage)?;
    Some(Recorded::Block(
        (stage, u64::from_le_bytes(*block) as usize),
        place,
    ))
}

/// The number of a stage, as files and messages have it.
pub fn number_of(stage: RunStage) -> u32 {
    match stage {
        RunStage::Loop(step) => STEPS.saturating_add(step).min(END - 1),
        stage => STAGES.iter().position(|&s| s == stage).unwrap_or_default() as u32,
    }
}

/// The stage of a number.
pub fn stage_of(number: u32) -> Option<RunStage> {
    match number.checked_sub(STEPS) {
        Some(step) => Some(RunStage::Loop(step)),
        None => STAGES.get(number as usize).copied(),
    }
}
