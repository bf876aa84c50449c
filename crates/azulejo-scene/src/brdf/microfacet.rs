//! Common parts of microfacet models: the half vector, V-grooves, a base below the facets.

use super::BrdfError;
use super::arguments::Arguments;
use super::lambert::Lambert;
use super::lobe::Lobe;
use super::lobes::Lobes;
use super::models::ParameterInfo;
use glam::DVec3;

/// Slope of the facets along x, the tangent.
pub(super) const AX: ParameterInfo =
    ParameterInfo::number("ax", [1e-4, 10.0], "roughness along the tangent").also(&["alpha"]);

/// Slope of the facets along y, the bitangent.
pub(super) const AY: ParameterInfo = ParameterInfo::number(
    "ay",
    [1e-4, 10.0],
    "roughness along the bitangent; `ax` where it is not given",
)
.optional();

/// `ax` and `ay`.
pub(super) fn roughness(arguments: &Arguments) -> [f64; 2] {
    let ax = arguments.number("ax");
    let ay = arguments.has("ay").then(|| arguments.number("ay"));
    [ax, ay.unwrap_or(ax)]
}

/// The vector halfway between two directions: the normal of the facets that reflect one into the
/// other. All its methods return bit-identical values if the two are exchanged.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfVector {
    /// The sum of the two.
    pub v: DVec3,
    length: f64,
}

impl HalfVector {
    pub fn new(wo: DVec3, wi: DVec3) -> HalfVector {
        let v = wo + wi;
        HalfVector {
            v,
            length: v.length(),
        }
    }

    /// Cosine between the half vector and the normal.
    pub fn cos_h(&self) -> f64 {
        self.v.z / self.length
    }

    /// Cosine between the half vector and either direction.
    pub fn cos_d(&self) -> f64 {
        // |v|² = 2 + 2 cos of the angle between the two.
        (0.5 * self.length).min(1.0)
    }

    /// The angle between the half vector and the normal, in radians.
    pub fn theta_h(&self) -> f64 {
        self.v.x.hypot(self.v.y).atan2(self.v.z)
    }

    /// Converts the density `half_density` of half vectors to one over the solid angle of `wi`, by the
    /// Jacobian 1/(4 cos) of reflection.
    pub fn reflected(&self, half_density: f64) -> f64 {
        half_density / (4.0 * self.cos_d())
    }
}

/// The normal of the facets that reflect `wo` into `wi`.
pub(super) fn half(wo: DVec3, wi: DVec3) -> DVec3 {
    (wo + wi).normalize_or(DVec3::Z)
}

/// The direction into which a facet of unit normal `h` reflects `wo`. Below the surface if the
/// facet is not visible from `wo`.
pub(super) fn mirrored_by(wo: DVec3, h: DVec3) -> DVec3 {
    h * (2.0 * wo.dot(h)) - wo
}

/// Masking and shadowing by V-shaped grooves: the fraction of facets that are visible and lit.
/// Torrance and Sparrow 1967.
pub(super) fn v_grooves(half: &HalfVector, wo: DVec3, wi: DVec3) -> f64 {
    (2.0 * half.cos_h() * wo.z.min(wi.z) / half.cos_d()).min(1.0)
}

/// Lobes of facets on top of a diffuse base of reflectance `kd`.
///
/// # Errors
/// [`BrdfError::Energy`] if base and lobes reflect more uniform light than they receive, which is
/// impossible if `kd + ks` is at most 1.
pub(super) fn over_base(
    arguments: &Arguments,
    mut lobes: Vec<Lobe>,
) -> Result<Vec<Lobe>, BrdfError> {
    let (kd, ks) = (arguments.color("kd"), arguments.color("ks"));
    if (kd + ks).max_channel() > 1.0 {
        let facets = Lobes::new(lobes.iter().map(|l| (1.0, l.clone())).collect());
        let sum = (kd + facets.mean_albedo() + facets.mean_mirror()).max_channel();
        if sum > 1.0 && !kd.is_black() {
            return Err(BrdfError::Energy {
                what: "kd and what the facets reflect of even light".to_owned(),
                sum,
            });
        }
    }
    lobes.insert(0, Lobe::Lambert(Lambert { albedo: kd }));
    Ok(lobes)
}
