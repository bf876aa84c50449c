//! Assembles the lists of a file into a scene.

use super::PlyReader;
use super::faces::{FaceMaterial, PlyFaceList};
use super::header::PlyHeader;
use super::vertices::PlyVertices;
use crate::picture::srgb::linear_color;
use crate::reading::options::BLENDER_COLORS;
use crate::reading::warnings::Warnings;
use crate::stl::painted;
use crate::surface::textures::Textures;
use crate::{Files, Position, ReadOptions, VertexColors};
use azulejo_scene::{
    Attribute, Faces, Material, MaterialId, Mesh, Object, Rgb, Scene, Shape, TextureId,
};
use glam::{DVec2, DVec3};
use std::ops::Range;

/// Reflectance of faces without a colour.
pub(super) const DEFAULT_REFLECTANCE: Rgb = Rgb::grey(0.5);

/// The scene of a file, and the warnings.
pub(super) fn scene(
    reader: PlyReader<'_>,
    header: &PlyHeader,
    files: &dyn Files,
    options: &ReadOptions,
) -> (Scene, Warnings) {
    // Blender's colours are sRGB by default; an option of the caller takes precedence.
    let is_said_srgb = options.vertex_colors == Some(VertexColors::Srgb);
    let is_by_blender = options.vertex_colors.is_none() && header.is_by_blender;
    let mut builder = PlyBuilder {
        file: reader.file,
        warnings: reader.warnings,
        is_srgb: is_said_srgb || is_by_blender,
    };
    let mut vertices = reader.vertices.unwrap_or_default();
    if is_by_blender {
        builder.count(BLENDER_COLORS, vertices.colors.len());
    }
    // Check the faces before anything is looked up by their corners.
    let mut list = reader.faces;
    builder.check_faces(&mut list, &vertices.positions);
    // The header may tell that the vertices only carry the colours of their faces: move them there.
    if header.carries_face_colors && list.materials.is_empty() && !vertices.colors.is_empty() {
        list.take_colors(&std::mem::take(&mut vertices.colors));
    }
    let mut scene = Scene {
        units: header.units,
        ..Scene::default()
    };
    if list.faces.is_empty() {
        let points = vertices.positions.len();
        let message = match points {
            0 => "no faces: the scene is empty".to_owned(),
            _ => format!("no faces: {points} points without a surface, the scene is empty"),
        };
        builder.warnings.add_whole(builder.file, message);
        return (scene, builder.warnings);
    }
    let materials = builder.materials(&list, &vertices, header, files, &mut scene);
    // Restore the objects of a scene that azulejo has written; any other file is a single object.
    let objects = std::mem::take(&mut vertices.objects);
    let mesh = builder.mesh(list, vertices, &materials);
    let parts = match parts(&mesh, &objects) {
        Some(parts) => parts
            .into_iter()
            .map(|piece| (piece.object, part(&mesh, piece.faces, piece.vertices)))
            .collect(),
        None => vec![(0, mesh)],
    };
    for (object, mut mesh) in parts {
        builder.drop_zero_normals(&mut mesh);
        let name = header.objects.get(object as usize).cloned();
        let shape = Shape::Mesh(mesh);
        scene
            .objects
            .push(Object::new(name.unwrap_or_default(), shape));
    }
    (scene, builder.warnings)
}

struct PlyBuilder<'a> {
    file: &'a str,
    warnings: Warnings,
    /// Whether colours are sRGB.
    is_srgb: bool,
}

