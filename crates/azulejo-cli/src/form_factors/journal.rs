//! The journal next to the output: finished blocks of rows, with which the same command resumes
//! after an interruption.
//!
//! A header identifies the work by a hash of scene, options and version. Records follow, each with
//! its length and checksums of header and content, and are only appended: however the process ends,
//! earlier records are complete, and an incomplete record at the end is detected and truncated.

use crate::content_key::ContentKey;
use crate::failure::Failure;
use azulejo_factors::form_factors::{Journal, JournalStage};
use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

const MAGIC: [u8; 24] = *b"azulejo form factors 2\r\n";

/// What the magic of every version begins with.
const MARK: &[u8] = b"azulejo form factors ";

/// Magic, key and checksum.
const HEADER: u64 = 24 + 32 + 4;

/// Stage, block, length, checksum of the content, checksum of the fields before.
const HEAD: usize = 4 + 8 + 8 + 4 + 4;

/// A journal in a file.
pub struct FileJournal {
    path: PathBuf,
    key: ContentKey,
    state: Mutex<JournalState>,
}

#[derive(Default)]
struct JournalState {
    /// Created with the first record.
    file: Option<File>,
    stored: HashMap<(JournalStage, usize), StoredBlock>,
    /// Position of the next record.
    end: u64,
    /// Set after a write error: no more records are written.
    is_broken: bool,
    messages: Vec<String>,
}

#[derive(Clone, Copy)]
struct StoredBlock {
    start: u64,
    length: u64,
    checksum: u32,
}

impl FileJournal {
    /// Opens the journal at `path`, or prepares to create it. A journal of other work, or a damaged
    /// one, is restarted, with a message in [`take_messages`](FileJournal::take_messages).
    pub fn open(path: PathBuf, key: ContentKey) -> Result<FileJournal, Failure> {
        let mut state = JournalState::default();
        match OpenOptions::new().read(true).write(true).open(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => {}
            Err(e) => return Err(Failure::file("open", &path, &e)),
            Ok(file) => {
                lock(&file, &path)?;
                state.resume(file, key, &path)?;
            }
        }
        Ok(FileJournal {
            path,
            key,
            state: Mutex::new(state),
        })
    }

    /// Number of stored blocks.
    pub fn blocks(&self) -> usize {
        self.state().stored.len()
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Messages about it since the last call.
    pub fn take_messages(&self) -> Vec<String> {
        std::mem::take(&mut self.state().messages)
    }

    /// Removes the file: the work is done.
    pub fn remove(self) {
        let state = self.state.into_inner();
        let state = state.unwrap_or_else(PoisonError::into_inner);
        if state.file.is_some() {
            // A file that cannot be removed is restarted or used by the next run.
            let _ = std::fs::remove_file(&self.path);
        }
    }

    fn state(&self) -> MutexGuard<'_, JournalState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Journal for FileJournal {
    fn load(&self, stage: JournalStage, block: usize) -> Option<Vec<u8>> {
        let mut state = self.state();
        let place = *state.stored.get(&(stage, block))?;
        let read = state.read(place);
        if read.is_none() {
            let path = self.path.display();
            let words = format!("{path}: a block is damaged and is computed again");
            state.messages.push(words);
        }
        read
    }

    fn save(&self, stage: JournalStage, block: usize, bytes: &[u8]) {
        let mut state = self.state();
        if state.is_broken {
            return;
        }
        if let Err(e) = state.append(&self.path, self.key, stage, block, bytes) {
            state.is_broken = true;
            let failure = Failure::file("write", &self.path, &e);
            let words = format!("{failure}: rows from here on would be lost by an interruption");
            state.messages.push(words);
        }
    }
}

impl JournalState {
    /// Reads the record headers of an existing journal.
    fn resume(&mut self, mut file: File, key: ContentKey, path: &Path) -> Result<(), Failure> {
        let failed = |e| Failure::file("read", path, &e);
        let mut header = [0; HEADER as usize];
        let read = read_up_to(&mut file, &mut header).map_err(failed)?;
        let is_ours = header.starts_with(&MARK[..MARK.len().min(read)]);
        if !is_ours || (read == 0 && file.metadata().map_err(failed)?.len() > 0) {
            return Err(Failure::failed(format_args!(
                "{} exists and is not a journal: move it away, or use --no-journal",
                path.display()
            )));
        }
        if header != self::header(key) {
            let words = format!(
                "{}: belongs to another scene, other options or another version, or is damaged; restarted",
                path.display()
            );
            self.messages.push(words);
            file.set_len(0).map_err(failed)?;
            file.rewind().map_err(failed)?;
            file.write_all(&self::header(key)).map_err(failed)?;
            self.end = HEADER;
        } else {
            self.scan(&mut file).map_err(failed)?;
            let length = file.metadata().map_err(failed)?.len();
            if length > self.end {
                let words = format!(
                    "{}: the last {} bytes are incomplete or damaged; they are computed again",
                    path.display(),
                    length - self.end
                );
                self.messages.push(words);
                file.set_len(self.end).map_err(failed)?;
            }
        }
        self.file = Some(file);
        Ok(())
    }

