//! A GRF file as it stands: what [`Document`] is made of.

use super::brdf::Reflection;
use super::solids::{ExactBlock, FigureBlock, SolidDefinition};
use crate::{Position, ReadError};
use azulejo_scene::{Attribute, Light, PrimitiveKind, Rgb, SurfaceLight};
use azulejo_scene::{Camera, Faces, Fog, Units};
use glam::{DAffine3, DVec2, DVec3};
use std::sync::Arc;

/// A GRF file, mirrored literally: its leading comments, definitions and uses, transforms,
/// includes, parameters, and the extensions that azulejo does not know.
///
/// Layout is not kept: [`write`](Document::write) lays out canonically. Comments behind the
/// first block are not kept either.
///
/// Every name that [`parse`](Document::parse) let through is defined where it is used.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// The comments before the first block, one per line, without their `//`.
    pub comments: Vec<String>,
    pub(super) blocks: Vec<Block>,
    /// The file and everything it includes; [`Place::file`] points here.
    pub(super) sources: Sources,
}

/// The files of a document, the outermost first.
#[derive(Clone, Debug, Default)]
pub(super) struct Sources(Vec<Source>);

/// One file, as often as it is included.
#[derive(Clone, Debug)]
pub(super) struct Source {
    /// The name that messages show.
    pub shown: String,
    /// The name by which [`Files`](crate::Files) gives it.
    pub path: String,
    /// Which file includes it, and in which line.
    pub parent: Option<(u32, u32)>,
}

impl Sources {
    /// Adds a file and returns its index.
    pub fn push(&mut self, source: Source) -> u32 {
        self.0.push(source);
        self.0.len() as u32 - 1
    }

    /// A file by its index; `None` for a document that was not read from files.
    pub fn get(&self, file: u32) -> Option<&Source> {
        self.0.get(file as usize)
    }

    /// The name of a file in messages; empty for a document that was not read from files.
    pub fn shown(&self, file: u32) -> &str {
        self.get(file).map_or("", |source| &source.shown)
    }

    /// A file and those that include it, innermost first.
    pub fn chain(&self, file: u32) -> impl Iterator<Item = &Source> {
        std::iter::successors(self.get(file), |s| {
            s.parent.and_then(|(parent, _)| self.get(parent))
        })
    }

    /// An error at a place.
    pub fn fail(
        &self,
        place: Place,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Fail {
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

/// An error on its way out; in a box, because results of numbers should stay small.
pub(super) type Fail = Box<ReadError>;

/// Where something stands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    /// Index into [`Document::sources`].
    pub file: u32,
    /// From 1; 0 for what was not read from a file.
    pub line: u32,
    /// From 1.
    pub column: u32,
}

impl Place {
    /// The line and column, or the whole of what was not read from a file.
    pub fn position(self) -> Position {
        match self.line {
            0 => Position::Whole,
            line => Position::Line(line, self.column),
        }
    }
}

/// One block and where it begins.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub place: Place,
    pub kind: BlockKind,
}

#[derive(Clone, Debug)]
pub(super) enum BlockKind {
    /// `params begin ... end`: the text between, as it stood.
    Params(String),
    Mesh(Box<MeshBlock>),
    AreaLight(Box<AreaLight>),
    /// `ext primitive`.
    Primitive(Box<PrimitiveBlock>),
    /// `ext solids`, `ext prism` and the like.
    Exact(Box<ExactBlock>),
    Figure(FigureBlock),
    Define(Box<SolidDefinition>),
    /// `include "name"` and what that file holds.
    Include {
        name: String,
        blocks: Vec<Block>,
    },
    Transform {
        /// In the order written; the first acts first.
        steps: Vec<Step>,
        blocks: Vec<Block>,
    },
    /// `def ...` and the blocks in which the definitions hold. Without blocks they hold in the
    /// list where they stand.
    Definitions {
        definitions: Vec<Definition>,
        blocks: Option<Vec<Block>>,
    },
    Units(Units),
    Camera(Camera),
    Background(Rgb),
    Fog(Fog),
    Light(Light),
    Material(Box<MaterialNote>),
    Texture {
        of: Name,
        path: String,
    },
    /// An extension of somebody else: its name, and the text between `begin` and `end ext`.
    Unknown {
        name: String,
        text: String,
    },
}

/// An identifier; the same one is stored once.
pub(super) type Name = Arc<str>;

/// An elementary transformation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    Scale(DVec3),
    /// Degrees about x, then y, then z.
    Rotation(DVec3),
    Translation(DVec3),
}

#[derive(Clone, Debug)]
pub(super) struct Definition {
    pub name: Name,
    pub body: Body,
}

/// What a definition or a statement before a face says.
#[derive(Clone, Debug)]
pub(super) enum Body {
    Texture(Name),
    Color(Rgb),
    Brdf(Arc<Reflection>),
}

/// The kinds of name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    Texture,
    Color,
    Brdf,
    /// An `ext figure`.
    Figure,
    /// An `ext define`.
    Solid,
}