impl PlyBuilder<'_> {
    fn count(&mut self, message: &str, count: usize) {
        self.warnings
            .add_many(self.file, message.into(), count, || Position::Whole);
    }

    /// Drops faces with vertices that do not exist or are not finite.
    fn check_faces(&mut self, list: &mut PlyFaceList, positions: &[DVec3]) {
        let is_there = |&c: &u32| positions.get(c as usize).is_some_and(|p| p.is_finite());
        let largest = list.faces.corners.iter().max();
        let all_finite = || positions.iter().all(|p| p.is_finite());
        if largest.is_none_or(|&c| (c as usize) < positions.len()) && all_finite() {
            return;
        }
        let before = std::mem::take(list);
        for (face, corners) in before.faces.iter().enumerate() {
            if !corners.iter().all(is_there) {
                continue;
            }
            list.faces.push(corners);
            list.face_material_indices
                .extend(before.face_material_indices.get(face));
            let uvs = before.corner_uvs.get(before.faces.corner_range(face));
            list.corner_uvs.extend_from_slice(uvs.unwrap_or_default());
        }
        list.materials = before.materials;
        let lost = before.faces.len() - list.faces.len();
        let message = "face with a vertex that does not exist or is not finite: skipped";
        self.count(message, lost);
    }

    /// One material for each distinct appearance of faces, or one for all.
    fn materials(
        &mut self,
        list: &PlyFaceList,
        vertices: &PlyVertices,
        header: &PlyHeader,
        files: &dyn Files,
        scene: &mut Scene,
    ) -> Vec<MaterialId> {
        let mut textures = Textures::default();
        let pictures: Vec<TextureId> = header
            .textures
            .iter()
            .map(|file| {
                let (id, problem) = textures.index("", file, files);
                if let Some(problem) = problem {
                    self.warnings.add_whole(self.file, problem);
                }
                id
            })
            .collect();
        let plain = [FaceMaterial::default()];
        let face_materials = match list.materials.as_slice() {
            [] => &plain,
            materials => materials,
        };
        let base = if vertices.colors.is_empty() {
            DEFAULT_REFLECTANCE
        } else {
            Rgb::WHITE
        };
        let ids = face_materials.iter().map(|face_material| {
            let picture = pictures.get(face_material.texture as usize).copied();
            let shown = picture.is_some_and(|p| textures.is_loaded(p));
            let base = if shown { Rgb::WHITE } else { base };
            let mut material = match face_material.color {
                Some(color) => painted(self.linear(color.map(limited))),
                None => Material::diffuse("default", base),
            };
            material.textures.extend(picture);
            scene.add_material(material)
        });
        let ids = ids.collect();
        scene.textures = textures.into_list();
        ids
    }

    fn mesh(&mut self, list: PlyFaceList, vertices: PlyVertices, materials: &[MaterialId]) -> Mesh {
        let indices = list.face_material_indices;
        let material = |f: usize| materials[indices.get(f).map_or(0, |&l| l as usize)];
        let face_materials = (0..list.faces.len()).map(material).collect();
        let finite = |p: DVec3| if p.is_finite() { p } else { DVec3::ZERO };
        Mesh {
            positions: vertices.positions.into_iter().map(finite).collect(),
            normals: normals(vertices.normals),
            uvs: self.uvs(vertices.uvs, list.corner_uvs),
            colors: self.colors(vertices.colors),
            irradiance: self.light(vertices.irradiance),
            irradiance_error: self.light(vertices.irradiance_error),
            faces: list.faces,
            face_materials,
            ..Mesh::default()
        }
    }

    /// Reports zero normals: of a whole mesh, which then has none, or of single vertices.
    fn drop_zero_normals(&mut self, mesh: &mut Mesh) {
        let Some(normals) = &mut mesh.normals else {
            return;
        };
        let zero = |n: &&mut DVec3| **n == DVec3::ZERO;
        let missing = normals.values.iter_mut().filter(zero).count();
        if missing == normals.values.len() {
            mesh.normals = None;
            return;
        }
        normals
            .values
            .iter_mut()
            .filter(zero)
            .for_each(|n| *n = DVec3::Z);
        self.count("zero or non-finite normal: taken as +z", missing);
    }

    fn uvs(&mut self, vertex_uvs: Vec<DVec2>, corner_uvs: Vec<DVec2>) -> Option<Attribute<DVec2>> {
        let by_corner = !corner_uvs.is_empty();
        let mut values = if by_corner { corner_uvs } else { vertex_uvs };
        let odd = values.iter_mut().filter(|uv| !uv.is_finite());
        let odd = odd.map(|uv| *uv = DVec2::ZERO).count();
        self.count(
            "texture coordinate that is not finite: taken as (0, 0)",
            odd,
        );
        let corners = by_corner.then(|| (0..values.len() as u32).collect());
        (!values.is_empty()).then_some(Attribute { values, corners })
    }

    /// Colours in 0..=1. Some programs write floating-point numbers up to 255.
    fn colors(&mut self, mut colors: Vec<Rgb>) -> Vec<Rgb> {
        let most = colors.iter().map(|c| c.max_channel()).fold(0.0, f64::max);
        if most > 1.0 && most <= 255.0 {
            self.count(
                "floating-point vertex colours above 1: scaled from 0..255",
                colors.len(),
            );
            colors.iter_mut().for_each(|c| *c *= 1.0 / 255.0);
        }
        let mut odd = 0;
        for color in &mut colors {
            let limited = color.map(limited);
            odd += usize::from(limited != *color);
            *color = self.linear(limited);
        }
        self.count("vertex colour outside 0..1: clamped", odd);
        colors
    }

    /// The linear colour of one in the file.
    fn linear(&self, color: Rgb) -> Rgb {
        if self.is_srgb {
            linear_color(color)
        } else {
            color
        }
    }

    fn light(&mut self, mut values: Vec<Rgb>) -> Vec<Rgb> {
        let sound = |c: &Rgb| c.is_finite() && c.to_array().iter().all(|x| *x >= 0.0);
        let odd = values.iter_mut().filter(|c| !sound(c));
        let odd = odd.map(|c| *c = Rgb::BLACK).count();
        self.count("negative or non-finite irradiance: taken as 0", odd);
        values
    }
}