    /// Finds all complete records.
    fn scan(&mut self, file: &mut File) -> io::Result<()> {
        let length = file.metadata()?.len();
        self.end = HEADER;
        let mut head = [0; HEAD];
        loop {
            file.seek(SeekFrom::Start(self.end))?;
            if read_up_to(file, &mut head)? < HEAD {
                return Ok(());
            }
            let Some((key, place)) = parse_record_header(&head, self.end + HEAD as u64) else {
                return Ok(());
            };
            let Some(end) = place
                .start
                .checked_add(place.length)
                .filter(|&e| e <= length)
            else {
                return Ok(());
            };
            self.stored.insert(key, place);
            self.end = end;
        }
    }

    fn read(&mut self, place: StoredBlock) -> Option<Vec<u8>> {
        let file = self.file.as_mut()?;
        file.seek(SeekFrom::Start(place.start)).ok()?;
        // The scan has checked that the file is long enough.
        let mut bytes = vec![0; usize::try_from(place.length).ok()?];
        file.read_exact(&mut bytes).ok()?;
        (crc32fast::hash(&bytes) == place.checksum).then_some(bytes)
    }

    fn append(
        &mut self,
        path: &Path,
        key: ContentKey,
        stage: JournalStage,
        block: usize,
        bytes: &[u8],
    ) -> io::Result<()> {
        if self.file.is_none() {
            let mut options = OpenOptions::new();
            let mut file = options.read(true).write(true).create_new(true).open(path)?;
            file.try_lock().map_err(io::Error::from)?;
            file.write_all(&header(key))?;
            self.end = HEADER;
            self.file = Some(file);
        }
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        let head = record_header(stage, block, bytes);
        file.seek(SeekFrom::Start(self.end))?;
        file.write_all(&head)?;
        file.write_all(bytes)?;
        let place = StoredBlock {
            start: self.end + HEAD as u64,
            length: bytes.len() as u64,
            checksum: crc32fast::hash(bytes),
        };
        self.stored.insert((stage, block), place);
        self.end = place.start + place.length;
        Ok(())
    }
}

/// Only one process at a time can use a journal.
fn lock(file: &File, path: &Path) -> Result<(), Failure> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(Failure::failed(format_args!(
            "{} is in use: another azulejo is writing the same output",
            path.display()
        ))),
        // Some file systems have no locks.
        Err(TryLockError::Error(_)) => Ok(()),
    }
}

fn header(key: ContentKey) -> [u8; HEADER as usize] {
    let mut header = [0; HEADER as usize];
    header[..24].copy_from_slice(&MAGIC);
    header[24..56].copy_from_slice(&key);
    let checksum = crc32fast::hash(&header[..56]);
    header[56..].copy_from_slice(&checksum.to_le_bytes());
    header
}

