//! What is asked of form factors.

use crate::engine::Engine;
use crate::patch::PatchSize;

/// What [`form_factors`](super::form_factors) should do.
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
    /// Error of the sums of rows, as an RMS over all, that the analytic engine is to keep within
    /// before anything is closed; below 1e-6 all pairs are exact to about that. `None` is 1e-11
    /// for up to 32 rows, else 5e-5.
    pub accuracy: Option<f64>,
    /// Whether light that comes straight, by one mirror, and by more of them or through glass,
    /// is also kept apart ([`FormFactors::orders`](super::FormFactors::orders)).
    pub separate: bool,
    /// Which scenes have their rows made to add up.
    pub closure: Closure,
    /// Bytes that may be used. What needs more, by a forecast, is refused before it begins.
    pub memory: u64,
}

/// Which scenes have rows changed within their errors so that no light is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Closure {
    /// None: rows add up as well as the estimates do.
    Never,
    /// Closed scenes without mirrors and glass, where rows sum to 1.
    #[default]
    Closed,
    /// All: in open scenes rows, sky and ground together sum to 1; with mirrors what they reflect
    /// is counted once. Scenes with coloured mirrors are left alone, because the mean of three
    /// channels keeps no sum, and so are those with glass, in which light does not end.
    Always,
}

/// More rays per row than this are not traced.
pub const MOST_RAYS: u32 = 1 << 20;

impl Default for FormFactorOptions {
    /// About 2,500 patches seen from their fronts, 4,096 rays each, formulas where they pay, all
    /// the memory that there may be.
    fn default() -> FormFactorOptions {
        FormFactorOptions {
            engine: Engine::Auto,
            size: PatchSize::Count(2_500),
            rays: 4_096,
            two_sided: false,
            seed: 0,
            analytic: true,
            accuracy: None,
            separate: false,
            closure: Closure::Closed,
            memory: u64::MAX,
        }
    }
}
