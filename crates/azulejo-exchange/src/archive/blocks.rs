//! Archives of matrices in blocks between clusters.

use super::BLOCKS;
use super::read::{ArchiveError, Arrays, ReadEnclosure};
use super::write::{list, write_around};
use crate::enclosure::Enclosure;
use azulejo_factors::CompressedFactors;
use azulejo_factors::form_factors::{ExchangeAreas, PreparedPlan};
use azulejo_factors::hierarchy::{
    Block, BlockKind, BlockPart, Estimated, StatedErrors, StatedFactors,
};
use azulejo_formats::numpy::npy;
use azulejo_formats::numpy::npz::{NpzReader, NpzWriter};
use azulejo_scene::Scene;
use std::io::{self, Read, Seek, Write};
use std::ops::Range;
use std::sync::Arc;

/// A compressed matrix with its rows.
#[derive(Clone, Debug, Default)]
pub struct BlockArchive {
    /// The rows; `elsewhere` is the matrix.
    pub enclosure: Enclosure,
    /// The matrix.
    pub factors: Arc<CompressedFactors>,
    /// The requested tolerance.
    pub tolerance: f64,
    /// How far it is off.
    pub stated: StatedErrors,
    /// Bytes of the whole matrix, or a forecast of them; 0 if unknown.
    pub whole_bytes: u64,
    /// Names of the arrays of the archive that was read, in its order.
    pub arrays: Vec<String>,
}

/// Factors of an archive, of either layout.
#[derive(Clone, Debug)]
pub enum StoredFactors {
    /// The whole matrix.
    Whole(Box<ReadEnclosure>),
    /// The matrix in blocks.
    Blocks(Box<BlockArchive>),
}

impl StoredFactors {
    /// The enclosure.
    pub fn into_enclosure(self) -> Enclosure {
        match self {
            StoredFactors::Whole(read) => read.enclosure,
            StoredFactors::Blocks(read) => read.enclosure,
        }
    }
}

/// Reads an archive, whole or in blocks: see [`read`](super::read()).
///
/// # Errors
/// The array, what was found and what was expected.
pub fn open(file: impl Read + Seek, budget: u64) -> Result<StoredFactors, ArchiveError> {
    let mut archive = Arrays::open(NpzReader::new(file, budget)?)?;
    if archive.format()? == BLOCKS {
        return read_blocks(archive).map(|read| StoredFactors::Blocks(Box::new(read)));
    }
    let read = archive.enclosure()?;
    Ok(StoredFactors::Whole(Box::new(read)))
}

/// Words for a kind of block.
const KINDS: &str = "0 (sparse), 1 (dense) or 2 (of low rank)";

impl BlockArchive {
    /// A matrix of `plan`, which was computed for `scene` with this tolerance.
    ///
    /// # Panics
    /// If the matrix has another number of rows than the plan.
    pub fn of(
        plan: &PreparedPlan,
        scene: &Scene,
        factors: StatedFactors,
        tolerance: f64,
    ) -> BlockArchive {
        let enclosure = Enclosure::new(plan, scene, factors.rows);
        BlockArchive {
            stated: factors.stated,
            whole_bytes: factors.whole_bytes,
            ..BlockArchive::new(enclosure, factors.factors, tolerance)
        }
    }

    /// A matrix with its rows, which have none of their own.
    fn new(mut enclosure: Enclosure, factors: CompressedFactors, tolerance: f64) -> BlockArchive {
        let factors = Arc::new(factors);
        enclosure.elsewhere = Some(factors.clone());
        BlockArchive {
            enclosure,
            factors,
            tolerance,
            stated: StatedErrors::default(),
            whole_bytes: 0,
            arrays: Vec::new(),
        }
    }
}

