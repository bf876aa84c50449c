//! Stereolithography, `.stl`, ASCII or binary.
//!
//! Each solid becomes one object, with equal positions merged; binary facets can have colours as
//! written by VisCAM and Magics. `docs/formats/stl.md` has the details.

mod ascii;
mod binary;
#[cfg(test)]
mod tests;
mod write;

pub use write::{losses, write, write_within};

use crate::reading::options::check_length;
use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::surface::single;
use crate::surface::weld::Welder;
use crate::{Files, Loaded, ReadError, ReadOptions};
use azulejo_scene::{Faces, Material, MaterialId, Mesh, Object, Rgb, Scene, Shape, Units, Up};
use glam::DVec3;

/// Reflectance of facets without a colour.
const DEFAULT_REFLECTANCE: Rgb = Rgb::grey(0.5);

/// Reads a model. `name` is used in messages; STL refers to no other files and has no options.
///
/// # Errors
/// Text with a coordinate that is not a number, and too few bytes for a binary file.
pub fn read(
    bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    _options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    check_length(bytes, name)?;
    let mut warnings = Warnings::default();
    let text = decoded(bytes);
    let is_text = is_text(&text) && !binary::has_right_length(bytes);
    let mut scene = if is_text {
        ascii::read(&text, name, &mut warnings)?
    } else {
        binary::read(bytes, name, &mut warnings)?
    };
    if scene.objects.is_empty() {
        warnings.add_whole(name, "no facets: the scene is empty");
    }
    scene.units = Units {
        up: Up::Z,
        ..Units::default()
    };
    if !is_text {
        single::warn(&scene, name, &mut warnings);
    }
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}

/// Whether this may be the ASCII format. Binary files may begin with `solid`, too, but then contain
/// zeros, or their length matches their count of triangles.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let says_solid = start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid");
    let has_zeros = || bytes.iter().take(1 << 10).any(|b| *b == 0);
    says_solid && !has_zeros()
}

/// A solid under construction.
struct StlSolid {
    name: String,
    welder: Welder,
    faces: Faces,
    face_materials: Vec<MaterialId>,
}

impl StlSolid {
    /// A solid with capacity for about this many triangles.
    fn new(name: String, triangles: usize) -> StlSolid {
        let mut faces = Faces::default();
        faces.starts.reserve(triangles);
        faces.corners.reserve(3 * triangles);
        StlSolid {
            name,
            // Around a vertex of a closed surface there are six triangles on average.
            welder: Welder::new(triangles / 2),
            faces,
            face_materials: Vec::with_capacity(triangles),
        }
    }

    /// Appends a polygon, or returns why it is skipped.
    #[inline]
    fn facet(&mut self, corners: &[DVec3], material: MaterialId) -> Result<(), &'static str> {
        if corners.len() < 3 {
            return Err("facet with fewer than three vertices: skipped");
        }
        if !corners.iter().all(|c| c.is_finite()) {
            return Err("facet with a vertex that is not finite: skipped");
        }
        for &corner in corners {
            self.faces.corners.push(self.welder.index(corner));
        }
        self.faces.starts.push(self.faces.corners.len() as u32);
        self.face_materials.push(material);
        Ok(())
    }

    /// Adds the solid to a scene, unless it is empty.
    fn finish(self, scene: &mut Scene) {
        if self.faces.is_empty() {
            return;
        }
        let mesh = Mesh {
            positions: self.welder.positions,
            faces: self.faces,
            face_materials: self.face_materials,
            ..Mesh::default()
        };
        scene
            .objects
            .push(Object::new(self.name, Shape::Mesh(mesh)));
    }
}

fn default_material() -> Material {
    Material::diffuse("default", DEFAULT_REFLECTANCE)
}

/// A material named after its colour.
pub(crate) fn painted(color: Rgb) -> Material {
    let [r, g, b] = color.to_array().map(|c| (255.0 * c).round() as u8);
    Material::diffuse(format!("#{r:02x}{g:02x}{b:02x}"), color)
}
