//! glTF: triangles and bounding box from assimp. Vertices are not compared: the plain counts
//! include vertices shared by several primitives once for each of them, azulejo includes them once.

use super::Quantity::{Bounds, Triangles};
use super::{Exception, Expected, Rules};

pub const RULES: Rules = Rules {
    folders: &["gltf/"],
    compared: &[
        (Triangles, &["assimp_triangles", "raw_triangles"]),
        (Bounds, &["assimp"]),
    ],
    allowed: &[],
    exceptions: &[
        Exception {
            path: "gltf/assimp/IncorrectVertexArrays/Cube.gltf",
            quantity: Bounds,
            expected: Expected::Box([-3.5, -1.0, -1.0], [3.5, 1.0, 3.500001]),
            why: "lines have no surface; assimp keeps them",
        },
        Exception {
            path: "gltf/assimp/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_00.gltf",
            quantity: Bounds,
            expected: Expected::Nothing,
            why: "points have no surface; assimp keeps them",
        },
        Exception {
            path: "gltf/assimp/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_01.gltf",
            quantity: Bounds,
            expected: Expected::Nothing,
            why: "lines have no surface; assimp keeps them",
        },
        Exception {
            path: "gltf/assimp/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_02.gltf",
            quantity: Bounds,
            expected: Expected::Nothing,
            why: "lines have no surface; assimp keeps them",
        },
        Exception {
            path: "gltf/assimp/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_03.gltf",
            quantity: Bounds,
            expected: Expected::Nothing,
            why: "lines have no surface; assimp keeps them",
        },
    ],
};
