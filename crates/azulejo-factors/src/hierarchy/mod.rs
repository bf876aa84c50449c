//! Form factors between 100,000 patches and more, in far fewer numbers than pairs.
//!
//! Patches that are close to each other and face the same way form clusters. The exchange areas
//! between two clusters are stored as the smallest of three: the entries that are not zero, a sum of a
//! few products u vᵀ, or the blocks between smaller clusters (Hanrahan, Salzman, Aupperle, *A rapid
//! hierarchical radiosity algorithm*, SIGGRAPH 1991; with blocks of low rank: Potter, Bertone,
//! Schörghofer, Mazarico, *Fast hierarchical low-rank view factor matrices for thermal irradiance on
//! planetary surfaces*, 2022, arXiv:2209.07632). A block serves both directions, so reciprocity holds
//! to the last bit.
//!
//! | | from | errors |
//! |---|---|---|
//! | [`CompressedFactors::new`] | an existing matrix: singular value decompositions of its blocks | bounded by the tolerance |
//! | [`CompressedFactors::from_rays`] | rays, one block of rows after the other: the matrix never exists | those of the rays, and of the tolerance where rays can tell |
//!
//! ```
//! use azulejo_factors::form_factors::Plan;
//! use azulejo_factors::hierarchy::radiosities;
//! use azulejo_factors::{CompressedFactors, CompressionOptions, FormFactorOptions, PatchSize};
//! use azulejo_scene::synthetic::cube_room;
//! use azulejo_trace::{Progress, Tracer};
//!
//! let (scene, progress) = (cube_room(), Progress::new());
//! let tracer = Tracer::new(&scene);
//! let options = FormFactorOptions { size: PatchSize::Count(600), rays: 256, ..Default::default() };
//! let plan = Plan::new(&scene, &tracer, &options)?;
//! let compression = CompressionOptions::default();
//! let factors = CompressedFactors::from_rays(&plan.prepare(), &compression, &progress)?;
//! // In a closed room whose walls all emit and reflect the same, B = M / (1 − ρ).
//! let (exitance, reflectance) = (vec![1.0; factors.len()], vec![0.5; factors.len()]);
//! let (light, _) = radiosities(&factors, &exitance, &reflectance, (1e-6, 50), &progress)?;
//! assert!(light.iter().all(|b| (b - 2.0).abs() < 0.02));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`FactorOperator`] is what the matrix and its compressed form have in common, [`radiosities`] solves
//! for the light with either, and [`OperatorError`] compares the two.

mod blocks;
mod clusters;
mod compress;
mod from_rays;
mod grouped;
mod low_rank;
mod operator;
mod partition;
mod plan;
mod scaling;
mod stated;

use crate::error::FactorsError;
use crate::form_factors::{FormFactors, PreparedPlan, RowRemainder};
use crate::proxy::PointNormal;
use azulejo_trace::{Cancelled, Progress};
pub use blocks::{Block, BlockKind, BlockPart};
use clusters::{Clusters, PairArea};
use compress::Compression;
pub use grouped::grouped;
pub use operator::{FactorOperator, OperatorError, radiosities};
use operator::{probe_vector, ratio};
pub use plan::StatedFactors;
pub use stated::{Estimated, StatedErrors};
use std::fmt;

/// Options of compression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompressionOptions {
    /// Error ε of the matrix A^−½ S A^−½: its Frobenius norm is at most ε times the mean of the row
    /// sums of X, weighted by areas. That mean is at most the largest ‖X x‖ / ‖x‖ in the norm ‖x‖² =
    /// Σ A_i x_i², so that a product with any x is off by at most ε of the largest that it could be.
    /// 0..1; 0 stores all entries as `f32`.
    pub tolerance: f64,
    /// Whether rows and columns are scaled until the light that ends is what it was: Σ_j X_ij `ends`_j
    /// of the matrix or, by rays, of the row's own rays.
    pub keep_sums: bool,
}

impl Default for CompressionOptions {
    /// ε = 1e-3, sums kept.
    fn default() -> CompressionOptions {
        CompressionOptions {
            tolerance: 1e-3,
            keep_sums: true,
        }
    }
}

/// Why there are no compressed factors.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum CompressionError {
    /// The tolerance is not a share of the matrix.
    Tolerance {
        /// What was given.
        found: f64,
    },
    /// The form factors could not be computed.
    Factors(FactorsError),
}

impl From<Cancelled> for CompressionError {
    fn from(_: Cancelled) -> CompressionError {
        CompressionError::Factors(FactorsError::Cancelled)
    }
}

