//! What the rays of every row find.

use super::near::ExactRow;
use super::sides::Sides;
use crate::rays::{Columns, RayEstimator};
use azulejo_scene::Rgb;
use azulejo_trace::follow::{Event, Path, Scratch, Via, follow};
use azulejo_trace::{Cancelled, Gatherer, KernelHit, Progress, REPLICATES};
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

/// Traces all rows.
pub(super) fn trace(
    sides: &Sides,
    gatherer: &Gatherer,
    exact: &[ExactRow],
    rays: u32,
    seed: u32,
    progress: &Progress,
) -> Result<Traced, Cancelled> {
    let estimator = RayEstimator::new(gatherer, sides.patches, rays, seed, Columns::All);
    progress.begin("form factors", sides.len() as u64);
    let row = |(scratch, bins): &mut (Scratch, Bins), i: usize| {
        progress.advance(1)?;
        exact[i]
            .iter()
            .for_each(|e| bins.is_near[e.column as usize] = true);
        let mut row = RayRow::default();
        let mut paths = estimator.start(sides.side(i));
        let key = azulejo_trace::sampling::hash(&[seed, i as u32]);
        follow(
            gatherer.surfaces(),
            &mut paths,
            scratch,
            key,
            |path, event| {
                account(sides, gatherer, &mut row, bins, path, event);
            },
        );
        exact[i]
            .iter()
            .for_each(|e| bins.is_near[e.column as usize] = false);
        (row.near, row.far) = (bins.near.drain(), bins.far.drain());
        Ok(row)
    };
    let working = || (Scratch::default(), Bins::new(sides.len()));
    let rows = (0..sides.len())
        .into_par_iter()
        .map_init(working, row)
        .collect::<Result<_, _>>()?;
    Ok(Traced {
        rows,
        rays: estimator.rays(),
    })
}

/// Enters one event of one path.
fn account(
    sides: &Sides,
    gatherer: &Gatherer,
    row: &mut RayRow,
    bins: &mut Bins,
    path: &Path,
    event: Event,
) {
    let weight = Rgb::from(path.weight.map(f64::from));
    let share = 1.0 / REPLICATES as f64;
    match event {
        Event::Escape => row.escaped += weight.mean() * share,
        Event::Cut => row.cut += weight.mean() * share,
        // What a surface keeps has no column: the row sums say it.
        Event::Absorbed => {}
        Event::Surface { hit, front } => {
            let patch = sides.patches.locate_hit(gatherer.surfaces(), &hit);
            match sides.column(patch, front) {
                Some(column) => bins.add(column, path, weight.mean()),
                None => row.hidden += (weight * ending(gatherer, &hit)).mean() * share,
            }
        }
    }
}

/// Share of the light at a hit that does not go on. Glass keeps nothing but what its colour
/// takes, which counts as nobody's.
fn ending(gatherer: &Gatherer, hit: &KernelHit) -> Rgb {
    let material = gatherer.surfaces().material(hit.item);
    if material.dielectric.is_some() {
        Rgb::BLACK
    } else {
        Rgb::WHITE - material.mirror
    }
}

/// Sums of one row, kept between rows to save allocations.
struct Bins {
    near: Sums,
    far: Sums,
    /// Whether a column of this row has an exact estimate.
    is_near: Vec<bool>,
}

impl Bins {
    fn new(columns: usize) -> Bins {
        let sums = || Sums {
            sums: vec![[0.0; REPLICATES]; columns],
            touched: Vec::new(),
        };
        Bins {
            near: sums(),
            far: sums(),
            is_near: vec![false; columns],
        }
    }

    fn add(&mut self, column: u32, path: &Path, weight: f64) {
        let is_near = path.via == Via::Direct && self.is_near[column as usize];
        let sums = if is_near {
            &mut self.near
        } else {
            &mut self.far
        };
        sums.add(column, path.id as usize, weight);
    }
}

/// Sums per column and replicate.
struct Sums {
    sums: Vec<[f64; REPLICATES]>,
    touched: Vec<u32>,
}

impl Sums {
    fn add(&mut self, column: u32, replicate: usize, weight: f64) {
        let sums = &mut self.sums[column as usize];
        // Weights of 0 occur at the poles of curved patches.
        if weight > 0.0 && *sums == [0.0; REPLICATES] {
            self.touched.push(column);
        }
        sums[replicate] += weight;
    }

    /// The entries, and empty sums for the next row.
    fn drain(&mut self) -> Entries {
        self.touched.sort_unstable();
        let entries = self.touched.iter().map(|&column| {
            let values = std::mem::replace(&mut self.sums[column as usize], [0.0; REPLICATES]);
            entry(column, values)
        });
        let entries = entries.collect();
        self.touched.clear();
        entries
    }
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
