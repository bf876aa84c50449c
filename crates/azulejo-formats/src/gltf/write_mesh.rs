//! Writes objects as meshes: triangles by material over one list of vertices.

use super::irradiance::StoredIrradiance;
use super::local_origin;
use super::pack::Pack;
use super::vertices::is_unit;
use super::write_material::Materials;
use crate::surface::tessellate::lit_mesh_of;
use azulejo_scene::{Attribute, MaterialId, Mesh, Object, Rgb};
use glam::DVec3;
use serde_json::{Map, Value, json};
use std::collections::HashMap;

/// The texture coordinates of lightmaps; [`super::write_material`] has the number.
const LIGHTMAP_SET: &str = "TEXCOORD_1";

/// The mesh of an object and its origin, both relative to that of the scene; `None` if it has no faces.
pub(super) fn mesh(
    object: &Object,
    origin: DVec3,
    scale: f64,
    photometric: bool,
    materials: &mut Materials,
    pack: &mut Pack,
) -> Option<(Value, DVec3)> {
    let mesh = lit_mesh_of(object);
    let written = WrittenMesh::new(&mesh, origin, materials, pack)?;
    let json = written.lit(&mesh.irradiance, scale, photometric, pack);
    Some((json, written.origin))
}

/// A mesh without irradiance, which belongs to a place.
pub(super) struct WrittenMesh {
    json: Value,
    corners: MergedCorners,
    /// The number of the set of colours that the irradiance takes.
    set: u32,
    /// What its positions are relative to, in coordinates relative to the origin that it was packed with.
    pub origin: DVec3,
}

impl WrittenMesh {
    /// Packs a mesh with positions relative to `origin`, or to an origin of its own beside that where
    /// single precision asks for one; `None` if it has no faces.
    pub fn new(
        mesh: &Mesh,
        origin: DVec3,
        materials: &mut Materials,
        pack: &mut Pack,
    ) -> Option<WrittenMesh> {
        if mesh.faces.is_empty() {
            return None;
        }
        let corners = MergedCorners::of(mesh);
        let own_origin = local_origin::of_mesh(mesh, origin);
        let position = |p: DVec3| p - origin - own_origin;
        let attributes = attributes(mesh, &corners, position, pack);
        let primitives: Vec<Value> = by_material(mesh, &corners)
            .into_iter()
            .map(|(material, indices)| {
                json!({
                    "attributes": attributes,
                    "indices": pack.indices(&indices, corners.vertices.len()),
                    "material": match mesh.uvs {
                        Some(_) => material as usize,
                        None => materials.plain(material),
                    },
                })
            })
            .collect();
        Some(WrittenMesh {
            json: json!({ "primitives": primitives }),
            corners,
            set: u32::from(!mesh.colors.is_empty()),
            origin: own_origin,
        })
    }

    /// The mesh with the irradiance of its vertices, if there is any.
    pub fn lit(&self, irradiance: &[Rgb], scale: f64, photometric: bool, pack: &mut Pack) -> Value {
        let mut json = self.json.clone();
        if irradiance.is_empty() {
            return json;
        }
        let stored = StoredIrradiance {
            set: self.set,
            scale,
        };
        let share = move |c: Rgb| (c * (1.0 / scale)).to_array();
        let light = self.corners.of_vertices(irradiance, 0, share);
        let accessor = pack.attribute(light);
        let primitives = json["primitives"].as_array_mut();
        for primitive in primitives.into_iter().flatten() {
            primitive["attributes"][format!("COLOR_{}", self.set)] = json!(accessor);
            primitive["extras"] = stored.extras(photometric);
        }
        json["extras"] = stored.extras(photometric);
        json
    }
}

/// The vertices that glTF needs: one for each combination of a vertex with a normal, texture
/// coordinates and those of the lightmap.
struct MergedCorners {
    /// Vertex, normal and both texture coordinates, as indices into the mesh's lists.
    vertices: Vec<[u32; 4]>,
    /// Index of the combination of each corner of the mesh.
    corners: Vec<u32>,
}

