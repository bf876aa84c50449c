//! The solved light of patches as a light source of gathers.

use crate::fine_light::IrradianceField;
use azulejo_factors::Patches;
use azulejo_factors::rays::HitPatches;
use azulejo_factors::row::side;
use azulejo_scene::Rgb;
use azulejo_trace::{DiffuseHit, DiffuseLight, OutgoingRadiosity, REPLICATES, Surfaces};

/// Distance, as a share of its diameter, below which a patch is too coarse to be read. Half of it
/// leaves no visible bias beside 1% of noise (measured on Cornell boxes), and saves most of the
/// work of a whole diameter.
const COARSE: f64 = 0.5;

/// Reflected radiosity of every side of every patch, in independent replicates.
pub struct PatchLight<'a> {
    hit_patches: HitPatches<'a>,
    reflectance: &'a [Rgb],
    /// That of all patches of a material, where it is the same.
    reflectance_of_materials: Vec<Option<Rgb>>,
    surfaces: &'a Surfaces<'a>,
    /// Empty if nothing is known.
    reflected: Vec<[[f32; 3]; REPLICATES]>,
    /// Distance from which each diffuse patch may be read, zero for the others.
    footprint: Vec<f32>,
    /// Light finer than that of the patches.
    fine: Option<&'a dyn IrradianceField>,
}

impl<'a> PatchLight<'a> {
    /// From one solution R per replicate and side, in W/m².
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
            footprint,
            reflected: (0..2 * patches.len()).map(of_side).collect(),
            ..PatchLight::unknown(surfaces, patches, reflectance)
        }
    }

    /// Light of which nothing is known: for path tracing alone.
    pub fn unknown(
        surfaces: &'a Surfaces<'a>,
        patches: &'a Patches,
        reflectance: &'a [Rgb],
    ) -> PatchLight<'a> {
        PatchLight {
            reflectance_of_materials: reflectance_of_materials(surfaces, patches, reflectance),
            surfaces,
            hit_patches: HitPatches::new(surfaces, patches),
            reflectance,
            footprint: Vec::new(),
            reflected: Vec::new(),
            fine: None,
        }
    }

    /// The same with light that is known finer where there is some.
    pub(crate) fn with_fine(self, field: &'a dyn IrradianceField) -> PatchLight<'a> {
        PatchLight {
            fine: Some(field),
            ..self
        }
    }

    /// The same, read from any distance: final gathers from near hits would add bounces, which is
    /// wrong where their number is limited.
    pub fn without_footprint(self) -> PatchLight<'a> {
        PatchLight {
            footprint: vec![0.0; self.footprint.len()],
            ..self
        }
    }
}

/// The reflectance of each material, where all of its patches have the same: without textures and vertex colours.
fn reflectance_of_materials(
    surfaces: &Surfaces,
    patches: &Patches,
    reflectance: &[Rgb],
) -> Vec<Option<Rgb>> {
    let mut of_materials: Vec<Option<Rgb>> = vec![None; surfaces.scene.materials.len()];
    let mut varies = vec![false; of_materials.len()];
    for (patch, &reflectance) in reflectance.iter().enumerate() {
        let material = patches.material(patch) as usize;
        varies[material] |= *of_materials[material].get_or_insert(reflectance) != reflectance;
    }
    for (reflectance, varies) in of_materials.iter_mut().zip(varies) {
        *reflectance = reflectance.filter(|_| !varies);
    }
    of_materials
}

impl DiffuseLight for PatchLight<'_> {
    fn outgoing(&self, at: &DiffuseHit, replicate: usize) -> OutgoingRadiosity {
        let fine = self.fine.and_then(|field| field.irradiance(at));
        if let Some((irradiance, footprint)) = fine {
            let reflectance = self.reflectance(at).to_f32();
            return OutgoingRadiosity {
                radiosity: std::array::from_fn(|c| reflectance[c] * irradiance[c]),
                footprint,
            };
        }
        let patch = self.hit_patches.at(&at.hit);
        match self.reflected.get(side(patch, at.front) as usize) {
            Some(reflected) => OutgoingRadiosity {
                radiosity: reflected[replicate],
                footprint: self.footprint[patch as usize],
            },
            None => OutgoingRadiosity::default(),
        }
    }

    fn reflectance(&self, at: &DiffuseHit) -> Rgb {
        let material = self.surfaces.material_id(at.hit.item);
        match self.reflectance_of_materials[material as usize] {
            Some(reflectance) => reflectance,
            None => self.reflectance[self.hit_patches.at(&at.hit) as usize],
        }
    }

    fn is_unknown(&self) -> bool {
        self.reflected.is_empty() && self.fine.is_none()
    }
}
