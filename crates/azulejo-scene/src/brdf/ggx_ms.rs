//! GGX with multiple scattering between its facets: `ggx_ms`.
//!
//! C. Kulla, A. Conty, *Revisiting physically based shading at Imageworks*, SIGGRAPH 2017 course.
//! The energy that single scattering loses is returned by a second, isotropic lobe, so that white
//! facets reflect all light from every direction.

use super::BrdfError;
use super::arguments::Arguments;
use super::ggx_smith::GgxSmith;
use super::lobe::Lobe;
use super::matt::Matt;
use super::microfacet::{mirrored_by, over_base};
use super::models::{KD, KS, ModelInfo, PLAIN, ParameterInfo};
use super::quadrature::{gauss_legendre, midpoints};
use super::vndf::Ggx;
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;
use std::sync::Arc;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "ggx_ms",
    title: "GGX with multiple reflections",
    paper: "C. Kulla, A. Conty, Revisiting physically based shading at Imageworks, SIGGRAPH 2017",
    parameters: &[
        KD,
        KS,
        ParameterInfo::number("ax", [1e-4, 1.0], "roughness").also(&["alpha"]),
        ParameterInfo::number("ay", [1e-4, 1.0], "the same again, if it is given").optional(),
    ],
    examples: &[
        "ggx_ms ax = 0.5",
        "ggx_ms ax = 1 metal = copper",
        "ggx_ms kd = 0.4 ks = 0.6 ax = 0.2 eta = 1.5",
    ],
    has_fresnel: true,
    make,
    ..PLAIN
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    let alpha = arguments.number("ax");
    if arguments.has("ay") && arguments.number("ay") != alpha {
        return Err(BrdfError::Other(
            "`ggx_ms` is the same along both axes: `ax` and `ay` must be equal, or `ggx_smith` \
             be used"
                .to_owned(),
        ));
    }
    let (scale, fresnel) = (arguments.color("ks"), arguments.fresnel()?);
    let facets = Ggx {
        ax: alpha,
        ay: alpha,
    };
    let multiple = GgxMultiple::new(scale, fresnel.mean(), LostEnergy::new(facets));
    let once = GgxSmith {
        scale,
        fresnel,
        facets,
    };
    over_base(
        arguments,
        vec![Lobe::GgxSmith(once), Lobe::GgxMultiple(multiple)],
    )
}

/// Fms (1 − E(i))(1 − E(o))/(π (1 − Ē)).
#[derive(Clone, Debug)]
pub(super) struct GgxMultiple {
    /// ks Fms/(π (1 − Ē)).
    scale: Rgb,
    lost: Arc<LostEnergy>,
}

impl GgxMultiple {
    /// `fresnel` is the mean of the Fresnel term: the fraction that is left after each reflection.
    fn new(scale: Rgb, fresnel: Rgb, lost: LostEnergy) -> GgxMultiple {
        let once = 1.0 - lost.mean;
        let multiple = fresnel.map(|f| f * f * once / (1.0 - f * lost.mean));
        // Nearly flat facets lose nothing, so there is nothing to return.
        let over = FRAC_1_PI / lost.mean.max(1e-12);
        GgxMultiple {
            scale: scale * multiple * over,
            lost: Arc::new(lost),
        }
    }
}

impl Matt for GgxMultiple {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.scale * (self.lost.at(wo.z) * self.lost.at(wi.z))
    }
}

/// Intervals of the table of lost energy.
const INTERVALS: usize = 48;

/// Energy that single scattering loses at white facets, by direction: 1 − E.
#[derive(Debug)]
struct LostEnergy {
    alpha: f64,
    /// At equal steps of √ln(1 + μ/α) from the horizon to the normal, with μ = cos θ; in this
    /// variable it is smooth for any roughness α, also at the horizon.
    table: Vec<f64>,
    /// ln(1 + 1/α), where the table ends.
    end: f64,
    /// 1 − Ē = 2 ∫ (1 − E) μ dμ.
    mean: f64,
}

impl LostEnergy {
    fn new(facets: Ggx) -> LostEnergy {
        let alpha = facets.ax;
        let points = gauss_legendre(64);
        let end = (1.0 / alpha).ln_1p();
        let cosine = |t: f64| (alpha * (t * end).exp_m1()).min(1.0);
        let at = |k: usize| cosine((k as f64 / INTERVALS as f64).powi(2));
        let table = (0..=INTERVALS).map(|k| lost(facets, at(k)));
        let mut lost = LostEnergy {
            alpha,
            table: table.collect(),
            end,
            mean: 0.0,
        };
        // dμ = (μ + α) end dt.
        let term = |&(t, weight): &(f64, f64)| {
            let cos = cosine(t);
            2.0 * weight * lost.at(cos) * cos * (cos + alpha) * end
        };
        lost.mean = points.iter().map(term).sum();
        lost
    }

    /// 1 − E, by cubic interpolation.
    fn at(&self, cos: f64) -> f64 {
        let t = ((cos / self.alpha).ln_1p() / self.end).sqrt() * INTERVALS as f64;
        let first = (t as usize).saturating_sub(1).min(INTERVALS - 3);
        let x = t - first as f64;
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| self.table[first + k]);
        // Lagrange's polynomial through four points at 0, 1, 2, 3.
        let (x1, x2, x3) = (x - 1.0, x - 2.0, x - 3.0);
        let outer = (d * x * x1 * x2 - a * x1 * x2 * x3) / 6.0;
        let inner = 0.5 * (b * x * x2 * x3 - c * x * x1 * x3);
        (outer + inner).clamp(0.0, 1.0)
    }
}

/// 1 − E at one cosine: the mean, over the visible facets, of the fraction that is shadowed from
/// the direction in which they reflect.
fn lost(facets: Ggx, cos: f64) -> f64 {
    const INCLINATIONS: usize = 256;
    // The integrand has an edge where shadowing begins in azimuth, which fewer points would miss.
    const TURNS: usize = 64;
    let wo = DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let shaded = |u1: f64, u2: f64| {
        let wi = mirrored_by(wo, facets.sample(wo, [u1, u2, 0.0]));
        if wi.z <= 0.0 {
            return 1.0;
        }
        // 1 − G₂/G₁ of Smith's shadowing, where both cosines may be nearly 0.
        let (o, i) = (wo.z * facets.stretch(wi), wi.z * facets.stretch(wo));
        (o - wo.z * wi.z) / (o + i)
    };
    // Both halves of the azimuth are the same.
    let turn = |u1: f64| midpoints(TURNS).map(|u| shaded(u1, 0.5 * u)).sum::<f64>();
    // Steep facets, which are shadowed most, are rare and come last: u = 1 − x² resolves them.
    let term = |x: f64| 2.0 * x * turn(1.0 - x * x);
    midpoints(INCLINATIONS).map(term).sum::<f64>() / (INCLINATIONS * TURNS) as f64
}
