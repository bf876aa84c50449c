//! The lists of a file as a scene.

use super::parse::OffLists;
use crate::Position;
use crate::reading::warnings::Warnings;
use crate::stl::painted;
use azulejo_scene::{Attribute, Material, MaterialId, Mesh, Object, Rgb, Scene, Shape};
use glam::DVec3;
use std::collections::HashMap;

/// Reflectance of faces without a colour.
const DEFAULT_REFLECTANCE: Rgb = Rgb::grey(0.5);

/// Maximum number of distinct colours of faces; each becomes a material.
const MOST_COLORS: usize = 1 << 16;

/// The scene of a file; `name` is used in warnings.
pub(super) fn scene(mut lists: OffLists, name: &str, warnings: &mut Warnings) -> Scene {
    // Report what the parser skipped, once for each kind of problem.
    let counts = [
        ("face of fewer than three corners: skipped", lists.lines),
        (
            "face with a number of a colour, whose table only Geomview has: grey",
            lists.indexed,
        ),
        (
            "face with more numbers after its corners than a colour: these are skipped",
            lists.surplus,
        ),
        ("line after the last face: skipped", lists.rest),
    ];
    for (message, count) in counts {
        warnings.add_many(name, message.to_owned(), count, || Position::Whole);
    }
    let mut scene = Scene::default();
    if lists.faces.is_empty() {
        warnings.add_whole(name, "no faces: the scene is empty");
        return scene;
    }
    // A single normal without direction makes the whole list useless.
    let normals = std::mem::take(&mut lists.normals);
    let has_normals = !normals.is_empty();
    let normals = unit_normals(normals);
    if has_normals && normals.is_none() {
        warnings.add_whole(name, "normals of no length: all normals are skipped");
    }
    // Colours of vertices multiply the reflectance of the material, which is white below them.
    let mut materials = FaceMaterials {
        base: if lists.colors.is_empty() {
            DEFAULT_REFLECTANCE
        } else {
            Rgb::WHITE
        },
        known: HashMap::new(),
    };
    let face_colors = lists.face_colors.iter();
    let face_materials = face_colors
        .map(|&c| materials.index(c, &mut scene))
        .collect();
    let mesh = Mesh {
        positions: lists.positions,
        normals,
        uvs: (!lists.uvs.is_empty()).then(|| Attribute::per_vertex(lists.uvs)),
        colors: lists.colors,
        faces: lists.faces,
        face_materials,
        ..Mesh::default()
    };
    scene.objects.push(Object::new("", Shape::Mesh(mesh)));
    scene
}

/// Normals of unit length; `None` if there are none, or one has no direction.
fn unit_normals(normals: Vec<DVec3>) -> Option<Attribute<DVec3>> {
    // Dividing first avoids overflow and underflow of the squared length.
    let unit = |n: DVec3| (n / n.abs().max_element()).try_normalize();
    let normals: Vec<DVec3> = normals.into_iter().map(unit).collect::<Option<_>>()?;
    (!normals.is_empty()).then(|| Attribute::per_vertex(normals))
}

/// A material for each colour of faces.
struct FaceMaterials {
    /// Reflectance of faces without a colour.
    base: Rgb,
    known: HashMap<Option<[u64; 3]>, MaterialId>,
}

impl FaceMaterials {
    fn index(&mut self, color: Option<Rgb>, scene: &mut Scene) -> MaterialId {
        let color = color.filter(|_| self.known.len() < MOST_COLORS);
        let key = color.map(|c| c.to_array().map(f64::to_bits));
        let base = self.base;
        *self.known.entry(key).or_insert_with(|| {
            scene.add_material(match color {
                Some(color) => painted(color),
                None => Material::diffuse("default", base),
            })
        })
    }
}
