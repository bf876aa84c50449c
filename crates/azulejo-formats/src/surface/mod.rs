//! What all formats share for surfaces: materials and their reflection models, textures, and
//! the vertices, normals and polygons of meshes, also of volumes.

pub(crate) mod boundary;
pub(crate) mod closed;
pub(crate) mod cut;
pub(crate) mod finite;
pub(crate) mod gloss;
pub(crate) mod holes;
pub(crate) mod losses;
pub(crate) mod materials;
pub(crate) mod mean_plane;
pub(crate) mod model;
pub(crate) mod named;
pub(crate) mod phong;
pub(crate) mod repeated;
pub(crate) mod single;
pub(crate) mod smooth;
pub(crate) mod tessellate;
pub(crate) mod textures;
pub(crate) mod unpainted;
pub(crate) mod weld;
