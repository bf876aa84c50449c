//! Tables on grids adapted to the material, as in the RGL database.

use super::super::BrdfError;
use super::super::lobe::{Reflect, Spread};
use super::super::microfacet::HalfVector;
use super::super::quadrature::cosine_hemisphere;
use super::square;
use super::warp::{Mix, Tables, Warp, mix};
use crate::Rgb;
use crate::content_bytes::{ContentBytes, ContentSink, content_of_fields};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, TAU};

/// A BRDF measured on a grid warped by the distribution of its facets' visible normals.
///
/// J. Dupuy, W. Jakob, *An adaptive parameterization for efficient material acquisition and
/// rendering*, SIGGRAPH Asia 2018. The file's θi and φi are used for the viewer here; by reciprocity
/// this is the same for materials, and nearly the same for measurements.
#[derive(Clone, PartialEq)]
pub struct Rgl {
    theta: Vec<f32>,
    phi: Vec<f32>,
    /// Number of equal parts into which symmetry divides the whole turn: 1, 2 or 4.
    parts: u8,
    facets: Option<[Tables; 2]>,
    visible: Warp,
    luminance: Warp,
    /// Red, green and blue of each pair of angles.
    rgb: Tables,
}

content_of_fields! { Rgl { theta, phi, parts, facets, visible, luminance, rgb } }

/// The content of a file of the RGL database, tensors row by row.
#[derive(Clone, Debug, Default)]
pub struct RglTensors {
    /// Angles to the normal, radians, rising.
    pub theta_i: Vec<f32>,
    /// Angles around it, radians, rising; two at most for isotropic materials.
    pub phi_i: Vec<f32>,
    /// Distribution of facets: height × width.
    pub ndf: Grid,
    /// Their projected area: height × width.
    pub sigma: Grid,
    /// Distribution of visible facets: φi × θi × height × width.
    pub vndf: Grid,
    /// Luminance of the reflected light on the warped grid: φi × θi × height × width.
    pub luminance: Grid,
    /// The same in red, green and blue: φi × θi × 3 × height × width.
    pub rgb: Grid,
    /// Whether values are relative to the facets' distribution.
    pub jacobian: bool,
}

/// Tables of one size.
#[derive(Clone, Debug, Default)]
pub struct Grid {
    /// Nodes in a row.
    pub width: usize,
    /// Rows of a table.
    pub height: usize,
    /// Table by table, row by row.
    pub values: Vec<f32>,
}

/// Fraction of samples from a cosine distribution, for directions that the tables miss.
const EVEN: f64 = 0.1;

/// Lower bound for cosines and areas, to avoid division by 0.
const GRAZING: f64 = 1e-6;

impl Rgl {
    /// Checks sizes and values and builds the tables.
    ///
    /// # Errors
    /// [`BrdfError::Other`] if sizes are inconsistent, angles do not rise, or values are negative
    /// or not finite.
    pub fn new(tensors: RglTensors) -> Result<Rgl, BrdfError> {
        let RglTensors { theta_i, phi_i, .. } = &tensors;
        for (name, angles) in [("theta_i", theta_i), ("phi_i", phi_i)] {
            let rises = angles.windows(2).all(|pair| pair[0] < pair[1]);
            let is_good = !angles.is_empty() && rises && angles.iter().all(|a| a.is_finite());
            ensure(is_good, || format!("`{name}` must be angles that rise"))?;
        }
        let (pairs, parts) = (theta_i.len() * phi_i.len(), parts(phi_i)?);
        let facets = [
            tables("ndf", tensors.ndf, 1)?,
            tables("sigma", tensors.sigma, 1)?,
        ];
        Ok(Rgl {
            parts,
            facets: tensors.jacobian.then_some(facets),
            visible: Warp::new(tables("vndf", tensors.vndf, pairs)?),
            luminance: Warp::new(tables("luminance", tensors.luminance, pairs)?),
            rgb: tables("rgb", tensors.rgb, 3 * pairs)?,
            theta: tensors.theta_i,
            phi: tensors.phi_i,
        })
    }

    /// Whether it is isotropic.
    pub fn is_isotropic(&self) -> bool {
        self.phi.len() <= 2
    }

