//! VRML97: triangles and box as Coin or MeshLab have them.

use super::Quantity::{Bounds, Triangles};
use super::Rules;

pub const RULES: Rules = Rules {
    folders: &["wrl/"],
    compared: &[
        (Triangles, &["second_triangles", "third_triangles"]),
        (Bounds, &["second", "third"]),
    ],
    allowed: &[],
    exceptions: &[],
};
