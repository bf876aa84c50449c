//! The connection of the thread that works with the thread that talks to other ranks, and the messages of the latter,
//! as bytes.

use crate::runner::journal::FileJournal;
use crate::runner::record_file::{number_of, stage_of};
use azulejo_trace::run::Division;
use azulejo_trace::{Cancelled, RunStage};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// What the work asks for.
pub enum Request {
    /// Blocks that no rank has yet, this many at most.
    Next {
        stage: RunStage,
        division: Division,
        left: Range<usize>,
        most: usize,
    },
    /// A finished block for rank 0, from another.
    Deliver {
        stage: RunStage,
        block: usize,
        bytes: Vec<u8>,
    },
    /// At rank 0, the blocks that others computed, as soon as they have all.
    Collect(RunStage),
    /// The bytes of all ranks.
    AllGather(Vec<u8>),
    /// The bytes of rank 0.
    Broadcast(Vec<u8>),
    /// At rank 0, from now on blocks are kept in a file.
    Keep(Arc<FileJournal>),
    /// The work has ended; why it failed, if it did, and with which exit status.
    Ended(Option<String>, u8),
}

/// A block with its bytes.
pub type FinishedBlock = (usize, Vec<u8>);

/// A block that rank 0 hands out, with its bytes if they are known already.
pub type HandedBlock = (usize, Option<Vec<u8>>);

/// What it gets.
pub enum Reply {
    /// Blocks, ascending; none if there are no more.
    Handed(Vec<HandedBlock>),
    /// Blocks of others.
    Collected(Vec<FinishedBlock>),
    /// One for each rank.
    Gathered(Vec<Vec<u8>>),
    /// What rank 0 sent.
    Broadcast(Vec<u8>),
    /// The work is to end.
    Stop,
}

/// The end of the thread that works. Clones share one connection, on which one request at a time is made.
#[derive(Clone, Debug)]
pub struct Link(Arc<Mutex<LinkEnds>>);

#[derive(Debug)]
struct LinkEnds {
    requests: Sender<Request>,
    replies: Receiver<Reply>,
    traffic: Traffic,
    /// When the work was handed the blocks that it computes now.
    handed: Option<Instant>,
}

/// What a rank exchanges with others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traffic {
    /// Bytes that it gave: finished blocks, and its part of what all exchanged.
    pub given: u64,
    /// Bytes that all ranks together gave in exchanges between all, which each of them received.
    pub gathered: u64,
    /// Exchanges between all.
    pub exchanges: u64,
    /// Blocks that it computed.
    pub blocks: u64,
    /// Seconds in which its work waited.
    pub waited: f64,
    /// Seconds in which its work was busy with blocks.
    pub divided: f64,
}

/// The end of the thread that talks to other ranks.
pub struct WorkEnd {
    pub requests: Receiver<Request>,
    pub replies: Sender<Reply>,
}

/// Both ends.
pub fn connected() -> (Link, WorkEnd) {
    let ((requests, request_queue), (replies, reply_queue)) = (channel(), channel());
    let link = Link(Arc::new(Mutex::new(LinkEnds {
        requests,
        replies: reply_queue,
        traffic: Traffic::default(),
        handed: None,
    })));
    let end = WorkEnd {
        requests: request_queue,
        replies,
    };
    (link, end)
}

impl Link {
    /// The next blocks for this rank, at most this many, with their bytes if they are known already.
    pub fn next(
        &self,
        stage: RunStage,
        division: Division,
        left: Range<usize>,
        most: usize,
    ) -> Result<Vec<HandedBlock>, Cancelled> {
        match self.ask(Request::Next {
            stage,
            division,
            left,
            most,
        })? {
            Reply::Handed(blocks) => Ok(blocks),
            _ => Err(Cancelled),
        }
    }

    /// Gives a block to rank 0, which is another.
    pub fn deliver(&self, stage: RunStage, block: usize, bytes: &[u8]) {
        let bytes = bytes.to_vec();
        self.say(Request::Deliver {
            stage,
            block,
            bytes,
        });
    }

    /// The blocks of a stage that other ranks computed, at rank 0.
    pub fn collect(&self, stage: RunStage) -> Result<Vec<FinishedBlock>, Cancelled> {
        match self.ask(Request::Collect(stage))? {
            Reply::Collected(blocks) => Ok(blocks),
            _ => Err(Cancelled),
        }
    }

    /// The bytes that each rank gives.
    pub fn all_gather(&self, own: Vec<u8>) -> Result<Vec<Vec<u8>>, Cancelled> {
        match self.ask(Request::AllGather(own))? {
            Reply::Gathered(all) => Ok(all),
            _ => Err(Cancelled),
        }
    }