impl MergedCorners {
    fn of(mesh: &Mesh) -> MergedCorners {
        let by_corner = |a: Option<&Vec<u32>>, corner: usize, v: u32| a.map_or(v, |a| a[corner]);
        let normals = mesh.normals.as_ref().and_then(|a| a.corners.as_ref());
        let uvs = mesh.uvs.as_ref().and_then(|a| a.corners.as_ref());
        let lightmap_uvs = mesh.lightmap_uvs.as_ref().and_then(|a| a.corners.as_ref());
        if normals.is_none() && uvs.is_none() && lightmap_uvs.is_none() {
            return MergedCorners {
                vertices: (0..mesh.positions.len() as u32).map(|v| [v; 4]).collect(),
                corners: mesh.faces.corners.clone(),
            };
        }
        let mut vertices = Vec::with_capacity(mesh.positions.len());
        let mut known = HashMap::with_capacity(mesh.positions.len());
        let corners = mesh.faces.corners.iter().enumerate().map(|(corner, &v)| {
            let key = [
                v,
                by_corner(normals, corner, v),
                by_corner(uvs, corner, v),
                by_corner(lightmap_uvs, corner, v),
            ];
            *known.entry(key).or_insert_with(|| {
                vertices.push(key);
                vertices.len() as u32 - 1
            })
        });
        let corners = corners.collect();
        MergedCorners { vertices, corners }
    }

    /// A list of the mesh, indexed by new vertices.
    fn of_vertices<'c, T: Copy, const N: usize>(
        &'c self,
        list: &'c [T],
        which: usize,
        numbers: impl Fn(T) -> [f64; N] + 'c,
    ) -> impl ExactSizeIterator<Item = [f64; N]> + 'c {
        let value = move |key: &[u32; 4]| numbers(list[key[which] as usize]);
        self.vertices.iter().map(value)
    }
}

/// The attributes of a mesh, whose positions are written as `position` has them.
fn attributes(
    mesh: &Mesh,
    corners: &MergedCorners,
    position: impl Fn(DVec3) -> DVec3,
    pack: &mut Pack,
) -> Map<String, Value> {
    let mut attributes = Map::new();
    let positions = corners.of_vertices(&mesh.positions, 0, |p| position(p).to_array());
    attributes.insert("POSITION".into(), json!(pack.positions(positions)));
    if let Some(Attribute { values, .. }) = &mesh.normals {
        // Normals of a valid scene may be off by a thousandth, those of glTF by less.
        let exact = |n: DVec3| if is_unit(n) { n } else { n.normalize() };
        let normals = corners.of_vertices(values, 1, move |n| exact(n).to_array());
        attributes.insert("NORMAL".into(), json!(pack.attribute(normals)));
    }
    if let Some(Attribute { values, .. }) = &mesh.uvs {
        let uvs = corners.of_vertices(values, 2, |uv| [uv.x, 1.0 - uv.y]);
        attributes.insert("TEXCOORD_0".into(), json!(pack.attribute(uvs)));
    }
    if let Some(Attribute { values, .. }) = &mesh.lightmap_uvs {
        let uvs = corners.of_vertices(values, 3, |uv| [uv.x, 1.0 - uv.y]);
        let accessor = json!(pack.attribute(uvs));
        // Sets are numbered without gaps.
        let first = attributes.entry("TEXCOORD_0");
        first.or_insert_with(|| accessor.clone());
        attributes.insert(LIGHTMAP_SET.into(), accessor);
    }
    if !mesh.colors.is_empty() {
        let colors = corners.of_vertices(&mesh.colors, 0, |c| c.to_array().map(|c| c.min(1.0)));
        attributes.insert("COLOR_0".into(), json!(pack.attribute(colors)));
    }
    attributes
}

/// The triangles of each material, in the order in which the materials are first used.
fn by_material(mesh: &Mesh, corners: &MergedCorners) -> Vec<(MaterialId, Vec<u32>)> {
    let mut lists: Vec<(MaterialId, Vec<u32>)> = Vec::new();
    let mut known = HashMap::new();
    let mut triangles = Vec::new();
    for (face, &material) in mesh.face_materials.iter().enumerate() {
        let list = *known.entry(material).or_insert_with(|| {
            lists.push((material, Vec::new()));
            lists.len() - 1
        });
        triangles.clear();
        mesh.triangulate_into(face, &mut triangles);
        let range = mesh.faces.corner_range(face);
        let face_corners = &corners.corners[range];
        let indices = triangles
            .iter()
            .flatten()
            .map(|&k| face_corners[k as usize]);
        lists[list].1.extend(indices);
    }
    lists
}
