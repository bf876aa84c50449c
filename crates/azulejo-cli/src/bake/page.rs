//! The scene of a lightmap as a page.

use super::args::BakeArgs;
use super::source::BakeSource;
use crate::camera;
use crate::report::percent;
use azulejo::bake::layout::NO_CHART;
use azulejo::bake::web_page::{
    self, PageLightmap, PageMaterial, PageMesh, PageModel, PageOpacity, PagePicture,
};
use azulejo::lightmap::Baked;
use azulejo_formats::gltf;
use azulejo_formats::picture::png;
use azulejo_scene::{Camera, Material, OpacityChannel, OpacityMode, Scene, Sidedness};
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::io::{self, Write};
use std::path::Path;

/// Width over height of the window that the page is expected in.
const ASPECT: f64 = 1.6;

/// Opacity with which glass is shown.
const GLASS: f32 = 0.25;

/// Writes the page.
pub fn write(
    args: &BakeArgs,
    source: &BakeSource,
    baked: &Baked,
    out: &mut dyn Write,
) -> io::Result<()> {
    let scene = &source.scene;
    let origin = gltf::local_origin(scene);
    let title = args
        .input
        .scenes
        .first()
        .map(|p: &std::path::PathBuf| p.as_path());
    let title = title.and_then(Path::file_stem).unwrap_or_default();
    let mut model = PageModel {
        title: title.to_string_lossy().into_owned(),
        cameras: cameras(scene, origin),
        up: scene.units.up,
        photometric: scene.units.photometric,
        note: format!(
            "Irradiance is known to {} of its mean (one standard error).",
            percent(baked.lightmap.relative_error())
        ),
        ..PageModel::default()
    };
    for page in &baked.lightmap.pages {
        model.lightmaps.push(PageLightmap {
            width: page.size[0],
            height: page.size[1],
            irradiance: page.irradiance.clone(),
            standard_error: page.standard_error.clone(),
        });
    }
    for material in &scene.materials {
        model.materials.push(material_of(scene, material)?);
    }
    for receiver in 0..baked.atlas.receivers.len() {
        add_meshes(scene, origin, baked, receiver, &mut model);
    }
    web_page::write(&model, out)
}

/// The views of the scene; without any, the one that `render` takes if it is from within. From outside the page
/// frames everything by itself, in windows of any shape. They are relative to the page's origin.
fn cameras(scene: &Scene, origin: DVec3) -> Vec<Camera> {
    let moved = |camera: Camera| Camera {
        eye: camera.eye - origin,
        target: camera.target - origin,
        ..camera
    };
    if !scene.cameras.is_empty() {
        return scene.cameras.iter().cloned().map(moved).collect();
    }
    let first = camera::first_look(scene, ASPECT);
    if first == camera::overview(scene, ASPECT) {
        return Vec::new();
    }
    vec![moved(Camera {
        name: "Inside".into(),
        ..first
    })]
}

fn material_of(scene: &Scene, material: &Material) -> io::Result<PageMaterial> {
    let picture = material
        .textures
        .first()
        .map(|&t| &scene.textures[t as usize]);
    let picture = match picture.and_then(|t| Some((t, t.image.as_ref()?))) {
        None => None,
        Some((texture, image)) => {
            let mut bytes = Vec::new();
            png::write_linear(image, &mut bytes)?;
            Some(PagePicture {
                bytes,
                media_type: "image/png".to_owned(),
                wrap: texture.wrap,
            })
        }
    };
    Ok(PageMaterial {
        name: material.name.clone(),
        base_color: material.diffuse.to_f32(),
        picture,
        emission: material.emission.to_f32(),
        opacity: opacity_of(material),
        double_sided: material.sidedness != Sidedness::One,
        unlit: false,
    })
}

