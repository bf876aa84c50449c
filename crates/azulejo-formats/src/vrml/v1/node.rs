//! Nodes as they stand in the file, and what fields each kind has.

use azulejo_scene::Rgb;
use glam::{DVec2, DVec3};
use std::borrow::Cow;

/// Index of a node in [`Document::nodes`].
pub(super) type NodeId = u32;

/// The nodes of a file. Children stand before their parents, so no node is inside itself.
#[derive(Debug, Default)]
pub(super) struct Document<'a> {
    /// All nodes.
    pub nodes: Vec<Node<'a>>,
    /// Those that are in no other.
    pub roots: Vec<NodeId>,
}

/// A node.
#[derive(Debug)]
pub(super) struct Node<'a> {
    /// What it is.
    pub kind: Kind,
    /// The word by which the file calls its kind.
    pub type_name: &'a [u8],
    /// Its name, if it has a DEF.
    pub name: Option<Cow<'a, str>>,
    /// The byte where it begins.
    pub at: usize,
    /// The fields that the file gives; of one that is given twice, the last.
    pub fields: Vec<(&'static str, Value<'a>)>,
    /// The nodes inside it, in order.
    pub children: Vec<NodeId>,
    /// Whether it is or holds a shape or another file.
    pub has_shapes: bool,
}

/// The value of a field.
#[derive(Debug)]
pub(super) enum Value<'a> {
    /// Numbers, a picture's included.
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

/// How the value of a field is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// So many numbers.
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

/// A field that is known: its name, and how its value is written.
pub(super) type Field = (&'static str, Form);

/// What a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
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
    /// Lines, points and writing: shapes without a surface.
    NoSurface,
    /// A camera without perspective.
    OrthographicCamera,
    /// What only matters to shapes that are not read.
    Silent,
    /// None of VRML 1.0. What is inside stands as in a [`Kind::Separator`].
    Unknown,
}

impl Kind {
    /// Whether nodes inside it are meant to be there.
    pub fn is_group(self) -> bool {
        matches!(
            self,
            Kind::Separator
                | Kind::TransformSeparator
                | Kind::Group
                | Kind::Switch
                | Kind::Lod
                | Kind::Unknown
        )
    }

    /// Whether it shows something by itself.
    pub fn is_shape(self) -> bool {
        matches!(
            self,
            Kind::IndexedFaceSet
                | Kind::Cube
                | Kind::Sphere
                | Kind::Cylinder
                | Kind::Cone
                | Kind::Inline
        )
    }

    /// The fields that are read.
    pub fn fields(self) -> &'static [Field] {
        let known = TYPES.iter().find(|known| known.1 == self);
        known.map_or(&[], |known| known.2)
    }

    /// The kind of that name, [`Kind::Unknown`] if it is none.
    pub fn named(name: &[u8]) -> Kind {
        let known = TYPES.iter().find(|known| known.0.as_bytes() == name);
        known.map_or(Kind::Unknown, |known| known.1)
    }
}

/// Fields that say how to draw or to pick, not what is there.
pub(super) const IGNORED_FIELDS: [&[u8]; 4] = [
    b"renderCulling",
    b"renderCaching",
    b"boundingBoxCaching",
    b"pickCulling",
];

const NUMBER: Form = Form::Exactly(1);
const TRIPLE: Form = Form::Exactly(3);

