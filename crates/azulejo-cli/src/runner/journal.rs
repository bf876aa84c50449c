//! The journal next to the output: finished blocks, with which the same command resumes after an
//! interruption.
//!
//! A header identifies the work by a hash of scene, options and version; records follow
//! ([`RecordFile`]).

use super::record_file::{self, BlockId, RecordFile, read_up_to};
use crate::content_key::ContentKey;
use crate::failure::Failure;
use crate::session::Session;
use azulejo_trace::run::RunRole;
use azulejo_trace::{Blocks, RunStage};
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

const MAGIC: [u8; 24] = *b"azulejo journal 4     \r\n";

/// What the magics of all versions begin with.
const MARKS: [&[u8]; 2] = [b"azulejo journal ", b"azulejo form factors "];

/// Magic, key and checksum.
const HEADER: u64 = 24 + 32 + 4;

/// A journal in a file.
pub struct FileJournal {
    path: PathBuf,
    key: ContentKey,
    state: Mutex<JournalState>,
}

#[derive(Default)]
struct JournalState {
    /// Created with the first record.
    records: Option<RecordFile>,
    /// Set after a write error: no more records are written.
    is_broken: bool,
    messages: Vec<String>,
}

impl FileJournal {
    /// The journal next to an output.
    ///
    /// # Errors
    /// As [`open`](FileJournal::open).
    pub fn beside(output: &Path, key: ContentKey) -> Result<FileJournal, Failure> {
        let mut name = output.as_os_str().to_owned();
        name.push(".journal");
        FileJournal::open(name.into(), key)
    }

    /// Does work whose blocks it keeps, and says what is to be known of them.
    ///
    /// # Errors
    /// Those of the work.
    pub fn keeping<T>(
        &self,
        session: &mut Session,
        work: impl FnOnce(&mut Session) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let note = |session: &mut Session| {
            let messages = self.take_messages();
            messages.iter().for_each(|message| session.note(message));
        };
        note(session);
        if self.blocks() > 0 {
            session.say(&format!("resuming from {}", self.path.display()));
        }
        let outcome = work(session);
        note(session);
        if outcome.is_err() && self.blocks() > 0 {
            session.say(&format!(
                "completed work is kept in {}: the same command resumes from there",
                self.path.display()
            ));
        }
        outcome
    }

    /// Opens the journal at `path`, or prepares to create it. A journal of other work, or a damaged
    /// one, is restarted, with a message in [`take_messages`](FileJournal::take_messages).
    pub fn open(path: PathBuf, key: ContentKey) -> Result<FileJournal, Failure> {
        let mut state = JournalState::default();
        match OpenOptions::new().read(true).write(true).open(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => {}
            Err(e) => return Err(Failure::file("open", &path, &e)),
            // Only one process at a time can use a journal.
            Ok(file) if !record_file::is_free(&file) => {
                return Err(Failure::failed(format_args!(
                    "{} is in use: another azulejo is writing the same output",
                    path.display()
                )));
            }
            Ok(file) => state.resume(file, key, &path)?,
        }
        Ok(FileJournal {
            path,
            key,
            state: Mutex::new(state),
        })
    }

    /// Number of stored blocks.
    fn blocks(&self) -> usize {
        self.state().records.as_ref().map_or(0, RecordFile::len)
    }

    /// Whether it holds a block.
    pub fn has(&self, stage: RunStage, block: usize) -> bool {
        let state = self.state();
        let records = state.records.as_ref();
        records.is_some_and(|records| records.has((stage, block)))
    }

    /// Messages about it since the last call.
    fn take_messages(&self) -> Vec<String> {
        std::mem::take(&mut self.state().messages)
    }

    /// Removes the file: the work is done.
    pub fn remove(&self) {
        if self.state().records.take().is_some() {
            // A file that cannot be removed is restarted or used by the next run.
            let _ = std::fs::remove_file(&self.path);
        }
    }

    fn state(&self) -> MutexGuard<'_, JournalState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Blocks for FileJournal {
    fn role(&self) -> RunRole {
        RunRole {
            is_kept: true,
            ..RunRole::default()
        }
    }

    fn load(&self, stage: RunStage, block: usize) -> Option<Vec<u8>> {
        let mut state = self.state();
        let records = state.records.as_mut()?;
        if !records.has((stage, block)) {
            return None;
        }
        let read = records.read((stage, block));
        if read.is_none() {
            let path = self.path.display();
            let words = format!("{path}: a block is damaged and is computed again");
            state.messages.push(words);
        }
        read
    }

