//! The traversal state, which property nodes change and shapes use.

use super::node::V1Node;
use crate::vrml::faces::Binding;
use azulejo_scene::TextureId;
use glam::{DAffine2, DAffine3, DMat3, DQuat, DVec2, DVec3};

/// The traversal state between two nodes.
#[derive(Clone, Copy)]
pub(super) struct TraversalState<'d> {
    /// From object coordinates to those of the file.
    pub matrix: DAffine3,
    /// The texture coordinate transformation.
    pub uv_matrix: DAffine2,
    /// The current coordinates.
    pub points: &'d [DVec3],
    /// The current normals.
    pub normals: &'d [DVec3],
    /// The current texture coordinates.
    pub uvs: &'d [DVec2],
    /// The current Material node.
    pub material: Option<&'d V1Node<'d>>,
    /// What each of the materials belongs to.
    pub material_binding: V1Binding,
    /// What each of the normals belongs to.
    pub normal_binding: V1Binding,
    /// The current FontStyle.
    pub font: Option<&'d V1Node<'d>>,
    /// The current texture.
    pub texture: Option<TextureId>,
    /// The current shape hints.
    pub hints: ShapeHints,
}

impl TraversalState<'_> {
    /// The state at the start of a file.
    pub fn new(inventor: bool) -> Self {
        TraversalState {
            matrix: DAffine3::IDENTITY,
            uv_matrix: DAffine2::IDENTITY,
            // The default Coordinate3 holds one point.
            points: &[DVec3::ZERO],
            normals: &[],
            uvs: &[],
            material: None,
            material_binding: V1Binding::Default,
            normal_binding: V1Binding::Default,
            font: None,
            texture: None,
            hints: ShapeHints {
                clockwise: false,
                has_inside: false,
                crease_angle: default_crease_angle(inventor),
            },
        }
    }
}

/// VRML 1.0 smooths edges of less than half a radian, Inventor none.
fn default_crease_angle(inventor: bool) -> f64 {
    if inventor { 0.0 } else { 0.5 }
}

/// The content of a ShapeHints node.
#[derive(Clone, Copy)]
pub(super) struct ShapeHints {
    /// Whether vertices are clockwise as seen from the front.
    pub clockwise: bool,
    /// Whether shapes are solid with known fronts, so that backs are never visible.
    pub has_inside: bool,
    /// Greatest angle between faces that are smoothed across their common edge, radians.
    pub crease_angle: f64,
}

impl ShapeHints {
    /// The hints of a node, which replace all previous ones.
    pub fn of(node: &V1Node, inventor: bool) -> ShapeHints {
        let ordering = node.word("vertexOrdering");
        let default = default_crease_angle(inventor);
        ShapeHints {
            clockwise: ordering == "CLOCKWISE",
            has_inside: matches!(ordering, "CLOCKWISE" | "COUNTERCLOCKWISE")
                && node.word("shapeType") == "SOLID",
            crease_angle: node.number("creaseAngle", default),
        }
    }
}

/// A value of MaterialBinding or NormalBinding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum V1Binding {
    /// The natural binding of the shape.
    Default,
    Overall,
    Part,
    PartIndexed,
    Face,
    FaceIndexed,
    Vertex,
    VertexIndexed,
}

impl V1Binding {
    /// The value of that name; `None` if there is none.
    pub fn named(word: &str) -> Option<V1Binding> {
        Some(match word {
            "" | "DEFAULT" => V1Binding::Default,
            "OVERALL" | "NONE" => V1Binding::Overall,
            "PER_PART" => V1Binding::Part,
            "PER_PART_INDEXED" => V1Binding::PartIndexed,
            "PER_FACE" => V1Binding::Face,
            "PER_FACE_INDEXED" => V1Binding::FaceIndexed,
            "PER_VERTEX" => V1Binding::Vertex,
            "PER_VERTEX_INDEXED" => V1Binding::VertexIndexed,
            _ => return None,
        })
    }

    /// How the faces of a set use values with this binding; the parts of a set are its faces.
    pub fn of_faces(self, default: Binding) -> Binding {
        match self {
            V1Binding::Default => default,
            V1Binding::Overall => Binding::Overall,
            V1Binding::Part | V1Binding::Face => Binding::PerFace,
            V1Binding::PartIndexed | V1Binding::FaceIndexed => Binding::PerFaceIndexed,
            V1Binding::Vertex => Binding::PerVertex,
            V1Binding::VertexIndexed => Binding::PerVertexIndexed,
        }
    }

    /// Whether the parts of a sphere, cube, cylinder or cone have separate materials.
    pub fn is_per_part(self) -> bool {
        matches!(self, V1Binding::Part | V1Binding::PartIndexed)
    }
}

/// The rotation given by an axis and an angle; the identity if the axis is zero.
pub(super) fn rotation(numbers: Option<[f64; 4]>) -> DQuat {
    let [x, y, z, angle] = numbers.unwrap_or([0.0, 0.0, 1.0, 0.0]);
    let axis = DVec3::new(x, y, z).try_normalize();
    axis.map_or(DQuat::IDENTITY, |axis| DQuat::from_axis_angle(axis, angle))
}

/// The map of a Transform: scale along rotated axes, rotation and translation, about a centre.
pub(super) fn transform(node: &V1Node) -> DAffine3 {
    let centre = node.vector("center", DVec3::ZERO);
    let turned = DAffine3::from_quat(rotation(node.exactly("scaleOrientation")));
    DAffine3::from_translation(node.vector("translation", DVec3::ZERO) + centre)
        * DAffine3::from_quat(rotation(node.exactly("rotation")))
        * turned
        * DAffine3::from_scale(node.vector("scaleFactor", DVec3::ONE))
        * turned.inverse()
        * DAffine3::from_translation(-centre)
}

/// The map of a MatrixTransform. Points are row vectors multiplied from the left, so the last row
/// is the translation. `None` if it is not affine.
pub(super) fn matrix_transform(node: &V1Node) -> Option<DAffine3> {
    let Some(m) = node.exactly::<16>("matrix") else {
        return Some(DAffine3::IDENTITY);
    };
    let row = |i: usize| DVec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]) / m[15];
    let map = DAffine3 {
        matrix3: DMat3::from_cols(row(0), row(1), row(2)),
        translation: row(3),
    };
    ([m[3], m[7], m[11]] == [0.0; 3] && map.is_finite()).then_some(map)
}

/// The map of a Texture2Transform: scale and rotation about a centre, then translation.
pub(super) fn uv_transform(node: &V1Node) -> DAffine2 {
    let pair = |field, default| node.exactly(field).map_or(default, DVec2::from_array);
    let centre = pair("center", DVec2::ZERO);
    DAffine2::from_translation(pair("translation", DVec2::ZERO) + centre)
        * DAffine2::from_angle(node.number("rotation", 0.0))
        * DAffine2::from_scale(pair("scaleFactor", DVec2::ONE))
        * DAffine2::from_translation(-centre)
}
