//! Nodes as they appear in the file, and the fields of each kind.

use azulejo_scene::Rgb;
use glam::{DVec2, DVec3};
use std::borrow::Cow;

/// Index of a node in [`V1Document::nodes`].
pub(super) type NodeId = u32;

/// The nodes of a file. Children precede their parents, so no node contains itself.
#[derive(Debug, Default)]
pub(super) struct V1Document<'a> {
    /// All nodes.
    pub nodes: Vec<V1Node<'a>>,
    /// The top-level nodes.
    pub roots: Vec<NodeId>,
}

/// A node.
#[derive(Debug)]
pub(super) struct V1Node<'a> {
    pub kind: V1NodeKind,
    /// The type name in the file.
    pub type_name: &'a [u8],
    /// Its name by DEF.
    pub name: Option<Cow<'a, str>>,
    /// The offset of its first byte.
    pub at: usize,
    /// The fields given in the file; of a repeated one, the last.
    pub fields: Vec<(&'static str, V1Value<'a>)>,
    /// The nodes inside it, in order.
    pub children: Vec<NodeId>,
    /// Whether it is or contains a shape or a nested file.
    pub has_shapes: bool,
}

/// The value of a field.
#[derive(Debug)]
pub(super) enum V1Value<'a> {
    /// Numbers, including those of an image.
    Numbers(Vec<f64>),
    /// Indices.
    Integers(Vec<i32>),
    /// Points and normals.
    Vectors(Vec<DVec3>),
    /// Texture coordinates.
    Vectors2(Vec<DVec2>),
    /// Colours.
    Colors(Vec<Rgb>),
    /// Strings, flags and enumerated values.
    Words(Vec<Cow<'a, str>>),
}

/// The syntax of a field's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum V1FieldType {
    /// Exactly this many numbers.
    Exactly(usize),
    /// A list of numbers.
    Numbers,
    /// A list of integers.
    Integers,
    /// A list of triples.
    Vectors,
    /// A list of pairs.
    Vectors2,
    /// A list of colours.
    Colors,
    /// A word, a string, a list of strings, or words in parentheses with `|` between.
    Words,
    /// Width, height, number of components, and a number for each pixel.
    Image,
}

/// Known fields of one syntax: it, and their names with blanks between them.
type V1FieldSpec = (V1FieldType, &'static str);

/// The type of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum V1NodeKind {
    Separator,
    TransformSeparator,
    Group,
    Switch,
    Lod,
    Inline,
    Coordinate3,
    Normal,
    NormalBinding,
    Material,
    MaterialBinding,
    Texture2,
    Texture2Transform,
    TextureCoordinate2,
    /// Inventor 2.1: coordinates, normals and texture coordinates of the one shape that it is inside.
    VertexProperty,
    ShapeHints,
    Transform,
    Translation,
    Rotation,
    Scale,
    MatrixTransform,
    IndexedFaceSet,
    Cube,
    Sphere,
    Cylinder,
    Cone,
    PointLight,
    SpotLight,
    DirectionalLight,
    PerspectiveCamera,
    Info,
    /// Lines and points: shapes without a surface.
    NoSurface,
    /// A camera without perspective.
    OrthographicCamera,
    FontStyle,
    AsciiText,
    /// Not a node of VRML 1.0. Its children are read as in a [`V1NodeKind::Separator`].
    Unknown,
}

impl V1NodeKind {
    /// Whether it may contain nodes.
    pub fn is_group(self) -> bool {
        matches!(
            self,
            V1NodeKind::Separator
                | V1NodeKind::TransformSeparator
                | V1NodeKind::Group
                | V1NodeKind::Switch
                | V1NodeKind::Lod
                | V1NodeKind::Unknown
        )
    }

    /// Whether it displays something itself.
    pub fn is_shape(self) -> bool {
        matches!(
            self,
            V1NodeKind::IndexedFaceSet
                | V1NodeKind::Cube
                | V1NodeKind::Sphere
                | V1NodeKind::Cylinder
                | V1NodeKind::Cone
                | V1NodeKind::AsciiText
                | V1NodeKind::Inline
        )
    }

