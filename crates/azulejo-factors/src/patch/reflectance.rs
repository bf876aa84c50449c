//! Mean reflectance of patches, and the patch of a hit.

use super::{Patches, RefinedShape};
use azulejo_scene::{Material, Mesh, Rgb, Scene};
use azulejo_trace::{KernelHit, Surfaces};
use glam::DVec2;

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
    for image in material
        .textures
        .iter()
        .filter_map(|&t| scene.textures[t as usize].image.as_ref())
    {
        // Corners moved half way to the centre sample the face and not its neighbours.
        let sample = |p: DVec2| Rgb::from(image.sample(p.x, p.y).map(f64::from));
        let sum: Rgb = at.iter().map(|&p| sample(0.5 * (p + centre))).sum::<Rgb>() + sample(centre);
        mean *= sum / (at.len() + 1) as f64;
    }
    mean
}
