//! A part while it is computed: a file of the finished blocks of a shard.

use super::Describe;
use super::command::{self, DescribedCommand};
use super::header::{FileStart, PartHeader, WorkKey};
use super::record_file::{self, RecordFile};
use crate::content_key::shown;
use crate::failure::Failure;
use crate::interrupt::BlockEnd;
use crate::parts::Shard;
use crate::report::{Report, count};
use crate::session::Session;
use azulejo_trace::run::{Division, RunRole};
use azulejo_trace::{Blocks, Cancelled, RunStage};
use std::fs::{self, File, OpenOptions};
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The number of the record that says on what the blocks of a stage rely.
pub const BASIS: usize = usize::MAX;

/// A part to be computed.
pub struct PartPlan {
    path: PathBuf,
    shard: Shard,
    /// The command without what is about the shard, as its parsed arguments show it.
    options: String,
    /// The files that it names.
    files: Vec<PathBuf>,
}

impl PartPlan {
    /// Checks that a part can be written, before the work begins.
    ///
    /// # Errors
    /// What is there is not a part; the model is a stream; the output is.
    pub fn check(
        shard: Shard,
        output: Option<&Path>,
        described: Describe,
    ) -> Result<PartPlan, Failure> {
        let Some(output) = output else {
            return Err(Failure::misuse("--shard: -o PART is missing"));
        };
        if output == Path::new("-") {
            return Err(Failure::misuse(
                "--shard: a part is a file that the shard continues after an interruption, and not standard \
                 output; give -o PART",
            ));
        }
        let DescribedCommand { files, options } = described()?;
        files.iter().try_for_each(|file| refuse_stream(file))?;
        if let Ok(mut file) = File::open(output) {
            let meta = file
                .metadata()
                .map_err(|e| Failure::file("read", output, &e))?;
            if meta.is_dir() {
                let message = format_args!("{} is a folder, expected a file", output.display());
                return Err(Failure::failed(message));
            }
            PartHeader::read(&mut file, output)?;
        }
        Ok(PartPlan {
            path: output.to_owned(),
            shard,
            options,
            files,
        })
    }

    /// Opens the part: a new one, or that of an interrupted run of the same command.
    ///
    /// # Errors
    /// It cannot be written, is in use, or belongs to other work.
    pub fn open(&self, key: &WorkKey, session: &mut Session) -> Result<ShardPart, Failure> {
        let header = PartHeader {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: command::typed()?,
            options: self.options.clone(),
            folder: command::folder(),
            shard: self.shard,
            files: command::named_files(&self.files, session.files())?,
            scene: shown(&key.scene),
            settings: shown(&key.settings),
            engine: key.engine.clone(),
        };
        let records = match OpenOptions::new().read(true).write(true).open(&self.path) {
            Err(e) if e.kind() == ErrorKind::NotFound => {
                let created = RecordFile::create(&self.path, &header.bytes());
                created.map_err(|e| Failure::file("write", &self.path, &e))?
            }
            Err(e) => return Err(Failure::file("open", &self.path, &e)),
            Ok(file) => self.resumed(file, &header, session)?,
        };
        Ok(ShardPart {
            path: self.path.clone(),
            shard: self.shard,
            block_end: session.block_end(),
            state: Mutex::new(PartState {
                before: blocks_of(&records),
                records,
                failure: None,
            }),
        })
    }

    /// The part of an interrupted run.
    fn resumed(
        &self,
        mut file: File,
        header: &PartHeader,
        session: &mut Session,
    ) -> Result<RecordFile, Failure> {
        let shown = self.path.display();
        if !record_file::is_free(&file) {
            return Err(Failure::failed(format_args!(
                "{shown} is in use: another azulejo is computing it"
            )));
        }
        let failed = |e| Failure::file("write", &self.path, &e);
        let FileStart::Header(there, length) = PartHeader::read(&mut file, &self.path)? else {
            return RecordFile::begun(file, &header.bytes()).map_err(failed);
        };
        if there.shard != header.shard {
            return Err(Failure::failed(format_args!(
                "{shown} is shard {}, and this is {}: give each shard a file of its own, or remove that one",
                there.shard, header.shard
            )));
        }
        if let Some(difference) = there.difference(header) {
            return Err(Failure::failed(format_args!(
                "{shown} is of other work, so it is left as it is: this run {difference}\nremove the file, or give \
                 another -o"
            )));
        }
        let records = RecordFile::scan(file, length).map_err(failed)?;
        let rest = records.rest().map_err(failed)?;
        if rest > 0 {
            session.note(&format!(
                "{shown}: the last {rest} bytes are incomplete or damaged; they are computed again"
            ));
            records.cut().map_err(failed)?;
        }
        Ok(records)
    }
}

/// Refuses what cannot be read a second time.
fn refuse_stream(path: &Path) -> Result<(), Failure> {
    if path == Path::new("-") {
        return Err(Failure::misuse(
            "--shard: merge has to read the model again, which it cannot do from standard input; give a file",
        ));
    }
    Ok(())
}