impl From<FactorsError> for CompressionError {
    fn from(error: FactorsError) -> CompressionError {
        CompressionError::Factors(error)
    }
}

impl fmt::Display for CompressionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CompressionError::Tolerance { found } => write!(
                f,
                "the tolerance of compression is {found}: expected 0 or more and less than 1, such as 1e-3"
            ),
            CompressionError::Factors(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for CompressionError {}

/// Extended form factors X in blocks between clusters of rows; see the [module](self).
///
/// Rows are those of [`FormFactors`]; *positions* are places in the order of the clusters. All data are
/// plain arrays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CompressedFactors {
    /// The row at each position.
    pub order: Vec<u32>,
    /// The blocks, in parts that are multiplied in parallel. Each pair of positions lies in at most one;
    /// others exchange nothing.
    pub parts: Vec<BlockPart>,
    /// Area of each row, in square scene units.
    pub areas: Vec<f64>,
    /// Share of the light arriving at each row that ends there: 1 − ρ_s, 0 for glass.
    pub ends: Vec<f64>,
    /// Shares of each row's light that reach no column.
    pub rest: Vec<RowRemainder>,
    /// Standard error of Σ_j X_ij `ends`_j of each row.
    pub sum_errors: Vec<f64>,
    /// Variance of each row's entries over their values: one over its rays, for counts of hits. 0
    /// without rays.
    pub entry_noise: Vec<f64>,
    /// Bound of the error by compression before sums were scaled, in units of
    /// [`CompressionOptions::tolerance`]; of a matrix by rays, where nothing bounds it, NaN.
    pub bound: f64,
    /// Largest change of a row and column to keep sums, |d − 1|.
    pub scaled: f64,
    /// Root mean square, over the rows, and largest of what Σ_j X_ij `ends`_j still is off after that:
    /// where rows see what does not see them, as where fronts and backs are mixed up, no factors of at
    /// most 4 reconcile them.
    pub deficit: [f64; 2],
    /// Rays traced from patches.
    pub rays: u64,
}

impl CompressedFactors {
    /// Compresses a matrix. `places` are a point and the normal of each row, see
    /// [`PreparedPlan::places`](crate::form_factors::PreparedPlan::places).
    ///
    /// Takes 12 bytes per pair besides the result. Values of low rank may be negative, by no more than
    /// the tolerance. The same bits for any number of threads.
    ///
    /// # Errors
    /// [`CompressionError`].
    ///
    /// # Panics
    /// If there is not one place for each row.
    pub fn new(
        factors: &FormFactors,
        places: &[PointNormal],
        options: &CompressionOptions,
        progress: &Progress,
    ) -> Result<CompressedFactors, CompressionError> {
        options.check()?;
        assert_eq!(places.len(), factors.len(), "one place for each row");
        // The pairs by positions in the order of clusters.
        let clusters = Clusters::new(places, &factors.areas, compress::LEAF);
        let positions = clusters.positions();
        let mut pairs = Vec::with_capacity(factors.exchange.pairs());
        for (i, &p) in positions.iter().enumerate() {
            let upper = factors.exchange.upper(i).iter();
            let pair = |q: u32, value: f64| PairArea::new(p, positions[q as usize], value as f32);
            pairs.extend(upper.map(|e| pair(e.column, e.value)));
        }
        progress.begin("compression", pairs.len() as u64);
        let light: f64 = factors.exchange.row_sums().iter().sum();
        let scale = ratio(light, clusters.whole());
        let compression = Compression {
            clusters: &clusters,
            allowed: options.tolerance * scale,
            progress,
        };
        // Blocks with the error that the tolerance allows, in the norm of the whole matrix.
        let mut compressed = CompressedFactors {
            areas: factors.areas.clone(),
            ends: factors.ends.clone(),
            rest: factors.rest.clone(),
            sum_errors: ended_errors(factors),
            rays: factors.rays,
            ..CompressedFactors::default()
        };
        if !factors.is_empty() {
            let blocks = compression.diagonal(0, &mut pairs)?;
            drop(pairs);
            compressed.bound = ratio((2.0 * blocks.error).sqrt(), scale);
            compressed.parts = blocks::store(blocks.blocks);
        }
        compressed.order = clusters.tree.order;
        let sums = factors.row_sums();
        let noise = factors.noise_of_sums();
        let noise = noise.iter().zip(&sums);
        compressed.entry_noise = noise.map(|(e, &sum)| ratio(e * e, sum)).collect();
        if options.keep_sums && options.tolerance > 0.0 {
            compressed.keep_sums(&factors.ended(), progress)?;
        }
        Ok(compressed)
    }

