//! The table of models and their parameters, for readers, help, documentation and editors.

use super::arguments::Arguments;
use super::lobe::Lobe;
use super::{
    BrdfError, ashikhmin_shirley, beard_maxwell, beckmann_smith, blinn, burley_diffuse,
    cook_torrance, eon, ggx_ms, ggx_smith, gltf_mr, he_torrance, lafortune, lambert, lewis,
    minnaert, oren_nayar, phong, poulin_fournier, schlick, smooth, strauss, torrance_sparrow_gauss,
    ward,
};

/// A model that descriptions can name.
pub struct ModelInfo {
    /// Its name.
    pub name: &'static str,
    /// Other accepted names.
    pub aliases: &'static [&'static str],
    /// Its title, for documentation.
    pub title: &'static str,
    /// Its publication.
    pub paper: &'static str,
    /// Its parameters.
    pub parameters: &'static [ParameterInfo],
    /// Example descriptions, for help and documentation; the checks of all models use them.
    pub examples: &'static [&'static str],
    /// Whether it also takes one of the parameter sets of [`FRESNEL`]; without one the Fresnel term
    /// is 1.
    pub has_fresnel: bool,
    /// Whether it is reciprocal: f(wo, wi) = f(wi, wo).
    pub is_reciprocal: bool,
    /// Whether it conserves energy for all parameters in range.
    pub is_energy_safe: bool,
    pub(super) make: fn(&Arguments) -> Result<Vec<Lobe>, BrdfError>,
}

/// A model without Fresnel term that is reciprocal and conserves energy: what tables of a model do not say
/// themselves.
pub(super) const PLAIN: ModelInfo = ModelInfo {
    name: "",
    aliases: &[],
    title: "",
    paper: "",
    parameters: &[],
    examples: &[],
    has_fresnel: false,
    is_reciprocal: true,
    is_energy_safe: true,
    make: |_| Ok(Vec::new()),
};

/// A parameter of a model.
pub struct ParameterInfo {
    /// Its name.
    pub name: &'static str,
    /// Other accepted names.
    pub aliases: &'static [&'static str],
    /// The type of its value.
    pub kind: ParameterKind,
    /// The default value, unless [`about`](ParameterInfo::about) states another.
    pub default: Option<f64>,
    /// Whether it must be given.
    pub is_needed: bool,
    /// The smallest allowed value, of each channel.
    pub least: f64,
    /// The largest allowed value, of each channel.
    pub most: f64,
    /// Unit; empty for plain numbers.
    pub unit: &'static str,
    /// A description for users.
    pub about: &'static str,
}

/// The type of a parameter's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterKind {
    /// One number.
    Number,
    /// One number for all channels, or three.
    Color,
    /// A word.
    Word,
}

impl ParameterInfo {
    /// A number that must be given.
    pub(super) const fn number(name: &'static str, range: [f64; 2], about: &'static str) -> Self {
        ParameterInfo {
            name,
            aliases: &[],
            kind: ParameterKind::Number,
            default: None,
            is_needed: true,
            least: range[0],
            most: range[1],
            unit: "",
            about,
        }
    }

    /// A colour that must be given.
    pub(super) const fn color(name: &'static str, range: [f64; 2], about: &'static str) -> Self {
        ParameterInfo {
            kind: ParameterKind::Color,
            ..ParameterInfo::number(name, range, about)
        }
    }

    /// With a default value.
    pub(super) const fn or(self, default: f64) -> Self {
        ParameterInfo {
            default: Some(default),
            is_needed: false,
            ..self
        }
    }

    /// One that may be omitted; the model defines its default.
    pub(super) const fn optional(self) -> Self {
        ParameterInfo {
            is_needed: false,
            ..self
        }
    }

    /// With alternative names.
    pub(super) const fn also(self, aliases: &'static [&'static str]) -> Self {
        ParameterInfo { aliases, ..self }
    }

    /// With a unit.
    pub(super) const fn in_unit(self, unit: &'static str) -> Self {
        ParameterInfo { unit, ..self }
    }

    /// Whether a name matches this one, in upper or lower case.
    pub fn is_called(&self, name: &str) -> bool {
        is_called(self.name, self.aliases, name)
    }
}

impl ModelInfo {
    /// Whether a name matches this one, in upper or lower case.
    pub fn is_called(&self, name: &str) -> bool {
        is_called(self.name, self.aliases, name)
    }

