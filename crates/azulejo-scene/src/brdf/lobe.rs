//! One lobe of a BRDF: the closed list of models.

use super::ashikhmin_shirley::{AshikhminShirley, AshikhminShirleyBase};
use super::beard_maxwell::{BeardMaxwell, BeardMaxwellBelow};
use super::beckmann_smith::BeckmannSmith;
use super::blinn::Blinn;
use super::burley_diffuse::BurleyDiffuse;
use super::cook_torrance::CookTorrance;
use super::eon::Eon;
use super::ggx_ms::GgxMultiple;
use super::ggx_smith::GgxSmith;
use super::gltf_mr::{GltfBase, GltfSurface};
use super::he_torrance::{HeMirror, HeTorrance};
use super::lafortune::Lafortune;
use super::lambert::Lambert;
use super::lewis::Lewis;
use super::measured::Table;
use super::minnaert::Minnaert;
use super::oren_nayar::OrenNayar;
use super::phong::Phong;
use super::poulin_fournier::{MattCylinders, ShinyCylinders};
use super::schlick::{Schlick, SchlickBase};
use super::smooth::Smooth;
use super::strauss::Strauss;
use super::torrance_sparrow_gauss::TorranceSparrow;
use super::ward::Ward;
use crate::Rgb;
use glam::DVec3;

/// Angular width of a lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Spread {
    /// Over the whole hemisphere.
    Matt,
    /// Around the specular direction: for incidence near the normal, half of the reflected light
    /// lies within this angle of it, in radians; zero for a mirror.
    Glossy(f64),
}

/// The interface of each lobe model; directions as in the module above, with `wo.z` and `wi.z`
/// above 0.
pub(super) trait Reflect {
    /// f_r, 1/sr; finite.
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb;

    /// Density of [`sample`](Reflect::sample) over the solid angle of `wi`, 1/sr. Its integral over
    /// the hemisphere is 1 less the fraction of samples that are lost below the surface.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64;

    /// The direction for three numbers in 0..1, unit; one below the surface is a lost sample. The
    /// third number is for models that choose among parts; the first two are the best stratified.
    fn sample(&self, wo: DVec3, u: [f64; 3]) -> DVec3;

    /// Reflectance of the perfectly specular part, which `eval` and `sample` leave out.
    fn mirror(&self, _cos: f64) -> Rgb {
        Rgb::BLACK
    }

    /// Angular width of the lobe.
    fn spread(&self) -> Spread;
}

/// Defines the enum of models, whose methods dispatch to the model.
macro_rules! lobes {
    ($($(#[$doc:meta])* $name:ident($model:ty),)*) => {
        /// One lobe: a model with its parameters. Tables are shared: a lobe is cheap to clone.
        #[derive(Clone, Debug)]
        pub(super) enum Lobe { $($(#[$doc])* $name($model),)* }

        impl Lobe {
            fn model(&self) -> &dyn Reflect {
                match self { $(Lobe::$name(model) => model,)* }
            }
        }
    };
}

lobes! {
    /// Lambertian reflection.
    Lambert(Lambert),
    /// Mirrors, metals and dielectrics without roughness.
    Smooth(Smooth),
    /// Phong 1975.
    Phong(Phong),
    /// Lewis 1993: Phong's lobe, made reciprocal.
    Lewis(Lewis),
    /// Blinn 1977.
    Blinn(Blinn),
    /// Ward 1992 and its variants.
    Ward(Ward),
    /// Torrance and Sparrow 1967.
    TorranceSparrow(TorranceSparrow),
    /// Cook and Torrance 1982.
    CookTorrance(CookTorrance),
    /// Poulin and Fournier 1990: diffuse reflection of the cylinders.
    MattCylinders(MattCylinders),
    /// Poulin and Fournier 1990: the cylinders' highlights.
    ShinyCylinders(ShinyCylinders),
    /// He et al. 1991: the directional-diffuse part.
    HeTorrance(HeTorrance),
    /// He et al. 1991: the specular part.
    HeMirror(HeMirror),
    /// Trowbridge and Reitz's facets, Smith's masking and shadowing.
    GgxSmith(GgxSmith),
    /// Beckmann's facets, Smith's masking and shadowing.
    BeckmannSmith(BeckmannSmith),
    /// Kulla and Conty 2017: multiple scattering between facets.
    GgxMultiple(GgxMultiple),
    /// Schlick 1994, glossy.
    Schlick(Schlick),
    /// Schlick 1994, diffuse.
    SchlickBase(SchlickBase),
    /// Oren and Nayar 1994.
    OrenNayar(OrenNayar),
    /// Portsmouth, Kutz and Hill 2025.
    Eon(Eon),
    /// Burley 2012.
    BurleyDiffuse(BurleyDiffuse),
    /// Strauss 1990.
    Strauss(Strauss),
    /// Lafortune et al. 1997.
    Lafortune(Lafortune),
    /// Ashikhmin and Shirley 2000, the lobe.
    AshikhminShirley(AshikhminShirley),
    /// Ashikhmin and Shirley 2000, the base below it.
    AshikhminShirleyBase(AshikhminShirleyBase),
    /// Minnaert 1941.
    Minnaert(Minnaert),
    /// Beard and Maxwell 1973, the first surface.
    BeardMaxwell(BeardMaxwell),
    /// Beard and Maxwell 1973, the scattering below it.
    BeardMaxwellBelow(BeardMaxwellBelow),
    /// glTF's surface.
    GltfSurface(GltfSurface),
    /// glTF's diffuse base.
    GltfBase(GltfBase),
    /// Measurements.
    Measured(Table),
}

impl Reflect for Lobe {
    /// A formula may overflow within rounding of the horizon; nothing is reflected there.
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let value = self.model().eval(wo, wi);
        if value.is_finite() { value } else { Rgb::BLACK }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let density = self.model().pdf(wo, wi);
        if density.is_finite() { density } else { 0.0 }
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> DVec3 {
        self.model().sample(wo, u)
    }

    fn mirror(&self, cos: f64) -> Rgb {
        self.model().mirror(cos)
    }

    fn spread(&self) -> Spread {
        self.model().spread()
    }
}
