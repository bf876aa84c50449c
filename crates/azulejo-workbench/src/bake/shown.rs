//! A lightmap as the viewport shows it: triangles with their places on its pages.

use super::BakedDocument;
use crate::document::{ItemId, SceneDocument, SceneObject, same_geometry};
use azulejo::bake::layout::NO_CHART;
use azulejo::scene::{Attribute, Faces, Image, IrradiancePicture, MaterialId, Mesh, Object, Rgb};
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Most triangles that are shown with their lightmap: each has three vertices of its own.
const MAX_TRIANGLES: usize = 1 << 23;

/// The page of corners that have no place on one.
const NO_SPOT: f32 = -1.0;

/// Surfaces of a document with the pages of their light.
#[derive(Clone, Debug, Default)]
pub struct ShownLightmap {
    of: SceneDocument,
    meshes: HashMap<ItemId, Arc<LightmappedMesh>>,
    /// Irradiance, rows from the top; all of one size.
    pub pages: Vec<Image>,
}

/// Triangles that share no vertices, in the world.
#[derive(Clone, Debug, Default)]
pub struct LightmappedMesh {
    /// Three vertices for each triangle.
    pub mesh: Mesh,
    /// For each vertex its place on a page, (0, 0) in the upper left corner, and the page, or `NO_SPOT`.
    pub spots: Vec<[f32; 3]>,
}

impl ShownLightmap {
    /// The lightmap that was baked of a document; `None` if it is too large.
    pub fn baked(result: &BakedDocument) -> Option<ShownLightmap> {
        let (source, baked) = (&result.source, &result.baked);
        let layout = &baked.atlas.layout;
        let triangles: usize = layout.receivers.iter().map(|r| r.uvs.len()).sum();
        if triangles > MAX_TRIANGLES {
            return None;
        }
        let items = items_of(result)?;
        let page = |page: &azulejo::bake::LightmapPage| {
            Image::opaque(page.size[0], page.size[1], page.irradiance.clone())
        };
        let pages = SharedPages::new(baked.lightmap.pages.iter().map(page).collect());
        let mut meshes = HashMap::new();
        for (receiver, layout) in layout.receivers.iter().enumerate() {
            let object = baked.objects[receiver];
            let place = source.receivers.iter().position(|&r| r == object)?;
            let mesh = LightmappedMesh::new(&source.scene.objects[object as usize], |corner| {
                let triangle = corner / 3;
                let page = match *layout.charts.get(triangle)? {
                    NO_CHART => return None,
                    _ => layout.pages[triangle],
                };
                pages.spot(layout.uvs[triangle][corner % 3], page as usize)
            });
            meshes.insert(*items.get(place)?, Arc::new(mesh));
        }
        Some(ShownLightmap {
            of: result.document.clone(),
            meshes,
            pages: pages.images,
        })
    }

    /// The lightmap that came with the files of a document, if there is one.
    pub fn of_file(document: &SceneDocument) -> Option<ShownLightmap> {
        let lightmaps = || document.materials.iter().filter_map(|m| m.lightmap);
        lightmaps().next()?;
        let (mut known, mut images): (Vec<IrradiancePicture>, Vec<Image>) = Default::default();
        for lightmap in lightmaps() {
            let texture = document.textures.get(lightmap.texture as usize)?;
            if let (Some(image), false) = (&texture.image, known.contains(&lightmap)) {
                known.push(lightmap);
                images.push(scaled(image, lightmap.scale));
            }
        }
        let page_of = |material: MaterialId| {
            let lightmap = document.materials.get(material as usize)?.lightmap?;
            known.iter().position(|k| *k == lightmap)
        };
        let pages = SharedPages::new(images);
        let mut meshes = HashMap::new();
        let has_coordinates =
            |item: &SceneObject| item.shape.mesh().is_some_and(|m| m.lightmap_uvs.is_some());
        for item in document.objects.iter().filter(|i| has_coordinates(i)) {
            let object = item.object();
            let mesh = object.shape.placed_mesh()?.mesh;
            let corners = corners_of(mesh);
            let mesh = LightmappedMesh::new(&object, |corner| {
                let (face, corner) = corners[corner];
                let page = page_of(mesh.face_materials[face])?;
                let uv = mesh.lightmap_uv(corner)?;
                pages.spot([uv.x as f32, (1.0 - uv.y) as f32], page)
            });
            meshes.insert(item.id, Arc::new(mesh));
        }
        (!meshes.is_empty()).then(|| ShownLightmap {
            of: document.clone(),
            meshes,
            pages: pages.images,
        })
    }

    /// The triangles to show for an object, as long as it has not been moved since.
    pub fn shown(&self, item: &SceneObject) -> Option<&Arc<LightmappedMesh>> {
        let then = self.of.object(item.id)?;
        let mesh = self.meshes.get(&item.id)?;
        same_geometry(then, item).then_some(mesh)
    }

    /// Irradiance at a place on a page; `None` where there is none.
    pub fn irradiance(&self, [u, v, page]: [f64; 3]) -> Option<Rgb> {
        if page < 0.0 {
            return None;
        }
        let image = self.pages.get(page.round() as usize)?;
        let wrap = [azulejo::scene::WrapMode::Clamp; 2];
        let texel = image.sample_wrapped(DVec2::new(u, 1.0 - v), wrap);
        Some(Rgb::from(texel.map(f64::from)))
    }
}