/// Writes a matrix in blocks. Its bytes depend on its content alone.
///
/// # Errors
/// Those of writing.
pub fn write_blocks(content: &BlockArchive, out: &mut dyn Write) -> io::Result<()> {
    let factors = &*content.factors;
    let mut archive = NpzWriter::new(out);
    archive.add("format", |w| npy::write_bytes(BLOCKS.as_bytes(), w))?;
    archive.add("shape", |w| npy::write(&[2], &[factors.len() as i64; 2], w))?;
    archive.add("order", |w| list(&factors.order, |&row| row, w))?;
    // Write the place and the kind of each block: rows and columns are positions in the order of clusters.
    let parts = &factors.parts;
    let blocks: Vec<&Block> = parts.iter().flat_map(|part| &part.blocks).collect();
    archive.add("block_rows", |w| ranges(&blocks, |b| &b.rows, w))?;
    archive.add("block_columns", |w| ranges(&blocks, |b| &b.columns, w))?;
    archive.add("block_kind", |w| {
        let kind = |b: &&Block| match b.kind {
            BlockKind::Sparse => 0,
            BlockKind::Dense => 1,
            BlockKind::LowRank { .. } => 2,
        };
        list(&blocks, kind, w)
    })?;
    archive.add("block_rank", |w| {
        let rank = |b: &&Block| match b.kind {
            BlockKind::LowRank { rank } => rank as i32,
            BlockKind::Sparse | BlockKind::Dense => 0,
        };
        list(&blocks, rank, w)
    })?;
    // State where the numbers of each block begin among those of all.
    let starts = |count: fn(&Block) -> usize| {
        let mut starts = vec![0i64];
        for block in &blocks {
            starts.push(starts[starts.len() - 1] + count(block) as i64);
        }
        starts
    };
    archive.add("block_values", |w| {
        list(&starts(|b| b.values.len()), |&x| x, w)
    })?;
    archive.add("block_layout", |w| {
        list(&starts(|b| b.layout.len()), |&x| x, w)
    })?;
    // Stream the numbers part by part, without a copy of the matrix.
    archive.add("values", |w| {
        let count = parts.iter().map(|part| part.values.len()).sum();
        npy::write_header(<f32 as npy::Element>::DESCR, &[count], w)?;
        let mut numbers = parts.iter().flat_map(|part| &part.values);
        numbers.try_for_each(|&x| npy::Element::write(x, w))
    })?;
    archive.add("layout", |w| {
        let count = parts.iter().map(|part| part.layout.len()).sum();
        npy::write_header(<u16 as npy::Element>::DESCR, &[count], w)?;
        let mut numbers = parts.iter().flat_map(|part| &part.layout);
        numbers.try_for_each(|&x| npy::Element::write(x, w))
    })?;
    archive.add("part_blocks", |w| {
        let mut first = 0;
        let firsts = parts.iter().map(|part| {
            first += part.blocks.len();
            (first - part.blocks.len()) as i64
        });
        list(&firsts.collect::<Vec<i64>>(), |&x| x, w)
    })?;
    // Add the errors: those of single rows, and what is stated of the whole matrix.
    archive.add("sum_error", |w| list(&factors.sum_errors, |&x| x, w))?;
    archive.add("entry_noise", |w| list(&factors.entry_noise, |&x| x, w))?;
    let StatedErrors {
        product,
        sums,
        rows,
    } = content.stated;
    let numbers: [(&str, &[f64]); 5] = [
        ("deficit", &factors.deficit),
        ("product_error", &[product.value, product.error]),
        ("row_sum_error", &[sums.value, sums.error]),
        ("tolerance", &[content.tolerance]),
        ("scaled", &[factors.scaled]),
    ];
    for (name, numbers) in numbers {
        let shape: &[usize] = if numbers.len() == 1 { &[] } else { &[2] };
        archive.add(name, |w| npy::write(shape, numbers, w))?;
    }
    archive.add("bound", |w| npy::write(&[], &[factors.bound], w))?;
    archive.add("traced_again", |w| npy::write(&[], &[rows as i64], w))?;
    archive.add("whole_bytes", |w| {
        npy::write(&[], &[content.whole_bytes as i64], w)
    })?;
    write_around(&content.enclosure, &mut archive)?;
    archive.finish()
}

