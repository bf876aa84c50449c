//! The main thread of a rank: the messages of its work to other ranks, and at rank 0 the answers.

use super::link::{FinishedBlock, FromRoot, Reply, Request, ToRoot, WorkEnd};
use crate::interrupt::BlockEnd;
use crate::runner::journal::FileJournal;
use azulejo_trace::run::{Division, guided_share};
use azulejo_trace::{Blocks, Progress, RunStage};
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, TryRecvError};
use std::time::Duration;

/// Pause after which a rank looks for messages again: from the first while messages come, doubled up to
/// the second while none do. A rank waits for two of them whenever it asks for blocks of some milliseconds;
/// looking so often takes a few hundredths of a processor.
const PAUSE: [Duration; 2] = [Duration::from_micros(20), Duration::from_micros(200)];

/// The same of a rank whose work is done.
const IDLE: Duration = Duration::from_millis(20);

/// Messages between ranks. Used by one thread of each.
pub trait Transport {
    /// Number of this rank.
    fn rank(&self) -> usize;

    /// Number of all.
    fn size(&self) -> usize;

    /// Sends bytes to a rank. Those to one rank arrive in their order.
    fn send(&self, to: usize, bytes: &[u8]);

    /// The next message that has arrived, with the rank that sent it; `None` if there is none yet.
    fn receive(&self) -> Option<(usize, Vec<u8>)>;

    /// The bytes of all ranks, in their order. All ranks call it.
    fn all_gather(&self, own: &[u8]) -> Vec<Vec<u8>>;

    /// The bytes of rank 0. All ranks call it; `own` counts at rank 0.
    fn broadcast(&self, own: Vec<u8>) -> Vec<u8>;
}

/// What is common to the work and its messages.
#[derive(Clone, Debug, Default)]
pub struct Control {
    /// Whether the work is to end behind its block.
    pub block_end: Arc<BlockEnd>,
    /// Shows, at rank 0, what all have done.
    pub progress: Arc<Progress>,
}

/// Serves the work of this rank until all ranks have ended. The exit status of rank 0 and, there, what the
/// first of the others that failed says of it.
pub fn serve(transport: &dyn Transport, work: &WorkEnd, control: &Control) -> (u8, Option<String>) {
    if transport.rank() == 0 {
        return Root::new(transport, work, control).serve();
    }
    let helper = Helper {
        transport,
        work,
        control,
    };
    (helper.serve(), None)
}

/// Waits between looks.
struct Patience(Duration);

impl Patience {
    fn new() -> Patience {
        Patience(PAUSE[0])
    }

    fn wait(&mut self) {
        std::thread::sleep(self.0);
        self.0 = (self.0 * 2).min(PAUSE[1]);
    }
}

/// A rank other than 0.
struct Helper<'a> {
    transport: &'a dyn Transport,
    work: &'a WorkEnd,
    control: &'a Control,
}

impl Helper<'_> {
    fn serve(&self) -> u8 {
        loop {
            // A work that ended without a word has panicked.
            let lost = || Request::Ended(Some("the work ended unexpectedly".to_owned()), 1);
            let request = self.work.requests.recv().unwrap_or_else(|_| lost());
            if let Request::Ended(why, _) = request {
                self.tell(&ToRoot::Ended(why));
                loop {
                    match self.transport.receive().and_then(from_root) {
                        Some(FromRoot::Finish(status)) => return status,
                        _ => std::thread::sleep(IDLE),
                    }
                }
            }
            let reply = match &request {
                Request::Next { .. } => {
                    request.message().iter().for_each(|m| self.tell(m));
                    match self.answer() {
                        FromRoot::Handed(blocks) => Reply::Handed(blocks),
                        _ => Reply::Stop,
                    }
                }
                Request::Deliver { .. } => {
                    request.message().iter().for_each(|m| self.tell(m));
                    continue;
                }
                Request::AllGather(own) => match self.ready() {
                    FromRoot::Go => Reply::Gathered(self.transport.all_gather(own)),
                    _ => Reply::Stop,
                },
                Request::Broadcast(_) => match self.ready() {
                    FromRoot::Go => Reply::Broadcast(self.transport.broadcast(Vec::new())),
                    _ => Reply::Stop,
                },
                Request::Collect(_) => Reply::Collected(Vec::new()),
                Request::Keep(_) | Request::Ended(..) => continue,
            };
            // Nobody waits for it if the work has panicked, which the next round finds out.
            let _ = self.work.replies.send(reply);
        }
    }

    fn tell(&self, message: &ToRoot) {
        self.transport.send(0, &message.bytes());
    }

    fn ready(&self) -> FromRoot {
        self.tell(&ToRoot::Ready);
        self.answer()
    }

    /// The next message of rank 0.
    fn answer(&self) -> FromRoot {
        let mut patience = Patience::new();
        let mut has_told = false;
        loop {
            if let Some(message) = self.transport.receive().and_then(from_root) {
                return message;
            }
            if self.control.block_end.is_asked() && !has_told {
                self.tell(&ToRoot::Stopping);
                has_told = true;
            }
            patience.wait();
        }
    }
}

