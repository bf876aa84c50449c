//! Wavefront OBJ and its material files, MTL.
//!
//! The reader supports vertices with colours, texture coordinates and normals, polygons of any
//! number of corners and any shape, free-form surfaces with trimming curves, objects, groups,
//! smoothing groups, and materials with reflectance, emission, mirrors, glass and textures. Points,
//! lines and curves are counted and skipped. `docs/formats/obj.md` documents how every statement is
//! interpreted.

mod assemble;
mod cursor;
mod free_form;
mod lists;
mod mtl;
mod placement;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use mtl::read as read_materials;
pub use read::{read, read_with};
pub use write::{losses, write};
