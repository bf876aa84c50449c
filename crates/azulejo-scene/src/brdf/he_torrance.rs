//! Reflection by wave optics from rough metals and glass: `he_torrance`.
//!
//! X. D. He, K. E. Torrance, F. X. Sillion, D. P. Greenberg, *A comprehensive physical model for
//! light reflection*, SIGGRAPH 1991. The smoother the surface is compared with the wavelength, the
//! more light is reflected specularly; the rest is spread about the specular direction by
//! diffraction. The paper's geometric factor has projections over |k_r × k_i|⁴ that cancel to 1 (A.
//! Willmott, in Radiance's `He.cal`) and are left out.

mod series;
mod table;

use super::arguments::Arguments;
use super::beckmann::Beckmann;
use super::facet_guide::FacetGuide;
use super::lobe::{Lobe, Reflect, Spread};
use super::microfacet::{HalfVector, over_base};
use super::models::{KD, KS, ModelInfo, PLAIN, ParameterInfo};
use super::quadrature::cosine_hemisphere;
use super::{BrdfError, Fresnel, WAVELENGTHS};
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, LN_2, PI, TAU};
use std::sync::Arc;
use table::SeriesTable;

const PARAMETERS: &[ParameterInfo] = &[
    KD.also(&["rd", "a"]),
    KS,
    ParameterInfo::number("sigma0", [1e-4, 1e4], "root mean square height")
        .also(&["sigma"])
        .in_unit("µm"),
    ParameterInfo::number("tau", [1e-3, 1e6], "correlation length of the heights").in_unit("µm"),
    ParameterInfo::color(
        "lambda",
        [1e-2, 1e3],
        "wavelength of each channel; (0.61, 0.55, 0.465) where it is not given",
    )
    .optional()
    .in_unit("µm"),
];

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "he_torrance",
    aliases: &["he", "he_torrance_dd"],
    title: "He–Torrance–Sillion–Greenberg",
    paper: "X. D. He et al., A comprehensive physical model for light reflection, SIGGRAPH 1991",
    parameters: PARAMETERS,
    examples: &[
        "he_torrance sigma0 = 0.18 tau = 3 metal = aluminium",
        "he_torrance sigma0 = 0.28 tau = 1.77 lambda = 0.5",
        "he_torrance kd = 0.4 ks = 0.6 sigma0 = 0.05 tau = 2 eta = 1.5",
        "he_torrance sigma0 = 2 tau = 12 metal = gold",
    ],
    has_fresnel: true,
    make: |arguments| {
        let surface = RoughSurface::new(arguments)?;
        let lobes = vec![
            Lobe::HeTorrance(HeTorrance::new(surface)),
            Lobe::HeMirror(HeMirror { surface }),
        ];
        over_base(arguments, lobes)
    },
    ..PLAIN
};

/// Only perfect specular reflection.
pub(super) const MIRROR: ModelInfo = ModelInfo {
    name: "he_torrance_mirror",
    aliases: &["he_torrance_rho_s"],
    title: "He–Torrance–Sillion–Greenberg, the coherent part alone",
    examples: &["he_torrance_mirror sigma0 = 0.05 tau = 2 metal = silver"],
    make: |arguments| {
        let surface = RoughSurface::new(arguments)?;
        over_base(arguments, vec![Lobe::HeMirror(HeMirror { surface })])
    },
    ..INFO
};

/// Cotangent of an angle, in units of the slopes, beyond which rounding hides that facets hide each
/// other.
const ALL_SEEN: f64 = 6.0;

/// Slope of the facets that are sampled relative to those that reflect: theirs tail off sooner than
/// the light of diffraction.
const BROADER: f64 = 1.3;

/// Share of the samples with a cosine distribution, for directions that the facets rarely sample.
const WIDE: f64 = 0.03;

/// A Gaussian surface of random heights. Lengths in micrometres.
#[derive(Clone, Copy, Debug)]
struct RoughSurface {
    scale: Rgb,
    fresnel: Fresnel,
    sigma0: f64,
    tau: f64,
    lambda: Rgb,
}

/// Terms that depend on the angle of one direction only.
#[derive(Clone, Copy)]
struct Slant {
    /// K: the shadowing and masking term of the apparent roughness.
    shade: f64,
    /// S: the visible fraction of the surface.
    seen: f64,
}

impl RoughSurface {
    fn new(arguments: &Arguments) -> Result<RoughSurface, BrdfError> {
        let lambda = arguments.has("lambda").then(|| arguments.color("lambda"));
        Ok(RoughSurface {
            scale: arguments.color("ks"),
            fresnel: arguments.fresnel()?,
            sigma0: arguments.number("sigma0"),
            tau: arguments.number("tau"),
            lambda: lambda.unwrap_or(WAVELENGTHS),
        })
    }

