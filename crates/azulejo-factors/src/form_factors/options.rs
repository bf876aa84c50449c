//! Options of form factor computations.

use super::group_plan::GroupBy;
use crate::engine::Engine;
use crate::patch::PatchSize;

/// Options of [`form_factors`](super::form_factors).
#[derive(Clone, Debug, PartialEq)]
pub struct FormFactorOptions {
    /// The engine.
    pub engine: Engine,
    /// The groups over which rows are added up, where nothing else is wanted of them
    /// ([`FormFactors::grouped`](super::FormFactors::grouped)). Division and samples are then planned for their
    /// sums, in place of `size`, `rays` and [`Hemicube::points`](crate::Hemicube::points).
    pub groups: Option<GroupBy>,
    /// How finely faces are divided; `PatchSize::Edge(0.0)` keeps them whole, but cuts concave ones
    /// into convex pieces.
    pub size: PatchSize,
    /// Rays per row, rounded up to a multiple of four, at most [`MOST_RAYS`]. The error of a row
    /// falls as rays^−0.6.
    pub rays: u32,
    /// Whether the backs of patches are rows and columns of their own.
    pub two_sided: bool,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Whether close pairs, and pairs with emitters, are computed by formula where that has the
    /// smaller standard error.
    pub analytic: bool,
    /// RMS error of the sums of rows that the analytic engine has to reach before closure; below
    /// 1e-6 all pairs are exact to about that. `None` is 1e-11 for up to 32 rows, else 5e-5,
    /// or 3e-4 where [`Engine::Auto`] finds that to take long.
    pub accuracy: Option<f64>,
    /// Whether direct light, light by one mirror, and light by more mirrors or through glass are
    /// also kept separately ([`FormFactors::orders`](super::FormFactors::orders)).
    pub separate: bool,
    /// Whether closure is enforced.
    pub closure: Closure,
    /// Bytes that may be used. Computations whose forecast exceeds this are refused.
    pub memory: u64,
}

/// Which scenes have closure enforced: rows changed within their errors so that no light is
/// missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Closure {
    /// None: rows add up as well as the estimates do.
    Never,
    /// Closed scenes without mirrors and glass, where rows sum to 1.
    #[default]
    Closed,
    /// All: in open scenes rows, sky and ground together sum to 1; with mirrors, what they reflect
    /// is counted once. Scenes with coloured mirrors are left alone, because the mean of three
    /// channels preserves no sum, and so are those with glass, in which light does not end, or
    /// with glossy surfaces.
    Always,
}

/// Most rays per row: their sample points take 4 bytes each.
pub const MOST_RAYS: u32 = 1 << 24;

impl Default for FormFactorOptions {
    /// About 2,500 patches, fronts only, 4,096 rays each, formulas where they pay, unlimited
    /// memory.
    fn default() -> FormFactorOptions {
        FormFactorOptions {
            engine: Engine::Auto,
            groups: None,
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
