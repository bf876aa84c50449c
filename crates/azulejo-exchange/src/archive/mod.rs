//! Enclosures as `.npz` archives, which NumPy and SciPy read.
//!
//! | array | per | content |
//! |---|---|---|
//! | `format`, `shape`, `indptr`, `indices`, `data` | | X in compressed sparse rows, for `scipy.sparse.load_npz` |
//! | `std_error` | entry | standard errors |
//! | `direct`, `one_mirror`, `more_mirrors`, each with `…_error` | entry | orders of reflection, if they were kept |
//! | `areas`, `row_error`, `sky`, `sky_error`, `ground`, `ground_error`, `escaped`, `hidden`, `hidden_error`, `cut`, `lost`, `unseen` | row | see [`FormFactors`](azulejo_factors::FormFactors) |
//! | `irradiance`, `irradiance_error` (n × 3) | row | light from outside, if there is any |
//! | `sky_patches`, `sky_patches_error` (n × p) | row | shares toward the patches of the sky, if they were asked for: the ground, and [`SkyDivision`](azulejo_scene::sky::SkyDivision) |
//! | `sky_directions` (p × 3), `sky_solid_angles`, `sky_division`, `sky_north` | patch | their middles as unit vectors of the model, sr; their name, and radians |
//! | `names`, `patch_face` (n × 2: object, face), `patch_back`, `material`, `rho_s`, `diffuse` (n × 3) | row | what the row is |
//! | `centroids`, `normals` (n × 3) | row | its place |
//! | `points` (m × 3), `cell_corners`, `cell_starts`, `cell_rows` | | its polygons |
//! | `group_faces` (m × 3: object, face, row) | | the faces of groups |
//! | `object_names`, `material_names` | | what `patch_face` and `material` count |
//! | `metres_per_unit`, `up`, `engine`, `rays`, `groups`, `closed`, `version` | | the whole |
//!
//! Matrices in blocks between clusters ([`write_blocks`]) have the arrays of rows, cells and the whole too, and
//! instead of the matrix:
//!
//! | array | per | content |
//! |---|---|---|
//! | `format`, `shape` | | `blocks`; n, n |
//! | `order` | row | the row at each position; blocks are ranges of positions |
//! | `block_rows`, `block_columns` (b × 2) | block | its positions: from, to |
//! | `block_kind`, `block_rank` | block | 0 sparse, 1 dense, 2 of low rank; number of terms u vᵀ |
//! | `block_values`, `block_layout` | block | where its numbers start among `values`, and its indices among `layout`; and where the last ends |
//! | `values`, `layout` | | numbers of 32 bits, S or its root; indices of 16 bits, see [`BlockKind`](azulejo_factors::hierarchy::BlockKind) |
//! | `part_blocks` | part | its first block; parts are multiplied at the same time |
//! | `sum_error`, `entry_noise` | row | see [`CompressedFactors`](azulejo_factors::CompressedFactors) |
//! | `tolerance`, `bound`, `scaled`, `deficit` (2) | | likewise |
//! | `product_error` (2), `row_sum_error` (2), `traced_again`, `whole_bytes` | | [`StatedErrors`](azulejo_factors::hierarchy::StatedErrors), each with its standard error; bytes of the whole matrix, or a forecast |

mod blocks;
mod read;
#[cfg(test)]
mod tests;
pub(crate) mod write;

pub use blocks::{BlockArchive, StoredFactors, open, write_blocks};
pub use read::{ArchiveError, ReadEnclosure, read, reciprocal};
pub use write::{ArchivePrecision, write};

/// Array names of the separate orders of reflection.
const ORDERS: [[&str; 2]; 3] = [
    ["direct", "direct_error"],
    ["one_mirror", "one_mirror_error"],
    ["more_mirrors", "more_mirrors_error"],
];

/// The `format` of matrices in blocks.
const BLOCKS: &str = "blocks";

/// The layout's number. Archives without one come from elsewhere.
const VERSION: i64 = 1;
