//! Where the parts of a document stand in its files, for those who edit the text itself.

use super::document::{GrfName, NameKind};
use std::collections::HashSet;
use std::ops::Range;

/// The places of a document's parts, recorded while it is parsed. Offsets are bytes of the decoded
/// text of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct GrfLayout {
    /// The text of each file, by its index.
    pub texts: Vec<String>,
    /// The blocks that make objects, in the order of the scene's objects.
    pub objects: Vec<ObjectLayout>,
    pub includes: Vec<IncludeLayout>,
    /// The file names of includes, textures and reflection models.
    pub names: Vec<NameLayout>,
    /// The texts of parameters and of unknown extensions.
    pub opaque: Vec<(u32, Range<usize>)>,
    /// Every name that is defined: file, offset, kind, name.
    pub definitions: Vec<(u32, usize, NameKind, GrfName)>,
    /// Names that something refers to.
    pub uses: HashSet<(NameKind, GrfName)>,
    /// Whether the file is parsed alone: includes and files of reflection models are not read, and
    /// names may be defined elsewhere.
    pub is_alone: bool,
    /// The vertices of the mesh that is being read.
    pub open_vertices: Vec<VertexLayout>,
    /// The starts of its faces.
    pub open_faces: Vec<usize>,
}

/// A block that makes an object.
#[derive(Clone, Debug)]
pub(super) struct ObjectLayout {
    pub file: u32,
    /// The end of the block.
    pub end: usize,
    /// For meshes.
    pub vertices: Vec<VertexLayout>,
    /// The starts of a mesh's faces.
    pub faces: Vec<usize>,
    /// The extensions behind the block that belong to it, by name in lower case.
    pub notes: Vec<(String, Range<usize>)>,
}

/// A vertex of a mesh.
#[derive(Clone, Debug)]
pub(super) struct VertexLayout {
    /// The start of its position.
    pub position: usize,
    /// Its first `irad`.
    pub irradiance: Option<IrradLayout>,
}

/// `irad (r, g, b)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct IrradLayout {
    pub keyword: usize,
    /// The start of the vector.
    pub vector: usize,
    pub end: usize,
}

/// `include "name"`.
#[derive(Clone, Debug)]
pub(super) struct IncludeLayout {
    pub file: u32,
    pub range: Range<usize>,
    /// The included file.
    pub target: u32,
}

/// A file name, with its quotes if it has any.
#[derive(Clone, Debug)]
pub(super) struct NameLayout {
    pub file: u32,
    pub range: Range<usize>,
    pub name: String,
}
