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

/// A known field: its name and the syntax of its value.
pub(super) type V1FieldSpec = (&'static str, V1FieldType);

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
    /// Lines, points and text: shapes without a surface.
    NoSurface,
    /// A camera without perspective.
    OrthographicCamera,
    /// Nodes that only affect shapes that are not read.
    Silent,
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
                | V1NodeKind::Inline
        )
    }

    /// The fields that are read.
    pub fn fields(self) -> &'static [V1FieldSpec] {
        let known = TYPES.iter().find(|known| known.1 == self);
        known.map_or(&[], |known| known.2)
    }

    /// The kind of that name, [`V1NodeKind::Unknown`] if it is none.
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
    ("Switch", V1NodeKind::Switch, &[("whichChild", NUMBER)]),
    ("LOD", V1NodeKind::Lod, LOD),
    ("LevelOfDetail", V1NodeKind::Lod, LOD),
    ("WWWInline", V1NodeKind::Inline, INLINE),
    (
        "Coordinate3",
        V1NodeKind::Coordinate3,
        &[("point", V1FieldType::Vectors)],
    ),
    (
        "Normal",
        V1NodeKind::Normal,
        &[("vector", V1FieldType::Vectors)],
    ),
    ("NormalBinding", V1NodeKind::NormalBinding, BINDING),
    ("Material", V1NodeKind::Material, MATERIAL),
    ("MaterialBinding", V1NodeKind::MaterialBinding, BINDING),
    ("Texture2", V1NodeKind::Texture2, TEXTURE),
    (
        "Texture2Transform",
        V1NodeKind::Texture2Transform,
        TEXTURE_TRANSFORM,
    ),
    (
        "TextureCoordinate2",
        V1NodeKind::TextureCoordinate2,
        &[("point", V1FieldType::Vectors2)],
    ),
    ("ShapeHints", V1NodeKind::ShapeHints, HINTS),
    ("Transform", V1NodeKind::Transform, TRANSFORM),
    (
        "Translation",
        V1NodeKind::Translation,
        &[("translation", TRIPLE)],
    ),
    (
        "Rotation",
        V1NodeKind::Rotation,
        &[("rotation", V1FieldType::Exactly(4))],
    ),
    ("Scale", V1NodeKind::Scale, &[("scaleFactor", TRIPLE)]),
    (
        "MatrixTransform",
        V1NodeKind::MatrixTransform,
        &[("matrix", V1FieldType::Exactly(16))],
    ),
    ("IndexedFaceSet", V1NodeKind::IndexedFaceSet, FACE_SET),
    (
        "Cube",
        V1NodeKind::Cube,
        &[("width", NUMBER), ("height", NUMBER), ("depth", NUMBER)],
    ),
    ("Sphere", V1NodeKind::Sphere, &[("radius", NUMBER)]),
    (
        "Cylinder",
        V1NodeKind::Cylinder,
        &[
            ("parts", V1FieldType::Words),
            ("radius", NUMBER),
            ("height", NUMBER),
        ],
    ),
    (
        "Cone",
        V1NodeKind::Cone,
        &[
            ("parts", V1FieldType::Words),
            ("bottomRadius", NUMBER),
            ("height", NUMBER),
        ],
    ),
    ("PointLight", V1NodeKind::PointLight, LIGHT),
    ("SpotLight", V1NodeKind::SpotLight, LIGHT),
    ("DirectionalLight", V1NodeKind::DirectionalLight, LIGHT),
    ("PerspectiveCamera", V1NodeKind::PerspectiveCamera, CAMERA),
    (
        "OrthographicCamera",
        V1NodeKind::OrthographicCamera,
        ORTHOGRAPHIC,
    ),
    ("Info", V1NodeKind::Info, &[("string", V1FieldType::Words)]),
    ("AsciiText", V1NodeKind::NoSurface, NO_SURFACE),
    ("IndexedLineSet", V1NodeKind::NoSurface, NO_SURFACE),
    ("PointSet", V1NodeKind::NoSurface, NO_SURFACE),
    ("FontStyle", V1NodeKind::Silent, FONT),
];

