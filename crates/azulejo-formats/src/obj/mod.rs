//! Wavefront OBJ and its material files, MTL.
//!
//! What is read: vertices with colours, texture coordinates and normals, polygons of any number
//! of corners and any shape, objects, groups, smoothing groups, materials with reflectance,
//! emission, mirrors, glass and pictures. Points, lines and free-form surfaces are counted and
//! skipped. `docs/formats/obj.md` says how every statement is understood.

mod assemble;
mod cursor;
mod mtl;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use mtl::read as read_materials;
pub use read::read;
pub use write::{losses, write};
