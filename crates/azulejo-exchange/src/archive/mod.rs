//! Enclosures as `.npz` archives, which NumPy and SciPy read.
//!
//! | array | per | content |
//! |---|---|---|
//! | `format`, `shape`, `indptr`, `indices`, `data` | | X in compressed sparse rows, for `scipy.sparse.load_npz` |
//! | `std_error` | entry | standard errors |
//! | `direct`, `one_mirror`, `more_mirrors`, each with `…_error` | entry | orders of reflection, if they were kept |
//! | `areas`, `row_error`, `sky`, `sky_error`, `ground`, `ground_error`, `escaped`, `hidden`, `cut`, `lost`, `unseen` | row | see [`FormFactors`](azulejo_factors::FormFactors) |
//! | `irradiance`, `irradiance_error` (n × 3) | row | light from outside, if there is any |
//! | `names`, `patch_face` (n × 2: object, face), `patch_back`, `material`, `rho_s`, `diffuse` (n × 3) | row | what the row is |
//! | `centroids`, `normals` (n × 3) | row | its place |
//! | `points` (m × 3), `cell_corners`, `cell_starts`, `cell_rows` | | its polygons |
//! | `group_faces` (m × 3: object, face, row) | | the faces of groups |
//! | `object_names`, `material_names` | | what `patch_face` and `material` count |
//! | `metres_per_unit`, `up`, `engine`, `rays`, `groups`, `closed`, `version` | | the whole |

mod read;
#[cfg(test)]
mod tests;
mod write;

pub use read::{ArchiveError, ReadEnclosure, read, reciprocal};
pub use write::{ArchivePrecision, write};

/// Array names of the separate orders of reflection.
const ORDERS: [[&str; 2]; 3] = [
    ["direct", "direct_error"],
    ["one_mirror", "one_mirror_error"],
    ["more_mirrors", "more_mirrors_error"],
];

/// The layout's number. Archives without one come from elsewhere.
const VERSION: i64 = 1;
