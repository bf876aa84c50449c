//! Messages between rank 0 and the others, as bytes.

use super::link::HandedBlock;
use crate::runner::record_file::{number_of, stage_of};
use azulejo_trace::RunStage;
use azulejo_trace::run::{Record, RecordReader, write_list};

/// From another rank to rank 0.
#[derive(Clone, Debug, PartialEq)]
pub enum ToRoot {
    /// Is done with its blocks, and asks for at most so many of a stage, of `items` in blocks of `size`, not
    /// before block `from`.
    Next {
        stage: RunStage,
        items: usize,
        size: usize,
        from: usize,
        most: usize,
    },
    /// A finished block.
    Block {
        stage: RunStage,
        block: usize,
        bytes: Vec<u8>,
    },
    /// Is ready for an exchange between all.
    Ready,
    /// Has to end behind its block.
    Stopping,
    /// Its work is done; why it failed, if it did.
    Ended(Option<String>),
}

/// From rank 0 to another.
#[derive(Clone, Debug, PartialEq)]
pub enum FromRoot {
    /// Blocks to be computed, or known already; none if there are no more.
    Handed(Vec<HandedBlock>),
    /// All are ready.
    Go,
    /// The work ends.
    Stop,
    /// All have ended, and rank 0 with this exit status.
    Finish(u8),
}

impl ToRoot {
    /// Its bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        match self {
            ToRoot::Next {
                stage,
                items,
                size,
                from,
                most,
            } => {
                0u8.write(&mut bytes);
                number_of(*stage).write(&mut bytes);
                [items, size, from, most]
                    .map(|n| *n as u64)
                    .write(&mut bytes);
            }
            ToRoot::Block {
                stage,
                block,
                bytes: content,
            } => {
                1u8.write(&mut bytes);
                number_of(*stage).write(&mut bytes);
                (*block as u64).write(&mut bytes);
                bytes.extend(content);
            }
            ToRoot::Ready => 2u8.write(&mut bytes),
            ToRoot::Stopping => 3u8.write(&mut bytes),
            ToRoot::Ended(why) => {
                4u8.write(&mut bytes);
                u8::from(why.is_some()).write(&mut bytes);
                bytes.extend(why.as_deref().unwrap_or_default().as_bytes());
            }
        }
        bytes
    }

    /// The inverse of [`bytes`](ToRoot::bytes).
    pub fn read(bytes: &[u8]) -> Option<ToRoot> {
        let mut reader = RecordReader::new(bytes);
        let message = match u8::read(&mut reader)? {
            0 => {
                let stage = stage_of(reader.u32()?)?;
                let [items, size, from, most] = <[u64; 4]>::read(&mut reader)?.map(|n| n as usize);
                ToRoot::Next {
                    stage,
                    items,
                    size,
                    from,
                    most,
                }
            }
            1 => ToRoot::Block {
                stage: stage_of(reader.u32()?)?,
                block: reader.u64()? as usize,
                bytes: reader.rest().to_vec(),
            },
            2 => ToRoot::Ready,
            3 => ToRoot::Stopping,
            4 => {
                let has_failed = u8::read(&mut reader)? == 1;
                let why = String::from_utf8_lossy(reader.rest()).into_owned();
                ToRoot::Ended(has_failed.then_some(why))
            }
            _ => return None,
        };
        Some(message)
    }
}

impl FromRoot {
    /// Its bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        match self {
            FromRoot::Handed(blocks) => {
                0u8.write(&mut bytes);
                write_list(blocks, &mut bytes, |(block, known), bytes| {
                    (*block as u64).write(bytes);
                    known.write(bytes);
                });
            }
            FromRoot::Go => 1u8.write(&mut bytes),
            FromRoot::Stop => 2u8.write(&mut bytes),
            FromRoot::Finish(status) => [3u8, *status].write(&mut bytes),
        }
        bytes
    }

    /// The inverse of [`bytes`](FromRoot::bytes).
    pub fn read(bytes: &[u8]) -> Option<FromRoot> {
        let mut reader = RecordReader::new(bytes);
        let message = match u8::read(&mut reader)? {
            0 => {
                let handed = |reader: &mut RecordReader| {
                    Some((reader.u64()? as usize, Option::<Vec<u8>>::read(reader)?))
                };
                FromRoot::Handed(reader.list(handed)?)
            }
            1 => FromRoot::Go,
            2 => FromRoot::Stop,
            3 => FromRoot::Finish(u8::read(&mut reader)?),
            _ => return None,
        };
        Some(message)
    }
}