    /// The bytes that rank 0 gives.
    pub fn broadcast(&self, own: Vec<u8>) -> Result<Vec<u8>, Cancelled> {
        match self.ask(Request::Broadcast(own))? {
            Reply::Broadcast(bytes) => Ok(bytes),
            _ => Err(Cancelled),
        }
    }

    /// Keeps blocks in a file, at rank 0.
    pub fn keep(&self, journal: Arc<FileJournal>) {
        self.say(Request::Keep(journal));
    }

    /// Says that the work has ended.
    pub fn end(&self, failure: Option<String>, status: u8) {
        self.say(Request::Ended(failure, status));
    }

    /// What it has exchanged so far.
    pub fn traffic(&self) -> Traffic {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .traffic
    }

    /// Asks and waits. If there is nobody to ask, the work ends.
    fn ask(&self, request: Request) -> Result<Reply, Cancelled> {
        let mut ends = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let start = Instant::now();
        if let Some(handed) = ends.handed.take() {
            ends.traffic.divided += start.duration_since(handed).as_secs_f64();
        }
        ends.traffic.given += request.size();
        ends.requests.send(request).map_err(|_| Cancelled)?;
        let reply = ends.replies.recv();
        let LinkEnds {
            traffic, handed, ..
        } = &mut *ends;
        traffic.waited += start.elapsed().as_secs_f64();
        match reply {
            Ok(Reply::Stop) | Err(_) => return Err(Cancelled),
            Ok(Reply::Handed(ref blocks)) if !blocks.is_empty() => {
                traffic.blocks += blocks.len() as u64;
                *handed = Some(Instant::now());
            }
            Ok(Reply::Gathered(ref all)) => {
                traffic.exchanges += 1;
                traffic.gathered += all.iter().map(|bytes| bytes.len() as u64).sum::<u64>();
            }
            Ok(_) => {}
        }
        reply.map_err(|_| Cancelled)
    }

    fn say(&self, request: Request) {
        let mut ends = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        ends.traffic.given += request.size();
        // If there is nobody to tell, the work ends at its next question.
        let _ = ends.requests.send(request);
    }
}

impl Request {
    /// Bytes that it gives to others.
    fn size(&self) -> u64 {
        match self {
            Request::Deliver { bytes, .. } | Request::AllGather(bytes) => bytes.len() as u64,
            _ => 0,
        }
    }

    /// As a message to rank 0; `None` for what ranks do together or by themselves.
    pub fn message(&self) -> Option<ToRoot> {
        match self {
            Request::Next {
                stage,
                division,
                left,
                most,
            } => Some(ToRoot::Next {
                stage: *stage,
                items: division.items,
                size: division.size,
                from: left.start,
                most: *most,
            }),
            Request::Deliver {
                stage,
                block,
                bytes,
            } => Some(ToRoot::Block {
                stage: *stage,
                block: *block,
                bytes: bytes.clone(),
            }),
            _ => None,
        }
    }
}

/// From another rank to rank 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ToRoot {
    /// Is done with its blocks, and asks for at most this many of a stage, of `items` in blocks of `size`, not
    /// before block `from`.
    Next {
        #[serde(with = "stage_number")]
        stage: RunStage,
        items: usize,
        size: usize,
        from: usize,
        most: usize,
    },
    /// A finished block.
    Block {
        #[serde(with = "stage_number")]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

/// The bytes of a message.
fn bytes_of(message: &impl Serialize) -> Vec<u8> {
    // Writing to memory does not fail.
    postcard::to_allocvec(message).unwrap_or_default()
}

/// The message that has these bytes, all of them.
fn message_of<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Option<T> {
    let (message, rest) = postcard::take_from_bytes(bytes).ok()?;
    rest.is_empty().then_some(message)
}

impl ToRoot {
    /// Its bytes.
    pub fn bytes(&self) -> Vec<u8> {
        bytes_of(self)
    }

    /// The inverse of [`bytes`](ToRoot::bytes).
    pub fn read(bytes: &[u8]) -> Option<ToRoot> {
        message_of(bytes)
    }
}

impl FromRoot {
    /// Its bytes.
    pub fn bytes(&self) -> Vec<u8> {
        bytes_of(self)
    }

    /// The inverse of [`bytes`](FromRoot::bytes).
    pub fn read(bytes: &[u8]) -> Option<FromRoot> {
        message_of(bytes)
    }
}

/// Stages in messages, as numbers.
mod stage_number {
    use super::{RunStage, number_of, stage_of};
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(stage: &RunStage, to: S) -> Result<S::Ok, S::Error> {
        number_of(*stage).serialize(to)
    }

    pub fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<RunStage, D::Error> {
        let stage = stage_of(u32::deserialize(from)?);
        stage.ok_or_else(|| D::Error::custom("a stage that does not exist"))
    }
}
