//! The messages between ranks, with threads in place of processes.

use super::Ranks;
use super::blocks::RankBlocks;
use super::link::{FromRoot, ToRoot, connected};
use super::messenger::{self, Control, Transport};
use crate::runner::Sharing;
use crate::runner::journal::FileJournal;
use azulejo_trace::run::LoopSize;
use azulejo_trace::{Blocks, Cancelled, Progress, Run, RunStage};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Barrier, Mutex};
use std::thread;

/// Messages to a rank, with the rank that sent each.
type Mail = VecDeque<(usize, Vec<u8>)>;

/// Mail of all ranks.
struct Post {
    boxes: Vec<Mutex<Mail>>,
    table: Mutex<Vec<Vec<u8>>>,
    barrier: Barrier,
}

/// A rank of several threads.
struct ThreadTransport {
    post: Arc<Post>,
    rank: usize,
}

impl Transport for ThreadTransport {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.post.boxes.len()
    }

    fn send(&self, to: usize, bytes: &[u8]) {
        let mut mail = self.post.boxes[to].lock().unwrap();
        mail.push_back((self.rank, bytes.to_vec()));
    }

    fn receive(&self) -> Option<(usize, Vec<u8>)> {
        self.post.boxes[self.rank].lock().unwrap().pop_front()
    }

    fn all_gather(&self, own: &[u8]) -> Vec<Vec<u8>> {
        self.post.table.lock().unwrap()[self.rank] = own.to_vec();
        self.post.barrier.wait();
        let all = self.post.table.lock().unwrap().clone();
        self.post.barrier.wait();
        all
    }

    fn broadcast(&self, own: Vec<u8>) -> Vec<u8> {
        self.all_gather(&own).swap_remove(0)
    }
}

/// Does the same work as this many ranks; the results in their order, and what rank 0 hears of failures.
fn run<T: Send + 'static>(
    size: usize,
    sharing: Sharing,
    file: Option<PathBuf>,
    work: impl Fn(usize, &RankBlocks) -> Result<T, Cancelled> + Send + Sync + 'static,
) -> (Vec<Result<T, Cancelled>>, Option<String>) {
    let post = Arc::new(Post {
        boxes: (0..size).map(|_| Mutex::default()).collect(),
        table: Mutex::new(vec![Vec::new(); size]),
        barrier: Barrier::new(size),
    });
    let work = Arc::new(work);
    let start = |rank: usize| {
        let (post, work) = (Arc::clone(&post), Arc::clone(&work));
        let file = file.clone().filter(|_| rank == 0);
        thread::spawn(move || {
            let (control, (link, end)) = (Control::default(), connected());
            let ranks = Ranks {
                link: link.clone(),
                rank,
                size,
                nodes: 1,
                threads: 1,
                memory: None,
                control: control.clone(),
            };
            let worker = thread::spawn(move || {
                let file = file.map(|path| FileJournal::open(path, [7; 32]).unwrap());
                let result = match &RankBlocks::new(&ranks, sharing, file) {
                    Ok(blocks) => work(rank, blocks),
                    Err(_) => Err(Cancelled),
                };
                link.end(result.is_err().then(String::new), u8::from(result.is_err()));
                result
            });
            let (_, heard) = messenger::serve(&ThreadTransport { post, rank }, &end, &control);
            (worker.join(), heard)
        })
    };
    let threads: Vec<_> = (0..size).map(start).collect();
    let mut heard = None;
    let ends = threads.into_iter().map(|thread| {
        let (end, message) = thread.join().unwrap();
        heard = heard.take().or(message);
        end.unwrap_or(Err(Cancelled))
    });
    (ends.collect(), heard)
}

fn square(i: usize) -> f64 {
    (i * i) as f64
}

fn squares(count: usize) -> Vec<f64> {
    (0..count).map(square).collect()
}

/// So many items, in blocks of which three are computed at once.
fn loop_of(items: usize, block: usize) -> LoopSize {
    LoopSize {
        items,
        block,
        at_once: 3 * block,
    }
}

#[test]
fn messages_are_read_as_they_were_written() {
    let to_root = [
        ToRoot::Next {
            stage: RunStage::Loop(3),
            items: 7,
            size: 2,
            from: 1,
            most: 4,
        },
        ToRoot::Block {
            stage: RunStage::Rows,
            block: 9,
            bytes: vec![1, 2, 3],
        },
        ToRoot::Ready,
        ToRoot::Stopping,
        ToRoot::Ended(None),
        ToRoot::Ended(Some("no such file".to_owned())),
    ];
    for message in to_root {
        assert_eq!(ToRoot::read(&message.bytes()), Some(message));
    }
    let from_root = [
        FromRoot::Handed(Vec::new()),
        FromRoot::Handed(vec![(4, None), (5, Some(vec![5, 6])), (7, None)]),
        FromRoot::Go,
        FromRoot::Stop,
        FromRoot::Finish(2),
    ];
    for message in from_root {
        assert_eq!(FromRoot::read(&message.bytes()), Some(message));
    }
    for bad in [&[][..], &[9], &[0, 1]] {
        assert_eq!(ToRoot::read(bad), None);
    }
    assert_eq!(FromRoot::read(&[0, 1, 0, 0, 0]), None);
}