    /// For the sine and cosine of the angle to the normal.
    fn slant(&self, sin: f64, cos: f64) -> Slant {
        let tan = sin / cos;
        let q = self.tau / (2.0 * self.sigma0 * tan);
        if q > ALL_SEEN {
            return Slant {
                shade: 0.0,
                seen: 1.0,
            };
        }
        let erfc = libm::erfc(q);
        // Smith's Λ, hidden facets per visible one.
        let hidden = 0.5 * ((-q * q).exp() / (q * PI.sqrt()) - erfc);
        Slant {
            shade: (tan * erfc).min(1e300),
            seen: (1.0 - 0.5 * erfc) / (1.0 + hidden.max(0.0)),
        }
    }

    fn slant_of(&self, w: DVec3) -> Slant {
        self.slant((w.x * w.x + w.y * w.y).sqrt(), w.z)
    }

    /// σ: the apparent roughness, that of the illuminated and visible parts.
    fn apparent_roughness(&self, i: Slant, o: Slant) -> f64 {
        let z = shadow_depth(0.25 * (i.shade + o.shade));
        self.sigma0 / (1.0 + z * z).sqrt()
    }

    /// Evaluates each channel, or one if all wavelengths are equal.
    fn per_wavelength(&self, of: impl Fn(f64) -> f64) -> Rgb {
        if self.lambda.is_grey() {
            return Rgb::grey(of(self.lambda.r));
        }
        self.lambda.map(of)
    }
}

/// z₀/σ₀, the solution z of √(π/2) z = k exp(−z²/2), k ≥ 0.
fn shadow_depth(k: f64) -> f64 {
    let k = k / FRAC_PI_2.sqrt();
    if !(k > 0.0) {
        return 0.0;
    }
    // Newton's method on z²/2 + ln z − ln k, which rises, concave below 1 and convex above: from
    // this start, which is no less than the solution, no step leaves z > 0. z ≤ k, and where z ≥ 1,
    // z² ≤ 2 ln k.
    let mut z = k.min((2.0 * k.ln()).max(1.0).sqrt());
    for _ in 0..20 {
        let step = (0.5 * z * z + (z / k).ln()) / (z + 1.0 / z);
        z -= step;
        if step.abs() <= 1e-15 * z {
            break;
        }
    }
    z
}

/// The directional-diffuse part: F G S D/(π cos θi cos θo).
#[derive(Clone, Debug)]
pub(super) struct HeTorrance {
    surface: RoughSurface,
    /// The longest wavelength, which has the widest lobe.
    longest: f64,
    series: Arc<SeriesTable>,
    guide: Arc<FacetGuide>,
}

impl HeTorrance {
    fn new(surface: RoughSurface) -> HeTorrance {
        let [longest, shortest] = [
            surface.lambda.max_channel(),
            -(surface.lambda * -1.0).max_channel(),
        ];
        let root = 2.0 * TAU * surface.sigma0 / shortest;
        let offset = TAU * surface.tau / shortest;
        let mut lobe = HeTorrance {
            surface,
            longest,
            series: Arc::new(SeriesTable::new(root, offset)),
            guide: Arc::new(FacetGuide::new(|_, _, _| 1.0)),
        };
        let guide = FacetGuide::new(|cos, slope, azimuth| lobe.weight(cos, slope, azimuth));
        lobe.guide = Arc::new(guide);
        lobe
    }

    /// What facets reflect over the density of what facets sampled without a guide would.
    fn weight(&self, cos: f64, slope: f64, azimuth: f64) -> f64 {
        let wo = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
        let facets = self.facets(wo);
        let wi = facets.sample(wo, slope, azimuth);
        if !(wi.z > 0.0) {
            return 0.0;
        }
        let weight = self.eval(wo, wi).mean() * wi.z / facets.pdf(&HalfVector::new(wo, wi));
        if weight.is_finite() { weight } else { 0.0 }
    }

    /// Facets whose reflected light is about as wide as the lobe of light along `wo`. Their slope
    /// is 2σ₀/τ where the surface is rough compared with the wavelength, and that of diffraction
    /// where it is smooth: terms m of the series have the slope λ√m/(π τ v_z), and m is about g.
    fn facets(&self, wo: DVec3) -> Beckmann {
        let surface = &self.surface;
        let root = 2.0 * TAU * surface.sigma0 * wo.z / self.longest;
        let term = if root < 1e-3 {
            1.0
        } else {
            root * root / -(-root * root).exp_m1()
        };
        let slope = self.longest * term.sqrt() / (TAU * surface.tau * wo.z);
        Beckmann::isotropic((BROADER * slope).clamp(1e-5, 1.0))
    }
}