/// Pages that were made as large as the largest.
struct SharedPages {
    images: Vec<Image>,
    /// The part of each that was there before.
    parts: Vec<[f32; 2]>,
}

impl SharedPages {
    fn new(mut images: Vec<Image>) -> SharedPages {
        let width = images.iter().map(|i| i.width).max().unwrap_or(0);
        let height = images.iter().map(|i| i.height).max().unwrap_or(0);
        let part =
            |i: &Image| [(i.width, width), (i.height, height)].map(|(a, b)| a as f32 / b as f32);
        let parts = images.iter().map(part).collect();
        for image in images
            .iter_mut()
            .filter(|i| (i.width, i.height) != (width, height))
        {
            let mut pixels = vec![[0.0; 3]; width as usize * height as usize];
            let rows = image.pixels.chunks_exact(image.width.max(1) as usize);
            for (row, old) in pixels.chunks_exact_mut(width as usize).zip(rows) {
                row[..old.len()].copy_from_slice(old);
            }
            *image = Image::opaque(width, height, pixels);
        }
        SharedPages { images, parts }
    }

    /// A place on a page, with the page.
    fn spot(&self, uv: [f32; 2], page: usize) -> Option<[f32; 3]> {
        let part = self.parts.get(page)?;
        Some([uv[0] * part[0], uv[1] * part[1], page as f32])
    }
}

/// The object of the document that each receiver of a baked source is.
fn items_of(result: &BakedDocument) -> Option<Vec<ItemId>> {
    let objects = &result.document.objects;
    let source = &result.source;
    if source.is_given {
        let item = |&number: &usize| objects.get(number).map(|item| item.id);
        return source.origin_of.iter().map(item).collect();
    }
    // What has no faces is not written.
    let has_faces =
        |item: &&Arc<SceneObject>| (item.shape.mesh()).is_none_or(|mesh| !mesh.faces.is_empty());
    let items: Vec<ItemId> = objects.iter().filter(has_faces).map(|i| i.id).collect();
    (items.len() == source.scene.objects.len()).then_some(items)
}

/// The face and the corner, counted over all corners, of each corner of each triangle.
fn corners_of(mesh: &Mesh) -> Vec<(usize, usize)> {
    let of_face = |face: usize| {
        let first = mesh.faces.starts[face] as usize;
        let triangles = mesh.triangulate(face).into_iter().flatten();
        let corners: Vec<_> = triangles.map(|c| (face, first + c as usize)).collect();
        corners
    };
    (0..mesh.faces.len()).flat_map(of_face).collect()
}

impl LightmappedMesh {
    /// The triangles of an object; `spot` says for each of their corners the place and the page.
    fn new(object: &Object, spot: impl Fn(usize) -> Option<[f32; 3]>) -> LightmappedMesh {
        let Some(placed) = object.shape.placed_mesh() else {
            return LightmappedMesh::default();
        };
        let mesh = placed.mesh;
        let corners = corners_of(mesh);
        let vertex = |corner: usize| mesh.faces.corners[corner];
        let has_colors = mesh.colors.len() == mesh.positions.len();
        let each = |make: &dyn Fn(usize) -> DVec3| -> Vec<DVec3> {
            corners.iter().map(|(_, corner)| make(*corner)).collect()
        };
        let normal = |corner: usize| placed.normal(corner, vertex(corner)).unwrap_or(DVec3::Z);
        let uvs = mesh.uvs.as_ref().map(|uvs| {
            let uv = |(_, corner): &(usize, usize)| uvs.at(*corner, vertex(*corner));
            Attribute::per_vertex(corners.iter().map(uv).collect())
        });
        let normals = mesh.normals.as_ref();
        let count = corners.len() as u32;
        let triangles = Mesh {
            positions: each(&|corner| placed.position(vertex(corner))),
            normals: normals.map(|_| Attribute::per_vertex(each(&normal))),
            uvs,
            colors: (corners.iter().filter(|_| has_colors))
                .map(|(_, corner)| mesh.colors[vertex(*corner) as usize])
                .collect(),
            faces: Faces {
                starts: (0..=count / 3).map(|t| 3 * t).collect(),
                corners: (0..count).collect(),
            },
            face_materials: (corners.chunks_exact(3))
                .map(|c| mesh.face_materials[c[0].0])
                .collect(),
            ..Mesh::default()
        };
        let place = |corner: usize| spot(corner).unwrap_or([0.0, 0.0, NO_SPOT]);
        LightmappedMesh {
            mesh: triangles,
            spots: (0..corners.len()).map(place).collect(),
        }
    }

    /// The place on a page at a point of a triangle.
    pub fn spot(&self, corners: [u32; 3], weights: DVec3) -> [f64; 3] {
        let mut sum = DVec3::ZERO;
        for (corner, weight) in corners.iter().zip(weights.to_array()) {
            let spot = self.spots.get(*corner as usize).copied();
            sum += weight * DVec3::from(spot.unwrap_or([0.0, 0.0, NO_SPOT]).map(f64::from));
        }
        sum.to_array()
    }
}

fn scaled(image: &Image, scale: f64) -> Image {
    let texel = |t: &[f32; 3]| t.map(|x| (f64::from(x) * scale) as f32);
    let pixels = image.pixels.iter().map(texel).collect();
    Image::opaque(image.width, image.height, pixels)
}
