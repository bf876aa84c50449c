//! What the rays of every row find.

use super::near::ExactRow;
use super::sides::Sides;
use crate::engine::Estimator;
use crate::row::{Row, Side};
use azulejo_scene::{Material, Rgb};
use azulejo_trace::{Cancelled, Gatherer, Progress, REPLICATES};
use rayon::prelude::*;

/// A form factor as one row's rays see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Entry {
    pub column: u32,
    /// Mean of the replicates.
    pub mean: f32,
    /// Variance of `mean`, from the spread of the replicates.
    pub variance: f32,
}

/// Entries by column, ascending.
pub(super) type Entries = Vec<Entry>;

/// What the rays of one row found.
#[derive(Default)]
pub(super) struct RayRow {
    /// Light that came straight to columns for which there is an exact estimate too.
    pub near: Entries,
    /// All other.
    pub far: Entries,
    pub escaped: f64,
    pub cut: f64,
    pub hidden: f64,
}

/// The rows of all sides.
pub(super) struct Traced {
    pub rows: Vec<RayRow>,
    /// Rays per row.
    pub rays: u32,
}

/// Rows asked of the estimator at a time, per thread.
const BLOCK: usize = 64;

/// Traces all rows.
pub(super) fn trace(
    sides: &Sides,
    gatherer: &Gatherer,
    exact: &[ExactRow],
    estimator: &Estimator,
    progress: &Progress,
) -> Result<Traced, Cancelled> {
    progress.begin("form factors", sides.len() as u64);
    let mut rows = Vec::with_capacity(sides.len());
    let numbers: Vec<usize> = (0..sides.len()).collect();
    for block in numbers.chunks(BLOCK * rayon::current_num_threads().max(1)) {
        let wanted: Vec<Side> = block.iter().map(|&i| sides.side(i)).collect();
        let found = estimator.rows(&wanted, progress)?;
        let row = |(&i, row): (&usize, &Row)| ray_row(sides, gatherer, &exact[i], row);
        rows.par_extend(block.par_iter().zip(&found).map(row));
    }
    Ok(Traced {
        rows,
        rays: estimator.rays(),
    })
}

/// Sorts what was found of one row by what there is a formula for.
fn ray_row(sides: &Sides, gatherer: &Gatherer, exact: &ExactRow, found: &Row) -> RayRow {
    let mut row = RayRow {
        escaped: found.all_escaped().mean(),
        cut: found.cut.mean(),
        ..RayRow::default()
    };
    let materials = &gatherer.surfaces().scene.materials;
    let (mut near, mut far) = (Vec::new(), Vec::new());
    for (replicate, entries) in found.entries.iter().enumerate() {
        for entry in entries {
            let weight = entry.weight;
            let patch = entry.side / 2;
            let Some(column) = sides.column(patch, entry.side.is_multiple_of(2)) else {
                let material = &materials[sides.patches.material(patch as usize) as usize];
                row.hidden += (weight * ending(material)).mean() / REPLICATES as f64;
                continue;
            };
            let is_near =
                entry.order == 0 && exact.binary_search_by_key(&column, |e| e.column).is_ok();
            let list = if is_near { &mut near } else { &mut far };
            list.push((column, replicate, weight.mean()));
        }
    }
    (row.near, row.far) = (entries(near), entries(far));
    row
}

/// Share of the light on a surface that does not go on. Glass keeps nothing but what its colour
/// takes, which counts as nobody's.
fn ending(material: &Material) -> Rgb {
    if material.dielectric.is_some() {
        Rgb::BLACK
    } else {
        Rgb::WHITE - material.mirror
    }
}

/// Means and variances by column of values in replicates.
fn entries(mut found: Vec<(u32, usize, f64)>) -> Entries {
    found.sort_by_key(|&(column, ..)| column);
    let mean_and_variance = |group: &[(u32, usize, f64)]| {
        let mut values = [0.0; REPLICATES];
        group.iter().for_each(|&(_, r, w)| values[r] += w);
        entry(group[0].0, values)
    };
    found
        .chunk_by(|a, b| a.0 == b.0)
        .map(mean_and_variance)
        .collect()
}

fn entry(column: u32, values: [f64; REPLICATES]) -> Entry {
    let n = REPLICATES as f64;
    let mean = values.iter().sum::<f64>() / n;
    let spread: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    Entry {
        column,
        mean: mean as f32,
        variance: (spread / (n * (n - 1.0))) as f32,
    }
}