/// From and to of each block.
fn ranges(
    blocks: &[&Block],
    range: fn(&Block) -> &Range<u32>,
    out: &mut dyn Write,
) -> io::Result<()> {
    npy::write_header(<u32 as npy::Element>::DESCR, &[blocks.len(), 2], out)?;
    let mut ends = blocks.iter().flat_map(|b| [range(b).start, range(b).end]);
    ends.try_for_each(|x| npy::Element::write(x, out))
}

fn read_blocks(mut archive: Arrays) -> Result<BlockArchive, ArchiveError> {
    let arrays = archive.npz.names();
    archive.read_shape()?;
    let n = archive.rows;
    let areas = archive.areas()?;
    let order = archive.order()?;
    let parts = archive.parts()?;
    let mut factors = archive.factors(areas.clone(), ExchangeAreas::new(), Vec::new())?;
    if !arrays.iter().any(|name| name == "row_error") {
        // Unknown, not 0.
        factors.row_errors.clear();
    }
    let or_zeros = |numbers: Option<Vec<f64>>| numbers.unwrap_or_else(|| vec![0.0; n]);
    let compressed = CompressedFactors {
        order,
        parts,
        areas,
        ends: factors.ends.clone(),
        rest: factors.rest.clone(),
        sum_errors: or_zeros(archive.list("sum_error", 1)?),
        entry_noise: or_zeros(archive.list("entry_noise", 1)?),
        bound: archive.whole("bound")?.unwrap_or(f64::NAN),
        scaled: archive.whole("scaled")?.unwrap_or_default(),
        deficit: archive.two("deficit")?,
        rays: factors.rays,
    };
    let estimated = |[value, error]: [f64; 2]| Estimated { value, error };
    let stated = StatedErrors {
        product: estimated(archive.two("product_error")?),
        sums: estimated(archive.two("row_sum_error")?),
        rows: archive.whole("traced_again")?.unwrap_or_default() as u64,
    };
    let enclosure = Enclosure {
        rows: archive.row_table(&factors)?,
        factors,
        elsewhere: None,
        outside: archive.outside()?,
        sky: archive.sky()?,
    };
    let tolerance = archive.whole("tolerance")?.unwrap_or_default();
    Ok(BlockArchive {
        arrays,
        stated,
        whole_bytes: archive.whole("whole_bytes")?.unwrap_or_default() as u64,
        ..BlockArchive::new(enclosure, compressed, tolerance)
    })
}

