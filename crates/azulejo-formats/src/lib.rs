//! Reads [`Scene`](azulejo_scene::Scene)s from the bytes of model files and writes them, and reads
//! and writes pictures.
//!
//! | module | purpose | may use |
//! |---|---|---|
//! | `reading` | bytes, text, numbers, files, options, errors, warnings, recognition | – |
//! | [`picture`] | PNG, JPEG, Radiance HDR, OpenEXR, BMP, TGA, GIF, SGI, TIFF, WebP, DDS, KTX2 | – |
//! | `surface` | materials, reflection models, textures, normals, polygons of exact shapes | `reading`, `picture` |
//! | [`outline`] | fonts, encodings, typefaces, drawings | `reading` |
//! | [`brdf`], [`camera_json`] | reflection models; cameras and lights | `reading` |
//! | [`numpy`] | arrays and archives of them | – |
//! | [`grf`], [`obj`], [`gltf`], ... | one folder per model format | all above |
//! | `read` | recognizes a format and calls its reader | all above |
//!
//! Every format is a module with `read` and, where it makes sense, `write`. A reader returns
//! [`Loaded`]: a scene that is valid in the sense of
//! [`Scene::validate`](azulejo_scene::Scene::validate), with warnings that count what was
//! skipped; or a [`ReadError`] with the file, the position, what was found and what was
//! expected. No file makes a reader panic, hang or reserve memory that the file's own
//! size does not justify. Other files that a model names (includes, materials, pictures) are
//! read through a small trait, [`Files`], so that a folder, files in memory and a sandbox
//! work alike.

pub mod abaqus;
pub mod brdf;
pub mod camera_json;
pub mod cityjson;
pub mod disk;
pub mod dxf;
pub mod energyplus;
pub mod gltf;
pub mod gmsh;
pub mod grf;
pub mod mgf;
pub mod nastran;
pub mod numpy;
pub mod obj;
pub mod off;
pub mod openflight;
pub mod openfoam;
pub mod outline;
pub mod photometry;
pub mod picture;
pub mod ply;
mod read;
#[cfg(test)]
mod reader_tests;
mod reading;
pub mod scn;
pub mod sff;
pub mod stl;
pub mod studio3ds;
mod surface;
pub mod three_mf;
pub mod view3d;
pub mod vrml;
pub mod vtk;

pub use picture::{PictureError, decode as read_picture};
pub use read::{RecognizedModel, read, read_drawing, read_with};
pub use reading::detect::{Format, Unrecognized, detect, recognize};
pub use reading::error::{Loaded, Position, ReadError, Warning};
pub use reading::files::{FileError, Files, Folder, Memory};
pub use reading::fonts::{FontFile, FontRequest};
pub use reading::options::{Lod, ReadOptions, VertexColors};
pub use surface::closed::open_objects;
pub use surface::tessellate::{divide_into_triangles, tessellate};
