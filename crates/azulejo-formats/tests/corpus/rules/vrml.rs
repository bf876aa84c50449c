//! VRML97: triangles and bounding box from Coin or MeshLab.

use super::Quantity::{Bounds, Triangles};
use super::{Exception, Expected, Rules};

const EXACT: &str = "spheres, boxes, cylinders and cones are exact here, and have no triangles";
const CHORDS: &str = "the others divide spheres into triangles whose chords are inside them";

pub const RULES: Rules = Rules {
    folders: &["wrl/"],
    compared: &[
        (Triangles, &["second_triangles", "third_triangles"]),
        (Bounds, &["second", "third"]),
    ],
    allowed: &[],
    exceptions: &[
        Exception {
            path: "wrl/assimp/HelloWorld.wrl",
            quantity: Triangles,
            expected: Expected::Count(0),
            why: EXACT,
        },
        Exception {
            path: "wrl/assimp/HelloWorld.wrl",
            quantity: Bounds,
            expected: Expected::Box([-1.0; 3], [1.0; 3]),
            why: "Coin also shows the text, which is skipped here with a warning",
        },
        Exception {
            path: "wrl/castle/prototypes/proto_nested.wrl",
            quantity: Triangles,
            expected: Expected::Count(0),
            why: EXACT,
        },
        Exception {
            path: "wrl/castle/prototypes/proto_nodes.wrl",
            quantity: Triangles,
            expected: Expected::Count(0),
            why: EXACT,
        },
        Exception {
            path: "wrl/castle/prototypes/proto_nodes.wrl",
            quantity: Bounds,
            expected: Expected::Box([4.0, -1.0, -1.0], [31.0, 1.0, 1.0]),
            why: "Coin also shows the texts, which are skipped here with a warning",
        },
        Exception {
            path: "wrl/castle/vrml_2/collisions.wrl",
            quantity: Triangles,
            expected: Expected::Count(10_789),
            why: "MeshLab makes 4 triangles of each of the 164 lines of an IndexedLineSet, which has no surface",
        },
        Exception {
            path: "wrl/castle/vrml_2/kings_head.wrl",
            quantity: Triangles,
            expected: Expected::Count(76),
            why: "only the open cylinder is divided here, into 38 sides; the rest is exact",
        },
        Exception {
            path: "wrl/castle/vrml_2/kings_head.wrl",
            quantity: Bounds,
            expected: Expected::Box([-1.2, -4.0, -1.2], [1.2, 1.0, 1.7]),
            why: CHORDS,
        },
        Exception {
            path: "wrl/castle/vrml_engine_doc_simple_examples/inline.wrl",
            quantity: Triangles,
            expected: Expected::Count(0),
            why: EXACT,
        },
        Exception {
            path: "wrl/castle/vrml_engine_doc_simple_examples/reuse_cone.wrl",
            quantity: Triangles,
            expected: Expected::Count(0),
            why: EXACT,
        },
        Exception {
            path: "wrl/vrintra/alien.wrl",
            quantity: Triangles,
            expected: Expected::Count(656),
            why: "the extrusions are divided as the file says; spheres and cylinders are exact",
        },
        Exception {
            path: "wrl/vrintra/alien.wrl",
            quantity: Bounds,
            expected: Expected::Box([-0.345, -0.875, -0.2], [0.345, 0.265_103, 0.2]),
            why: CHORDS,
        },
        Exception {
            path: "wrl/vrintra/humain.wrl",
            quantity: Triangles,
            expected: Expected::Count(656),
            why: "the extrusions are divided as the file says; spheres and cylinders are exact",
        },
        Exception {
            path: "wrl/vrintra/humain.wrl",
            quantity: Bounds,
            expected: Expected::Box([-0.345, -0.875, -0.2], [0.345, 0.2, 0.2]),
            why: CHORDS,
        },
    ],
};
