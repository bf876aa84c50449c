//! Form factors as a product: the whole matrix, with a standard error for every entry.
//!
//! 1. `near` finds the pairs for which a formula pays: close ones, and those with lamps. Their
//!    direct part is the exact form factor times the visible fraction.
//! 2. `rows` traces rays from every side of every patch.
//! 3. `merge` makes one exchange area of the two estimates that the sides of a pair give.
//! 4. `restore` changes closed scenes within their errors so that rows sum to 1.
//!
//! [`form_factors`] does all four, in this order.

mod boxes;
mod exchange;
mod merge;
mod near;
mod restore;
mod rows;
mod shaft;
mod sides;

use crate::engine::{Engine, Estimator, Ran};
use crate::patch::{FaceId, PatchSize, Patches};
use crate::row::Columns;
use crate::solve::SolveError;
use crate::stand_in::StandIn;
use azulejo_scene::Scene;
use azulejo_trace::sampling::hash;
use azulejo_trace::{Gatherer, Progress, Surfaces, Tracer};
pub use exchange::{Exchange, ExchangeAreas};
use sides::Sides;
use std::ops::Range;

/// What [`form_factors`] should do.
#[derive(Clone, Debug, PartialEq)]
pub struct FormFactorOptions {
    /// Who computes them.
    pub engine: Engine,
    /// How finely faces are divided; `PatchSize::Edge(0.0)` leaves them whole, but cuts concave
    /// ones into convex pieces.
    pub size: PatchSize,
    /// Rays per row, rounded up to a multiple of four, at most [`MOST_RAYS`]. The error of a row
    /// falls as rays^−0.6.
    pub rays: u32,
    /// Whether the backs of patches are rows and columns of their own.
    pub two_sided: bool,
    /// Another seed gives other noise.
    pub seed: u64,
    /// Whether close pairs, and pairs with patches that emit, are computed by formula where that
    /// has the smaller standard error.
    pub analytic: bool,
}

/// More rays per row than this are not traced: a thread keeps 64 bytes for each.
pub const MOST_RAYS: u32 = 1 << 20;

/// Entries that are looked at together where whole rows are wanted: 64 MiB of them.
const BLOCK: usize = 1 << 22;

impl Default for FormFactorOptions {
    /// About 2,500 patches seen from their fronts, 4,096 rays each, formulas where they pay.
    fn default() -> FormFactorOptions {
        FormFactorOptions {
            engine: Engine::Auto,
            size: PatchSize::Count(2_500),
            rays: 4_096,
            two_sided: false,
            seed: 0,
            analytic: true,
        }
    }
}

/// The extended form factors X of a scene: X_ij is the share of the light leaving row i
/// diffusely that arrives at column j, directly or after any chain of mirrors and glass, with
/// its whole weight (additive model, Sillion and Puech 1989).
///
/// Rows and columns are the same list. Without `two_sided` it is the fronts of the patches, in
/// the order of [`Patches`]: light that meets a back ends there, unless it is covered by a front
/// (two patches in one place, back to back). With it, front and back of
/// patch p are entries 2p and 2p + 1. Where mirrors are coloured X is the mean of the three
/// channels.
///
/// Reciprocity is exact: one number S_ij is kept per pair, and X_ij is S_ij / A_i, rounded. It
/// holds for mirrors and for glass between equal media, so X is not defined where a patch lies
/// inside glass. Pairs are stored sparsely; one that is absent is an estimate of 0. X is not
/// negative, and at most 1 for patches that no mirror shows twice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FormFactors {
    /// S_ij = A_i X_ij of every pair, with its standard error: two to either side hold the truth
    /// 95 times in 100.
    pub exchange: ExchangeAreas,
    /// Area of each row, in square scene units.
    pub areas: Vec<f64>,
    /// The face that each row is a piece of.
    pub faces: Vec<FaceId>,
    /// Whether each row is the back of its patch.
    pub is_back: Vec<bool>,
    /// Error to be expected of each row, Σ_j E|error of X_ij|: for normal errors √(2/π) times the
    /// sum of the standard errors. In rooms with known entries 1.2 to 1.3 times the true one.
    pub row_errors: Vec<f64>,
    /// Share of each row's light that leaves the scene, as its own rays found it.
    pub escaped: Vec<f64>,
    /// Share that was not followed to its end between mirrors: what was too weak.
    pub cut: Vec<f64>,
    /// Share that ends on sides which have no column: backs, without `two_sided`.
    pub hidden: Vec<f64>,
    /// What the restoration of rows changed: Σ|ΔS_ij| / ΣS_ij; 0 without one.
    pub correction: f64,
    /// Whether no row that sees anything loses light to the outside, but for 1e-6 of it. Closed
    /// scenes without mirrors and glass are restored: rows sum to 1 − `hidden` − `cut`.
    pub is_closed: bool,
    /// Rays traced from patches, without those that mirrors and visibility tests added.
    pub rays: u64,
    /// Which engine ran.
    pub ran: Ran,
}