    /// What is known of the rows of these factors, which were computed from `plan` by rays: a matrix
    /// without pairs, whose `exchange` has no rows.
    ///
    /// # Panics
    /// If the plan has other rows.
    pub fn rows_alone(&self, plan: &PreparedPlan) -> FormFactors {
        assert_eq!(self.len(), plan.rows(), "the rows of the plan");
        let mut rows = FormFactors {
            rest: self.rest.clone(),
            rays: self.rays,
            engine_used: plan.rays_used(),
            ..FormFactors::default()
        };
        plan.describe(&mut rows);
        let sums = self.sums();
        rows.is_closed = rows.seeing_lose_no_light(|i| sums[i] > 0.0);
        rows
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// S_ij, in square scene units. Searches all blocks: products are faster for many pairs.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn exchange_area(&self, i: usize, j: usize) -> f64 {
        let position = |row: usize| {
            let place = self.order.iter().position(|&r| r as usize == row);
            place.expect("a row of these factors") as u32
        };
        let (p, q) = (position(i), position(j));
        let area = |part: &BlockPart| part.get(p.min(q), p.max(q));
        self.parts.iter().find_map(area).unwrap_or(0.0)
    }

    /// X x with its standard errors by the noise of rays, if the numbers of x have none of their own.
    ///
    /// X x is a row's sum times a mean of x over what the row sees. The sum has its own error. Hits of
    /// rays, each 1/N of the row, give the mean the variance (X x² − (X x)² / X 1) / N; for rays that
    /// Sobol's points distribute it is an upper estimate. Errors of compression are not in it.
    ///
    /// # Panics
    /// If `x` has another length than there are rows.
    pub fn apply_with_errors(&self, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let squares: Vec<f64> = x.iter().map(|x| x * x).collect();
        let (products, squares, sums) = (self.apply(x), self.apply(&squares), self.sums());
        let error = |i: usize| {
            if sums[i] <= 0.0 {
                return 0.0;
            }
            let mean = products[i] / sums[i];
            let spread = (squares[i] - products[i] * mean).max(0.0);
            (self.entry_noise[i] * spread + (self.sum_errors[i] * mean).powi(2)).sqrt()
        };
        let errors = (0..products.len()).map(error).collect();
        (products, errors)
    }

    /// Number of blocks that are sparse, dense and of low rank.
    pub fn kinds(&self) -> [usize; 3] {
        let mut kinds = [0; 3];
        for block in self.parts.iter().flat_map(|p| &p.blocks) {
            kinds[match block.kind {
                BlockKind::Sparse => 0,
                BlockKind::Dense => 1,
                BlockKind::LowRank { .. } => 2,
            }] += 1;
        }
        kinds
    }

    fn by_position(&self, x: &[f64]) -> Vec<f64> {
        self.order.iter().map(|&row| x[row as usize]).collect()
    }

    /// Scales rows until Σ_j X_ij `ends`_j is `sums`_i.
    fn keep_sums(&mut self, sums: &[f64], progress: &Progress) -> Result<(), Cancelled> {
        let areas = sums.iter().zip(&self.areas).map(|(t, a)| t * a);
        let targets = self.by_position(&areas.collect::<Vec<f64>>());
        let weights = self.by_position(&self.ends);
        let factors = scaling::scale(&mut self.parts, &weights, &targets, progress)?;
        self.scaled = factors
            .iter()
            .fold(0.0, |most, d| most.max((d - 1.0).abs()));
        let off = self.apply(&self.ends);
        let off = || off.iter().zip(sums).map(|(scaled, sum)| scaled - sum);
        let squares: f64 = off().map(|d| d * d).sum();
        let most = off().fold(0.0f64, |most, d| most.max(d.abs()));
        self.deficit = [(squares / self.len().max(1) as f64).sqrt(), most];
        Ok(())
    }
}

/// Standard error of Σ_j X_ij `ends`_j of each row, if entries erred by themselves.
fn ended_errors(factors: &FormFactors) -> Vec<f64> {
    let variances = factors.exchange.sums(|i, e| {
        let error = f64::from(e.error);
        [e.column as usize, i].map(|to| (error * factors.ends[to]).powi(2))
    });
    let rows = variances.iter().zip(&factors.areas);
    rows.map(|(v, &a)| ratio(v.sqrt(), a)).collect()
}

impl CompressionOptions {
    fn check(&self) -> Result<(), CompressionError> {
        if (0.0..1.0).contains(&self.tolerance) {
            Ok(())
        } else {
            let tolerance = self.tolerance;
            Err(CompressionError::Tolerance { found: tolerance })
        }
    }
}
