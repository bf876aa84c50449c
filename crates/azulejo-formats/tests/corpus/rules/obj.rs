//! Wavefront OBJ: polygons from plain counts of the file's lines; triangles, positions and bounding
//! box from assimp.

use super::Quantity::{Bounds, Faces, Positions, Triangles};
use super::{Exception, Expected, Rules};

/// The highest point of the surface is at 9/8; its polygons come within a thousandth of its size.
const BEZIER: &str = "a surface in 15 × 15 pieces; the others know its control points only";

pub const RULES: Rules = Rules {
    folders: &["obj/"],
    compared: &[
        (Positions, &["assimp_distinct_positions_per_mesh"]),
        (Faces, &["raw_faces"]),
        (Triangles, &["raw_triangles"]),
        (Bounds, &["assimp"]),
    ],
    allowed: &[],
    exceptions: &[
        Exception {
            path: "obj/freeform/bezier_patch.obj",
            quantity: Positions,
            expected: Expected::Count(256),
            why: BEZIER,
        },
        Exception {
            path: "obj/freeform/bezier_patch.obj",
            quantity: Faces,
            expected: Expected::Count(225),
            why: BEZIER,
        },
        Exception {
            path: "obj/freeform/bezier_patch.obj",
            quantity: Triangles,
            expected: Expected::Count(450),
            why: BEZIER,
        },
        Exception {
            path: "obj/freeform/bezier_patch.obj",
            quantity: Bounds,
            expected: Expected::Box([-5.0, -5.0, 0.0], [5.0, 5.0, 1.115022]),
            why: BEZIER,
        },
        Exception {
            path: "obj/tinyobjloader/points-prim.obj",
            quantity: Bounds,
            expected: Expected::Nothing,
            why: "points have no surface; assimp keeps them",
        },
        Exception {
            path: "obj/trimesh/emptyIO/obj_wireframe.obj",
            quantity: Bounds,
            expected: Expected::Nothing,
            why: "lines have no surface; assimp keeps them",
        },
        Exception {
            path: "obj/tinyobjloader/test-nan.obj",
            quantity: Bounds,
            expected: Expected::Refused,
            why: "no surface goes through a vertex that is nowhere; assimp takes it",
        },
        Exception {
            path: "obj/jdk/dinasaur.obj",
            quantity: Faces,
            expected: Expected::Column("assimp_polygons"),
            why: "the plain count knows lines that end in LF only, and no `fo`",
        },
        Exception {
            path: "obj/jdk/dinasaur.obj",
            quantity: Triangles,
            expected: Expected::Column("assimp_triangles"),
            why: "the plain count knows lines that end in LF only, and no `fo`",
        },
    ],
};