fn from_root((_, bytes): (usize, Vec<u8>)) -> Option<FromRoot> {
    FromRoot::read(&bytes)
}

/// What a rank waits for.
#[derive(Clone, Copy, PartialEq)]
enum State {
    /// It works.
    Working,
    /// For all others.
    Ready,
    /// For nothing any more.
    Ended,
}

/// Blocks of a stage.
#[derive(Default)]
struct StageBlocks {
    /// The first block that nobody has.
    next: usize,
    /// Blocks that each of the others has and has not delivered.
    out: HashMap<usize, Vec<usize>>,
    /// Blocks that others delivered and no file keeps.
    delivered: Vec<FinishedBlock>,
}

/// What the work of rank 0 waits for.
enum Pending {
    Collect(RunStage),
    AllGather(Vec<u8>),
    Broadcast(Vec<u8>),
}

/// Rank 0.
struct Root<'a> {
    transport: &'a dyn Transport,
    work: &'a WorkEnd,
    control: &'a Control,
    /// One for each rank, its own among them.
    states: Vec<State>,
    stages: HashMap<RunStage, StageBlocks>,
    journal: Option<Arc<FileJournal>>,
    pending: Option<Pending>,
    is_stopping: bool,
    /// What the first of the others that failed says of it.
    failure: Option<String>,
    /// The exit status of its own work.
    status: u8,
}

