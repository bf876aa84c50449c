//! The solved light of the patches, as gathers read it.

use crate::patch::{Patches, RefinedShape};
use crate::row::side;
use azulejo_scene::{Material, Mesh, Rgb, Scene};
use azulejo_trace::{DiffuseHit, DiffuseLight, KernelHit, OutgoingRadiosity, REPLICATES, Surfaces};
use glam::DVec2;

/// From nearer than this share of its diameter a patch is too coarse to be looked at. Half of it
/// leaves no bias that shows beside 1% of noise (measured on Cornell boxes), and spares most of
/// the work of a whole one.
const COARSE: f64 = 0.5;

/// Reflected radiosity of every side of every patch, in independent replicates.
pub struct PatchLight<'a> {
    surfaces: &'a Surfaces<'a>,
    patches: &'a Patches,
    reflectance: &'a [Rgb],
    reflected: Vec<[[f32; 3]; REPLICATES]>,
    /// Distance from which each diffuse patch may be looked at, zero for the others.
    footprint: Vec<f32>,
}

impl<'a> PatchLight<'a> {
    /// From one solution per replicate, each R per side in W/m².
    pub fn new(
        surfaces: &'a Surfaces<'a>,
        patches: &'a Patches,
        reflectance: &'a [Rgb],
        solutions: &[Vec<Rgb>],
    ) -> PatchLight<'a> {
        let of_side =
            |s: usize| std::array::from_fn(|r| solutions[r % solutions.len()][s].to_f32());
        let footprint = |p: usize| {
            if reflectance[p].is_black() {
                0.0
            } else {
                (COARSE * patches.diameter(p)) as f32
            }
        };
        let footprint = (0..patches.len()).map(footprint).collect();
        PatchLight {
            surfaces,
            patches,
            reflectance,
            footprint,
            reflected: (0..2 * patches.len()).map(of_side).collect(),
        }
    }

    /// The same read from any distance: gathering anew from near hits would add bounces, and is
    /// wrong where their number is limited.
    pub fn without_footprint(self) -> PatchLight<'a> {
        PatchLight {
            footprint: vec![0.0; self.footprint.len()],
            ..self
        }
    }
}

impl DiffuseLight for PatchLight<'_> {
    fn outgoing(&self, at: &DiffuseHit, replicate: usize) -> OutgoingRadiosity {
        let patch = self.patches.locate_hit(self.surfaces, &at.hit);
        OutgoingRadiosity {
            radiosity: self.reflected[side(patch, at.front) as usize][replicate],
            footprint: self.footprint[patch as usize],
        }
    }

    fn reflectance(&self, at: &DiffuseHit) -> Rgb {
        self.reflectance[self.patches.locate_hit(self.surfaces, &at.hit) as usize]
    }
}

impl Patches {
    /// The patch that a hit of the scene's own tracer lies on.
    pub fn locate_hit(&self, surfaces: &Surfaces, hit: &KernelHit) -> u32 {
        let item = surfaces.item(hit.item);
        self.locate(item.object, item.face, item.triangle, hit.u, hit.v)
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
        // Corners drawn half way to the centre sample the face and not its neighbours.
        let sample = |p: DVec2| Rgb::from(image.sample(p.x, p.y).map(f64::from));
        let sum: Rgb = at.iter().map(|&p| sample(0.5 * (p + centre))).sum::<Rgb>() + sample(centre);
        mean *= sum / (at.len() + 1) as f64;
    }
    mean
}
