//! Scenes as web pages: with the light of a lightmap, with that of their vertices, or plain.
//!
//! [`of_baked`] and [`of_scene`] make the model of a page, which [`azulejo_bake::web_page::write()`] writes. The
//! title is the caller's to fill in.

mod vertices;

use crate::lightmap::Baked;
use azulejo_bake::ReceiverLayout;
use azulejo_bake::layout::NO_CHART;
use azulejo_bake::web_page::{
    PageLightmap, PageMaterial, PageMesh, PageModel, PageOpacity, PagePicture,
};
use azulejo_formats::picture::png;
use azulejo_formats::{divide_into_triangles, gltf};
use azulejo_scene::{
    Camera, Image, Material, Object, OpacityChannel, OpacityMode, Scene, Shape, Sidedness, Texture,
};
use azulejo_trace::Tracer;
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::io;
use vertices::VertexTexels;

/// Width over height of the window that the page is expected in.
const ASPECT: f64 = 1.6;

/// Opacity with which glass is shown.
const GLASS: f32 = 0.25;

/// Bytes of a page that a triangle takes at least, about, with its vertices: of models by others 6 to 67.
const LEAST_TRIANGLE: u64 = 6;

/// Triangles of an exact solid: of a parallelogram 2, of a sphere some 1,500.
const EXACT_TRIANGLES: u64 = 100;

/// The page of a baked scene.
///
/// # Errors
/// A picture of a material cannot be written.
pub fn of_baked(scene: &Scene, baked: &Baked) -> io::Result<PageModel> {
    let origin = gltf::local_origin(scene);
    let mut model = PageModel {
        materials: materials(scene)?,
        ..surroundings(scene, origin)
    };
    model.lightmaps = (baked.lightmap.pages.iter())
        .map(|page| PageLightmap {
            width: page.size[0],
            height: page.size[1],
            irradiance: page.irradiance.clone(),
            standard_error: page.standard_error.clone(),
        })
        .collect();
    for (&object, layout) in baked.objects.iter().zip(&baked.atlas.layout.receivers) {
        let object = &scene.objects[object as usize];
        add_meshes(object, origin, Some(layout), &mut model);
    }
    Ok(model)
}

/// The page of a scene with the irradiance of its vertices; what has none is plain, a scene without any as a whole. The
/// note says which of these it is.
///
/// Exact shapes become polygons, and sheets with light on both sides are there twice.
///
/// # Errors
/// A picture of a material cannot be written.
pub fn of_scene(scene: &Scene) -> io::Result<PageModel> {
    let mut shown = scene.split_sides().into_owned();
    divide_into_triangles(&mut shown);
    let origin = gltf::local_origin(&shown);
    let light = VertexTexels::new(&shown);
    let note = match light.map {
        Some(_) => "Irradiance is that of vertices, interpolated between them.",
        None => "The scene has no light on vertices: it is shown plain.",
    };
    let mut model = PageModel {
        materials: materials(&shown)?,
        lightmaps: light.map.into_iter().collect(),
        note: note.to_owned(),
        ..surroundings(scene, origin)
    };
    for (object, layout) in shown.objects.iter().zip(&light.layouts) {
        add_meshes(object, origin, layout.as_ref(), &mut model);
    }
    Ok(model)
}

/// Bytes that the page of a scene takes at least, about: few operations tell that a scene is too large for one.
pub fn least_size(scene: &Scene) -> u64 {
    let triangles = scene.objects.iter().map(|object| triangles(&object.shape));
    // A byte per pixel is little for a photograph.
    let pixels = |material: &Material| {
        let shown = picture_of(scene, material);
        shown.map_or(0, |(_, image)| image.pixels.len() as u64)
    };
    let pictures: u64 = scene.materials.iter().map(pixels).sum();
    LEAST_TRIANGLE * triangles.sum::<u64>() + pictures
}

/// The triangles of a shape, about if it is exact.
fn triangles(shape: &Shape) -> u64 {
    match (shape, shape.mesh()) {
        (_, Some(mesh)) => (mesh.faces.corners.len() - 2 * mesh.faces.len()) as u64,
        (Shape::Exact(exact), _) => EXACT_TRIANGLES * exact.solids.len() as u64,
        _ => EXACT_TRIANGLES,
    }
}

