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
    let mut reflectances = Vec::with_capacity(patches.len());
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
            reflectances.push(material.diffuse * pattern);
        }
    }
    reflectances
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
    let opacities = scene.materials.iter().map(Material::see_through);
    let opacities: Vec<Option<&Opacity>> = opacities.collect();
    if opacities.iter().all(Option::is_none) {
        return None;
    }
    let mut maps = HashMap::new();
    let opacity = |patch: usize| opacities[patches.material(patch) as usize];
    let mean = |patch: usize, uvs: Option<Vec<DVec2>>| {
        let Some(opacity) = opacity(patch) else {
            return 1.0;
        };
        let map = opacity.picture.and_then(|picture| {
            let map = maps
                .entry((picture.texture, picture.channel))
                .or_insert_with(|| {
                    let texture = scene.textures.get(picture.texture as usize)?;
                    OpacityMap::new(texture.image.as_ref()?, picture.channel, texture.wrap)
                });
            map.as_ref()
        });
        let mean = match map.zip(uvs) {
            Some((map, uvs)) => {
                let value = |uv| Rgb::grey(opacity.at(map.sample(uv)));
                mean_over(&uvs, OPACITY_STEPS, value).r
            }
            None => opacity.at(1.0),
        };
        mean.clamp(LEAST_OPACITY, 1.0)
    };
    let is_see_through = |patch: usize| opacity(patch).is_some();
    Some(by_texture(scene, patches, is_see_through, mean))
}

/// A value of each patch from its number and the texture coordinates of its corners; these are looked up for
/// meshes of which `is_textured` holds for some patch.
fn by_texture<T>(
    scene: &Scene,
    patches: &Patches,
    is_textured: impl Fn(usize) -> bool,
    mut value: impl FnMut(usize, Option<Vec<DVec2>>) -> T,
) -> Vec<T> {
    let mut values = Vec::with_capacity(patches.len());
    for (object, o) in (0..).zip(&scene.objects) {
        let range = patches.patches_of(object);
        let is_mesh = matches!(o.shape, Shape::Mesh(_) | Shape::Instance(_));
        let is_divided = is_mesh && range.clone().any(&is_textured);
        let mesh = is_divided.then(|| patches.refined(object, scene));
        for (face, patch) in range.enumerate() {
            let uvs = match &mesh {
                Some(RefinedShape::Mesh(mesh)) => texture_corners(mesh, face),
                _ => None,
            };
            values.push(value(patch, uvs));
        }
    }
    values
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
    let emits = |patch: usize| means[patches.material(patch) as usize].is_some();
    let value = |patch: usize, uvs: Option<Vec<DVec2>>| {
        let material = patches.material(patch) as usize;
        let Some(mean) = means[material] else {
            return Rgb::WHITE;
        };
        let texture = picture(&scene.materials[material]).map(|id| &scene.textures[id as usize]);
        match uvs.zip(texture) {
            Some((uvs, texture)) => mean_of_texels(texture, &uvs),
            None => mean,
        }
    };
    Some(by_texture(scene, patches, emits, value))
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
    let corners = mesh.faces.corner_range(face).zip(mesh.faces.get(face));
    Some(
        corners
            .map(|(corner, &vertex)| uvs.at(corner, vertex))
            .collect(),
    )
}

/// Mean of a function over a convex polygon, by points spread evenly over its triangles, `n` along each
/// side.
fn mean_over(corners: &[DVec2], n: u32, value: impl Fn(DVec2) -> Rgb) -> Rgb {
    let (mut sum, mut whole) = (Rgb::BLACK, 0.0);
    for k in 2..corners.len() {
        let a = corners[0];
        let (b, c) = (corners[k - 1] - a, corners[k] - a);
        // A triangle without area in the picture shows one colour.
        let weight = b.perp_dot(c).abs().max(f64::MIN_POSITIVE);
        let (mut triangle_sum, mut count) = (Rgb::BLACK, 0.0);
        for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
            // The centres of the triangles that point up, and of those that point down.
            for third in [1.0, 2.0] {
                let at = |k: u32| (f64::from(k) + third / 3.0) / f64::from(n);
                if third == 1.0 || i + j + 1 < n {
                    triangle_sum += value(a + at(i) * b + at(j) * c);
                    count += 1.0;
                }
            }
        }
        sum += triangle_sum * (weight / count);
        whole += weight;
    }
    sum / whole
}

/// Mean colour and texture of a face.
fn pattern(scene: &Scene, mesh: &Mesh, face: usize, material: &Material) -> Rgb {
    let vertices = mesh.faces.get(face);
    let share = 1.0 / vertices.len() as f64;
    let mut mean = Rgb::WHITE;
    if !mesh.colors.is_empty() {
        mean = vertices
            .iter()
            .map(|&v| mesh.colors[v as usize])
            .sum::<Rgb>()
            * share;
    }
    let Some(at) = texture_corners(mesh, face) else {
        return mean;
    };
    let centre = at.iter().copied().sum::<DVec2>() * share;
    let textures = material
        .textures
        .iter()
        .map(|&t| &scene.textures[t as usize]);
    for texture in textures.filter(|texture| texture.image.is_some()) {
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
