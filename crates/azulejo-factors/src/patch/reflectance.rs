//! Mean reflectance of patches, and the patch of a hit.

use super::{Patches, RefinedShape};
use azulejo_scene::{Material, Mesh, Opacity, OpacityMap, Rgb, Scene, Shape, Texture};
use azulejo_trace::{KernelHit, Surfaces};
use glam::DVec2;
use std::collections::HashMap;

impl Patches {
    /// The patch that a hit of the scene's own tracer lies on.
    pub fn locate_hit(&self, surfaces: &Surfaces, hit: &KernelHit) -> u32 {
        let item = surfaces.item(hit.item);
        let [u, v] = hit.uv();
        self.locate(item.object, item.face, item.triangle, u, v)
    }
}

/// Diffuse reflectance of every patch: of its material, times the mean of its vertices' colours
/// and of its textures over its corners and centre.
pub fn reflectances(scene: &Scene, patches: &Patches) -> Vec<Rgb> {
    let mut all = Vec::with_capacity(patches.len());
    for object in 0..scene.objects.len() as u32 {
        let divided = match patches.refined(object, scene) {
            RefinedShape::Mesh(mesh) if !mesh.colors.is_empty() || mesh.uvs.is_some() => Some(mesh),
            _ => None,
        };
        for (face, patch) in patches.patches_of(object).enumerate() {
            let material = &scene.materials[patches.material(patch) as usize];
            let pattern = divided
                .as_ref()
                .map_or(Rgb::WHITE, |mesh| pattern(scene, mesh, face, material));
            all.push(material.diffuse * pattern);
        }
    }
    all
}

/// Least share of a patch that counts as there: none has no area at all.
const LEAST_OPACITY: f64 = 1e-3;

/// Steps along each side of a triangle over which an opacity is averaged.
const OPACITY_STEPS: u32 = 12;

/// Mean opacity of every patch, 1e-3..=1; `None` if nothing lets light pass.
///
/// A patch sends and takes light on this share of its area; the rest of what arrives passes it, and is
/// found by rays on the patches behind.
pub(super) fn mean_opacities(scene: &Scene, patches: &Patches) -> Option<Vec<f64>> {
    let opacities: Vec<Option<&Opacity>> =
        scene.materials.iter().map(Material::see_through).collect();
    if opacities.iter().all(Option::is_none) {
        return None;
    }
    let mut maps = HashMap::new();
    let mut all = Vec::with_capacity(patches.len());
    for object in 0..scene.objects.len() as u32 {
        let of_object = patches.patches_of(object);
        let is_see_through = |i: usize| opacities[patches.material(i) as usize].is_some();
        let divided = match &scene.objects[object as usize].shape {
            Shape::Mesh(_) | Shape::Instance(_) if of_object.clone().any(is_see_through) => {
                patches.refined(object, scene)
            }
            _ => RefinedShape::Mesh(Mesh::default()),
        };
        for (face, patch) in of_object.enumerate() {
            let Some(opacity) = opacities[patches.material(patch) as usize] else {
                all.push(1.0);
                continue;
            };
            let map = opacity.picture.and_then(|picture| {
                let known = maps.entry((picture.texture, picture.channel));
                let texture = scene.textures.get(picture.texture as usize);
                known
                    .or_insert_with(|| {
                        let texture = texture?;
                        OpacityMap::new(texture.image.as_ref()?, picture.channel, texture.wrap)
                    })
                    .as_ref()
            });
            let uvs = match &divided {
                RefinedShape::Mesh(mesh) => texture_corners(mesh, face),
                RefinedShape::Surface(_) => None,
            };
            let mean = match map.zip(uvs) {
                Some((map, uvs)) => {
                    let value = |uv| Rgb::grey(opacity.at(map.sample(uv)));
                    mean_over(&uvs, OPACITY_STEPS, value).r
                }
                None => opacity.at(1.0),
            };
            all.push(mean.clamp(LEAST_OPACITY, 1.0));
        }
    }
    Some(all)
}

/// Most steps along each side of a triangle over which an emission is averaged; one for each texel is
/// enough.
const MOST_EMISSION_STEPS: f64 = 64.0;