/// Kinds by name, with their fields. Of two names for a kind, the first has the fields of both.
const TYPES: &[(&str, Kind, &[Field])] = &[
    ("Separator", Kind::Separator, ANCHOR),
    ("WWWAnchor", Kind::Separator, ANCHOR),
    ("TransformSeparator", Kind::TransformSeparator, &[]),
    ("Group", Kind::Group, &[]),
    ("Switch", Kind::Switch, &[("whichChild", NUMBER)]),
    ("LOD", Kind::Lod, LOD),
    ("LevelOfDetail", Kind::Lod, LOD),
    ("WWWInline", Kind::Inline, INLINE),
    (
        "Coordinate3",
        Kind::Coordinate3,
        &[("point", Form::Vectors)],
    ),
    ("Normal", Kind::Normal, &[("vector", Form::Vectors)]),
    ("NormalBinding", Kind::NormalBinding, BINDING),
    ("Material", Kind::Material, MATERIAL),
    ("MaterialBinding", Kind::MaterialBinding, BINDING),
    ("Texture2", Kind::Texture2, TEXTURE),
    (
        "Texture2Transform",
        Kind::Texture2Transform,
        TEXTURE_TRANSFORM,
    ),
    (
        "TextureCoordinate2",
        Kind::TextureCoordinate2,
        &[("point", Form::Vectors2)],
    ),
    ("ShapeHints", Kind::ShapeHints, HINTS),
    ("Transform", Kind::Transform, TRANSFORM),
    ("Translation", Kind::Translation, &[("translation", TRIPLE)]),
    (
        "Rotation",
        Kind::Rotation,
        &[("rotation", Form::Exactly(4))],
    ),
    ("Scale", Kind::Scale, &[("scaleFactor", TRIPLE)]),
    (
        "MatrixTransform",
        Kind::MatrixTransform,
        &[("matrix", Form::Exactly(16))],
    ),
    ("IndexedFaceSet", Kind::IndexedFaceSet, FACE_SET),
    (
        "Cube",
        Kind::Cube,
        &[("width", NUMBER), ("height", NUMBER), ("depth", NUMBER)],
    ),
    ("Sphere", Kind::Sphere, &[("radius", NUMBER)]),
    (
        "Cylinder",
        Kind::Cylinder,
        &[
            ("parts", Form::Words),
            ("radius", NUMBER),
            ("height", NUMBER),
        ],
    ),
    (
        "Cone",
        Kind::Cone,
        &[
            ("parts", Form::Words),
            ("bottomRadius", NUMBER),
            ("height", NUMBER),
        ],
    ),
    ("PointLight", Kind::PointLight, LIGHT),
    ("SpotLight", Kind::SpotLight, LIGHT),
    ("DirectionalLight", Kind::DirectionalLight, LIGHT),
    ("PerspectiveCamera", Kind::PerspectiveCamera, CAMERA),
    ("OrthographicCamera", Kind::OrthographicCamera, ORTHOGRAPHIC),
    ("Info", Kind::Info, &[("string", Form::Words)]),
    ("AsciiText", Kind::NoSurface, NO_SURFACE),
    ("IndexedLineSet", Kind::NoSurface, NO_SURFACE),
    ("PointSet", Kind::NoSurface, NO_SURFACE),
    ("FontStyle", Kind::Silent, FONT),
];