    /// The name and the syntax of a field that is read.
    pub fn field(self, word: &[u8]) -> Option<(&'static str, V1FieldType)> {
        let (_, _, fields) = TYPES.iter().find(|known| known.1 == self)?;
        fields.iter().find_map(|&(form, names)| {
            let name = names.split(' ').find(|name| name.as_bytes() == word)?;
            Some((name, form))
        })
    }

    /// The kind of that name, [`V1NodeKind::Unknown`] if there is none.
    pub fn named(name: &[u8]) -> V1NodeKind {
        let known = TYPES.iter().find(|known| known.0.as_bytes() == name);
        known.map_or(V1NodeKind::Unknown, |known| known.1)
    }
}

/// Fields that concern rendering hints or picking, not the scene.
pub(super) const IGNORED_FIELDS: [&[u8]; 4] = [
    b"renderCulling",
    b"renderCaching",
    b"boundingBoxCaching",
    b"pickCulling",
];

const NUMBER: V1FieldType = V1FieldType::Exactly(1);
const TRIPLE: V1FieldType = V1FieldType::Exactly(3);

/// Kinds by name, with their fields. If a kind has two names, the fields of the first hold for
/// both.
const TYPES: &[(&str, V1NodeKind, &[V1FieldSpec])] = &[
    ("Separator", V1NodeKind::Separator, ANCHOR),
    ("WWWAnchor", V1NodeKind::Separator, ANCHOR),
    ("TransformSeparator", V1NodeKind::TransformSeparator, &[]),
    ("Group", V1NodeKind::Group, &[]),
    ("Switch", V1NodeKind::Switch, SWITCH),
    ("LOD", V1NodeKind::Lod, LOD),
    ("LevelOfDetail", V1NodeKind::Lod, LOD),
    ("WWWInline", V1NodeKind::Inline, INLINE),
    ("Coordinate3", V1NodeKind::Coordinate3, POINTS),
    ("Normal", V1NodeKind::Normal, NORMALS),
    ("NormalBinding", V1NodeKind::NormalBinding, BINDING),
    ("Material", V1NodeKind::Material, MATERIAL),
    ("MaterialBinding", V1NodeKind::MaterialBinding, BINDING),
    ("Texture2", V1NodeKind::Texture2, TEXTURE),
    (
        "Texture2Transform",
        V1NodeKind::Texture2Transform,
        TEXTURE_TRANSFORM,
    ),
    ("TextureCoordinate2", V1NodeKind::TextureCoordinate2, PAIRS),
    (
        "VertexProperty",
        V1NodeKind::VertexProperty,
        VERTEX_PROPERTY,
    ),
    ("ShapeHints", V1NodeKind::ShapeHints, HINTS),
    ("Transform", V1NodeKind::Transform, TRANSFORM),
    ("Translation", V1NodeKind::Translation, TRANSLATION),
    ("Rotation", V1NodeKind::Rotation, ROTATION),
    ("Scale", V1NodeKind::Scale, SCALE),
    ("MatrixTransform", V1NodeKind::MatrixTransform, MATRIX),
    ("IndexedFaceSet", V1NodeKind::IndexedFaceSet, FACE_SET),
    ("Cube", V1NodeKind::Cube, CUBE),
    ("Sphere", V1NodeKind::Sphere, SPHERE),
    ("Cylinder", V1NodeKind::Cylinder, CYLINDER),
    ("Cone", V1NodeKind::Cone, CONE),
    ("PointLight", V1NodeKind::PointLight, LIGHT),
    ("SpotLight", V1NodeKind::SpotLight, LIGHT),
    ("DirectionalLight", V1NodeKind::DirectionalLight, LIGHT),
    ("PerspectiveCamera", V1NodeKind::PerspectiveCamera, CAMERA),
    (
        "OrthographicCamera",
        V1NodeKind::OrthographicCamera,
        ORTHOGRAPHIC,
    ),
    ("Info", V1NodeKind::Info, INFO),
    ("AsciiText", V1NodeKind::AsciiText, ASCII_TEXT),
    ("IndexedLineSet", V1NodeKind::NoSurface, NO_SURFACE),
    ("PointSet", V1NodeKind::NoSurface, NO_SURFACE),
    ("FontStyle", V1NodeKind::FontStyle, FONT),
];

