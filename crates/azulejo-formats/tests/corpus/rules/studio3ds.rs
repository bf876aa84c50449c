//! 3D Studio: counts of the chunks, and the bounding box from OpenSceneGraph, which keeps z up.

use super::Quantity::{Bounds, Faces, Objects, Triangles, Vertices};
use super::{Exception, Expected, Rules};

pub const RULES: Rules = Rules {
    folders: &["3ds/"],
    compared: &[
        (Objects, &["raw_objects"]),
        (Vertices, &["raw_vertices"]),
        (Faces, &["raw_faces"]),
        (Triangles, &["raw_triangles"]),
        (Bounds, &["second"]),
    ],
    allowed: &[],
    exceptions: &[
        Exception {
            path: "3ds/demo-models/p47d.3ds",
            quantity: Bounds,
            expected: Expected::Box(
                [-207.499908, -148.764404, -77.503799],
                [134.286621, 161.960342, 49.161758],
            ),
            why: "the file lost its local frames, without which pivots tear the aeroplane apart",
        },
        Exception {
            path: "3ds/derived/jeep1_truncated.3ds",
            quantity: Objects,
            expected: Expected::Column("second_objects"),
            why: "the file ends in the vertices of the last mesh, which has no faces",
        },
        Exception {
            path: "3ds/derived/jeep1_truncated.3ds",
            quantity: Vertices,
            expected: Expected::Column("third_vertices"),
            why: "the plain count is what the last mesh promises",
        },
    ],
};
