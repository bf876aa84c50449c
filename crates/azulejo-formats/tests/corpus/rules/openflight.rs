//! OpenFlight: counts of the records; triangles and bounding box from OpenSceneGraph.

use super::Quantity::{Bounds, Faces, Triangles, Vertices};
use super::{Exception, Expected, Rules};

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
    exceptions: &[
        Exception {
            path: "flt/derived/tank_truncated.flt",
            quantity: Vertices,
            expected: Expected::Nothing,
            why: "cut off in the vertex palette, before the first face; warnings say so",
        },
        Exception {
            path: "flt/nested_references/master/master.flt",
            quantity: Vertices,
            expected: Expected::Count(12),
            why: "the plain count leaves out the two files that it refers to, of 4 each",
        },
        Exception {
            path: "flt/nested_references/master/master.flt",
            quantity: Faces,
            expected: Expected::Count(3),
            why: "the plain count leaves out the two files that it refers to, of 1 each",
        },
        Exception {
            path: "flt/nested_references/shared/a.flt",
            quantity: Vertices,
            expected: Expected::Count(8),
            why: "the plain count leaves out the file that it refers to, of 4",
        },
        Exception {
            path: "flt/nested_references/shared/a.flt",
            quantity: Faces,
            expected: Expected::Count(2),
            why: "the plain count leaves out the file that it refers to, of 1",
        },
        Exception {
            path: "flt/osgearth/tank.FLT",
            quantity: Vertices,
            expected: Expected::Count(3107),
            why: "6 vertices of the palette are used by faces of two objects, and are in both",
        },
        Exception {
            path: "flt/vrjuggler/head.flt",
            quantity: Vertices,
            expected: Expected::Count(93),
            why: "4 vertices of the palette are named by no face",
        },
        Exception {
            path: "flt/vrjuggler/head.flt",
            quantity: Faces,
            expected: Expected::Count(63),
            why: "12 corners are not a vertex of the palette, which leaves 5 faces with fewer than \
                  three; OpenSceneGraph has the same 72 triangles",
        },
        Exception {
            path: "flt/vrjuggler/head.flt",
            quantity: Bounds,
            // The column times 1 / 0.3048.
            expected: Expected::Box(
                [-0.415_746, -1.142_940, -0.415_746],
                [0.415_746, 0.165_746, 0.415_746],
            ),
            why: "in feet, as the file says; OpenSceneGraph makes metres of it",
        },
    ],
};