fn record_header(stage: JournalStage, block: usize, bytes: &[u8]) -> Vec<u8> {
    let mut head = number_of(stage).to_le_bytes().to_vec();
    head.extend((block as u64).to_le_bytes());
    head.extend((bytes.len() as u64).to_le_bytes());
    head.extend(crc32fast::hash(bytes).to_le_bytes());
    head.extend(crc32fast::hash(&head).to_le_bytes());
    head
}

/// Parses a record header, if it is intact.
fn parse_record_header(
    head: &[u8; HEAD],
    start: u64,
) -> Option<((JournalStage, usize), StoredBlock)> {
    let (said, checksum) = head.split_last_chunk::<4>()?;
    if crc32fast::hash(said) != u32::from_le_bytes(*checksum) {
        return None;
    }
    let (stage, rest) = said.split_first_chunk::<4>()?;
    let (block, rest) = rest.split_first_chunk::<8>()?;
    let (length, checksum) = rest.split_first_chunk::<8>()?;
    let stage = stage_of(u32::from_le_bytes(*stage))?;
    let place = StoredBlock {
        start,
        length: u64::from_le_bytes(*length),
        checksum: u32::from_le_bytes(*checksum.first_chunk()?),
    };
    Some(((stage, u64::from_le_bytes(*block) as usize), place))
}

fn number_of(stage: JournalStage) -> u32 {
    match stage {
        JournalStage::Rows => 0,
        JournalStage::Pairs => 1,
    }
}

fn stage_of(number: u32) -> Option<JournalStage> {
    [JournalStage::Rows, JournalStage::Pairs]
        .into_iter()
        .find(|&s| number_of(s) == number)
}