impl Arrays<'_> {
    /// Two numbers; zeros if there is no such array.
    fn two(&mut self, name: &str) -> Result<[f64; 2], ArchiveError> {
        let array = self.npz.array(name)?.filter(|a| a.len() == 2);
        Ok(array.map_or([0.0; 2], |a| [a.number(0), a.number(1)]))
    }

    /// Whole numbers from 0 on.
    fn counts(&mut self, name: &str) -> Result<Vec<usize>, ArchiveError> {
        let array = self.required(name)?;
        let integers = array.integers().unwrap_or_default();
        if integers.len() != array.len() {
            return Err(ArchiveError(format!("{name}: expected whole numbers")));
        }
        let bad = integers.iter().find(|&&x| x < 0);
        match bad {
            Some(x) => Err(ArchiveError(format!("{name}: {x}, expected 0 or more"))),
            None => Ok(integers.into_iter().map(|x| x as usize).collect()),
        }
    }

    /// The row at each position.
    fn order(&mut self) -> Result<Vec<u32>, ArchiveError> {
        let order = self.counts("order")?;
        let mut is_there = vec![false; self.rows];
        for &row in &order {
            if let Some(seen) = is_there.get_mut(row) {
                *seen = true;
            }
        }
        if order.len() != self.rows || is_there.contains(&false) {
            return Err(ArchiveError(format!(
                "order: {} numbers, expected each of the {} rows once",
                order.len(),
                self.rows
            )));
        }
        Ok(order.into_iter().map(|row| row as u32).collect())
    }

    /// The blocks, checked.
    fn parts(&mut self) -> Result<Vec<BlockPart>, ArchiveError> {
        let (rows, columns) = (self.counts("block_rows")?, self.counts("block_columns")?);
        let (kinds, ranks) = (self.counts("block_kind")?, self.counts("block_rank")?);
        let count = kinds.len();
        if [rows.len(), columns.len(), 2 * ranks.len()] != [2 * count; 3] {
            return Err(ArchiveError(format!(
                "block_rows, block_columns, block_rank: expected two, two and one numbers for each of \
                 {count} blocks"
            )));
        }
        // Divide the numbers of all blocks at the places where each block's begin.
        let values = self.required("values")?;
        let layout = self.required("layout")?;
        let value_starts = self.starts("block_values", count, values.len())?;
        let layout_starts = self.starts("block_layout", count, layout.len())?;
        // Parts are runs of blocks; the end of the last one is not stored.
        let mut firsts = self.counts("part_blocks")?;
        if !firsts.is_sorted()
            || firsts.first().is_some_and(|&f| f != 0)
            || firsts.is_empty() != (count == 0)
        {
            let message = "part_blocks: expected the first block of each part, ascending from 0";
            return Err(ArchiveError(message.to_owned()));
        }
        firsts.push(count);
        // Copy the numbers to the parts: a block counts its own from the beginning of its part.
        let (mut parts, mut pairs) = (Vec::new(), 0u64);
        for part in firsts.windows(2) {
            let mut read = BlockPart::default();
            for k in part[0]..part[1].min(count) {
                let fail = |what: String| ArchiveError(format!("block {k}: {what}"));
                let range = |ends: &[usize]| ends[2 * k]..ends[2 * k + 1];
                let place = BlockPlace {
                    rows: range(&rows),
                    columns: range(&columns),
                };
                pairs += place.check(self.rows).map_err(fail)?;
                let from = layout_starts[k]..layout_starts[k + 1];
                let from: Vec<usize> = from.map(|i| layout.integer(i).max(0) as usize).collect();
                let numbers = value_starts[k]..value_starts[k + 1];
                let kind = place.kind(kinds[k], ranks[k], &from, numbers.len());
                let kind = kind.map_err(fail)?;
                let starts = [read.values.len(), read.layout.len()];
                for i in numbers {
                    let value = values.number(i) as f32;
                    if !value.is_finite() {
                        let message = format!("values[{i}] is {value}, expected a finite number");
                        return Err(ArchiveError(message));
                    }
                    read.values.push(value);
                }
                read.layout.extend(from.iter().map(|&x| x as u16));
                let ends = [read.values.len(), read.layout.len()];
                let block = place.block(kind, starts, ends);
                let message = || "its part has more than 2^32 numbers".to_owned();
                read.blocks.push(block.ok_or_else(|| fail(message()))?);
            }
            parts.push(read);
        }
        // All blocks lie in the upper half of the matrix: if they have more pairs than it, some overlap.
        let most = self.rows as u64 * (self.rows as u64 + 1) / 2;
        if pairs > most {
            return Err(ArchiveError(format!(
                "block_rows, block_columns: the blocks have {pairs} pairs, expected at most the {most} of the \
                 matrix: some overlap"
            )));
        }
        Ok(parts)
    }

    /// Where lists begin among `whole` numbers, and where the last ends.
    fn starts(
        &mut self,
        name: &str,
        count: usize,
        whole: usize,
    ) -> Result<Vec<usize>, ArchiveError> {
        let starts = self.counts(name)?;
        let is_whole = starts.first() == Some(&0) && starts.last() == Some(&whole);
        if starts.len() != count + 1 || !starts.is_sorted() || !is_whole {
            return Err(ArchiveError(format!(
                "{name}: {} numbers up to {}, expected {} ascending from 0 to {whole}",
                starts.len(),
                starts.last().copied().unwrap_or_default(),
                count + 1
            )));
        }
        Ok(starts)
    }
}