/// How light passes a material: what the picture of its colour does not have is opaque.
fn opacity_of(material: &Material) -> PageOpacity {
    if material.dielectric.is_some() {
        return PageOpacity::Blend { opacity: GLASS };
    }
    let Some(opacity) = &material.opacity else {
        return PageOpacity::Opaque;
    };
    let has_alpha = opacity.picture.is_none_or(|picture| {
        picture.channel == OpacityChannel::Alpha
            && material.textures.first() == Some(&picture.texture)
    });
    match opacity.mode {
        _ if !has_alpha => PageOpacity::Opaque,
        OpacityMode::Mask { cutoff } => PageOpacity::Mask {
            cutoff: cutoff as f32,
        },
        OpacityMode::Blend => PageOpacity::Blend {
            opacity: opacity.constant as f32,
        },
    }
}

/// A vertex of the page: that of the mesh, its normal, its texture coordinates and its place in the lightmap.
type Key = (u32, [u64; 3], [u64; 2], [u32; 2]);

/// Adds a mesh for each material and page of an object, with positions relative to the page's origin: they
/// are in single precision.
fn add_meshes(scene: &Scene, origin: DVec3, baked: &Baked, receiver: usize, model: &mut PageModel) {
    let object = &scene.objects[baked.objects[receiver] as usize];
    let Some(placed) = object.shape.placed_mesh() else {
        return;
    };
    let (mesh, layout) = (placed.mesh, &baked.atlas.layout.receivers[receiver]);
    // A mesh of the page has one material and one lightmap, so an object falls into parts.
    let mut parts: HashMap<(u32, u32), (PageMesh, HashMap<Key, u32>)> = HashMap::new();
    let mut order = Vec::new();
    let mut number = 0;
    for face in 0..mesh.faces.len() {
        let first = mesh.faces.starts[face] as usize;
        for triangle in mesh.triangulate(face) {
            let part = (mesh.face_materials[face], layout.pages[number]);
            let (page_mesh, known) = parts.entry(part).or_insert_with(|| {
                order.push(part);
                let new = PageMesh {
                    name: object.name.clone(),
                    material: part.0,
                    lightmap: part.1,
                    ..PageMesh::default()
                };
                (new, HashMap::new())
            });
            // Triangles without a chart have no place in the lightmap, and are left out.
            let is_charted = layout.charts[number] != NO_CHART;
            for (k, &corner) in triangle.iter().enumerate().filter(|_| is_charted) {
                let corner = first + corner as usize;
                let vertex = mesh.faces.corners[corner];
                let normal = placed.normal(corner, vertex);
                let normal =
                    normal.unwrap_or_else(|| placed.face_area_vector(face).normalize_or(DVec3::Z));
                let uv = mesh.uvs.as_ref().map(|uvs| uvs.at(corner, vertex));
                let place = layout.uvs[number][k];
                // Corners that agree in all attributes share a vertex; floats are compared by their bits.
                let key = (
                    vertex,
                    normal.to_array().map(f64::to_bits),
                    uv.unwrap_or(DVec2::ZERO).to_array().map(f64::to_bits),
                    place.map(f32::to_bits),
                );
                let next = page_mesh.positions.len() as u32;
                let index = *known.entry(key).or_insert(next);
                if index == next {
                    let position = placed.position(vertex) - origin;
                    page_mesh.positions.push(position.as_vec3().to_array());
                    page_mesh.normals.push(normal.as_vec3().to_array());
                    page_mesh.uvs.extend(uv.map(|uv| uv.as_vec2().to_array()));
                    page_mesh.lightmap_uvs.push(place);
                    let color = mesh.colors.get(vertex as usize);
                    page_mesh.colors.extend(color.map(|c| c.to_f32()));
                }
                page_mesh.indices.push(index);
            }
            number += 1;
        }
    }
    // A part of which no triangle has a chart stays empty, and is dropped.
    let filled = order.into_iter().filter_map(|part| parts.remove(&part));
    let filled = filled
        .map(|(mesh, _)| mesh)
        .filter(|mesh| !mesh.indices.is_empty());
    model.meshes.extend(filled);
}
