//! PLY: what the header says.

use super::Quantity::{Bounds, Faces, Objects, Triangles, Vertices};
use super::Rules;

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
    exceptions: &[],
};
