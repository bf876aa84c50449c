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
use super::quadrature::{gauss_legendre, lagrange};
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

/// Points of the integrals over facets, in each direction and between edges.
const POINTS: usize = 24;

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
        let (points, few) = (gauss_legendre(64), gauss_legendre(POINTS));
        let end = (1.0 / alpha).ln_1p();
        let cosine = |t: f64| (alpha * (t * end).exp_m1()).min(1.0);
        let at = |k: usize| cosine((k as f64 / INTERVALS as f64).powi(2));
        let table = (0..=INTERVALS).map(|k| lost(facets, at(k), &few));
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
        let weights = lagrange::<4>(t - first as f64);
        let terms = self.table[first..].iter().zip(weights).map(|(v, w)| v * w);
        terms.sum::<f64>().clamp(0.0, 1.0)
    }
}

/// 1 − E at one cosine: the mean, over the visible facets, of the fraction that is shadowed from
/// the direction in which they reflect.
fn lost(facets: Ggx, cos: f64, rule: &[(f64, f64)]) -> f64 {
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
    // Over half a turn, as both halves are the same, up to where facets reflect below the horizon.
    let turn = |u1: f64| {
        let [from, to] = lit(facets, wo, u1);
        let term = |&(x, weight): &(f64, f64)| weight * shaded(u1, 0.5 * (from + (to - from) * x));
        1.0 - (to - from) * (1.0 - rule.iter().map(term).sum::<f64>())
    };
    // Steep facets, which are shadowed most, are rare and come last: u = 1 − x² resolves them. The integrand has edges
    // where the first of them, and where all of one slope, reflect below the horizon; above those it is steep.
    let share = |x: f64| {
        let [from, to] = lit(facets, wo, 1.0 - x * x);
        to - from
    };
    let (some, all) = (rise(|x| share(x) > 0.0), rise(|x| share(x) >= 1.0));
    let part = |[low, high]: [f64; 2]| {
        let log = (high / low).ln();
        let term = |&(t, weight): &(f64, f64)| {
            let x = low * (log * t * t).exp();
            weight * 2.0 * t * log * x * 2.0 * x * turn(1.0 - x * x)
        };
        rule.iter().map(term).sum::<f64>()
    };
    some * some + part([some, all]) + part([all, 1.0])
}

/// Where in 0..1 a condition becomes true that stays so, by bisection.
fn rise(is_true: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if is_true(middle) {
            high = middle
        } else {
            low = middle
        }
    }
    high
}

/// The range of u₂, in halves, for which the facets that [`Ggx::sample`] gives for `wo` in the plane of x and z reflect
/// above the horizon.
fn lit(facets: Ggx, wo: DVec3, u1: f64) -> [f64; 2] {
    let lean = DVec3::new(wo.x * facets.ax, 0.0, wo.z).normalize();
    let z = (1.0 - u1) * (1.0 + lean.z) - lean.z;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (up, alpha) = ((z + lean.z).max(0.0), facets.ax);
    // Where the normal is (α (r cos φ + lean x), α r sin φ, up), the reflected direction rises as base + swing cos φ.
    let base = 2.0 * up * (wo.x * alpha * lean.x + wo.z * up)
        - wo.z * (alpha * alpha * (r * r + lean.x * lean.x) + up * up);
    let swing = 2.0 * alpha * r * (up * wo.x - wo.z * alpha * lean.x);
    if base.abs() >= swing.abs() {
        return [0.0, f64::from(u8::from(base > 0.0))];
    }
    let edge = (-base / swing).acos() * FRAC_1_PI;
    if swing > 0.0 {
        [0.0, edge]
    } else {
        [edge, 1.0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::quadrature::midpoints;

    #[test]
    fn lost_energy_is_that_of_brute_force() {
        let wide = lost(Ggx { ax: 1.0, ay: 1.0 }, 1.0, &gauss_legendre(POINTS));
        assert!((wide - std::f64::consts::LN_2).abs() < 1e-12, "{wide}");
        for alpha in [0.05, 0.5, 1.0] {
            let facets = Ggx {
                ax: alpha,
                ay: alpha,
            };
            for cos in [0.01 * alpha, alpha, 0.2, 0.7, 1.0] {
                let wo = DVec3::new((1.0f64 - cos * cos).sqrt(), 0.0, cos);
                let shaded = |x: f64, u2: f64| {
                    let wi = mirrored_by(wo, facets.sample(wo, [1.0 - x * x, u2, 0.0]));
                    let (o, i) = (wo.z * facets.stretch(wi), wi.z * facets.stretch(wo));
                    if wi.z > 0.0 {
                        (o - wo.z * wi.z) / (o + i)
                    } else {
                        1.0
                    }
                };
                let row = |x: f64| {
                    midpoints(400)
                        .map(|u2| 2.0 * x * shaded(x, 0.5 * u2))
                        .sum::<f64>()
                };
                let expected = midpoints(2000).map(row).sum::<f64>() / 800_000.0;
                let found = lost(facets, cos, &gauss_legendre(POINTS));
                assert!(
                    (found - expected).abs() < 3e-6,
                    "{alpha} {cos}: {found} {expected}"
                );
            }
        }
    }
}
