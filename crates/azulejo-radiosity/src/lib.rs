//! First pass: from a scene to irradiance, once for all viewpoints.
//!
//! [`solve()`] divides the faces into [`Patches`], traces the extended form factors between them
//! (light that arrives straight, by mirrors or through glass), solves the radiosity system, and
//! gathers irradiance at the vertices; [`probe`] gathers it at any points. The answer carries
//! its standard error, and is the same to the bit for any number of threads.
//!
//! The order of reading: [`patch`] (what is divided), [`rays`] and [`hemicube`] (rows of form
//! factors),
//! [`system`] (their solution; [`refine`] gives more rays to rows that matter; [`stochastic`]
//! does without rows), [`gather`] and [`vertices`]
//! (irradiance), [`mod@solve`] (all of it, in order). Exact shapes are divided as polygons that
//! stand for them ([`faceted`]). [`form_factors`](mod@form_factors)
//! delivers rows for their own sake, with standard errors. [`truth`] holds scenes with known
//! answers, to judge all of it by.

pub mod analytic;
mod choice;
pub mod direct;
pub mod engine;
mod facets;
pub mod form_factors;
pub mod gather;
pub mod hemicube;
pub mod light;
pub mod matrix;
pub mod patch;
pub mod rays;
pub mod refine;
pub mod row;
mod shadow_rays;
pub mod solve;
pub mod solved;
mod stand_in;
pub mod stochastic;
pub mod system;
pub mod truth;
pub mod vertices;
mod watch;

pub use engine::{DrawnBy, Engine, Hemicube, Ran};
pub use form_factors::{
    Closure, Factor, FactorsFrom, FormFactorOptions, FormFactors, form_factors, form_factors_from,
};
pub use patch::{
    DisplayVertex, FaceId, GivenVertex, PatchPoint, PatchSize, Patches, Polygon, RefinedShape,
};
pub use solve::{
    Estimate, FirstPass, Light, Method, PointNormal, Probed, Report, SolveError, probe, solve,
    solve_watched,
};
pub use solved::{PatchRadiosity, radiosity};
pub use stand_in::{CHORD_ERROR, faceted};
pub use system::Balance;
pub use watch::{Preview, Settled};