    fn save(&self, stage: RunStage, block: usize, bytes: &[u8]) {
        let mut state = self.state();
        if state.is_broken {
            return;
        }
        if let Err(e) = state.append(&self.path, self.key, (stage, block), bytes) {
            state.is_broken = true;
            let failure = Failure::file("write", &self.path, &e);
            let words =
                format!("{failure}: what is computed from now on would be lost by an interruption");
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
        let is_ours = MARKS
            .iter()
            .any(|mark| header.starts_with(&mark[..mark.len().min(read)]));
        if !is_ours || (read == 0 && file.metadata().map_err(failed)?.len() > 0) {
            return Err(Failure::failed(format_args!(
                "{} exists and is not a journal: move it away, or use --no-journal",
                path.display()
            )));
        }
        let records = if header != self::header(key) {
            let words = format!(
                "{}: belongs to another scene, other options or another version, or is damaged; restarted",
                path.display()
            );
            self.messages.push(words);
            RecordFile::begun(file, &self::header(key)).map_err(failed)?
        } else {
            let records = RecordFile::scan(file, HEADER).map_err(failed)?;
            let rest = records.rest().map_err(failed)?;
            if rest > 0 {
                let words = format!(
                    "{}: the last {rest} bytes are incomplete or damaged; they are computed again",
                    path.display()
                );
                self.messages.push(words);
                records.cut().map_err(failed)?;
            }
            records
        };
        self.records = Some(records);
        Ok(())
    }

    fn append(
        &mut self,
        path: &Path,
        key: ContentKey,
        id: BlockId,
        bytes: &[u8],
    ) -> io::Result<()> {
        let records = match &mut self.records {
            Some(records) => records,
            None => self.records.insert(RecordFile::create(path, &header(key))?),
        };
        records.append(id, bytes)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runner::record_file::HEAD;
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
            (0..3).for_each(|k| journal.save(RunStage::Rows, k, &[k as u8; 100]));
            drop(journal);
            fs::read(self.journal()).unwrap()
        }

        /// What is there of the three blocks, and what is said, after the file became `bytes`.
        fn after(&self, bytes: &[u8], key: u8) -> (Vec<usize>, String) {
            fs::write(self.journal(), bytes).unwrap();
            let journal = self.open(key);
            let has = |k: &usize| journal.load(RunStage::Rows, *k).is_some();
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
        assert_eq!(journal.load(RunStage::Rows, 1), Some(vec![1; 100]));
        assert_eq!(journal.load(RunStage::Pairs, 1), None);
        journal.save(RunStage::Pairs, 9, b"more");
        assert_eq!(journal.load(RunStage::Pairs, 9).unwrap(), b"more");
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
            let (there, message) = folder.after(&whole[..whole.len() - missing], 7);
            assert_eq!(there, [0, 1]);
            assert!(
                message.contains(&format!("last {} bytes", record - missing)),
                "{message}"
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
                    let loaded = (0..3).map(|k| journal.load(RunStage::Rows, k));
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
        let (there, message) = folder.after(&whole, 8);
        assert!(
            there.is_empty() && message.contains("restarted"),
            "{message}"
        );
        assert_eq!(fs::read(folder.journal()).unwrap(), header([8; 32]));
        // An incomplete header is not a record of other work.
        assert!(folder.after(&whole[..10], 7).0.is_empty());
        assert!(folder.after(&[], 7).0.is_empty());
        // A journal of another version is not a diary.
        let mut old = whole.clone();
        old[21] = b'1';
        let (there, message) = folder.after(&old, 7);
        assert!(
            there.is_empty() && message.contains("another version"),
            "{message}"
        );
    }

    #[test]
    fn other_files_are_not_touched() {
        let folder = Folder::new("alien");
        fs::write(folder.journal(), "my diary").unwrap();
        let message = FileJournal::open(folder.journal(), [7; 32])
            .err()
            .unwrap()
            .to_string();
        assert!(message.contains("is not a journal"), "{message}");
        assert_eq!(fs::read(folder.journal()).unwrap(), b"my diary");
    }

    #[test]
    fn two_at_once_are_refused() {
        let folder = Folder::new("two");
        folder.filled();
        let first = folder.open(7);
        let message = FileJournal::open(folder.journal(), [7; 32])
            .err()
            .unwrap()
            .to_string();
        assert!(message.contains("in use"), "{message}");
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
        journal.state().records = Some(RecordFile::scan(full, HEADER).unwrap());
        journal.save(RunStage::Rows, 0, b"block");
        journal.save(RunStage::Rows, 1, b"block");
        let messages = journal.take_messages();
        assert!(
            messages.len() == 1 && messages[0].contains("No space left"),
            "{messages:?}"
        );
        assert_eq!(journal.load(RunStage::Rows, 0), None);
    }
}
