//! Where the light of texels comes from: the radiance above each as spherical harmonics of bands 0 and 1.

use crate::lattice::TexelCells;
use crate::samples::Samples;
use azulejo_radiosity::sites::{SiteCells, SiteLight, interpolated_signed};
use azulejo_trace::{Cancelled, GatherPoint, Gathered, Harmonics, Run};

/// Coefficients: those of bands 0 and 1, in the order (0,0), (1,−1), (1,0), (1,1).
pub const DIRECTIONAL: usize = 4;

/// Texels along a side of the cells at whose nodes indirect light is gathered, as a power of two: it comes from
/// about the same direction all over so small a place.
const LEVEL: u32 = 3;

/// The indirect light that arrives at points from their hemispheres.
pub type HarmonicGather<'g, E> = dyn FnMut(&[GatherPoint]) -> Result<Vec<Harmonics>, E> + 'g;

/// The first coefficients of what was gathered, each with its standard error, W/(sr·m²).
pub(crate) fn site_harmonics(found: &Harmonics) -> Vec<SiteLight> {
    let coefficients = found.coefficients[..DIRECTIONAL].iter();
    coefficients
        .map(|coefficient| SiteLight {
            irradiance: coefficient.mean().to_f32(),
            standard_error: coefficient.standard_error().to_f32(),
        })
        .collect()
}

/// The coefficients of the radiance above all samples, W/(sr·m²), with their standard errors, in place of irradiance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexelHarmonics {
    /// For each coefficient its value at each sample; empty if they are not asked for.
    pub coefficients: [Vec<SiteLight>; DIRECTIONAL],
}

impl TexelHarmonics {
    /// No light at this many samples.
    pub fn none(count: usize) -> TexelHarmonics {
        TexelHarmonics {
            coefficients: std::array::from_fn(|_| vec![SiteLight::default(); count]),
        }
    }

    /// Whether they are not asked for.
    pub fn is_empty(&self) -> bool {
        self.coefficients[0].is_empty()
    }

    /// Sets those of a sample, if they are asked for.
    pub(crate) fn set(&mut self, sample: usize, found: &[SiteLight]) {
        for (of_all, light) in self.coefficients.iter_mut().zip(found) {
            of_all[sample] = *light;
        }
    }

    /// Adds other light, whose errors are independent.
    fn add(&mut self, coefficient: usize, other: &[SiteLight]) {
        for (all, other) in self.coefficients[coefficient].iter_mut().zip(other) {
            for k in 0..3 {
                all.irradiance[k] += other.irradiance[k];
                all.standard_error[k] = all.standard_error[k].hypot(other.standard_error[k]);
            }
        }
    }

    /// Adds the indirect light that `gather` finds at the nodes of a lattice of samples, and that lies between them.
    ///
    /// # Errors
    /// Those of `gather`.
    pub fn add_indirect<E: From<Cancelled>>(
        &mut self,
        samples: &Samples,
        run: Run,
        gather: &mut HarmonicGather<E>,
    ) -> Result<(), E> {
        let cells = TexelCells::of_level(samples, LEVEL);
        let points: Vec<GatherPoint> = cells.nodes().iter().map(|&n| cells.point(n)).collect();
        let found = gather(&points)?;
        let of_nodes = (0..DIRECTIONAL).map(|k| {
            found
                .iter()
                .map(|h| h.coefficients[k])
                .collect::<Vec<Gathered>>()
        });
        let coefficients = interpolated_signed(cells, of_nodes, run)?;
        for (k, light) in coefficients.iter().enumerate() {
            self.add(k, light);
        }
        Ok(())
    }
}