impl FormFactors {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Column, X and standard error of each entry of row `i`, columns ascending. Searches all
    /// rows above: [`rows`](FormFactors::rows) finds many at once.
    ///
    /// # Panics
    /// Without such a row.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (u32, f64, f32)> {
        self.rows(i..i + 1).into_iter().flatten()
    }

    /// Column, X and standard error of the entries of some rows, columns ascending.
    ///
    /// # Panics
    /// If the range goes beyond the last row.
    pub fn rows(&self, range: Range<usize>) -> Vec<Vec<(u32, f64, f32)>> {
        let rows = self.exchange.rows(range.clone());
        let factors = |(i, row): (usize, Vec<Exchange>)| {
            let factor = |e: Exchange| {
                let (value, error) = self.factor(i, e);
                (e.column, value, error)
            };
            row.into_iter().map(factor).collect()
        };
        range.zip(rows).map(factors).collect()
    }

    /// Ranges of rows, in order, each of a few million entries: as much as
    /// [`rows`](FormFactors::rows) should be asked for at a time.
    pub fn blocks(&self) -> Vec<Range<usize>> {
        let (mut blocks, mut start, mut entries) = (Vec::new(), 0, 0);
        for (i, length) in self.exchange.row_lengths().iter().enumerate() {
            entries += length;
            if entries >= BLOCK || i + 1 == self.len() {
                blocks.push(start..i + 1);
                (start, entries) = (i + 1, 0);
            }
        }
        blocks
    }

    /// X_ij and its standard error; zeros if the pair is absent.
    ///
    /// # Panics
    /// Without a row of the smaller number.
    pub fn get(&self, i: usize, j: u32) -> (f64, f32) {
        self.factor(i, self.exchange.get(i, j as usize))
    }

    /// Σ_j X_ij of every row. Without mirrors it is 1 less what escapes or is hidden, but for
    /// noise, which restoration takes away in closed scenes. With mirrors that is
    /// Σ_j X_ij (1 − ρ_s,j), so that the plain sum exceeds 1.
    pub fn row_sums(&self) -> Vec<f64> {
        let sums = self.exchange.row_sums();
        sums.iter().zip(&self.areas).map(|(s, a)| s / a).collect()
    }

    fn factor(&self, i: usize, e: Exchange) -> (f64, f32) {
        let area = self.areas[i];
        (e.value / area, (f64::from(e.error) / area) as f32)
    }
}

/// Computes the form factors of a scene; lights play no part, but for the choice of formulas.
///
/// Rows of exact shapes are pieces of the polygons that [`faceted`](crate::faceted) puts in their
/// place. The result is the same to the bit for any number of threads. Beside the result it takes 12
/// bytes for each entry that rays found.
///
/// # Errors
/// [`SolveError::NoSurface`], [`SolveError::Cancelled`].
///
/// ```
/// use azulejo_radiosity::{FormFactorOptions, PatchSize, form_factors};
/// use azulejo_scene::synthetic::cube_room;
/// use azulejo_trace::{Progress, Tracer};
///
/// let scene = cube_room();
/// let whole = FormFactorOptions { size: PatchSize::Edge(0.0), ..Default::default() };
/// let factors = form_factors(&scene, &Tracer::new(&scene), &whole, &Progress::new())?;
/// let (opposite, error) = factors.get(0, 1);
/// assert!((opposite - 0.19982489569839).abs() < 1e-9, "{opposite} ± {error}");
/// # Ok::<(), azulejo_radiosity::SolveError>(())
/// ```
pub fn form_factors(
    scene: &Scene,
    tracer: &Tracer,
    options: &FormFactorOptions,
    progress: &Progress,
) -> Result<FormFactors, SolveError> {
    let stand_in = StandIn::new(scene, tracer, options.size);
    let (scene, tracer) = (stand_in.scene.as_ref(), stand_in.tracer.as_ref());
    let patches = Patches::new(scene, options.size);
    if patches.is_empty() {
        return Err(SolveError::NoSurface);
    }
    let sides = Sides::new(&patches, options.two_sided);
    let gatherer = Gatherer::new(Surfaces::new(scene, tracer));
    let seed = hash(&[options.seed as u32, (options.seed >> 32) as u32]);
    let exact = match options.analytic {
        true => near::exact(&sides, gatherer.surfaces(), hash(&[seed, 0]), progress)?,
        false => vec![Vec::new(); sides.len()],
    };
    let rays = options.rays.min(MOST_RAYS);
    let (estimator, ran) = Estimator::new(
        &options.engine,
        &gatherer,
        &patches,
        rays,
        hash(&[seed, 1]),
        Columns::All,
    );
    let traced = rows::trace(&sides, &gatherer, &exact, &estimator, progress)?;
    let mut factors = merge::merge(&sides, &traced, &exact, progress)?;
    factors.ran = ran;
    factors.is_closed = restore::is_closed(&factors);
    let is_specular = scene.materials.iter().any(|m| m.is_specular());
    if factors.is_closed && !is_specular {
        factors.correction = restore::restore(&mut factors, progress)?;
    }
    factors.row_errors = row_errors(&factors);
    Ok(factors)
}

/// What is known of a row once its entries are.
fn row_errors(factors: &FormFactors) -> Vec<f64> {
    let sums = factors.exchange.sums(|_, e| f64::from(e.error));
    let expected = std::f64::consts::FRAC_2_PI.sqrt();
    let rows = sums.iter().zip(&factors.areas);
    rows.map(|(sum, area)| expected * sum / area).collect()
}
