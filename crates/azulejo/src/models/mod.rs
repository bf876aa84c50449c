//! Model files: reading, merging and writing.
//!
//! [`read`] reads a model of any format, with limits on its size. [`changes`], [`branch_name`] and
//! [`name_branch`] are for merging several: the units of the first are those of the merged scene
//! ([`Scene::adapted`](crate::scene::Scene::adapted)), and each model is a branch in the tree of
//! names. [`write()`] writes a scene atomically in one of [`FORMATS`].
//!
//! ```
//! use azulejo::{models, scene::synthetic::cube_room, trace::Progress};
//!
//! let path = std::env::temp_dir().join(format!("azulejo-doc-{}.grf", std::process::id()));
//! let progress = Progress::new();
//! let lost = models::write(&cube_room(), &path, &progress)?;
//! assert!(lost.is_empty(), "GRF keeps all of it: {lost:?}");
//! let model = models::read(&path, &models::Reading::default(), &progress)?;
//! assert_eq!(model.format.name(), "GRF");
//! assert_eq!(model.scene.objects.len(), cube_room().objects.len());
//! std::fs::remove_file(path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod merging;
mod pictures;
mod reading;
mod writable;
mod written;
mod written_formats;

pub use azulejo_formats::RecognizedModel;
pub use merging::{Change, branch_name, changes, name_branch};
pub use reading::{
    MAX_FILE, MAX_STREAM, ReadFailure, Reading, VastFace, read, read_bytes, read_unbaked, unbaked,
};
pub use written::{ModelOutput, WriteFailure, write, write_copy};
pub use written_formats::{FORMATS, WrittenFormat, by_extension};
