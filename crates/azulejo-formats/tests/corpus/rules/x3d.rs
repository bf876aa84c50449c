//! X3D: triangles and box as MeshLab or assimp have them.

use super::Quantity::{Bounds, Triangles};
use super::Rules;

pub const RULES: Rules = Rules {
    folders: &["x3d/"],
    compared: &[
        (Triangles, &["second_triangles", "assimp_triangles"]),
        (Bounds, &["second", "assimp"]),
    ],
    allowed: &[],
    exceptions: &[],
};
