//! glTF: primitives and the box as assimp has them.

use super::Quantity::{Bounds, Triangles};
use super::Rules;

pub const RULES: Rules = Rules {
    folders: &["gltf/"],
    compared: &[
        (Triangles, &["assimp_triangles", "raw_triangles"]),
        (Bounds, &["assimp"]),
    ],
    allowed: &[],
    exceptions: &[],
};