/// Reads until `bytes` are full or the file ends.
fn read_up_to(file: &mut File, bytes: &mut [u8]) -> io::Result<usize> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Folder {
            let name = format!("azulejo-journal-{name}-{}", std::process::id());
            let folder = std::env::temp_dir().join(name);
            let _ = fs::remove_dir_all(&folder);
            fs::create_dir_all(&folder).unwrap();
            Folder(folder)
        }

        fn journal(&self) -> PathBuf {
            self.0.join("f.npz.journal")
        }

        fn open(&self, key: u8) -> FileJournal {
            FileJournal::open(self.journal(), [key; 32]).unwrap_or_else(|e| panic!("{e}"))
        }

        /// A journal of three blocks, and its bytes.
        fn filled(&self) -> Vec<u8> {
            let journal = self.open(7);
            (0..3).for_each(|k| journal.save(JournalStage::Rows, k, &[k as u8; 100]));
            drop(journal);
            fs::read(self.journal()).unwrap()
        }

        /// What is there of the three blocks, and what is said, after the file became `bytes`.
        fn after(&self, bytes: &[u8], key: u8) -> (Vec<usize>, String) {
            fs::write(self.journal(), bytes).unwrap();
            let journal = self.open(key);
            let has = |k: &usize| journal.load(JournalStage::Rows, *k).is_some();
            let there = (0..3).filter(has).collect();
            (there, journal.take_messages().join("\n"))
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn blocks_come_back() {
        let folder = Folder::new("back");
        let whole = folder.filled();
        let journal = folder.open(7);
        assert_eq!((journal.blocks(), journal.take_messages()), (3, vec![]));
        assert_eq!(journal.load(JournalStage::Rows, 1), Some(vec![1; 100]));
        assert_eq!(journal.load(JournalStage::Pairs, 1), None);
        journal.save(JournalStage::Pairs, 9, b"more");
        assert_eq!(journal.load(JournalStage::Pairs, 9).unwrap(), b"more");
        assert!(fs::read(folder.journal()).unwrap().starts_with(&whole));
        journal.remove();
        assert!(!folder.journal().exists());
    }

    #[test]
    fn nothing_is_there_before_the_first_block() {
        let folder = Folder::new("lazy");
        let journal = folder.open(7);
        assert!(!folder.journal().exists());
        journal.remove();
    }

    #[test]
    fn half_records_are_cut_off() {
        let folder = Folder::new("half");
        let whole = folder.filled();
        let record = HEAD + 100;
        for missing in [1, 50, 100, 101, HEAD + 99] {
            let (there, said) = folder.after(&whole[..whole.len() - missing], 7);
            assert_eq!(there, [0, 1]);
            assert!(
                said.contains(&format!("last {} bytes", record - missing)),
                "{said}"
            );
        }
        assert_eq!(
            folder.after(&whole[..whole.len() - record], 7),
            (vec![0, 1], String::new())
        );
    }

    #[test]
    fn damage_is_detected_everywhere() {
        let folder = Folder::new("damage");
        let whole = folder.filled();
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x10;
            fs::write(folder.journal(), &bytes).unwrap();
            match FileJournal::open(folder.journal(), [7; 32]) {
                Err(e) => assert!(
                    at < 24 && e.to_string().contains("is not a journal"),
                    "{at}: {e}"
                ),
                Ok(journal) => {
                    let loaded = (0..3).map(|k| journal.load(JournalStage::Rows, k));
                    let right =
                        |(k, b): (usize, Option<Vec<u8>>)| b.is_none_or(|b| b == [k as u8; 100]);
                    assert!(loaded.enumerate().all(right), "{at}");
                    assert!(!journal.take_messages().is_empty(), "{at}");
                }
            }
        }
    }

    #[test]
    fn other_work_restarts_the_journal() {
        let folder = Folder::new("other");
        let whole = folder.filled();
        let (there, said) = folder.after(&whole, 8);
        assert!(there.is_empty() && said.contains("restarted"), "{said}");
        assert_eq!(fs::read(folder.journal()).unwrap(), header([8; 32]));
        // An incomplete header is no record of other work.
        assert!(folder.after(&whole[..10], 7).0.is_empty());
        assert!(folder.after(&[], 7).0.is_empty());
        // A journal of another version is no diary.
        let mut old = whole.clone();
        old[21] = b'1';
        let (there, said) = folder.after(&old, 7);
        assert!(
            there.is_empty() && said.contains("another version"),
            "{said}"
        );
    }

    #[test]
    fn other_files_are_not_touched() {
        let folder = Folder::new("alien");
        fs::write(folder.journal(), "my diary").unwrap();
        let said = FileJournal::open(folder.journal(), [7; 32])
            .err()
            .unwrap()
            .to_string();
        assert!(said.contains("is not a journal"), "{said}");
        assert_eq!(fs::read(folder.journal()).unwrap(), b"my diary");
    }

    #[test]
    fn two_at_once_are_refused() {
        let folder = Folder::new("two");
        folder.filled();
        let first = folder.open(7);
        let said = FileJournal::open(folder.journal(), [7; 32])
            .err()
            .unwrap()
            .to_string();
        assert!(said.contains("in use"), "{said}");
        drop(first);
        folder.open(7);
    }

    #[cfg(unix)]
    #[test]
    fn a_full_disk_is_reported_only() {
        let folder = Folder::new("full");
        if !Path::new("/dev/full").exists() {
            return;
        }
        std::os::unix::fs::symlink("/dev/full", folder.0.join("x")).unwrap();
        let journal = folder.open(7);
        let full = OpenOptions::new()
            .read(true)
            .write(true)
            .open("/dev/full")
            .unwrap();
        journal.state().file = Some(full);
        journal.save(JournalStage::Rows, 0, b"block");
        journal.save(JournalStage::Rows, 1, b"block");
        let said = journal.take_messages();
        assert!(
            said.len() == 1 && said[0].contains("No space left"),
            "{said:?}"
        );
        assert_eq!(journal.load(JournalStage::Rows, 0), None);
    }
}