/// Mean of the picture that each patch emits; white where it emits none, and the mean of all of it where
/// there are no texture coordinates. `None` if no material emits a picture.
pub(super) fn mean_emitted_pictures(scene: &Scene, patches: &Patches) -> Option<Vec<Rgb>> {
    let picture = |m: &Material| m.emission_picture.filter(|_| m.is_emitter());
    if scene.materials.iter().all(|m| picture(m).is_none()) {
        return None;
    }
    let mean = |m: &Material| picture(m).map(|id| scene.textures[id as usize].mean());
    let means: Vec<Option<Rgb>> = scene.materials.iter().map(mean).collect();
    let mut all = Vec::with_capacity(patches.len());
    for object in 0..scene.objects.len() as u32 {
        let of_object = patches.patches_of(object);
        let emits = |i: usize| means[patches.material(i) as usize].is_some();
        let divided = match &scene.objects[object as usize].shape {
            Shape::Mesh(_) | Shape::Instance(_) if of_object.clone().any(emits) => {
                patches.refined(object, scene)
            }
            _ => RefinedShape::Mesh(Mesh::default()),
        };
        for (face, patch) in of_object.enumerate() {
            let material = patches.material(patch) as usize;
            let Some(mean) = means[material] else {
                all.push(Rgb::WHITE);
                continue;
            };
            let uvs = match &divided {
                RefinedShape::Mesh(mesh) => texture_corners(mesh, face),
                RefinedShape::Surface(_) => None,
            };
            let texture =
                picture(&scene.materials[material]).map(|id| &scene.textures[id as usize]);
            all.push(match uvs.zip(texture) {
                Some((uvs, texture)) => mean_of_texels(texture, &uvs),
                None => mean,
            });
        }
    }
    Some(all)
}

fn mean_of_texels(texture: &Texture, uvs: &[DVec2]) -> Rgb {
    let Some(image) = &texture.image else {
        return Rgb::BLACK;
    };
    let size = DVec2::new(image.width.into(), image.height.into());
    let longest = uvs.iter().map(|&uv| ((uv - uvs[0]) * size).length());
    let steps = longest.fold(4.0, f64::max).min(MOST_EMISSION_STEPS);
    mean_over(uvs, steps.ceil() as u32, |uv| {
        let color = texture.sample(uv).unwrap_or_default();
        Rgb::from(color.map(f64::from))
    })
}

/// Texture coordinates of a face's corners.
fn texture_corners(mesh: &Mesh, face: usize) -> Option<Vec<DVec2>> {
    let uvs = mesh.uvs.as_ref()?;
    let corners = mesh.faces.corner_range(face);
    let corners = corners.zip(mesh.faces.get(face).iter().copied());
    Some(
        corners
            .map(|(corner, vertex)| uvs.at(corner, vertex))
            .collect(),
    )
}

/// Mean of a function over a convex polygon, by points spread evenly over its triangles, `n` along each
/// side.
fn mean_over(corners: &[DVec2], n: u32, value: impl Fn(DVec2) -> Rgb) -> Rgb {
    let (mut sum, mut whole) = (Rgb::BLACK, 0.0);
    for k in 2..corners.len() {
        let (a, b, c) = (
            corners[0],
            corners[k - 1] - corners[0],
            corners[k] - corners[0],
        );
        // A triangle without area in the picture shows one colour.
        let weight = b.perp_dot(c).abs().max(f64::MIN_POSITIVE);
        let (mut of_triangle, mut count) = (Rgb::BLACK, 0.0);
        for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
            // The centres of the triangles that point up, and of those that point down.
            for third in [1.0, 2.0] {
                let at = |k: u32| (f64::from(k) + third / 3.0) / f64::from(n);
                if third == 1.0 || i + j + 1 < n {
                    of_triangle += value(a + at(i) * b + at(j) * c);
                    count += 1.0;
                }
            }
        }
        sum += of_triangle * (weight / count);
        whole += weight;
    }
    sum / whole
}

/// Mean colour and texture of a face.
fn pattern(scene: &Scene, mesh: &Mesh, face: usize, material: &Material) -> Rgb {
    let corners: Vec<(usize, u32)> = mesh
        .faces
        .corner_range(face)
        .zip(mesh.faces.get(face).iter().copied())
        .collect();
    let share = 1.0 / corners.len() as f64;
    let mut mean = Rgb::WHITE;
    if !mesh.colors.is_empty() {
        mean = corners
            .iter()
            .map(|&(_, v)| mesh.colors[v as usize])
            .sum::<Rgb>()
            * share;
    }
    let Some(uvs) = &mesh.uvs else { return mean };
    let at: Vec<DVec2> = corners.iter().map(|&(c, v)| uvs.at(c, v)).collect();
    let centre = at.iter().copied().sum::<DVec2>() * share;
    for texture in material
        .textures
        .iter()
        .map(|&t| &scene.textures[t as usize])
        .filter(|texture| texture.image.is_some())
    {
        // Corners moved half way to the centre sample the face and not its neighbours.
        let sample = |p: DVec2| {
            let color = texture.sample(p).unwrap_or([1.0; 3]);
            Rgb::from(color.map(f64::from))
        };
        let sum: Rgb = at.iter().map(|&p| sample(0.5 * (p + centre))).sum::<Rgb>() + sample(centre);
        mean *= sum / (at.len() + 1) as f64;
    }
    mean
}
