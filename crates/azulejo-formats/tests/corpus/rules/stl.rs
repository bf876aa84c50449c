//! STL: solids and triangles in the file, positions and bounding box from assimp.

use super::Quantity::{Bounds, Objects, Positions, Triangles};
use super::{Exception, Expected, Rules};

pub const RULES: Rules = Rules {
    folders: &["stl/"],
    compared: &[
        (Objects, &["raw_objects"]),
        (Positions, &["assimp_distinct_positions_per_mesh"]),
        (Triangles, &["raw_triangles"]),
        (Bounds, &["assimp"]),
    ],
    allowed: &[],
    exceptions: &[Exception {
        path: "stl/trimesh/empty.stl",
        quantity: Objects,
        expected: Expected::Nothing,
        why: "a solid without facets",
    }],
};