    /// All its parameters.
    pub fn all_parameters(&self) -> impl Iterator<Item = &'static ParameterInfo> + use<> {
        let fresnel: &[_] = if self.has_fresnel { FRESNEL } else { &[] };
        self.parameters.iter().chain(fresnel)
    }
}

pub(super) fn is_called(name: &str, aliases: &[&str], given: &str) -> bool {
    let is = |known: &str| known.eq_ignore_ascii_case(given);
    is(name) || aliases.iter().any(|a| is(a))
}

/// Diffuse reflectance, by default zero.
pub(super) const KD: ParameterInfo = ParameterInfo::color("kd", [0.0, 1.0], "diffuse reflectance")
    .or(0.0)
    .also(&["rd"]);

/// Reflectance of the lobe.
pub(super) const KS: ParameterInfo =
    ParameterInfo::color("ks", [0.0, 1.0], "reflectance of the lobe")
        .or(1.0)
        .also(&["rs"]);

/// An exponent of a cosine.
pub(super) const EXPONENT: ParameterInfo =
    ParameterInfo::number("n", [0.0, 1e6], "exponent: the higher, the narrower");

/// Sets of parameters for the Fresnel term, one of which a model may take: `eta` with `k` for a
/// metal, `eta` alone for a dielectric, `metal` by name, `f0` (with `tint`) for Schlick's
/// approximation, or a constant `F`.
pub const FRESNEL: &[ParameterInfo] = &[
    ParameterInfo::color("eta", [1e-3, 100.0], "index of refraction, real part")
        .also(&["nreal", "ior"])
        .optional(),
    ParameterInfo::color("k", [0.0, 100.0], "index of refraction, imaginary part")
        .also(&["nimag"])
        .optional(),
    ParameterInfo {
        kind: ParameterKind::Word,
        ..ParameterInfo::number("metal", [0.0, 0.0], "a metal of the table, by name").optional()
    },
    ParameterInfo::color("f0", [0.0, 1.0], "reflectance at normal incidence").optional(),
    ParameterInfo::color(
        "tint",
        [0.0, 1.0],
        "what OpenPBR leaves of it at cos θ = 1/7",
    )
    .optional(),
    ParameterInfo::color("F", [0.0, 1.0], "reflectance at all angles").optional(),
];

/// Every model, in the order of the documentation.
pub static MODELS: &[&ModelInfo] = &[
    &lambert::INFO,
    &smooth::SPECULAR,
    &smooth::CONDUCTOR,
    &smooth::DIELECTRIC,
    &phong::INFO,
    &lewis::INFO,
    &blinn::INFO,
    &ward::WARD,
    &ward::DUER,
    &ward::GMD,
    &torrance_sparrow_gauss::INFO,
    &cook_torrance::INFO,
    &poulin_fournier::INFO,
    &he_torrance::INFO,
    &he_torrance::MIRROR,
    &ggx_smith::INFO,
    &beckmann_smith::INFO,
    &ggx_ms::INFO,
    &schlick::INFO,
    &oren_nayar::INFO,
    &eon::INFO,
    &burley_diffuse::INFO,
    &strauss::INFO,
    &lafortune::INFO,
    &ashikhmin_shirley::INFO,
    &minnaert::INFO,
    &beard_maxwell::INFO,
    &gltf_mr::INFO,
];

/// The model with this name.
///
/// # Errors
/// [`BrdfError::UnknownModel`], with the most similar known name.
pub fn find(name: &str) -> Result<&'static ModelInfo, BrdfError> {
    let known = MODELS.iter().find(|m| m.is_called(name));
    known.copied().ok_or_else(|| {
        let names = MODELS
            .iter()
            .flat_map(|m| [m.name].into_iter().chain(m.aliases.iter().copied()));
        BrdfError::UnknownModel {
            name: name.to_owned(),
            nearest: nearest(name, names).unwrap_or("diffuse"),
        }
    })
}

/// The name most similar to `name`.
pub(super) fn nearest(
    name: &str,
    known: impl Iterator<Item = &'static str>,
) -> Option<&'static str> {
    let name = name.to_ascii_lowercase();
    let likeness = |known: &&str| strsim::jaro_winkler(&name, &known.to_ascii_lowercase());
    known.max_by(|a, b| likeness(a).total_cmp(&likeness(b)))
}