const ANCHOR: &[V1FieldSpec] = &[
    ("name", V1FieldType::Words),
    ("description", V1FieldType::Words),
    ("map", V1FieldType::Words),
];
const LOD: &[V1FieldSpec] = &[
    ("range", V1FieldType::Numbers),
    ("center", TRIPLE),
    ("screenArea", V1FieldType::Numbers),
];
const INLINE: &[V1FieldSpec] = &[
    ("name", V1FieldType::Words),
    ("bboxSize", TRIPLE),
    ("bboxCenter", TRIPLE),
];
const BINDING: &[V1FieldSpec] = &[("value", V1FieldType::Words)];
const MATERIAL: &[V1FieldSpec] = &[
    ("ambientColor", V1FieldType::Colors),
    ("diffuseColor", V1FieldType::Colors),
    ("specularColor", V1FieldType::Colors),
    ("emissiveColor", V1FieldType::Colors),
    ("shininess", V1FieldType::Numbers),
    ("transparency", V1FieldType::Numbers),
    ("mirror", V1FieldType::Numbers),
];
const TEXTURE: &[V1FieldSpec] = &[
    ("filename", V1FieldType::Words),
    ("image", V1FieldType::Image),
    ("wrapS", V1FieldType::Words),
    ("wrapT", V1FieldType::Words),
];
const TEXTURE_TRANSFORM: &[V1FieldSpec] = &[
    ("translation", V1FieldType::Exactly(2)),
    ("rotation", NUMBER),
    ("scaleFactor", V1FieldType::Exactly(2)),
    ("center", V1FieldType::Exactly(2)),
];
const HINTS: &[V1FieldSpec] = &[
    ("vertexOrdering", V1FieldType::Words),
    ("shapeType", V1FieldType::Words),
    ("faceType", V1FieldType::Words),
    ("creaseAngle", NUMBER),
];
const TRANSFORM: &[V1FieldSpec] = &[
    ("translation", TRIPLE),
    ("rotation", V1FieldType::Exactly(4)),
    ("scaleFactor", TRIPLE),
    ("scaleOrientation", V1FieldType::Exactly(4)),
    ("center", TRIPLE),
];
const FACE_SET: &[V1FieldSpec] = &[
    ("coordIndex", V1FieldType::Integers),
    ("materialIndex", V1FieldType::Integers),
    ("normalIndex", V1FieldType::Integers),
    ("textureCoordIndex", V1FieldType::Integers),
];
const LIGHT: &[V1FieldSpec] = &[
    ("on", V1FieldType::Words),
    ("intensity", NUMBER),
    ("color", V1FieldType::Colors),
    ("location", TRIPLE),
    ("direction", TRIPLE),
    ("dropOffRate", NUMBER),
    ("cutOffAngle", NUMBER),
];
const CAMERA: &[V1FieldSpec] = &[
    ("position", TRIPLE),
    ("orientation", V1FieldType::Exactly(4)),
    ("focalDistance", NUMBER),
    ("heightAngle", NUMBER),
    ("nearDistance", NUMBER),
    ("farDistance", NUMBER),
    ("aspectRatio", NUMBER),
    ("viewportMapping", V1FieldType::Words),
];
const ORTHOGRAPHIC: &[V1FieldSpec] = &[
    ("position", TRIPLE),
    ("orientation", V1FieldType::Exactly(4)),
    ("focalDistance", NUMBER),
    ("height", NUMBER),
    ("nearDistance", NUMBER),
    ("farDistance", NUMBER),
    ("aspectRatio", NUMBER),
    ("viewportMapping", V1FieldType::Words),
];
const NO_SURFACE: &[V1FieldSpec] = &[
    ("coordIndex", V1FieldType::Integers),
    ("materialIndex", V1FieldType::Integers),
    ("normalIndex", V1FieldType::Integers),
    ("textureCoordIndex", V1FieldType::Integers),
    ("startIndex", NUMBER),
    ("numPoints", NUMBER),
    ("string", V1FieldType::Words),
    ("spacing", NUMBER),
    ("justification", V1FieldType::Words),
    ("width", V1FieldType::Numbers),
];
const FONT: &[V1FieldSpec] = &[
    ("size", NUMBER),
    ("family", V1FieldType::Words),
    ("style", V1FieldType::Words),
];

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
        assert_eq!(V1NodeKind::Sphere.fields(), [("radius", NUMBER)]);
        assert!(V1NodeKind::Unknown.fields().is_empty());
        for (name, kind, _) in TYPES {
            assert_eq!(V1NodeKind::named(name.as_bytes()), *kind);
        }
    }
}
