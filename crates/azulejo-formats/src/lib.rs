//! Bytes to [`Scene`](azulejo_scene::Scene) and back, and pictures to files.
//!
//! Every format is a module with `read` and, where it makes sense, `write`. A reader returns
//! [`Loaded`]: the scene, which keeps every promise of
//! [`Scene::validate`](azulejo_scene::Scene::validate), and warnings that count what was
//! skipped; or a [`ReadError`] that says which file, where in it, what was found and what was
//! expected. Nothing in a file makes a reader panic, hang or reserve memory that the file's own
//! size does not justify. Other files that a model names (includes, materials, pictures) come
//! through one small trait, [`Files`], so that a folder, a test's map of strings and a sandbox
//! work alike.

pub mod brdf;
mod bytes;
pub mod camera_json;
mod detect;
pub mod drawing;
pub mod dxf;
mod error;
pub mod exr;
mod files;
mod gloss;
pub mod gltf;
pub mod grf;
mod gzip;
pub mod hdr;
pub mod jpeg;
mod materials;
pub mod mgf;
mod number;
pub mod obj;
pub mod openflight;
mod options;
mod pen;
mod phong;
mod picture;
pub mod ply;
pub mod png;
pub mod ppe;
pub mod ppf;
pub mod scn;
pub mod sff;
mod smooth;
pub mod stl;
pub mod studio3ds;
pub mod svg;
mod tessellate;
mod text;
mod textures;
#[cfg(feature = "fonts")]
pub mod typeface;
pub mod view3d;
pub mod vrml;
mod warnings;
mod weld;
mod words;

pub use detect::{Format, Unrecognised, detect, read, read_with, recognise};
pub use error::{Loaded, Position, ReadError, Warning};
pub use files::{FileError, Files, Folder, Memory};
pub use options::{Lod, ReadOptions};
pub use picture::{PictureError, decode as read_picture};
