//! The first pass: from a scene to irradiance, once for all viewpoints.
//!
//! [`solve()`] divides the faces into [`Patches`], computes the extended
//! form factors between them with `azulejo-factors`, solves the radiosity system, and gathers
//! irradiance at the vertices; [`probe`] gathers it at any points. Results carry standard errors
//! and are the same to the bit for any number of threads.
//!
//! | read in this order | purpose |
//! |---|---|
//! | [`mod@solve`] | the whole pass; `first_pass` has its options, `report` what it did, `error` why it failed |
//! | [`solved`] | the light on patches, before it is gathered |
//! | [`direct`] | direct light of patches |
//! | [`SolvedLight`], [`IrradianceField`] | the light of patches for any points, also with finer light of others |
//! | [`system`] | rows of form factors and their solution by Jacobi iteration |
//! | [`refine`] | more rays for the rows that dominate the error |
//! | [`stochastic`] | Stochastic Jacobi, which needs no rows |
//! | [`particles`] | particles from the lights, which need no rows either |
//! | [`gather`], [`light`], [`vertices`] | irradiance at points, from the light on patches; `gather_pass`, `gathering`, `gathered_values` are its steps and their results |
//! | [`strata`], `validation` | where the patches are good enough for that, and where paths are traced |
//! | `plan` | whether light between patches pays, or paths alone are cheaper |
//! | `deadline` | what the time until a deadline suffices for |
//! | `sparse`, `records`, `interpolation` | many points from few of them |
//! | [`sites`] | texels, or other sites in cells, from nodes that paths correct |
//! | `standard_errors` | errors of single points, from their own spread and that of points like them |
//! | [`StoredSides`] | which side of a surface is stored |
//!
//! Exact shapes are divided as polygons ([`faceted`](azulejo_factors::faceted)).

mod coarse;
mod deadline;
pub mod direct;
mod error;
mod fine_light;
mod first_pass;
pub mod gather;
mod gather_pass;
mod gathered_values;
mod gathering;
mod interpolation;
pub mod light;
pub mod particles;
mod path_pairs;
mod plan;
mod preview;
mod records;
pub mod refine;
mod report;
mod sides;
pub mod sites;
pub mod solve;
pub mod solved;
mod solved_light;
mod sparse;
mod standard_errors;
pub mod stochastic;
pub mod strata;
pub mod system;
mod validation;
pub mod vertices;

pub use azulejo_factors::{Engine, EngineUsed, PatchSize, Patches, PointNormal};
pub use error::SolveError;
pub use fine_light::IrradianceField;
pub use first_pass::FirstPass;
pub use path_pairs::{PairTargets, PathPair};
pub use preview::{Preview, PreviewStage};
pub use report::{Estimate, Method, Report};
pub use sides::StoredSides;
pub use solve::{LightSolution, solve, solve_watched};
pub use solved::{PatchRadiosity, radiosity};
pub use solved_light::{Probed, SolvedLight, SplitLight, probe};
pub use system::EnergyBalance;