const ANCHOR: &[V1FieldSpec] = &[(V1FieldType::Words, "name description map")];
const LOD: &[V1FieldSpec] = &[
    (V1FieldType::Numbers, "range screenArea"),
    (TRIPLE, "center"),
];
const INLINE: &[V1FieldSpec] = &[
    (V1FieldType::Words, "name"),
    (TRIPLE, "bboxSize bboxCenter"),
];
const BINDING: &[V1FieldSpec] = &[(V1FieldType::Words, "value")];
const MATERIAL: &[V1FieldSpec] = &[
    (
        V1FieldType::Colors,
        "ambientColor diffuseColor specularColor emissiveColor",
    ),
    (V1FieldType::Numbers, "shininess transparency mirror"),
];
const TEXTURE: &[V1FieldSpec] = &[
    (V1FieldType::Words, "filename wrapS wrapT"),
    (V1FieldType::Image, "image"),
];
const TEXTURE_TRANSFORM: &[V1FieldSpec] = &[
    (V1FieldType::Exactly(2), "translation scaleFactor center"),
    (NUMBER, "rotation"),
];
const HINTS: &[V1FieldSpec] = &[
    (V1FieldType::Words, "vertexOrdering shapeType faceType"),
    (NUMBER, "creaseAngle"),
];
const TRANSFORM: &[V1FieldSpec] = &[
    (TRIPLE, "translation scaleFactor center"),
    (V1FieldType::Exactly(4), "rotation scaleOrientation"),
];
const FACE_SET: &[V1FieldSpec] = &[(
    V1FieldType::Integers,
    "coordIndex materialIndex normalIndex textureCoordIndex",
)];
const LIGHT: &[V1FieldSpec] = &[
    (V1FieldType::Words, "on"),
    (NUMBER, "intensity dropOffRate cutOffAngle"),
    (V1FieldType::Colors, "color"),
    (TRIPLE, "location direction"),
];
const CAMERA: &[V1FieldSpec] = &[
    (TRIPLE, "position"),
    (V1FieldType::Exactly(4), "orientation"),
    (
        NUMBER,
        "focalDistance heightAngle nearDistance farDistance aspectRatio",
    ),
    (V1FieldType::Words, "viewportMapping"),
];
const ORTHOGRAPHIC: &[V1FieldSpec] = &[
    (TRIPLE, "position"),
    (V1FieldType::Exactly(4), "orientation"),
    (
        NUMBER,
        "focalDistance height nearDistance farDistance aspectRatio",
    ),
    (V1FieldType::Words, "viewportMapping"),
];
const NO_SURFACE: &[V1FieldSpec] = &[
    (
        V1FieldType::Integers,
        "coordIndex materialIndex normalIndex textureCoordIndex",
    ),
    (NUMBER, "startIndex numPoints"),
];
const ASCII_TEXT: &[V1FieldSpec] = &[
    (NUMBER, "spacing"),
    (V1FieldType::Words, "string justification"),
    (V1FieldType::Numbers, "width"),
];
const FONT: &[V1FieldSpec] = &[(NUMBER, "size"), (V1FieldType::Words, "family style")];
const SWITCH: &[V1FieldSpec] = &[(NUMBER, "whichChild")];
const POINTS: &[V1FieldSpec] = &[(V1FieldType::Vectors, "point")];
const NORMALS: &[V1FieldSpec] = &[(V1FieldType::Vectors, "vector")];
const PAIRS: &[V1FieldSpec] = &[(V1FieldType::Vectors2, "point")];
const VERTEX_PROPERTY: &[V1FieldSpec] = &[
    (V1FieldType::Vectors, "vertex normal"),
    (V1FieldType::Vectors2, "texCoord"),
    (V1FieldType::Words, "normalBinding materialBinding"),
];
const TRANSLATION: &[V1FieldSpec] = &[(TRIPLE, "translation")];
const ROTATION: &[V1FieldSpec] = &[(V1FieldType::Exactly(4), "rotation")];
const SCALE: &[V1FieldSpec] = &[(TRIPLE, "scaleFactor")];
const MATRIX: &[V1FieldSpec] = &[(V1FieldType::Exactly(16), "matrix")];
const CUBE: &[V1FieldSpec] = &[(NUMBER, "width height depth")];
const SPHERE: &[V1FieldSpec] = &[(NUMBER, "radius")];
const CYLINDER: &[V1FieldSpec] = &[(V1FieldType::Words, "parts"), (NUMBER, "radius height")];
const CONE: &[V1FieldSpec] = &[
    (V1FieldType::Words, "parts"),
    (NUMBER, "bottomRadius height"),
];
const INFO: &[V1FieldSpec] = &[(V1FieldType::Words, "string")];

