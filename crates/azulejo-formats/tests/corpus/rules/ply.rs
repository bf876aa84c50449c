//! PLY: counts in the header.

use super::Quantity::{Bounds, Faces, Objects, Triangles, Vertices};
use super::{Exception, Expected, Quantity, Rules};

pub const RULES: Rules = Rules {
    folders: &["ply/"],
    compared: &[
        (Objects, &["raw_objects"]),
        (Vertices, &["raw_vertices"]),
        (Faces, &["raw_faces"]),
        (Triangles, &["second_triangles"]),
        (Bounds, &["second"]),
    ],
    allowed: &[],
    exceptions: &[
        nothing("ply/assimp/issue623.ply", Objects, LISTS),
        nothing("ply/assimp/issue623.ply", Vertices, LISTS),
        nothing("ply/assimp/points.ply", Objects, POINTS),
        nothing("ply/assimp/points.ply", Vertices, POINTS),
        nothing(
            "ply/trimesh/empty.ply",
            Objects,
            "the header promises nothing",
        ),
        nothing("ply/trimesh/points_ascii_with_lists.ply", Objects, POINTS),
        nothing("ply/trimesh/points_ascii_with_lists.ply", Vertices, POINTS),
    ],
};

const POINTS: &str = "points without faces have no surface";
const LISTS: &str = "the element of the faces has been cut out of the header and of the rows";

const fn nothing(path: &'static str, quantity: Quantity, why: &'static str) -> Exception {
    Exception {
        path,
        quantity,
        expected: Expected::Nothing,
        why,
    }
}