/// What changes the look of the faces that follow.
#[derive(Clone, Debug)]
pub(super) enum Change {
    Set(Body),
    Use(Kind, Name),
}

/// `begin mesh`, or `mesh light begin`.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshBlock {
    /// `mesh light`.
    pub is_light: bool,
    /// The `rgb` of a `mesh light`: emitted radiance.
    pub radiance: Option<Rgb>,
    /// What stands at the head of the mesh, before its vertices.
    pub head: Vec<Change>,
    pub vertices: Vertices,
    pub faces: Faces,
    /// What stands before a face, with the face's index, ascending.
    pub changes: Vec<(u32, Change)>,
    pub notes: ObjectNotes,
}

/// A vertex list, by columns.
#[derive(Clone, Debug, Default)]
pub(super) struct Vertices {
    pub positions: Vec<DVec3>,
    pub normals: Column<DVec3>,
    pub irradiance: Column<Rgb>,
    pub uvs: Column<DVec2>,
    pub colors: Column<Rgb>,
    /// `use color id` before a vertex, by the vertex's index, ascending.
    pub named_colors: Vec<(u32, Name)>,
}

/// One attribute of the vertices, each of which may have it or not.
#[derive(Clone, Debug, Default)]
pub(super) struct Column<T> {
    /// Values of the first vertices; those behind the end have none.
    values: Vec<T>,
    /// Which of `values` are only place holders, ascending.
    missing: Vec<u32>,
}

impl<T: Copy + Default> Column<T> {
    /// A column in which no vertex lacks its value, or every vertex does.
    pub fn full(values: Vec<T>) -> Column<T> {
        Column {
            values,
            missing: Vec::new(),
        }
    }

    /// Sets the value of a vertex behind all that have one.
    pub fn push(&mut self, vertex: usize, value: T) {
        while self.values.len() < vertex {
            self.missing.push(self.values.len() as u32);
            self.values.push(T::default());
        }
        self.values.push(value);
    }

    pub fn get(&self, vertex: usize) -> Option<T> {
        let value = *self.values.get(vertex)?;
        // Most columns lack nothing: don't search then.
        let is_missing =
            !self.missing.is_empty() && self.missing.binary_search(&(vertex as u32)).is_ok();
        (!is_missing).then_some(value)
    }

    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// How many of `vertices` vertices have no value, or how many values no vertex.
    pub fn lacking(&self, vertices: usize) -> usize {
        vertices.abs_diff(self.values.len()) + self.missing.len()
    }

    /// The values, one per vertex, where none is missing.
    pub fn complete(&self, vertices: usize) -> Option<&[T]> {
        (self.lacking(vertices) == 0).then_some(&self.values)
    }
}

/// `light begin`: a parallelogram that shines.
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

/// What extensions beside a mesh, area light or primitive say about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ObjectNotes {
    pub name: String,
    /// The brdf that gives a light or primitive its material.
    pub material: Option<Name>,
    /// One smoothing group per face, or empty.
    pub smoothing: Vec<u32>,
    /// Standard error of `irad`, one per vertex, or empty.
    pub irradiance_error: Vec<Rgb>,
    /// Irradiance on a light or primitive.
    pub light: Option<SurfaceLight>,
    /// Normals by corners, of skins and meshes in solids.
    pub normals: Option<Box<Attribute<DVec3>>>,
}

/// `ext material`: what a material is beyond its brdf. What is `None` stays as the brdf says.
#[derive(Clone, Debug, Default)]
pub(super) struct MaterialNote {
    /// The brdf that it completes.
    pub of: Name,
    pub name: Option<String>,
    pub diffuse: Option<Rgb>,
    pub mirror: Option<Rgb>,
    pub emission: Option<Rgb>,
    pub emits_back: bool,
    pub ior: Option<f64>,
    pub transmittance: Option<Rgb>,
    pub thin: bool,
    pub textures: Option<Vec<Name>>,
    pub brdf_file: Option<Arc<Reflection>>,
}

impl MaterialNote {
    /// Whether it says nothing.
    pub fn is_empty(&self) -> bool {
        let colors = [self.diffuse, self.mirror, self.emission, self.transmittance];
        self.name.is_none()
            && colors.iter().all(Option::is_none)
            && !self.emits_back
            && self.ior.is_none()
            && !self.thin
            && self.textures.is_none()
            && self.brdf_file.is_none()
    }
}

impl BlockKind {
    /// The notes of a block that makes an object.
    pub fn notes_mut(&mut self) -> Option<&mut ObjectNotes> {
        match self {
            BlockKind::Mesh(mesh) => Some(&mut mesh.notes),
            BlockKind::AreaLight(light) => Some(&mut light.notes),
            BlockKind::Primitive(primitive) => Some(&mut primitive.notes),
            BlockKind::Exact(exact) => Some(&mut exact.notes),
            _ => None,
        }
    }
}