#[test]
fn every_block_is_computed_once_and_known_to_all() {
    for size in [2, 3, 5] {
        let computed = Arc::new(AtomicUsize::new(0));
        let counter = Arc::clone(&computed);
        let (ends, heard) = run(size, Sharing::All, None, move |_, blocks| {
            let compute = |items: &[usize]| {
                counter.fetch_add(items.len(), Ordering::Relaxed);
                Ok(items.iter().map(|&i| square(i)).collect())
            };
            let progress = Progress::new();
            let run = Run::new(blocks, &progress);
            let first: Vec<f64> = run.shared((100, 3), compute)?;
            let mut kept = 0;
            let keep = |_: usize, row: f64| {
                kept += 1;
                row
            };
            let second: Vec<f64> = run.distributed(loop_of(50, 4), compute, keep)?;
            Ok((first, second, kept))
        });
        assert_eq!(heard, None);
        let mut all = 0;
        for end in ends {
            let (first, second, kept) = end.unwrap();
            assert_eq!((first, second), (squares(100), squares(50)));
            all += kept;
        }
        assert_eq!((all, computed.load(Ordering::Relaxed)), (50, 150));
    }
}

#[test]
fn rank_0_alone_gets_what_it_alone_needs() {
    let (ends, _) = run(3, Sharing::Root, None, |_, blocks| {
        let compute = |items: &[usize]| Ok(items.iter().map(|&i| square(i)).collect());
        let progress = Progress::new();
        Run::new(blocks, &progress).resumed(RunStage::Rows, loop_of(64, 2), compute)
    });
    assert_eq!(ends, [Ok(Some(squares(64))), Ok(None), Ok(None)]);
}

#[test]
fn what_a_file_has_is_not_computed_again() {
    let name = format!("azulejo-ranks-{}.journal", std::process::id());
    let path = std::env::temp_dir().join(name);
    let _ = std::fs::remove_file(&path);
    for sharing in [Sharing::Root, Sharing::All] {
        for (round, size) in [2, 3, 2].into_iter().enumerate() {
            let computed = Arc::new(AtomicUsize::new(0));
            let counter = Arc::clone(&computed);
            let (ends, _) = run(size, sharing, Some(path.clone()), move |_, blocks| {
                let compute = |items: &[usize]| {
                    counter.fetch_add(items.len(), Ordering::Relaxed);
                    Ok(items.iter().map(|&i| square(i)).collect())
                };
                let progress = Progress::new();
                let run = Run::new(blocks, &progress);
                match sharing {
                    Sharing::Root => run.resumed(RunStage::Rows, loop_of(40, 4), compute),
                    Sharing::All => run.shared((40, 4), compute).map(Some),
                }
            });
            assert_eq!(ends[0], Ok(Some(squares(40))));
            let expected = if round == 0 { 40 } else { 0 };
            assert_eq!(
                computed.load(Ordering::Relaxed),
                expected,
                "{sharing:?} {round}"
            );
        }
    }
    std::fs::remove_file(&path).unwrap();
}

#[test]
fn the_end_of_one_is_the_end_of_all() {
    for failing in [0, 1, 2] {
        let (ends, _) = run(3, Sharing::All, None, move |rank, blocks| {
            let compute = |items: &[usize]| {
                // Some rank meets it, and all of them end.
                if rank == failing || items[0] > 30 {
                    return Err(Cancelled);
                }
                Ok(items.iter().map(|&i| square(i)).collect::<Vec<f64>>())
            };
            Run::new(blocks, &Progress::new()).shared((100, 1), compute)
        });
        assert_eq!(ends, [Err(Cancelled), Err(Cancelled), Err(Cancelled)]);
    }
}

#[test]
fn a_rank_that_panics_is_named() {
    let (ends, heard) = run(3, Sharing::All, None, |rank, blocks| {
        if rank == 2 {
            // As a defect would.
            std::panic::resume_unwind(Box::new("a defect"));
        }
        blocks.gather(RunStage::Points, vec![1])
    });
    assert_eq!(ends[..2], [Err(Cancelled), Err(Cancelled)]);
    assert_eq!(
        heard.as_deref(),
        Some("rank 2: the work ended unexpectedly")
    );
}

#[test]
fn ranks_with_other_light_are_found_out() {
    let (ends, _) = run(3, Sharing::All, None, |rank, blocks| {
        blocks.rely_on(RunStage::Points, (rank / 2) as u64)
    });
    assert_eq!(ends, [Err(Cancelled), Err(Cancelled), Err(Cancelled)]);
}