/// Normals of unit length, or zero.
fn normals(mut normals: Vec<DVec3>) -> Option<Attribute<DVec3>> {
    for normal in &mut normals {
        // Values accurate to single precision are kept.
        let is_unit = (normal.length_squared() - 1.0).abs() <= 1e-6;
        if !is_unit {
            // Dividing first avoids overflow and underflow of the squared length.
            let scaled = *normal / normal.abs().max_element();
            *normal = scaled.try_normalize().unwrap_or(DVec3::ZERO);
        }
    }
    (!normals.is_empty()).then(|| Attribute::per_vertex(normals))
}

fn limited(x: f64) -> f64 {
    if x >= 0.0 { x.min(1.0) } else { 0.0 }
}

/// One object of azulejo within the lists of the file.
struct ObjectPiece {
    object: u32,
    faces: Range<usize>,
    vertices: Range<usize>,
}

/// Object, faces and vertices of each object of azulejo, for a file that stores the object of each
/// vertex. `None` if the objects are not contiguous.
fn parts(mesh: &Mesh, objects: &[u32]) -> Option<Vec<ObjectPiece>> {
    if objects.is_empty() || !objects.is_sorted() {
        return None;
    }
    let mut parts: Vec<ObjectPiece> = Vec::new();
    for (face, corners) in mesh.faces.iter().enumerate() {
        let object = objects[corners[0] as usize];
        if corners.iter().any(|&c| objects[c as usize] != object) {
            return None;
        }
        match parts.last_mut() {
            Some(last) if last.object == object => last.faces.end = face + 1,
            Some(last) if last.object > object => return None,
            _ => parts.push(ObjectPiece {
                object,
                faces: face..face + 1,
                vertices: objects.partition_point(|o| *o < object)
                    ..objects.partition_point(|o| *o <= object),
            }),
        }
    }
    Some(parts)
}

/// A range of faces of a mesh with the range of vertices that they use.
fn part(mesh: &Mesh, faces: Range<usize>, vertices: Range<usize>) -> Mesh {
    let starts = &mesh.faces.starts[faces.start..=faces.end];
    let corners = starts[0] as usize..starts[starts.len() - 1] as usize;
    let slice = |list: &[Rgb]| list.get(vertices.clone()).unwrap_or_default().to_vec();
    Mesh {
        positions: mesh.positions[vertices.clone()].to_vec(),
        normals: mesh
            .normals
            .as_ref()
            .map(|n| slice_attribute(n, &vertices, &corners)),
        uvs: mesh
            .uvs
            .as_ref()
            .map(|uv| slice_attribute(uv, &vertices, &corners)),
        colors: slice(&mesh.colors),
        irradiance: slice(&mesh.irradiance),
        irradiance_error: slice(&mesh.irradiance_error),
        faces: Faces {
            starts: starts.iter().map(|s| s - starts[0]).collect(),
            corners: mesh.faces.corners[corners.clone()]
                .iter()
                .map(|c| c - vertices.start as u32)
                .collect(),
        },
        face_materials: mesh.face_materials[faces].to_vec(),
        ..Mesh::default()
    }
}

/// The part of an attribute for a range of vertices and corners. Values of corners keep their
/// order.
fn slice_attribute<T: Copy>(
    attribute: &Attribute<T>,
    vertices: &Range<usize>,
    corners: &Range<usize>,
) -> Attribute<T> {
    match &attribute.corners {
        None => Attribute::per_vertex(attribute.values[vertices.clone()].to_vec()),
        Some(_) => Attribute {
            values: attribute.values[corners.clone()].to_vec(),
            corners: Some((0..corners.len() as u32).collect()),
        },
    }
}