impl Reflect for HeTorrance {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let (surface, half) = (&self.surface, HalfVector::new(wo, wi));
        let (i, o) = (surface.slant_of(wi), surface.slant_of(wo));
        let sigma = surface.apparent_roughness(i, o);
        let v = half.v;
        let across = (v.x * v.x + v.y * v.y).sqrt();
        let geometry = (v.length_squared() / v.z).powi(2);
        let density = surface.per_wavelength(|lambda| {
            let (k, t) = (TAU / lambda, PI * surface.tau / lambda);
            0.25 * t * t * self.series.sum(k * sigma * v.z, t * across)
        });
        let seen = i.seen * o.seen / (PI * wi.z * wo.z);
        surface.scale * surface.fresnel.at(half.cos_d()) * density * (geometry * seen)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let (facets, half) = (self.facets(wo), HalfVector::new(wo, wi));
        let (v, sin) = (half.v, (wo.x * wo.x + wo.y * wo.y).sqrt());
        let along = if sin > 0.0 {
            v.x * wo.x + v.y * wo.y
        } else {
            v.x
        };
        let across = (v.x * v.x + v.y * v.y).sqrt() * if sin > 0.0 { sin } else { 1.0 };
        let cos_azimuth = if across > 0.0 { along / across } else { 1.0 };
        let smaller = 1.0 - facets.exponential(&half);
        let guided = self.guide.density(wo.z, smaller, cos_azimuth);
        WIDE * wi.z * FRAC_1_PI + (1.0 - WIDE) * facets.pdf(&half) * guided
    }

    fn sample(&self, wo: DVec3, [u1, u2, u3]: [f64; 3]) -> DVec3 {
        if u3 < WIDE {
            return cosine_hemisphere(u1, u2);
        }
        let sin = (wo.x * wo.x + wo.y * wo.y).sqrt();
        let (x, y) = if sin > 0.0 {
            (wo.x / sin, wo.y / sin)
        } else {
            (1.0, 0.0)
        };
        let (slope, azimuth) = self.guide.choose(wo.z, u1, u2);
        let wi = self
            .facets(wo)
            .sample(DVec3::new(sin, 0.0, wo.z), slope, azimuth);
        DVec3::new(x * wi.x - y * wi.y, y * wi.x + x * wi.y, wi.z)
    }

    fn spread(&self) -> Spread {
        let slope = self.facets(DVec3::Z).ax * 1.1 / BROADER;
        Spread::Glossy(2.0 * (slope * LN_2.sqrt()).atan())
    }
}

/// The specular part: F exp(−g) S².
#[derive(Clone, Debug)]
pub(super) struct HeMirror {
    surface: RoughSurface,
}

impl Reflect for HeMirror {
    fn eval(&self, _wo: DVec3, _wi: DVec3) -> Rgb {
        Rgb::BLACK
    }

    fn pdf(&self, _wo: DVec3, _wi: DVec3) -> f64 {
        0.0
    }

    fn sample(&self, wo: DVec3, _u: [f64; 3]) -> DVec3 {
        DVec3::new(-wo.x, -wo.y, wo.z)
    }

    fn mirror(&self, cos: f64) -> Rgb {
        let surface = &self.surface;
        let slant = surface.slant((1.0 - cos * cos).max(0.0).sqrt(), cos);
        let sigma = surface.apparent_roughness(slant, slant);
        let coherent = surface.per_wavelength(|lambda| {
            let root = 2.0 * TAU * sigma * cos / lambda;
            (-root * root).exp() * slant.seen * slant.seen
        });
        surface.scale * surface.fresnel.at(cos) * coherent
    }

    fn spread(&self) -> Spread {
        Spread::Glossy(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shadows_are_as_deep_as_their_equation_says() {
        for k in [1e-12, 0.01, 0.7, 1.0, 1.3, 30.0, 1e8, 1e300] {
            let z = shadow_depth(k);
            let (left, right) = (FRAC_PI_2.sqrt() * z, k * (-0.5 * z * z).exp());
            // An error of one ulp in z grows by z² in the exponential.
            assert!((left / right - 1.0).abs() < 1e-12, "{k}: {z}");
        }
        assert_eq!(shadow_depth(0.0), 0.0);
    }
}
