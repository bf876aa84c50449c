//! Tests of runs.

use super::*;
use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

const STAGE: RunStage = RunStage::Pairs;

/// Stores blocks in memory, as one of several processes.
#[derive(Default)]
struct Memory {
    blocks: Mutex<HashMap<(RunStage, usize), Vec<u8>>>,
    /// Which part of how many this is; 0 assembles all.
    part: usize,
    parts: usize,
}

impl Memory {
    fn whole(parts: usize) -> Memory {
        Memory {
            parts,
            ..Memory::default()
        }
    }
}

impl Blocks for Memory {
    fn load(&self, stage: RunStage, block: usize) -> Option<Vec<u8>> {
        self.blocks.lock().unwrap().get(&(stage, block)).cloned()
    }

    fn save(&self, stage: RunStage, block: usize, bytes: &[u8]) {
        let mut blocks = self.blocks.lock().unwrap();
        blocks.insert((stage, block), bytes.to_vec());
    }

    fn role(&self) -> RunRole {
        RunRole {
            parts: self.parts.max(1),
            assembles: self.part == 0,
            is_kept: true,
            ..RunRole::default()
        }
    }

    fn next(
        &self,
        _: RunStage,
        _: Division,
        left: Range<usize>,
        most: usize,
    ) -> Result<Vec<usize>, Cancelled> {
        let is_mine = |b: &usize| self.part == 0 || b % self.parts == self.part - 1;
        Ok(left.filter(is_mine).take(most).collect())
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Item(Vec<f64>);

impl Record for Item {
    fn write(&self, bytes: &mut Vec<u8>) {
        write_list(&self.0, bytes, |x, bytes| bytes.extend(x.to_le_bytes()));
    }

    fn read(bytes: &mut RecordReader) -> Option<Item> {
        bytes.list(RecordReader::f64).map(Item)
    }
}

fn item(i: usize) -> Item {
    Item((i..17).map(|j| 1.0 / (1 + i + j) as f64).collect())
}

/// 17 items in blocks of 3, of which this many are computed at once.
fn size(at_once: usize) -> LoopSize {
    LoopSize {
        items: 17,
        block: 3,
        at_once,
    }
}

/// All items, and how many of them had to be computed.
fn run(memory: &Memory) -> (Option<Vec<Item>>, usize) {
    run_at_once(memory, 3)
}

fn run_at_once(memory: &Memory, at_once: usize) -> (Option<Vec<Item>>, usize) {
    let (progress, mut computed) = (Progress::new(), 0);
    let compute = |indices: &[usize]| {
        assert!(indices.is_sorted(), "{indices:?}");
        assert!(indices.len() <= at_once.max(3), "{indices:?}");
        computed += indices.len();
        Ok(indices.iter().map(|&i| item(i)).collect())
    };
    let items = Run::new(memory, &progress)
        .resumed(STAGE, size(at_once), compute)
        .unwrap();
    if items.is_some() {
        assert_eq!(progress.done() + computed as u64, 17);
    }
    (items, computed)
}

fn whole() -> Option<Vec<Item>> {
    Some((0..17).map(item).collect())
}

#[test]
fn what_is_kept_is_not_computed_again() {
    let memory = Memory::default();
    assert_eq!(run(&memory), (whole(), 17));
    assert_eq!(run(&memory), (whole(), 0));
    memory.blocks.lock().unwrap().remove(&(STAGE, 1));
    assert_eq!(run(&memory), (whole(), 3));
}

#[test]
fn blocks_that_are_computed_at_once_are_those_that_are_computed_one_by_one() {
    for (parts, at_once) in [(1, 7), (1, 100), (3, 6), (5, 17), (1, 0)] {
        let [one_by_one, memory] = [(); 2].map(|()| Memory::whole(parts));
        assert_eq!(run(&one_by_one), (whole(), 17));
        assert_eq!(run_at_once(&memory, at_once), (whole(), 17));
        let stored = one_by_one.blocks.into_inner().unwrap();
        assert_eq!(*memory.blocks.lock().unwrap(), stored);
        // Only what is missing is computed again.
        memory.blocks.lock().unwrap().remove(&(STAGE, 0));
        let (items, computed) = run_at_once(&memory, at_once);
        assert_eq!(items, whole());
        assert!((1..=3).contains(&computed), "{computed}");
    }
}

#[test]
fn parts_together_are_the_whole() {
    for parts in [1, 2, 3, 7, 17, 40] {
        let all = Memory::whole(parts);
        let mut computed = 0;
        for part in 1..=parts {
            let memory = Memory {
                part,
                ..Memory::whole(parts)
            };
            let (items, own) = run(&memory);
            assert_eq!(items, None);
            // Nobody has more than one item more than another.
            assert!(
                (17 / parts..=17usize.div_ceil(parts)).contains(&own),
                "{own}"
            );
            assert_eq!(run(&memory), (None, 0));
            computed += own;
            let blocks = memory.blocks.into_inner().unwrap();
            all.blocks.lock().unwrap().extend(blocks);
        }
        assert_eq!(computed, 17);
        assert_eq!(run(&all), (whole(), 0));
    }
}

#[test]
fn processes_go_on_with_the_blocks_of_all() {
    for processes in [1, 2, 3, 5, 30] {
        let computed = AtomicUsize::new(0);
        let runs = together(processes, |blocks| {
            let compute = |indices: &[usize]| {
                computed.fetch_add(indices.len(), Ordering::Relaxed);
                Ok(indices.iter().map(|&i| item(i)).collect())
            };
            // Twice, so that loops are told apart.
            let progress = Progress::new();
            let run = Run::new(blocks, &progress);
            let first = run.shared((17, 3), compute).unwrap();
            let lengths = |indices: &[usize]| Ok(indices.iter().map(|&i| i as u32).collect());
            let second = run.shared((9, 1), lengths).unwrap();
            let points = run.resumed(RunStage::Points, size(6), compute);
            (first, second, points.unwrap())
        });
        for (first, second, points) in runs {
            assert_eq!((Some(first), points), (whole(), whole()));
            assert_eq!(second, (0..9).collect::<Vec<u32>>());
        }
        assert_eq!(computed.into_inner(), 34);
    }
}

#[test]
fn items_stay_where_they_were_computed() {
    for processes in [1, 2, 3, 5] {
        let kept = together(processes, |blocks| {
            let mut kept = Vec::new();
            let compute = |indices: &[usize]| Ok(indices.iter().map(|&i| item(i)).collect());
            let keep = |i: usize, row: Item| {
                kept.push(i);
                row.0.len() as u64
            };
            let progress = Progress::new();
            let size = LoopSize {
                items: 17,
                block: 2,
                at_once: 5,
            };
            let run = Run::new(blocks, &progress);
            let lengths = run.distributed(size, compute, keep).unwrap();
            assert_eq!(lengths, (0..17).rev().map(|n| n + 1).collect::<Vec<u64>>());
            kept
        });
        let mut all: Vec<usize> = kept.into_iter().flatten().collect();
        all.sort_unstable();
        assert_eq!(all, (0..17).collect::<Vec<usize>>());
    }
}

#[test]
fn one_that_is_cancelled_ends_all() {
    let ends = together(3, |blocks| {
        let compute = |indices: &[usize]| {
            if indices.contains(&5) {
                return Err(Cancelled);
            }
            Ok(indices.iter().map(|&i| item(i)).collect::<Vec<Item>>())
        };
        Run::new(blocks, &Progress::new()).shared((17, 1), compute)
    });
    assert_eq!(ends, [Err(Cancelled), Err(Cancelled), Err(Cancelled)]);
}

#[test]
fn digests_tell_bits_apart() {
    assert_eq!(digest([].into_iter()), 0xcbf2_9ce4_8422_2325);
    let of = |x: f64| digest([1.0, x].into_iter());
    assert_eq!(of(2.0), of(2.0));
    assert_ne!(of(2.0), of(2.0_f64.next_up()));
    assert_ne!(of(0.0), of(-0.0));
}

#[test]
fn bytes_that_are_no_items_are_not_taken() {
    let mut good = Vec::new();
    (0..3).for_each(|i| item(i).write(&mut good));
    let long = [&good[..], &[0]].concat();
    let endless = u32::MAX.to_le_bytes().repeat(3);
    for bytes in [&good[..good.len() - 1], &long, &endless, &[], &[1, 2, 3]] {
        let memory = Memory::default();
        memory.save(STAGE, 0, bytes);
        assert_eq!(run(&memory).1, 17);
    }
}