impl<'a> Root<'a> {
    fn new(transport: &'a dyn Transport, work: &'a WorkEnd, control: &'a Control) -> Root<'a> {
        Root {
            transport,
            work,
            control,
            states: vec![State::Working; transport.size()],
            stages: HashMap::new(),
            journal: None,
            pending: None,
            is_stopping: false,
            failure: None,
            status: 1,
        }
    }

    fn serve(mut self) -> (u8, Option<String>) {
        let mut pause = PAUSE[0];
        while self.states.iter().any(|state| *state != State::Ended) {
            let own = self.own_request(pause);
            let others = self.messages();
            pause = if own || others {
                PAUSE[0]
            } else {
                (pause * 2).min(PAUSE[1])
            };
            self.is_stopping |= self.control.block_end.is_asked();
            self.answer_waiting();
        }
        for rank in 1..self.states.len() {
            self.tell(rank, &FromRoot::Finish(self.status));
        }
        (self.status, self.failure)
    }

    /// Takes what its own work asks for, waiting so long for it; whether there was something.
    fn own_request(&mut self, pause: Duration) -> bool {
        let request = match self.states[0] {
            State::Working if self.pending.is_none() => {
                match self.work.requests.recv_timeout(pause) {
                    Ok(request) => Ok(request),
                    Err(RecvTimeoutError::Timeout) => Err(TryRecvError::Empty),
                    Err(RecvTimeoutError::Disconnected) => Err(TryRecvError::Disconnected),
                }
            }
            _ => {
                std::thread::sleep(pause);
                return false;
            }
        };
        match request {
            Err(TryRecvError::Empty) => return false,
            Err(TryRecvError::Disconnected) => self.ended(0, Some(String::new())),
            Ok(request) => self.own(request),
        }
        true
    }

    fn own(&mut self, request: Request) {
        match request {
            Request::Next {
                stage,
                division,
                left,
                most,
            } => {
                let blocks = self.next(stage, division, left.start, most);
                self.reply(if self.is_stopping {
                    Reply::Stop
                } else {
                    // Its own journal has what is known.
                    Reply::Handed(blocks.into_iter().map(|block| (block, None)).collect())
                });
            }
            Request::Deliver { .. } => {}
            Request::Keep(journal) => self.journal = Some(journal),
            Request::Collect(stage) => self.pending = Some(Pending::Collect(stage)),
            Request::AllGather(own) => {
                self.pending = Some(Pending::AllGather(own));
                self.states[0] = State::Ready;
            }
            Request::Broadcast(own) => {
                self.pending = Some(Pending::Broadcast(own));
                self.states[0] = State::Ready;
            }
            Request::Ended(why, status) => {
                self.status = status;
                self.ended(0, why);
            }
        }
    }

    /// Takes all messages that have arrived; whether there were some.
    fn messages(&mut self) -> bool {
        let mut any = false;
        while let Some((rank, bytes)) = self.transport.receive() {
            any = true;
            match ToRoot::read(&bytes) {
                Some(message) => self.message(rank, message),
                None => self.ended(rank, Some("sent what is not a message".to_owned())),
            }
        }
        any
    }

    fn message(&mut self, rank: usize, message: ToRoot) {
        match message {
            ToRoot::Next {
                stage,
                items,
                size,
                from,
                most,
            } => {
                let division = Division {
                    items,
                    size,
                    parts: 1,
                };
                self.finished(stage, rank, division);
                if self.is_stopping {
                    return self.tell(rank, &FromRoot::Stop);
                }
                let blocks = self.next(stage, division, from, most);
                let known = |block: usize| self.journal.as_deref()?.load(stage, block);
                let handed = blocks.iter().map(|&block| (block, known(block))).collect();
                self.stages
                    .entry(stage)
                    .or_default()
                    .out
                    .insert(rank, blocks);
                self.tell(rank, &FromRoot::Handed(handed));
            }
            ToRoot::Block {
                stage,
                block,
                bytes,
            } => self.delivered(stage, block, bytes),
            ToRoot::Ready => self.states[rank] = State::Ready,
            ToRoot::Stopping => self.is_stopping = true,
            ToRoot::Ended(why) => self.ended(rank, why),
        }
    }

    /// The next blocks of a stage that nobody has, at most this many, and fewer toward the end.
    fn next(
        &mut self,
        stage: RunStage,
        division: Division,
        from: usize,
        most: usize,
    ) -> Vec<usize> {
        let stage = self.stages.entry(stage).or_default();
        let (first, blocks) = (stage.next.max(from), division.blocks());
        let left = blocks.saturating_sub(first);
        let end = first + guided_share(left, self.states.len(), most);
        stage.next = stage.next.max(end);
        (first..end).collect()
    }

    /// Who asks for more has done with the last blocks.
    fn finished(&mut self, stage: RunStage, rank: usize, division: Division) {
        let stage = self.stages.entry(stage).or_default();
        for block in stage.out.remove(&rank).unwrap_or_default() {
            let items = division.of(block).count() as u64;
            // Cancellation ends its own work, which says so.
            let _ = self.control.progress.advance(items);
        }
    }

    fn delivered(&mut self, stage: RunStage, block: usize, bytes: Vec<u8>) {
        if let Some(journal) = &self.journal {
            if !journal.has(stage, block) {
                journal.save(stage, block, &bytes);
            }
            if journal.has(stage, block) {
                return;
            }
        }
        let stage = self.stages.entry(stage).or_default();
        stage.delivered.push((block, bytes));
    }

    fn ended(&mut self, rank: usize, why: Option<String>) {
        self.states[rank] = State::Ended;
        if rank == 0 {
            self.pending = None;
        }
        let Some(why) = why else {
            return;
        };
        self.is_stopping = true;
        // Those that end because others do have nothing to say.
        if rank > 0 && !why.is_empty() && self.failure.is_none() {
            self.failure = Some(format!("rank {rank}: {why}"));
        }
    }

    /// Answers those that wait for others, if these are there, or if the work ends.
    fn answer_waiting(&mut self) {
        let can_meet = self.states.iter().all(|state| *state == State::Ready);
        let is_alone = self.states.contains(&State::Ready) && self.states.contains(&State::Ended);
        // A rank that waits for all others would wait forever once one of them has ended, so all stop.
        if self.is_stopping || is_alone {
            self.is_stopping = true;
            for rank in 1..self.states.len() {
                if self.states[rank] == State::Ready {
                    self.states[rank] = State::Working;
                    self.tell(rank, &FromRoot::Stop);
                }
            }
            if self.pending.take().is_some() {
                self.states[0] = State::Working;
                self.reply(Reply::Stop);
            }
            return;
        }
        // All are ready for the same exchange: release the others, and take part in it for rank 0.
        if can_meet {
            self.states.fill(State::Working);
            for rank in 1..self.states.len() {
                self.tell(rank, &FromRoot::Go);
            }
            match self.pending.take() {
                Some(Pending::AllGather(own)) => {
                    let gathered = self.transport.all_gather(&own);
                    self.reply(Reply::Gathered(gathered));
                }
                Some(Pending::Broadcast(own)) => {
                    let bytes = self.transport.broadcast(own);
                    self.reply(Reply::Broadcast(bytes));
                }
                _ => {}
            }
            return;
        }
        // Rank 0 goes on with a stage when the others are done with all blocks that they were handed.
        if let Some(Pending::Collect(stage)) = self.pending {
            let queue = self.stages.entry(stage).or_default();
            if queue.out.values().all(Vec::is_empty) {
                let delivered = std::mem::take(&mut queue.delivered);
                self.pending = None;
                self.reply(Reply::Collected(delivered));
            }
        }
    }

    fn reply(&self, reply: Reply) {
        // Nobody waits for it if the work has panicked, which the next look finds out.
        let _ = self.work.replies.send(reply);
    }

    fn tell(&self, rank: usize, message: &FromRoot) {
        self.transport.send(rank, &message.bytes());
    }
}
