//! The content of a GRF file: the parts of [`GrfDocument`].

use super::brdf::GrfReflection;
use super::solids::{ExactBlock, FigureBlock, SolidDefinition};
use super::surroundings::{BackplateBlock, EnvironmentBlock};
use crate::{Position, ReadError};
use azulejo_scene::{
    Attribute, BackIrradiance, Light, OpacityChannel, OpacityMode, PictureChannel, PrimitiveKind,
    ReliefKind, Rgb, Sidedness, SurfaceLight, WrapMode,
};
use azulejo_scene::{Camera, Faces, Fog, Units};
use glam::{DAffine3, DVec2, DVec3};
use std::sync::Arc;

/// The blocks of a GRF file: its leading comments, definitions and uses, transforms, includes,
/// parameters, and unknown extensions.
///
/// The layout is not kept: [`write`](GrfDocument::write) uses a canonical one. Comments after the
/// first block are not kept either; [`GrfText`](super::GrfText) keeps both.
///
/// Every name that [`parse`](GrfDocument::parse) accepted is defined where it is used.
#[derive(Clone, Debug, Default)]
pub struct GrfDocument {
    /// The comments before the first block, one per line, without their `//`.
    pub comments: Vec<String>,
    pub(super) blocks: Vec<GrfBlock>,
    /// The file and everything it includes; [`SourcePosition::file`] is an index into it.
    pub(super) sources: GrfSources,
}

/// The files of a document, the outermost first.
#[derive(Clone, Debug, Default)]
pub(super) struct GrfSources(Vec<GrfSource>);

/// One file; listed once for each time it is included.
#[derive(Clone, Debug)]
pub(super) struct GrfSource {
    /// The name shown in messages.
    pub shown: String,
    /// The name by which [`Files`](crate::Files) provides it.
    pub path: String,
    /// The including file and the line of the include.
    pub parent: Option<(u32, u32)>,
}

impl GrfSources {
    /// Adds a file and returns its index.
    pub fn push(&mut self, source: GrfSource) -> u32 {
        self.0.push(source);
        self.0.len() as u32 - 1
    }

    /// A file by its index; `None` for a document that was not read from files.
    pub fn get(&self, file: u32) -> Option<&GrfSource> {
        self.0.get(file as usize)
    }

    /// The name of a file in messages; empty for a document that was not read from files.
    pub fn shown(&self, file: u32) -> &str {
        self.get(file).map_or("", |source| &source.shown)
    }

    /// A file and those that include it, innermost first.
    pub fn chain(&self, file: u32) -> impl Iterator<Item = &GrfSource> {
        std::iter::successors(self.get(file), |s| {
            s.parent.and_then(|(parent, _)| self.get(parent))
        })
    }

    /// An error at a position.
    pub fn fail(
        &self,
        place: SourcePosition,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> BoxedError {
        let mut error = ReadError::whole(self.shown(place.file), found, expected);
        error.position = place.position();
        let includes = self.chain(place.file).filter_map(|s| {
            let (parent, line) = s.parent?;
            Some((self.get(parent)?.shown.clone(), line))
        });
        error.included_from = includes.collect();
        error.included_from.reverse();
        Box::new(error)
    }
}

/// A boxed error, which keeps results of numbers small.
pub(super) type BoxedError = Box<ReadError>;

/// A position in a source file.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SourcePosition {
    /// Index into [`GrfDocument::sources`].
    pub file: u32,
    /// From 1; 0 for what was not read from a file.
    pub line: u32,
    /// From 1.
    pub column: u32,
}

impl SourcePosition {
    /// The line and column, or the whole of what was not read from a file.
    pub fn position(self) -> Position {
        match self.line {
            0 => Position::Whole,
            line => Position::Line(line, self.column),
        }
    }
}

/// A block and its position.
#[derive(Clone, Debug)]
pub(super) struct GrfBlock {
    pub place: SourcePosition,
    pub kind: BlockKind,
}

#[derive(Clone, Debug)]
pub(super) enum BlockKind {
    /// `params begin ... end`: the verbatim text in between.
    Params(String),
    Mesh(Box<MeshBlock>),
    AreaLight(Box<AreaLight>),
    /// `ext primitive`.
    Primitive(Box<PrimitiveBlock>),
    /// `ext solids`, `ext prism` and the like.
    Exact(Box<ExactBlock>),
    Figure(FigureBlock),
    Define(Box<SolidDefinition>),
    /// `include "name"` and the content of that file, which other includes of it share.
    Include {
        name: String,
        blocks: Arc<Vec<GrfBlock>>,
    },
    /// `ext mesh_instance`.
    MeshInstance(Box<MeshInstanceBlock>),
    Transform {
        /// In the order written; the first is applied first.
        steps: Vec<TransformStep>,
        blocks: Vec<GrfBlock>,
    },
    /// `def ...` and the blocks in which the definitions hold. Without blocks they hold in the
    /// enclosing list.
    Definitions {
        definitions: Vec<GrfDefinition>,
        blocks: Option<Vec<GrfBlock>>,
    },
    Units(Units),
    Camera(Camera),
    Background(Rgb),
    /// `ext background` with a picture that is fixed to the image.
    Backplate(Box<BackplateBlock>),
    Fog(Fog),
    Light(Light),
    /// `ext light` of kind `environment`, or `ext background` with a picture by direction.
    Environment(Box<EnvironmentBlock>),
    Material(Box<MaterialNote>),
    Texture {
        of: GrfName,
        path: String,
        wrap: [WrapMode; 2],
    },
    /// An unknown extension: its name, and the text between `begin` and `end ext`.
    Unknown {
        name: String,
        text: String,
    },
}

