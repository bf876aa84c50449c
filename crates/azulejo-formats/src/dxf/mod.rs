//! DXF, the drawing interchange format of AutoCAD, as text and binary, from release 10 to 2018.
//!
//! The reader supports faces, meshes, filled areas, lines, curves and polylines with thickness or
//! width, blocks inserted by INSERT, layers, colours, MATERIALs, lights, perspective
//! views, units and external references. Everything else is counted in warnings.
//! `docs/formats/dxf.md` documents how every entity is interpreted.

mod axes;
mod camera;
mod color;
mod curve;
mod drawing;
mod entities;
mod figures;
mod finish;
mod ids;
mod instantiate;
mod light;
mod mesh_entity;
#[cfg(feature = "fonts")]
mod mtext;
mod outline;
mod pairs;
mod parse;
mod polyline;
mod project;
mod record;
mod spline;
mod strands;
mod surfaces;
#[cfg(test)]
mod tests;
#[cfg(feature = "fonts")]
mod text;

mod units;
mod write;

use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions};
use azulejo_scene::{Units, Up};
use project::Project;

pub use figures::read_figures;
pub use write::{losses, write};

/// Reads a drawing. External references are read through `files`; `name` is used in messages.
///
/// # Errors
/// A file without sections, and one whose blocks and curves expand to more than `options` allow.
/// All other damage is repaired with a warning.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let bytes = &*decoded(bytes);
    let mut warnings = Warnings::default();
    let mut project = Project::read(bytes, name, files, options, &mut warnings)?;
    if !options.keeps {
        // What blocks unfold to has been counted.
        return Ok(Loaded::default());
    }
    let metres_per_unit = project.drawings[0].metres_per_unit;
    let cameras = std::mem::take(&mut project.drawings[0].cameras);
    let mut scene = instantiate::instantiate(project, &mut warnings);
    scene.cameras = cameras;
    scene.units = Units {
        metres_per_unit,
        up: Up::Z,
        photometric: false,
    };
    if scene.objects.is_empty() {
        warnings.add_whole(name, "the drawing contains no surfaces");
    }
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}
