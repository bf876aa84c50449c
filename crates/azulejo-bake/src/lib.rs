//! Lightmaps: the irradiance of surfaces in the texels of a second set of texture coordinates.
//!
//! | Step | Modules |
//! |---|---|
//! | Surfaces that receive light | [`Receiver`] |
//! | Charts, which end where light jumps, packed on pages | [`unwrap()`], [`layout`]: an [`Atlas`] |
//! | Which charts need more texels, by the light that they get | [`chart_importance`], [`repack_charts`] |
//! | Charts of coordinates that surfaces have already | [`kept_layout`] |
//! | What each texel covers, exactly, and the points at which it needs light | [`Coverage`], [`Samples`] |
//! | Direct light of each texel, more finely at the edges of shadows | [`direct()`] |
//! | Indirect light at some of them, interpolated, more finely where leaving one out shows an error | [`TexelCells`], with [`sites`](azulejo_radiosity::sites) |
//! | How much of the hemisphere over a point is free | [`Hemispheres`] |
//! | What is wrong with texture coordinates, ours or anybody's | [`check()`](check::check) |
//! | Texels without what lies inside of solids, continued around charts, alike on both sides of seams | [`Lightmap`], [`pad_charts`], [`stitch`], [`fill`] |
//! | What they are too coarse for, added to their errors | [`BetweenTexels`] |
//! | What surfaces reflect in each texel, for pictures of the light that leaves them | [`texel_colors`] |
//! | A model with its lightmaps and a viewer in one HTML file | [`web_page`] |
//!
//! `azulejo::lightmap::bake` brings this together with the light of a scene.
//!
//! Several processes can share the work ([`Run`](azulejo_trace::Run)): what is expensive is divided between them, and all get the
//! results of all, with the bits of one process.

mod atlas;
mod buried;
pub mod check;
mod coverage;
mod denoise;
mod direct;
mod encode;
mod field;
mod harmonics;
mod importance;
mod kept;
mod lattice;
pub mod layout;
mod lightmap;
mod lightmap_page;
mod occlusion;
mod pad;
mod receiver;
mod reflectance;
mod regions;
mod resolution;
mod samples;
mod seams;
mod solids;
mod stitch;
mod thin;
pub mod unwrap;
mod unwrap_mesh;
pub mod web_page;
pub use atlas::Atlas;
pub use buried::shares_inside;
pub use coverage::{Coverage, CoveredPiece, CoveredTexel, TriangleId};
pub use denoise::denoise;
pub use direct::{DirectGather, DirectTexels, direct, direct_from};
pub use encode::{linear_bytes, srgb_bytes, srgb_bytes_up_to};
pub use field::TexelField;
pub use harmonics::{DIRECTIONAL, HarmonicGather, TexelHarmonics};
pub use importance::{ChartImportance, chart_importance};
pub use kept::kept_layout;
pub use lattice::TexelCells;
pub use layout::{Layout, ReceiverLayout};
pub use lightmap::{Lightmap, QuarterLight, ShownSample, ShownSamples};
pub use lightmap_page::LightmapPage;
pub use occlusion::Hemispheres;
pub use pad::{fill, pad_charts};
pub use receiver::Receiver;
pub use reflectance::{SurfaceColor, texel_colors};
pub use resolution::{BetweenTexels, PointGather};
pub use samples::{Samples, TexelSample, sample_points};
pub use solids::backs_inside;
pub use stitch::{SeamErrors, seam_errors, stitch};
pub use unwrap::{LayoutError, Resolution, UnwrapOptions, repack, repack_charts, unwrap};