/// What a page shows beside surfaces and their materials.
fn surroundings(scene: &Scene, origin: DVec3) -> PageModel {
    PageModel {
        cameras: cameras(scene, origin),
        up: scene.units.up,
        photometric: scene.units.photometric,
        ..PageModel::default()
    }
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
    let first = azulejo_render::first_view(scene, &Tracer::new(scene), ASPECT);
    if first == Camera::framing(scene.main_bounds(), ASPECT, scene.units.up.axis()) {
        return Vec::new();
    }
    vec![moved(Camera {
        name: "Inside".into(),
        ..first
    })]
}

/// The picture that a page shows of a material, and how it is placed.
fn picture_of<'a>(scene: &'a Scene, material: &Material) -> Option<(&'a Texture, &'a Image)> {
    let texture = &scene.textures[*material.textures.first()? as usize];
    Some((texture, texture.image.as_ref()?))
}

fn materials(scene: &Scene) -> io::Result<Vec<PageMaterial>> {
    let materials = scene.materials.iter().map(|m| material_of(scene, m));
    materials.collect()
}

fn material_of(scene: &Scene, material: &Material) -> io::Result<PageMaterial> {
    let picture = picture_of(scene, material).map(|(texture, image)| {
        let mut bytes = Vec::new();
        png::write_linear(image, &mut bytes)?;
        Ok::<_, io::Error>(PagePicture {
            bytes,
            media_type: "image/png".to_owned(),
            wrap: texture.wrap,
        })
    });
    Ok(PageMaterial {
        name: material.name.clone(),
        base_color: material.diffuse.to_f32(),
        picture: picture.transpose()?,
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
/// are in single precision. The layout says where its triangles lie in lightmaps; without one it has no light.
fn add_meshes(
    object: &Object,
    origin: DVec3,
    layout: Option<&ReceiverLayout>,
    model: &mut PageModel,
) {
    let Some(placed) = object.shape.placed_mesh() else {
        return;
    };
    let mesh = placed.mesh;
    // A mesh of the page has one material and one lightmap, so an object falls into parts.
    let mut parts: HashMap<(u32, u32), (PageMesh, HashMap<Key, u32>)> = HashMap::new();
    let mut order = Vec::new();
    let mut number = 0;
    for face in 0..mesh.faces.len() {
        let first = mesh.faces.starts[face] as usize;
        for triangle in mesh.triangulate(face) {
            let part = (
                mesh.face_materials[face],
                layout.map_or(0, |l| l.pages[number]),
            );
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
            let is_charted = layout.is_none_or(|l| l.charts[number] != NO_CHART);
            for (k, &corner) in triangle.iter().enumerate().filter(|_| is_charted) {
                let corner = first + corner as usize;
                let vertex = mesh.faces.corners[corner];
                let normal = placed.normal(corner, vertex);
                let normal =
                    normal.unwrap_or_else(|| placed.face_area_vector(face).normalize_or(DVec3::Z));
                let uv = mesh.uvs.as_ref().map(|uvs| uvs.at(corner, vertex));
                let place = layout.map(|l| l.uvs[number][k]);
                // Corners that agree in all attributes share a vertex; floats are compared by their bits.
                let key = (
                    vertex,
                    normal.to_array().map(f64::to_bits),
                    uv.unwrap_or(DVec2::ZERO).to_array().map(f64::to_bits),
                    place.unwrap_or_default().map(f32::to_bits),
                );
                let next = page_mesh.positions.len() as u32;
                let index = *known.entry(key).or_insert(next);
                if index == next {
                    let position = placed.position(vertex) - origin;
                    page_mesh.positions.push(position.as_vec3().to_array());
                    page_mesh.normals.push(normal.as_vec3().to_array());
                    page_mesh.uvs.extend(uv.map(|uv| uv.as_vec2().to_array()));
                    page_mesh.lightmap_uvs.extend(place);
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
