//! `merge`: the result of a command from the parts that its shards computed.

use super::Runner;
use super::command::{FoundFiles, ShardedArgs};
use super::header::{FileStart, PartHeader, WorkKey};
use super::part::BASIS;
use super::record_file::RecordFile;
use crate::failure::Failure;
use crate::parts::MergeArgs;
use crate::session::Session;
use azulejo_trace::run::RunRole;
use azulejo_trace::{Blocks, Cancelled, RunStage};
use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Parts that are merged, and where the files of the command that they record are now.
pub struct MergePlan {
    parts: MergedParts,
    files: FoundFiles,
}

impl MergePlan {
    /// Reads the parts of `merge`, and finds the files of the command that they record.
    ///
    /// # Errors
    /// Parts or files are missing, or do not fit together.
    pub fn open(args: &MergeArgs, session: &mut Session) -> Result<MergePlan, Failure> {
        for output in args.outputs() {
            refuse_part(output)?;
        }
        session.progress().begin("reading parts", 0);
        let mut notes = Vec::new();
        let parts = MergedParts::read(&args.parts, &mut notes)?;
        notes.iter().for_each(|note| session.note(note));
        let header = parts.header();
        let files = FoundFiles::find(&header.files, &header.folder, args.files.as_deref())?;
        if let Some(output) = args.outputs().find(|output| files.has(output)) {
            return Err(Failure::misuse(format_args!(
                "{} is a file that the parts were computed from: write to another",
                output.display()
            )));
        }
        Ok(MergePlan { parts, files })
    }

    /// The arguments of the recorded command.
    pub fn arguments(&self) -> &[String] {
        &self.parts.header().command
    }

    /// Gives the recorded command its files where they are now, and the output of the merge.
    ///
    /// # Errors
    /// Its work cannot be divided, or it does not write what is requested.
    pub fn adapt(
        &self,
        sharded: Option<ShardedArgs>,
        args: &MergeArgs,
        session: &Session,
    ) -> Result<(), Failure> {
        let sharded = sharded.ok_or_else(|| no_command(self.parts.header()))?;
        *sharded.shard = None;
        match (sharded.maps, args.maps().next()) {
            (Some([lightmap, error_map]), _) => {
                lightmap.clone_from(&args.lightmap);
                error_map.clone_from(&args.error_map);
            }
            (None, Some(_)) => {
                return Err(Failure::misuse(format_args!(
                    "--lightmap and --error-map are for parts of bake, and these are of {}",
                    sharded.name
                )));
            }
            (None, None) => {}
        }
        sharded.output.set(args.output.as_deref())?;
        self.files.set(sharded.files);
        session.say(&format!(
            "merging {} parts of {}",
            self.parts.count(),
            sharded.name
        ));
        Ok(())
    }

    /// The parts compute its work.
    pub fn runner(&self) -> Runner<'_> {
        Runner::merged(&self.parts)
    }

    /// The result is written.
    pub fn finish(&self, session: &mut Session) {
        if self.parts.added() > 0 {
            session.note(&format!(
                "{} blocks were in no part and were computed now",
                self.parts.added()
            ));
        }
    }
}

fn no_command(header: &PartHeader) -> Failure {
    let line = header.line();
    Failure::failed(format_args!(
        "the parts record a command that has no --shard: {line}"
    ))
}

/// Refuses to write over a part.
fn refuse_part(output: &Path) -> Result<(), Failure> {
    let is_part = File::open(output).is_ok_and(|mut file| {
        file.metadata().is_ok_and(|m| m.is_file() && m.len() > 0)
            && PartHeader::read(&mut file, output).is_ok()
    });
    if is_part {
        return Err(Failure::misuse(format_args!(
            "{} is a part: give another file for the result",
            output.display()
        )));
    }
    Ok(())
}

/// A complete part.
struct CompletePart {
    path: PathBuf,
    header: PartHeader,
    records: RecordFile,
}

/// All parts of one work.
pub struct MergedParts {
    /// The header of the first.
    header: PartHeader,
    /// The part of each shard, in their order.
    parts: Vec<Mutex<RecordFile>>,
    /// The path of each.
    paths: Vec<PathBuf>,
    /// Blocks that were in no part.
    added: AtomicUsize,
    /// Why they do not fit to what was computed here.
    failure: Mutex<Option<Failure>>,
}

