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
            hit_patches: HitPatches::new(surfaces, patches),
            reflectance,
            footprint,
            reflected: (0..2 * patches.len()).map(of_side).collect(),
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

impl DiffuseLight for PatchLight<'_> {
    fn outgoing(&self, at: &DiffuseHit, replicate: usize) -> OutgoingRadiosity {
        let patch = self.hit_patches.at(&at.hit);
        let fine = self.fine.and_then(|field| field.irradiance(at));
        if let Some((irradiance, footprint)) = fine {
            let reflectance = self.reflectance[patch as usize].to_f32();
            return OutgoingRadiosity {
                radiosity: std::array::from_fn(|c| reflectance[c] * irradiance[c]),
                footprint,
            };
        }
        OutgoingRadiosity {
            radiosity: self.reflected[side(patch, at.front) as usize][replicate],
            footprint: self.footprint[patch as usize],
        }
    }

    fn reflectance(&self, at: &DiffuseHit) -> Rgb {
        self.reflectance[self.hit_patches.at(&at.hit) as usize]
    }
}