    /// The tables for a viewer in the measured range of azimuths.
    fn mix(&self, wo: DVec3) -> Mix {
        let phi = if self.is_isotropic() {
            f64::from(self.phi[0])
        } else {
            square::azimuth(wo)
        };
        mix([&self.phi, &self.theta], [phi, square::polar(wo)])
    }

    /// The angle by which half vectors are rotated back.
    fn turn(&self, wo: DVec3) -> f64 {
        if self.is_isotropic() {
            square::azimuth(wo)
        } else {
            0.0
        }
    }

    /// Signs that bring a viewer to the measured range of azimuths by symmetry.
    fn symmetry(&self, wo: DVec3) -> DVec3 {
        let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
        match self.parts {
            2 => DVec3::new(sign(wo.y), sign(wo.y), 1.0),
            4 => DVec3::new(sign(wo.x), sign(wo.y), 1.0),
            _ => DVec3::ONE,
        }
    }
}

fn ensure(holds: bool, otherwise: impl FnOnce() -> String) -> Result<(), BrdfError> {
    if holds {
        Ok(())
    } else {
        Err(BrdfError::Other(otherwise()))
    }
}

fn tables(name: &str, grid: Grid, count: usize) -> Result<Tables, BrdfError> {
    let is_good = grid.values.iter().all(|v| v.is_finite() && *v >= 0.0);
    ensure(is_good, || {
        format!("`{name}` has values that are negative or no numbers")
    })?;
    let tables = Tables::new(grid.width, grid.height, grid.values);
    let fits = tables.filter(|tables| tables.count() == count);
    fits.ok_or_else(|| {
        BrdfError::Other(format!(
            "`{name}` must be {count} tables of at least 2 × 2 values"
        ))
    })
}

/// The number of equal parts into which symmetry divides a full turn.
fn parts(phi: &[f32]) -> Result<u8, BrdfError> {
    let [first, .., last] = phi else { return Ok(1) };
    if phi.len() <= 2 {
        return Ok(1);
    }
    let parts = (TAU / f64::from(last - first)).round();
    match parts {
        1.0 => Ok(1),
        2.0 => Ok(2),
        4.0 => Ok(4),
        _ => Err(BrdfError::Other(
            "`phi_i` must span a whole turn, a half or a quarter".to_owned(),
        )),
    }
}

/// The tables of one channel.
fn channel(mix: &Mix, channel: usize) -> Mix {
    mix.map(|(table, weight)| (3 * table + channel, weight))
}

impl Reflect for Rgl {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let symmetry = self.symmetry(wo);
        let (wo, wi) = (wo * symmetry, wi * symmetry);
        let (half, mix) = (HalfVector::new(wo, wi), self.mix(wo));
        let place = square::place(&half, self.turn(wo));
        let warped = self.visible.invert(&mix, place);
        let of = |c: usize| self.rgb.at(&channel(&mix, c), warped);
        let whole = [(0, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
        let facets = self.facets.as_ref().map_or(1.0, |[ndf, sigma]| {
            let viewer = [
                square::polar_coordinate(square::polar(wo)),
                square::azimuth_coordinate(square::azimuth(wo)),
            ];
            ndf.at(&whole, place) / (4.0 * sigma.at(&whole, viewer).max(GRAZING))
        });
        // The tables include the cosine of the incident light.
        Rgb::new(of(0), of(1), of(2)) * (facets / wi.z.max(GRAZING))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let symmetry = self.symmetry(wo);
        let (wo, wi) = (wo * symmetry, wi * symmetry);
        let (half, mix) = (HalfVector::new(wo, wi), self.mix(wo));
        let place = square::place(&half, self.turn(wo));
        let warped = self.visible.invert(&mix, place);
        let density = self.visible.density(&mix, place) * self.luminance.density(&mix, warped);
        EVEN * wi.z * FRAC_1_PI + (1.0 - EVEN) * density / square::solid_angle(&half)
    }

    fn sample(&self, wo: DVec3, [u1, u2, choice]: [f64; 3]) -> DVec3 {
        if choice < EVEN {
            return cosine_hemisphere(u1, u2);
        }
        let symmetry = self.symmetry(wo);
        let wo = wo * symmetry;
        let mix = self.mix(wo);
        let warped = self.luminance.sample(&mix, [u1, u2]);
        let place = self.visible.sample(&mix, warped);
        square::mirrored_at(place, self.turn(wo), wo) * symmetry
    }

    fn spread(&self) -> Spread {
        super::spread(self)
    }
}