impl MergedParts {
    /// Opens parts, checks that they are whole, undamaged and all parts of one work. What is odd but does
    /// no harm is said in notes.
    ///
    /// # Errors
    /// They are not, or some are missing: with the names of the files and what to do.
    pub fn read(paths: &[PathBuf], notes: &mut Vec<String>) -> Result<MergedParts, Failure> {
        let mut by_number: BTreeMap<u32, CompletePart> = BTreeMap::new();
        let mut first: Option<(PathBuf, PartHeader)> = None;
        // The first part stands for the work: all others have to agree with it.
        for path in paths {
            let mut part = CompletePart::open(path)?;
            let (first_path, header) =
                first.get_or_insert_with(|| (path.clone(), part.header.clone()));
            if let Some(difference) = header.difference(&part.header) {
                return Err(Failure::failed(format_args!(
                    "{} does not belong to {}: it {difference}",
                    path.display(),
                    first_path.display()
                )));
            }
            // A shard may be given twice if both copies have the same content.
            match by_number.get_mut(&part.header.shard.number) {
                None => {
                    by_number.insert(part.header.shard.number, part);
                }
                Some(other) => notes.push(part.same_as(other)?),
            }
        }
        let Some((path, header)) = first else {
            return Err(Failure::misuse("no parts are given"));
        };
        // The recorded command is run again on the parts, which another version may do differently.
        if header.version != env!("CARGO_PKG_VERSION") {
            return Err(Failure::failed(format_args!(
                "{} is of version {} of azulejo, and this is {}: merge with the version that computed the parts",
                path.display(),
                header.version,
                env!("CARGO_PKG_VERSION")
            )));
        }
        refuse_gaps(&header, &by_number)?;
        // Keep the parts in the order of their shards, by which blocks are assigned to them.
        let paths = by_number.values().map(|part| part.path.clone()).collect();
        let parts = by_number.into_values().map(|part| Mutex::new(part.records));
        Ok(MergedParts {
            parts: parts.collect(),
            paths,
            header,
            added: AtomicUsize::new(0),
            failure: Mutex::default(),
        })
    }

    /// What the parts say of their work.
    pub fn header(&self) -> &PartHeader {
        &self.header
    }

    /// Number of parts.
    pub fn count(&self) -> usize {
        self.parts.len()
    }

    /// Refuses a work of which these are not parts.
    ///
    /// # Errors
    /// The scene is another, or the engine, or the options.
    pub fn check(&self, key: &WorkKey) -> Result<(), Failure> {
        if self.header.has(key) {
            return Ok(());
        }
        let here = PartHeader {
            scene: crate::content_key::shown(&key.scene),
            settings: crate::content_key::shown(&key.settings),
            engine: key.engine.clone(),
            ..self.header.clone()
        };
        let why = if here.scene != self.header.scene {
            "the model that the recorded command reads here is another: a file that it refers to differs, \
             or lies elsewhere"
                .to_owned()
        } else if here.engine != self.header.engine {
            format!(
                "the parts were computed by the engine {}, and here {} would be chosen, because the memory of the \
                 machines differs: merge with as much memory, or compute the parts with --engine",
                self.header.engine, here.engine
            )
        } else {
            "the processors that computed the parts have other instructions for rays than this one, whose \
             results differ in the last bits: merge on a machine of their kind"
                .to_owned()
        };
        Err(Failure::failed(format_args!("the parts do not fit: {why}")))
    }

    /// The outcome of work that used them: why they do not fit, if that ended it.
    ///
    /// # Errors
    /// Those of the work.
    pub fn used<T>(&self, outcome: Result<T, Failure>) -> Result<T, Failure> {
        let failure = &mut *self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.take().map_or(outcome, Err)
    }

    /// Number of blocks that were in no part and had to be computed.
    pub fn added(&self) -> usize {
        self.added.load(Ordering::Relaxed)
    }
}

/// Refuses parts of which some shards are missing.
fn refuse_gaps(
    header: &PartHeader,
    by_number: &BTreeMap<u32, CompletePart>,
) -> Result<(), Failure> {
    let of = header.shard.of;
    let missing = (1..=of).filter(|number| !by_number.contains_key(number));
    let missing: Vec<u32> = missing.collect();
    let (word, verb) = match missing.len() {
        0 => return Ok(()),
        1 => ("shard", "is"),
        _ => ("shards", "are"),
    };
    Err(Failure::failed(format_args!(
        "{word} {} of {of} {verb} missing: compute them by the same command with their --shard, or give their \
         parts too",
        runs(&missing),
    )))
}

