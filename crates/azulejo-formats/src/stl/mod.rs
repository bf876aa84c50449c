//! Stereolithography, `.stl`, as text or binary.
//!
//! What is read: solids of facets, each solid one object, its equal positions made one; colours
//! of binary facets as VisCAM and Magics write them. `docs/formats/stl.md` says more.

mod ascii;
mod binary;
#[cfg(test)]
mod tests;

use crate::reading::options::check_length;
use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::surface::weld::Welder;
use crate::{Files, Loaded, ReadError, ReadOptions};
use azulejo_scene::{Faces, Material, MaterialId, Mesh, Object, Rgb, Scene, Shape, Units, Up};
use glam::DVec3;

/// Reflectance of facets without a colour.
const DEFAULT_REFLECTANCE: Rgb = Rgb::grey(0.5);

/// Reads a model. `name` stands in messages; STL names no other files and takes no options.
///
/// # Errors
/// Text with a coordinate that is no number, and bytes too few for a binary file.
pub fn read(
    bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    _options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    check_length(bytes, name)?;
    let mut warnings = Warnings::default();
    let text = decoded(bytes);
    let mut scene = if is_text(&text) && !binary::has_right_length(bytes) {
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
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}

/// Whether bytes may be the text format. Binary files may begin with `solid` too, but have zeros
/// behind it or the length that their count of triangles gives them.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let says_solid = start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid");
    let has_zeros = || bytes.iter().take(1 << 10).any(|b| *b == 0);
    says_solid && !has_zeros()
}

/// A solid under construction.
struct Solid {
    name: String,
    welder: Welder,
    faces: Faces,
    face_materials: Vec<MaterialId>,
}

impl Solid {
    /// A solid with room for about so many triangles.
    fn new(name: String, triangles: usize) -> Solid {
        let mut faces = Faces::default();
        faces.starts.reserve(triangles);
        faces.corners.reserve(3 * triangles);
        Solid {
            name,
            // Around a vertex of a closed surface there are six triangles.
            welder: Welder::new(triangles / 2),
            faces,
            face_materials: Vec::with_capacity(triangles),
        }
    }

    /// Appends a polygon, or says why not.
    #[inline]
    fn facet(&mut self, corners: &[DVec3], material: MaterialId) -> Result<(), &'static str> {
        if corners.len() < 3 {
            return Err("facet of fewer than three vertices: skipped");
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
