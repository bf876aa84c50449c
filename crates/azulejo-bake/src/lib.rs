//! Lightmaps: irradiance in the texels of a second set of texture coordinates.
mod atlas;
mod buried;
mod coverage;
mod direct;
mod encode;
mod field;
mod indirect;
mod lattice;
pub mod layout;
mod lightmap;
mod pad;
pub mod page;
mod receiver;
mod samples;
mod seams;
mod solids;
mod stitch;
pub mod unwrap;
pub use atlas::Atlas;
pub use coverage::{Coverage, CoveredTexel, Piece, TriangleId};
pub use direct::{SampleDirect, direct};
pub use encode::srgb_bytes;
pub use field::TexelField;
pub use indirect::{
    NodeLattice, NodeLight, NodeRequest, TexelStatistics, first_look, with_indirect,
};
pub use layout::{Layout, ReceiverLayout};
pub use lightmap::{Lightmap, LightmapPage, QuarterLight, TexelLight};
pub use pad::{fill, pad_charts};
pub use receiver::Receiver;
pub use samples::{Samples, TexelSample};
pub use stitch::{SeamErrors, stitch};
pub use unwrap::{LayoutError, Resolution, UnwrapOptions, unwrap};