/// The positions of a block.
struct BlockPlace {
    rows: Range<usize>,
    columns: Range<usize>,
}

impl BlockPlace {
    /// Whether it lies in the upper half of a matrix of `n` rows; returns the number of its pairs.
    fn check(&self, n: usize) -> Result<u64, String> {
        let is_range = |r: &Range<usize>| r.start < r.end && r.end <= n;
        let is_upper = self.rows == self.columns || self.rows.end <= self.columns.start;
        if !is_range(&self.rows) || !is_range(&self.columns) || !is_upper {
            return Err(format!(
                "positions {:?} and {:?}, expected ranges within {n} positions, the first before the second \
                 or the same",
                self.rows, self.columns
            ));
        }
        let (m, n) = (self.rows.len() as u64, self.columns.len() as u64);
        Ok(if self.rows == self.columns {
            m * (m + 1) / 2
        } else {
            m * n
        })
    }

    /// The block between these numbers of values and indices; `None` beyond 32 bits.
    fn block(&self, kind: BlockKind, starts: [usize; 2], ends: [usize; 2]) -> Option<Block> {
        let range = |k: usize| {
            let (start, end) = (u32::try_from(starts[k]), u32::try_from(ends[k]));
            Some(start.ok()?..end.ok()?)
        };
        Some(Block {
            rows: self.rows.start as u32..self.rows.end as u32,
            columns: self.columns.start as u32..self.columns.end as u32,
            kind,
            values: range(0)?,
            layout: range(1)?,
        })
    }

    /// Its layout, if it fits the numbers.
    fn kind(
        &self,
        kind: usize,
        rank: usize,
        layout: &[usize],
        values: usize,
    ) -> Result<BlockKind, String> {
        let (m, n) = (self.rows.len(), self.columns.len());
        let (block_kind, count) = match kind {
            0 => {
                self.check_sparse(layout, values)?;
                return Ok(BlockKind::Sparse);
            }
            1 | 2 if self.rows == self.columns => {
                return Err("on the diagonal, expected it to be sparse".to_owned());
            }
            1 => (BlockKind::Dense, m.checked_mul(n)),
            2 => {
                let numbers = rank.checked_mul(m + n).filter(|_| rank > 0);
                (BlockKind::LowRank { rank: rank as u32 }, numbers)
            }
            other => return Err(format!("kind {other}, expected {KINDS}")),
        };
        if count != Some(values) || !layout.is_empty() {
            return Err(format!(
                "{values} numbers and {} indices, expected {} and none for {m} × {n} positions of rank {rank}",
                layout.len(),
                count.unwrap_or_default()
            ));
        }
        Ok(block_kind)
    }

    /// Rows, counts and columns within the block, one value for each column.
    fn check_sparse(&self, mut layout: &[usize], values: usize) -> Result<(), String> {
        let (m, n) = (self.rows.len(), self.columns.len());
        let fail = |what: &str| Err(format!("its indices: {what}"));
        if m.max(n) > usize::from(u16::MAX) {
            return fail("sparse blocks have at most 65,535 rows and columns");
        }
        let mut count = 0;
        while let [row, length, rest @ ..] = layout {
            let Some((columns, rest)) = rest.split_at_checked(*length) else {
                return fail("a row is cut off");
            };
            let is_upper = |&column: &usize| self.rows != self.columns || column >= *row;
            if *row >= m || !columns.iter().all(|c| *c < n && is_upper(c)) {
                return fail("a row or column beyond the block");
            }
            count += length;
            layout = rest;
        }
        if !layout.is_empty() || count != values {
            return Err(format!("its indices: {count} entries, expected {values}"));
        }
        Ok(())
    }
}
