//! Exact shapes: figures, and the nested solids of extensions.

mod bevel;
mod figure;
mod from_scene;
mod parse;
mod resolve;
mod skin;
mod write;

pub(super) use figure::figure;
pub(super) use from_scene::{Figures, exact_block};
pub(super) use parse::is_solid;
pub(super) use resolve::Defined;
pub(super) use skin::{skin, skin_block};
pub(super) use write::{define, exact};

use super::document::{GrfName, MeshBlock, ObjectNotes, SourcePosition};
use azulejo_scene::{Bevel, Figure, Operation, PrimitiveKind};
use glam::{DAffine3, DVec2, DVec3};
use std::sync::Arc;

/// Maximum depth of nested solids, including definitions that contain instances: that of a scene.
const DEEPEST: usize = 256;

/// `ext figure`: an outline that prisms and texts refer to.
#[derive(Clone, Debug)]
pub(super) struct FigureBlock {
    pub name: GrfName,
    pub figure: Arc<Figure>,
}

/// `ext define`: solids that instances refer to.
#[derive(Clone, Debug)]
pub(super) struct SolidDefinition {
    pub name: GrfName,
    pub material: Option<GrfName>,
    pub solids: Vec<SolidBlock>,
}

/// `ext solids`, or an extension that is one solid: an object of its own.
#[derive(Clone, Debug)]
pub(super) struct ExactBlock {
    pub solids: Vec<SolidBlock>,
    /// The `ext skin` after it.
    pub skin: Option<Box<SkinBlock>>,
    pub notes: ObjectNotes,
}

/// `ext skin`: the proxy mesh that represented an exact shape when it was solved.
#[derive(Clone, Debug)]
pub(super) struct SkinBlock {
    /// Vertices, faces, smoothing and errors; no appearance.
    pub mesh: MeshBlock,
    /// For each face, the solid from which it has its material: an index into
    /// [`Exact::leaves`](azulejo_scene::Exact::leaves). Empty if it is the first for all.
    pub leaves: Vec<u32>,
}

/// A solid and its position.
#[derive(Clone, Debug)]
pub(super) struct SolidBlock {
    pub place: SourcePosition,
    /// `None` for that of the enclosing block.
    pub material: Option<GrfName>,
    pub kind: SolidKind,
}

#[derive(Clone, Debug)]
pub(super) enum SolidKind {
    Primitive(PrimitiveKind, Box<DAffine3>),
    Prism(GrfName, Box<DAffine3>, Option<Arc<Bevel>>),
    Text(Box<TextBlock>),
    /// Sixteen control points, row by row.
    Patch(Box<[[DVec3; 4]; 4]>),
    /// Without appearance.
    Mesh(Box<MeshBlock>),
    Shell(Vec<SolidBlock>),
    Csg(Box<CsgBlock>),
    /// A copy of defined solids, optionally transformed.
    Instance(GrfName, Option<Box<DAffine3>>),
}

#[derive(Clone, Debug)]
pub(super) struct CsgBlock {
    pub operation: Operation,
    pub left: Vec<SolidBlock>,
    pub right: Vec<SolidBlock>,
}

/// `text`: prisms of many figures under one map.
#[derive(Clone, Debug)]
pub(super) struct TextBlock {
    /// The text in plain characters, for reference only.
    pub string: Option<String>,
    /// The images of the glyphs' x, y and z axes and of the first glyph origin.
    pub map: DAffine3,
    /// That of all glyphs.
    pub bevel: Option<Arc<Bevel>>,
    pub glyphs: Vec<GlyphBlock>,
}

#[derive(Clone, Debug)]
pub(super) struct GlyphBlock {
    pub figure: GrfName,
    pub pen: GlyphOrigin,
}

/// The origin of a glyph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum GlyphOrigin {
    /// In the plane of the text, in the units of its figures.
    Along(DVec2),
    /// In object coordinates.
    At(DVec3),
}

impl TextBlock {
    /// The map of a glyph's prism.
    pub fn map_at(&self, pen: GlyphOrigin) -> DAffine3 {
        let axes = self.map.matrix3;
        let translation = match pen {
            GlyphOrigin::At(place) => place,
            GlyphOrigin::Along(pen) => {
                self.map.translation + pen.x * axes.x_axis + pen.y * axes.y_axis
            }
        };
        DAffine3 {
            matrix3: axes,
            translation,
        }
    }
}

/// Whether a map is invertible.
pub(super) fn has_inverse(map: &DAffine3) -> bool {
    let size = map.matrix3.determinant();
    map.is_finite() && size != 0.0 && size.is_finite() && map.inverse().is_finite()
}
