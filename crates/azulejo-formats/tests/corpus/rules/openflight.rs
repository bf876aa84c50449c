//! OpenFlight: what the records say; triangles and box as OpenSceneGraph has them.

use super::Quantity::{Bounds, Faces, Triangles, Vertices};
use super::Rules;

pub const RULES: Rules = Rules {
    folders: &["flt/"],
    compared: &[
        (Vertices, &["raw_vertices"]),
        (Faces, &["raw_faces"]),
        (Triangles, &["second_triangles"]),
        (Bounds, &["second"]),
    ],
    allowed: &[(
        "flt/nested_references/master/master.flt",
        "flt/nested_references",
    )],
    exceptions: &[],
};