impl CompletePart {
    fn open(path: &Path) -> Result<CompletePart, Failure> {
        let failed = |e| Failure::file("read", path, &e);
        let shown = path.display();
        let mut file = File::open(path).map_err(failed)?;
        if file.metadata().map_err(failed)?.is_dir() {
            return Err(Failure::failed(format_args!(
                "{shown} is a folder, expected a part"
            )));
        }
        let is_in_work = matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock));
        let (header, records) = match PartHeader::read(&mut file, path)? {
            FileStart::Header(header, length) => {
                (header, RecordFile::scan(file, length).map_err(failed)?)
            }
            FileStart::Beginning => {
                return Err(Failure::failed(format_args!(
                    "{shown} is cut off in its header: copy it again, or compute it again"
                )));
            }
        };
        let number = header.shard;
        if is_in_work {
            return Err(Failure::failed(format_args!(
                "{shown} is still being computed, by a process that runs now: shard {number} has {} blocks so far",
                records.len()
            )));
        }
        let mut part = CompletePart {
            path: path.to_owned(),
            header: *header,
            records,
        };
        part.check_content()?;
        Ok(part)
    }

    /// Refuses a part that is not whole, or in which bytes have changed.
    fn check_content(&mut self) -> Result<(), Failure> {
        let (shown, number) = (self.path.display(), self.header.shard);
        let rest = self.records.rest();
        let rest = rest.map_err(|e| Failure::file("read", &self.path, &e))?;
        if !self.records.is_ended() {
            let more = match rest {
                0 => String::new(),
                rest => format!(", and {rest} bytes that are not a block"),
            };
            return Err(Failure::failed(format_args!(
                "{shown} is not complete: it has {} blocks of shard {number}{more}, and no end. It was interrupted, \
                 is still being computed elsewhere, or was cut off or damaged; to resume it, run in {}\n  {}",
                self.records.len(),
                self.header.folder,
                self.header.line()
            )));
        }
        if rest > 0 {
            return Err(Failure::failed(format_args!(
                "{shown} is damaged: {rest} bytes follow its end; copy it again, or compute shard {number} \
                 again"
            )));
        }
        let blocks: Vec<_> = self.records.blocks().collect();
        for id in blocks {
            if self.records.read(id).is_none() {
                return Err(Failure::failed(format_args!(
                    "{shown} is damaged: the checksum of a block is wrong; copy it again, or remove it and compute \
                     shard {number} again"
                )));
            }
        }
        Ok(())
    }

    /// A note that this is the same part as another.
    ///
    /// # Errors
    /// It is the same shard with other content.
    fn same_as(&mut self, other: &mut CompletePart) -> Result<String, Failure> {
        let blocks: Vec<_> = self.records.blocks().collect();
        let same = blocks.len() == other.records.len()
            && blocks
                .iter()
                .all(|&id| self.records.read(id) == other.records.read(id));
        let (this, that) = (self.path.display(), other.path.display());
        let shard = self.header.shard;
        if same {
            return Ok(format!(
                "{that} and {this} are both shard {shard}, with the same content: one of them is used"
            ));
        }
        Err(Failure::failed(format_args!(
            "{that} and {this} are both shard {shard}, and their content differs: compute that shard again"
        )))
    }
}

impl Blocks for MergedParts {
    fn role(&self) -> RunRole {
        RunRole {
            parts: self.parts.len(),
            is_kept: true,
            ..RunRole::default()
        }
    }

    fn load(&self, stage: RunStage, block: usize) -> Option<Vec<u8>> {
        let part = &self.parts[block % self.parts.len()];
        let mut records = part.lock().unwrap_or_else(PoisonError::into_inner);
        records.read((stage, block))
    }

    fn save(&self, _: RunStage, _: usize, _: &[u8]) {
        self.added.fetch_add(1, Ordering::Relaxed);
    }

    fn rely_on(&self, stage: RunStage, digest: u64) -> Result<(), Cancelled> {
        let bytes = digest.to_le_bytes();
        for (part, path) in self.parts.iter().zip(&self.paths) {
            let mut records = part.lock().unwrap_or_else(PoisonError::into_inner);
            if records
                .read((stage, BASIS))
                .is_some_and(|known| known == bytes)
            {
                continue;
            }
            let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
            *failure = Some(Failure::failed(format_args!(
                "{} was computed on a machine that computes the light between patches, or the places of texels, \
                 otherwise than this one, because of its memory or its processor: give the same --memory to all, or \
                 merge on a machine of that kind",
                path.display()
            )));
            return Err(Cancelled);
        }
        Ok(())
    }
}

/// Numbers with runs joined: `3, 7–12`.
fn runs(numbers: &[u32]) -> String {
    let mut words: Vec<String> = Vec::new();
    for run in numbers.chunk_by(|a, b| a + 1 == *b) {
        words.push(match run {
            [first, .., last] if run.len() > 2 => format!("{first}–{last}"),
            run => run
                .iter()
                .map(u32::to_string)
                .collect::<Vec<_>>()
                .join(", "),
        });
    }
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_numbers_are_joined() {
        let check = |numbers: &[u32], want: &str| assert_eq!(runs(numbers), want);
        check(&[3, 7, 8, 9, 10, 11, 12], "3, 7–12");
        check(&[1, 2], "1, 2");
        check(&[64], "64");
        check(&[], "");
    }
}