const ANCHOR: &[Field] = &[
    ("name", Form::Words),
    ("description", Form::Words),
    ("map", Form::Words),
];
const LOD: &[Field] = &[
    ("range", Form::Numbers),
    ("center", TRIPLE),
    ("screenArea", Form::Numbers),
];
const INLINE: &[Field] = &[
    ("name", Form::Words),
    ("bboxSize", TRIPLE),
    ("bboxCenter", TRIPLE),
];
const BINDING: &[Field] = &[("value", Form::Words)];
const MATERIAL: &[Field] = &[
    ("ambientColor", Form::Colors),
    ("diffuseColor", Form::Colors),
    ("specularColor", Form::Colors),
    ("emissiveColor", Form::Colors),
    ("shininess", Form::Numbers),
    ("transparency", Form::Numbers),
    ("mirror", Form::Numbers),
];
const TEXTURE: &[Field] = &[
    ("filename", Form::Words),
    ("image", Form::Image),
    ("wrapS", Form::Words),
    ("wrapT", Form::Words),
];
const TEXTURE_TRANSFORM: &[Field] = &[
    ("translation", Form::Exactly(2)),
    ("rotation", NUMBER),
    ("scaleFactor", Form::Exactly(2)),
    ("center", Form::Exactly(2)),
];
const HINTS: &[Field] = &[
    ("vertexOrdering", Form::Words),
    ("shapeType", Form::Words),
    ("faceType", Form::Words),
    ("creaseAngle", NUMBER),
];
const TRANSFORM: &[Field] = &[
    ("translation", TRIPLE),
    ("rotation", Form::Exactly(4)),
    ("scaleFactor", TRIPLE),
    ("scaleOrientation", Form::Exactly(4)),
    ("center", TRIPLE),
];
const FACE_SET: &[Field] = &[
    ("coordIndex", Form::Integers),
    ("materialIndex", Form::Integers),
    ("normalIndex", Form::Integers),
    ("textureCoordIndex", Form::Integers),
];
const LIGHT: &[Field] = &[
    ("on", Form::Words),
    ("intensity", NUMBER),
    ("color", Form::Colors),
    ("location", TRIPLE),
    ("direction", TRIPLE),
    ("dropOffRate", NUMBER),
    ("cutOffAngle", NUMBER),
];
const CAMERA: &[Field] = &[
    ("position", TRIPLE),
    ("orientation", Form::Exactly(4)),
    ("focalDistance", NUMBER),
    ("heightAngle", NUMBER),
    ("nearDistance", NUMBER),
    ("farDistance", NUMBER),
    ("aspectRatio", NUMBER),
    ("viewportMapping", Form::Words),
];
const ORTHOGRAPHIC: &[Field] = &[
    ("position", TRIPLE),
    ("orientation", Form::Exactly(4)),
    ("focalDistance", NUMBER),
    ("height", NUMBER),
    ("nearDistance", NUMBER),
    ("farDistance", NUMBER),
    ("aspectRatio", NUMBER),
    ("viewportMapping", Form::Words),
];
const NO_SURFACE: &[Field] = &[
    ("coordIndex", Form::Integers),
    ("materialIndex", Form::Integers),
    ("normalIndex", Form::Integers),
    ("textureCoordIndex", Form::Integers),
    ("startIndex", NUMBER),
    ("numPoints", NUMBER),
    ("string", Form::Words),
    ("spacing", NUMBER),
    ("justification", Form::Words),
    ("width", Form::Numbers),
];
const FONT: &[Field] = &[
    ("size", NUMBER),
    ("family", Form::Words),
    ("style", Form::Words),
];

impl Node<'_> {
    fn value(&self, field: &str) -> Option<&Value<'_>> {
        let given = self.fields.iter().find(|(name, _)| *name == field);
        given.map(|(_, value)| value)
    }

    /// The numbers of a field, if it is given.
    pub fn numbers(&self, field: &str) -> Option<&[f64]> {
        match self.value(field)? {
            Value::Numbers(list) => Some(list),
            _ => None,
        }
    }

    /// The `N` numbers of a field, if it is given and they are finite.
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
            Value::Vectors(list) => Some(list),
            _ => None,
        }
    }

    /// The pairs of a field.
    pub fn vectors2(&self, field: &str) -> Option<&[DVec2]> {
        match self.value(field)? {
            Value::Vectors2(list) => Some(list),
            _ => None,
        }
    }

    /// The colours of a field, if it is given.
    pub fn colors(&self, field: &str) -> Option<&[Rgb]> {
        match self.value(field)? {
            Value::Colors(list) => Some(list),
            _ => None,
        }
    }

    /// The indices of a field; `None` if it is not given, or with the −1 that says as much.
    pub fn index(&self, field: &str) -> Option<&[i32]> {
        match self.value(field)? {
            Value::Integers(list) if !matches!(**list, [] | [-1]) => Some(list),
            _ => None,
        }
    }

    /// The words of a field.
    pub fn words(&self, field: &str) -> &[Cow<'_, str>] {
        match self.value(field) {
            Some(Value::Words(list)) => list,
            _ => &[],
        }
    }

    /// The first word of a field; empty if there is none.
    pub fn word(&self, field: &str) -> &str {
        self.words(field).first().map_or("", |word| word)
    }

    /// Whether a flag is not off.
    pub fn is_on(&self, field: &str) -> bool {
        !matches!(self.word(field), "FALSE" | "false" | "0")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_find_their_fields() {
        assert_eq!(Kind::named(b"WWWAnchor"), Kind::Separator);
        assert_eq!(Kind::named(b"Cubist"), Kind::Unknown);
        assert_eq!(Kind::Sphere.fields(), [("radius", NUMBER)]);
        assert!(Kind::Unknown.fields().is_empty());
        for (name, kind, _) in TYPES {
            assert_eq!(Kind::named(name.as_bytes()), *kind);
        }
    }
}
