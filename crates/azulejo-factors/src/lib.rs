//! Form factors: the share of the light leaving one patch that arrives at another.
//!
//! [`form_factors()`] divides a scene into [`Patches`] and computes the matrix between all of them,
//! each entry with its standard error; [`form_factors_from`] computes one row. An extended form
//! factor counts light that arrives directly, by mirrors or through glass. Nothing here solves for
//! light: `azulejo-radiosity` does, from the rows that an [`Estimator`](estimator::Estimator) returns.
//!
//! ```
//! use azulejo_factors::{FormFactorOptions, PatchSize, form_factors};
//! use azulejo_scene::synthetic::cube_room;
//! use azulejo_trace::{Progress, Tracer};
//!
//! // The six faces of a closed cube, each a single patch.
//! let scene = cube_room();
//! let options = FormFactorOptions { size: PatchSize::Edge(0.0), ..Default::default() };
//! let factors = form_factors(&scene, &Tracer::new(&scene), &options, &Progress::new())?;
//! let (to_opposite, standard_error) = factors.get(0, 1);
//! assert!((to_opposite - 0.19982489569839).abs() < 1e-9, "{to_opposite} ± {standard_error}");
//! // What leaves a face of a closed room arrives at the others.
//! assert!(factors.row_sums().iter().all(|sum| (sum - 1.0).abs() < 1e-6));
//! # Ok::<(), azulejo_factors::FactorsError>(())
//! ```
//!
//! | read in this order | purpose |
//! |---|---|
//! | [`patch`] | faces divided into patches; [`faceted`] puts polygons in the place of exact shapes |
//! | [`row`] | a row of form factors, in four replicates whose spread is its error |
//! | [`samples`] | how many rays or hemicubes each row takes |
//! | [`engine`] | the engines and the choice between them |
//! | [`rays`] | rows by rays (Malley's method) |
//! | [`hemicube`] | rows by item buffers, on the processor or a graphics card |
//! | [`analytic`] | closed forms of pairs of polygons, with exact shadows and mirror images |
//! | [`form_factors`](mod@form_factors) | the matrix: merging, closure, grouping, truncation |
//! | [`hierarchy`] | the same for 100,000 patches and more, as blocks between clusters |
//! | [`sparse`], [`cholesky`] | compressed rows for solvers, and a solver of small systems |

pub mod analytic;
mod analytic_engine;
mod choice;
pub mod cholesky;
mod cluster_tree;
mod disjoint_sets;
pub mod engine;
mod error;
pub mod estimator;
mod exchange_areas;
pub mod facing;
pub mod form_factors;
pub mod hemicube;
pub mod hierarchy;
pub mod patch;
pub mod proxy;
pub mod rays;
pub mod row;
pub mod samples;
mod shadow_rays;
pub mod sparse;

pub use choice::{EngineChoice, FactorsChoice, FormulaTime};
pub use engine::{Engine, EngineUsed, Hemicube, HemicubeBackend};
pub use error::FactorsError;
pub use form_factors::{
    Closure, Factor, FactorsFrom, FormFactorOptions, FormFactors, GroupBy, form_factors,
    form_factors_from,
};
pub use hierarchy::{CompressedFactors, CompressionOptions, FactorOperator};
pub use patch::{
    DisplayVertex, FaceId, GivenVertex, PatchPoint, PatchSize, Patches, Polygon, RefinedShape,
    reflectances,
};
pub use proxy::{CHORD_ERROR, PointNormal, ProxyScene, faceted};
