//! X3D: triangles and bounding box from MeshLab or assimp.

use super::Quantity::{Bounds, Triangles};
use super::{Exception, Expected, Rules};

const EXACT: &str = "spheres are exact here, and have no triangles";
const CHORDS: &str = "MeshLab divides spheres into triangles whose chords are inside them";

pub const RULES: Rules = Rules {
    folders: &["x3d/"],
    compared: &[
        (Triangles, &["second_triangles", "assimp_triangles"]),
        (Bounds, &["second", "assimp"]),
    ],
    allowed: &[],
    exceptions: &[
        Exception {
            path: "x3d/assimp/ComputerKeyboard.x3d",
            quantity: Triangles,
            expected: Expected::Count(2020),
            why: "assimp shows 4 of the 100 shapes that the groups unfold to by USE",
        },
        Exception {
            path: "x3d/assimp/ComputerKeyboard.x3d",
            quantity: Bounds,
            expected: Expected::Box([0.0, -0.000_199_6, 0.0], [0.45, 0.104_992_5, 0.980_018]),
            why: "assimp shows 4 of the 100 shapes, and leaves out the turn of the keys",
        },
        Exception {
            path: "x3d/assimp/HelloWorld.x3d",
            quantity: Triangles,
            expected: Expected::Count(0),
            why: EXACT,
        },
        Exception {
            path: "x3d/assimp/HelloWorld.x3d",
            quantity: Bounds,
            expected: Expected::Box([-1.0; 3], [1.0; 3]),
            why: CHORDS,
        },
        Exception {
            path: "x3d/assimp/HelloWorld.x3dv",
            quantity: Triangles,
            expected: Expected::Count(0),
            why: EXACT,
        },
        Exception {
            path: "x3d/assimp/HelloWorld.x3dv",
            quantity: Bounds,
            expected: Expected::Box([-1.0; 3], [1.0; 3]),
            why: CHORDS,
        },
        Exception {
            path: "x3d/castle/x3d/concave.x3dv",
            quantity: Triangles,
            expected: Expected::Count(26),
            why: "MeshLab drops triangles without area, where a face names a position twice",
        },
        Exception {
            path: "x3d/castle/x3d/triangle_quad_sets.x3dv",
            quantity: Bounds,
            expected: Expected::Box([0.0, 0.0, 0.0], [26.5, 38.0, 1.0]),
            why: "MeshLab's box also holds the positions of QuadSets that make no whole face",
        },
        Exception {
            path: "x3d/castle/x3d/tricky_def_use.x3dv",
            quantity: Triangles,
            expected: Expected::Count(0),
            why: EXACT,
        },
        Exception {
            path: "x3d/castle/x3d/tricky_def_use.x3dv",
            quantity: Bounds,
            expected: Expected::Box([-1.0; 3], [13.0, 1.0, 1.0]),
            why: "MeshLab does not unfold the two prototypes, whose spheres stand at x = 8 and 12",
        },
    ],
};
