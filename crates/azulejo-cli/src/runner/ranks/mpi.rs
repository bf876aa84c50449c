//! Ranks by MPI, through rsmpi.

use super::link::{Link, connected};
use super::messenger::{self, Control, Transport};
use super::{Ranks, inputs};
use crate::failure::Failure;
use mpi::collective::Root;
use mpi::datatype::PartitionMut;
use mpi::environment::processor_name;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Destination, MatchedReceiveVec, Source};
use mpi::{Count, Threading};
use std::path::PathBuf;
use std::thread;

/// Most bytes of one call: MPI counts by `i32`.
const MOST_BYTES: usize = 1 << 28;

/// Stack of the thread that works, as main threads have it.
const STACK: usize = 8 << 20;

/// Runs a command by all ranks.
///
/// # Errors
/// Those of the command, or of another rank; MPI does not start.
pub fn launch<C: Send + 'static>(
    mut command: C,
    files: fn(&mut C) -> Vec<&mut PathBuf>,
    work: impl FnOnce(C, Option<Ranks>) -> Result<(), Failure> + Send + 'static,
) -> Result<(), Failure> {
    let (universe, _) = mpi::initialize_with_threading(Threading::Funneled)
        .ok_or_else(|| Failure::failed("MPI does not start: it was started already"))?;
    let world = MpiTransport(universe.world());
    if world.size() < 2 {
        return work(command, None);
    }
    let (link, end) = connected();
    let (mut ranks, is_near) = place(&world, link.clone());
    let (rank, control) = (ranks.rank, ranks.control.clone());
    let worker = move || {
        let outcome = if ranks.is_root() {
            work(command, Some(ranks))
        } else {
            inputs::receive(&link, rank, is_near, files(&mut command)).and_then(|received| {
                ranks.memory = received.memory;
                work(command, Some(ranks))
            })
        };
        let why = match &outcome {
            Ok(()) => None,
            Err(Failure::Cancelled | Failure::BrokenPipe) => Some(String::new()),
            Err(failure) => Some(failure.to_string()),
        };
        link.end(why, outcome.as_ref().map_or_else(Failure::status, |()| 0));
        outcome
    };
    let thread = thread::Builder::new().stack_size(STACK).spawn(worker);
    let thread = thread.map_err(|e| Failure::failed(format_args!("cannot start a thread: {e}")))?;
    let (status, of_others) = messenger::serve(&world, &end, &control);
    let panicked = |_| {
        Err(Failure::failed(format_args!(
            "rank {rank} ended unexpectedly"
        )))
    };
    let outcome = thread.join().unwrap_or_else(panicked);
    drop(universe);
    match (outcome, of_others) {
        (Err(Failure::Cancelled), Some(why)) => Err(Failure::failed(why)),
        // The launcher takes the exit status of the first rank that ends: all have that of rank 0.
        (Err(Failure::Cancelled), None) if status == 2 => {
            Err(Failure::misuse("rank 0 was misused"))
        }
        (outcome, _) => outcome,
    }
}

/// This rank among all, and whether it is on the machine of rank 0.
fn place(world: &MpiTransport, link: Link) -> (Ranks, bool) {
    let own = processor_name().unwrap_or_default();
    let nodes = world.all_gather(own.as_bytes());
    let beside = nodes.iter().filter(|node| *node == own.as_bytes()).count();
    let mut names = nodes.clone();
    names.sort_unstable();
    names.dedup();
    let ranks = Ranks {
        link,
        rank: world.rank(),
        size: world.size(),
        nodes: names.len(),
        threads: super::threads(beside),
        memory: azulejo::machine::memory(),
        control: Control::default(),
    };
    let is_near = nodes[0] == own.as_bytes();
    (ranks, is_near)
}

/// All processes of MPI.
struct MpiTransport(SimpleCommunicator);

impl Transport for MpiTransport {
    fn rank(&self) -> usize {
        self.0.rank() as usize
    }

    fn size(&self) -> usize {
        self.0.size() as usize
    }

    fn send(&self, to: usize, bytes: &[u8]) {
        self.0.process_at_rank(to as i32).send(bytes);
    }

    fn receive(&self) -> Option<(usize, Vec<u8>)> {
        let message = self.0.any_process().immediate_matched_probe()?;
        let (bytes, status) = message.matched_receive_vec::<u8>();
        Some((status.source_rank() as usize, bytes))
    }

    fn all_gather(&self, own: &[u8]) -> Vec<Vec<u8>> {
        let size = self.size();
        let mut lengths = vec![0u64; size];
        self.0
            .all_gather_into(&(own.len() as u64), &mut lengths[..]);
        let mut gathered: Vec<Vec<u8>> = lengths
            .iter()
            .map(|&length| Vec::with_capacity(length as usize))
            .collect();
        // As many bytes of each at once as one call can take of all.
        let share = (MOST_BYTES / size).max(1);
        let longest = lengths.iter().max().map_or(0, |&length| length as usize);
        for start in (0..longest).step_by(share) {
            let part = |length: usize| length.min(start + share).saturating_sub(start);
            let counts: Vec<Count> = lengths.iter().map(|&l| part(l as usize) as Count).collect();
            let places: Vec<Count> = counts
                .iter()
                .scan(0, |place, count| {
                    let at = *place;
                    *place += count;
                    Some(at)
                })
                .collect();
            let mut received = vec![0u8; counts.iter().map(|&c| c as usize).sum()];
            let from = start.min(own.len());
            let sent = &own[from..from + part(own.len())];
            let mut partition = PartitionMut::new(&mut received[..], &counts[..], &places[..]);
            self.0.all_gather_varcount_into(sent, &mut partition);
            for ((bytes, &at), &count) in gathered.iter_mut().zip(&places).zip(&counts) {
                bytes.extend(&received[at as usize..(at + count) as usize]);
            }
        }
        gathered
    }

    fn broadcast(&self, own: Vec<u8>) -> Vec<u8> {
        let root = self.0.process_at_rank(0);
        let mut length = own.len() as u64;
        root.broadcast_into(&mut length);
        let mut bytes = own;
        bytes.resize(length as usize, 0);
        for part in bytes.chunks_mut(MOST_BYTES) {
            root.broadcast_into(part);
        }
        bytes
    }
}