/// An identifier; equal ones are stored once.
pub(super) type GrfName = Arc<str>;

/// An elementary transformation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TransformStep {
    Scale(DVec3),
    /// Degrees about x, then y, then z.
    Rotation(DVec3),
    Translation(DVec3),
}

#[derive(Clone, Debug)]
pub(super) struct GrfDefinition {
    pub name: GrfName,
    pub body: DefinitionBody,
}

/// The right-hand side of a definition, or a statement before a face.
#[derive(Clone, Debug)]
pub(super) enum DefinitionBody {
    Texture(GrfName),
    Color(Rgb),
    Brdf(Arc<GrfReflection>),
}

/// The types of names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum NameKind {
    Texture,
    Color,
    Brdf,
    /// An `ext figure`.
    Figure,
    /// An `ext define`.
    Solid,
}

/// A change of the appearance of the faces that follow.
#[derive(Clone, Debug)]
pub(super) enum AppearanceChange {
    Set(DefinitionBody),
    Use(NameKind, GrfName),
}

/// `begin mesh`, or `mesh light begin`.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshBlock {
    /// `mesh light`.
    pub is_light: bool,
    /// The `rgb` of a `mesh light`: emitted radiance.
    pub radiance: Option<Rgb>,
    /// The appearance before the vertices of the mesh.
    pub head: Vec<AppearanceChange>,
    pub vertices: VertexList,
    pub faces: Faces,
    /// The changes before faces, with the indices of the faces, ascending.
    pub changes: Vec<(u32, AppearanceChange)>,
    pub notes: ObjectNotes,
}

/// A vertex list, stored by attribute.
#[derive(Clone, Debug, Default)]
pub(super) struct VertexList {
    pub positions: Vec<DVec3>,
    pub normals: VertexColumn<DVec3>,
    pub irradiance: VertexColumn<Rgb>,
    pub uvs: VertexColumn<DVec2>,
    pub colors: VertexColumn<Rgb>,
    /// `use color id` before a vertex, with the index of the vertex, ascending.
    pub named_colors: Vec<(u32, GrfName)>,
}

/// One attribute of the vertices, some of which may lack it.
#[derive(Clone, Debug, Default)]
pub(super) struct VertexColumn<T> {
    /// Values of the first vertices; the ones beyond its end have none.
    values: Vec<T>,
    /// The indices of placeholders in `values`, ascending.
    missing: Vec<u32>,
}

impl<T: Copy + Default> VertexColumn<T> {
    /// A column in which either all vertices have a value or none has.
    pub fn full(values: Vec<T>) -> VertexColumn<T> {
        VertexColumn {
            values,
            missing: Vec::new(),
        }
    }

    /// Sets the value of a vertex after all those with a value.
    pub fn push(&mut self, vertex: usize, value: T) {
        while self.values.len() < vertex {
            self.missing.push(self.values.len() as u32);
            self.values.push(T::default());
        }
        self.values.push(value);
    }

    pub fn get(&self, vertex: usize) -> Option<T> {
        let value = *self.values.get(vertex)?;
        // Most columns are complete: skip the search then.
        let is_missing =
            !self.missing.is_empty() && self.missing.binary_search(&(vertex as u32)).is_ok();
        (!is_missing).then_some(value)
    }

    /// The values of some vertices, if any vertex has one.
    pub fn taken(&self, vertices: &[usize]) -> VertexColumn<T> {
        if self.is_empty() {
            return VertexColumn::default();
        }
        let value = |&v: &usize| self.get(v).unwrap_or_default();
        VertexColumn::full(vertices.iter().map(value).collect())
    }

    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The number of vertices without a value, or of values without a vertex.
    pub fn lacking(&self, vertices: usize) -> usize {
        vertices.abs_diff(self.values.len()) + self.missing.len()
    }

    /// The values, one per vertex, if none is missing.
    pub fn complete(&self, vertices: usize) -> Option<&[T]> {
        (self.lacking(vertices) == 0).then_some(&self.values)
    }
}