/// Number of blocks with results.
fn blocks_of(records: &RecordFile) -> usize {
    records.blocks().filter(|id| id.1 != BASIS).count()
}

/// A part that is being computed.
pub struct ShardPart {
    path: PathBuf,
    shard: Shard,
    block_end: Arc<BlockEnd>,
    state: Mutex<PartState>,
}

struct PartState {
    records: RecordFile,
    /// Number of blocks that were there when it was opened.
    before: usize,
    /// Why it cannot be written any more.
    failure: Option<Failure>,
}

impl ShardPart {
    /// Computes the blocks of this shard by `work`, which ends without a result, and completes the part.
    ///
    /// # Errors
    /// [`Failure::Cancelled`] if the work was cancelled: what is done is kept; the part cannot be written.
    pub fn fill(
        self,
        session: &mut Session,
        report: &mut Report,
        work: impl FnOnce(&ShardPart, &mut Session) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let path = self.path.display().to_string();
        let (before, was_complete) = {
            let state = self.state();
            (state.before, state.records.is_ended())
        };
        if was_complete {
            session.say(&format!("{path} is complete already"));
        } else {
            if before > 0 {
                session.say(&format!("resuming from {path}, blocks done: {before}"));
            }
            self.complete(session, work)?;
        }
        let blocks = blocks_of(&self.state().records);
        let words = match blocks {
            0 => "nothing to do: there are fewer rows or points than shards, and an empty part is right".to_owned(),
            1 => "1 block".to_owned(),
            blocks => format!("{} blocks", count(blocks)),
        };
        report.fact("blocks", blocks, &format!("shard {}", self.shard), words);
        report.value("shard", self.shard.number);
        report.value("shards", self.shard.of);
        report.fact("output", path.clone(), "wrote", path);
        Ok(())
    }

    fn complete(
        &self,
        session: &mut Session,
        work: impl FnOnce(&ShardPart, &mut Session) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let done = work(self, session);
        self.block_end.set_in_block(false);
        let mut state = self.state();
        if let Some(failure) = state.failure.take() {
            return Err(failure);
        }
        match done {
            Err(failure) if blocks_of(&state.records) == 0 => {
                // There is nothing in it to go on from; if it cannot be removed, it does no harm.
                let _ = fs::remove_file(&self.path);
                Err(failure)
            }
            Err(Failure::Cancelled) => {
                session.say(&format!(
                    "{} blocks are kept in {}: the same command resumes from there",
                    blocks_of(&state.records),
                    self.path.display()
                ));
                Err(Failure::Cancelled)
            }
            Err(other) => Err(other),
            Ok(()) => {
                let finished = state.records.finish();
                finished.map_err(|e| Failure::file("write", &self.path, &e))
            }
        }
    }

    fn state(&self) -> MutexGuard<'_, PartState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Blocks for ShardPart {
    fn role(&self) -> RunRole {
        RunRole {
            parts: self.shard.of as usize,
            assembles: false,
            is_kept: true,
            ..RunRole::default()
        }
    }

    fn load(&self, stage: RunStage, block: usize) -> Option<Vec<u8>> {
        self.state().records.read((stage, block))
    }

    fn save(&self, stage: RunStage, block: usize, bytes: &[u8]) {
        let mut state = self.state();
        if let Err(e) = state.records.append((stage, block), bytes) {
            state.failure = Some(Failure::file("write", &self.path, &e));
        }
    }

    /// The next of its own, unless the work is to end or has nowhere to go.
    fn next(
        &self,
        _stage: RunStage,
        _division: Division,
        left: Range<usize>,
        most: usize,
    ) -> Result<Vec<usize>, Cancelled> {
        if self.block_end.is_asked() || self.state().failure.is_some() {
            return Err(Cancelled);
        }
        let own = (self.shard.number - 1) as usize;
        let is_own = |block: &usize| block % self.shard.of as usize == own;
        let next: Vec<usize> = left.filter(is_own).take(most).collect();
        self.block_end.set_in_block(!next.is_empty());
        Ok(next)
    }

    fn rely_on(&self, stage: RunStage, digest: u64) -> Result<(), Cancelled> {
        let (id, bytes) = ((stage, BASIS), digest.to_le_bytes());
        let mut state = self.state();
        let failure = match state.records.read(id) {
            Some(known) if known == bytes => return Ok(()),
            Some(_) => Failure::failed(format_args!(
                "{} was begun on a machine that computes the light between patches, or the places of texels, otherwise, \
                 because of its memory or its processor: resume it on a machine of that kind, or remove it",
                self.path.display()
            )),
            None => match state.records.append(id, &bytes) {
                Ok(()) => return Ok(()),
                Err(e) => Failure::file("write", &self.path, &e),
            },
        };
        state.failure = Some(failure);
        Err(Cancelled)
    }
}