impl V1Node<'_> {
    fn value(&self, field: &str) -> Option<&V1Value<'_>> {
        let given = self.fields.iter().find(|(name, _)| *name == field);
        given.map(|(_, value)| value)
    }

    /// The numbers of a field, if present.
    pub fn numbers(&self, field: &str) -> Option<&[f64]> {
        match self.value(field)? {
            V1Value::Numbers(list) => Some(list),
            _ => None,
        }
    }

    /// The `N` numbers of a field, if present and finite.
    pub fn exactly<const N: usize>(&self, field: &str) -> Option<[f64; N]> {
        let numbers: [f64; N] = self.numbers(field)?.try_into().ok()?;
        numbers.iter().all(|n| n.is_finite()).then_some(numbers)
    }

    /// The number of a field.
    pub fn number(&self, field: &str, default: f64) -> f64 {
        self.exactly(field).map_or(default, |[number]| number)
    }

    /// The three numbers of a field.
    pub fn vector(&self, field: &str, default: DVec3) -> DVec3 {
        self.exactly(field).map_or(default, DVec3::from_array)
    }

    /// The vectors of a field.
    pub fn vectors(&self, field: &str) -> Option<&[DVec3]> {
        match self.value(field)? {
            V1Value::Vectors(list) => Some(list),
            _ => None,
        }
    }

    /// The pairs of a field.
    pub fn vectors2(&self, field: &str) -> Option<&[DVec2]> {
        match self.value(field)? {
            V1Value::Vectors2(list) => Some(list),
            _ => None,
        }
    }

    /// The colours of a field, if present.
    pub fn colors(&self, field: &str) -> Option<&[Rgb]> {
        match self.value(field)? {
            V1Value::Colors(list) => Some(list),
            _ => None,
        }
    }

    /// The indices of a field; `None` if it is absent or the −1 that means the same.
    pub fn index(&self, field: &str) -> Option<&[i32]> {
        match self.value(field)? {
            V1Value::Integers(list) if !matches!(**list, [] | [-1]) => Some(list),
            _ => None,
        }
    }

    /// The words of a field.
    pub fn words(&self, field: &str) -> &[Cow<'_, str>] {
        match self.value(field) {
            Some(V1Value::Words(list)) => list,
            _ => &[],
        }
    }

    /// The first word of a field; empty if absent.
    pub fn word(&self, field: &str) -> &str {
        self.words(field).first().map_or("", |word| word)
    }

    /// Whether a flag is not explicitly off.
    pub fn is_on(&self, field: &str) -> bool {
        !matches!(self.word(field), "FALSE" | "false" | "0")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_find_their_fields() {
        assert_eq!(V1NodeKind::named(b"WWWAnchor"), V1NodeKind::Separator);
        assert_eq!(V1NodeKind::named(b"Cubist"), V1NodeKind::Unknown);
        let radius = V1NodeKind::Sphere.field(b"radius");
        assert_eq!(radius, Some(("radius", NUMBER)));
        assert_eq!(V1NodeKind::Unknown.field(b"radius"), None);
        for (name, kind, _) in TYPES {
            assert_eq!(V1NodeKind::named(name.as_bytes()), *kind);
        }
    }
}