/// `light begin`: an emitting parallelogram.
#[derive(Clone, Debug)]
pub(super) struct AreaLight {
    pub corner: DVec3,
    pub edges: [DVec3; 2],
    pub radiance: Option<Rgb>,
    pub notes: ObjectNotes,
}

/// `ext primitive`: an exact sphere, cylinder, cone, box or parallelogram.
#[derive(Clone, Debug)]
pub(super) struct PrimitiveBlock {
    pub kind: PrimitiveKind,
    pub map: DAffine3,
    pub notes: ObjectNotes,
}

/// Attributes of a mesh, area light or primitive from extensions next to it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ObjectNotes {
    pub name: String,
    /// The brdf that gives a light or primitive its material.
    pub material: Option<GrfName>,
    /// One smoothing group per face, or empty.
    pub smoothing: Vec<u32>,
    /// Standard error of `irad`, one per vertex, or empty.
    pub irradiance_error: Vec<Rgb>,
    /// For each of the last vertices the one that it is a copy of, because their corners differ in
    /// normal or texture coordinate.
    pub shared: Vec<u32>,
    /// Irradiance of the back, beside `irad`.
    pub back: Option<Box<BackIrradiance>>,
    /// Irradiance on a light or primitive.
    pub light: Option<Box<SurfaceLight>>,
    /// Normals per corner, for skins and meshes in solids.
    pub normals: Option<Box<Attribute<DVec3>>>,
    /// The name by which `ext mesh_instance` refers to a mesh, and its own place.
    pub shared_mesh: Option<(GrfName, DAffine3)>,
}

/// `ext mesh_instance`: a mesh that stands elsewhere, too.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshInstanceBlock {
    /// The name in the `ext shared_mesh` of that mesh.
    pub of: GrfName,
    pub map: DAffine3,
    /// Irradiance of each vertex, or empty.
    pub irradiance: Vec<Rgb>,
    pub irradiance_error: Vec<Rgb>,
    /// The vertices with irradiance on their back, with it and its errors.
    pub back: Option<(Vec<u32>, Vec<Rgb>, Vec<Rgb>)>,
    pub notes: ObjectNotes,
}

/// `ext material`: attributes of a material beyond its brdf. What is `None` follows from the brdf.
#[derive(Clone, Debug, Default)]
pub(super) struct MaterialNote {
    /// The brdf that it completes.
    pub of: GrfName,
    pub name: Option<String>,
    pub diffuse: Option<Rgb>,
    pub mirror: Option<Rgb>,
    pub emission: Option<Rgb>,
    pub emission_texture: Option<GrfName>,
    pub emits_back: bool,
    pub ior: Option<f64>,
    pub transmittance: Option<Rgb>,
    pub thin: bool,
    pub sidedness: Sidedness,
    pub textures: Option<Vec<GrfName>>,
    pub brdf_file: Option<Arc<GrfReflection>>,
    pub opacity: Option<OpacityNote>,
    pub finish: Option<FinishNote>,
    pub relief: Option<(GrfName, ReliefKind)>,
}

/// The opacity of an `ext material`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OpacityNote {
    pub constant: f64,
    /// The picture that multiplies it, and its part that counts.
    pub picture: Option<(GrfName, OpacityChannel)>,
    pub mode: OpacityMode,
}

/// Pictures of metalness and roughness of an `ext material`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FinishNote {
    pub base: Rgb,
    pub metallic: f64,
    pub roughness: f64,
    /// The picture of each, and its part that counts.
    pub metallic_picture: Option<(GrfName, PictureChannel)>,
    pub roughness_picture: Option<(GrfName, PictureChannel)>,
}

impl MaterialNote {
    /// Whether it has no attributes.
    pub fn is_empty(&self) -> bool {
        let colors = [self.diffuse, self.mirror, self.emission, self.transmittance];
        self.name.is_none()
            && colors.iter().all(Option::is_none)
            && self.emission_texture.is_none()
            && !self.emits_back
            && self.ior.is_none()
            && !self.thin
            && self.sidedness == Sidedness::Unsaid
            && self.textures.is_none()
            && self.brdf_file.is_none()
            && self.opacity.is_none()
            && self.finish.is_none()
            && self.relief.is_none()
    }
}

impl BlockKind {
    /// The notes of a block that creates an object.
    pub fn notes_mut(&mut self) -> Option<&mut ObjectNotes> {
        match self {
            BlockKind::Mesh(mesh) => Some(&mut mesh.notes),
            BlockKind::AreaLight(light) => Some(&mut light.notes),
            BlockKind::Primitive(primitive) => Some(&mut primitive.notes),
            BlockKind::Exact(exact) => Some(&mut exact.notes),
            BlockKind::MeshInstance(instance) => Some(&mut instance.notes),
            _ => None,
        }
    }
}
